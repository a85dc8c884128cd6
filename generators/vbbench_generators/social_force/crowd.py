"""A crowd at the moment it starts to walk."""

from dataclasses import dataclass, field

import numpy as np

from vbbench.geometry import FloatArray, IntArray, frozen_array

NO_GROUP = -1


@dataclass(frozen=True, kw_only=True)
class Crowd:
    """One scene at its start.

    Parameters
    ----------
    positions : [K, 2] in m.
    velocities : [K, 2] in m/s.
    speeds : [K] desired speeds in m/s.
    goals : [K, G, 2] in m, the places each person heads for, one after the other; the last one is kept to.
    groups : [K] group number, -1 for those who walk alone; by default everybody does.

    Raises
    ------
    ValueError
        If a shape does not fit, a number is not finite, a speed is negative or there is no goal.
    """

    positions: FloatArray
    velocities: FloatArray
    speeds: FloatArray
    goals: FloatArray
    groups: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    def __post_init__(self) -> None:
        people = len(np.atleast_1d(self.positions))
        shapes = {"positions": (people, 2), "velocities": (people, 2), "speeds": (people,), "goals": (people, None, 2)}
        for name, shape in shapes.items():
            values = frozen_array(name, getattr(self, name), shape)
            if not np.all(np.isfinite(values)):
                raise ValueError(f"{name} must be finite; they hold NaN or infinity")
            object.__setattr__(self, name, values)
        groups = self.groups if np.size(self.groups) else np.full(people, NO_GROUP)
        object.__setattr__(self, "groups", frozen_array("groups", groups, (people,), np.int64))
        if np.any(self.groups < NO_GROUP):
            raise ValueError("groups must be numbers from 0, or -1 for those who walk alone")
        if np.any(self.speeds < 0):
            raise ValueError("speeds must not be negative")
        if self.goals.shape[1] == 0:
            raise ValueError("goals must have shape [K, G, 2] with G of at least 1: everybody heads for some place")

    @property
    def people(self) -> int:
        """Number of people K."""
        return len(self.positions)

    def members(self) -> list[IntArray]:
        """Indices of the people of each group."""
        return [np.flatnonzero(self.groups == group) for group in np.unique(self.groups) if group != NO_GROUP]
