"""What walks and how: a crowd at the moment it starts, and the parameters of the model, one dataclass a force."""

from dataclasses import dataclass, field, fields

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
    groups : [K] group number, -1 for people who walk alone; by default everyone does.

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
            raise ValueError("groups must be numbers from 0, or -1 for people who walk alone")
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


STOP_RADIUS = 0.5
"""Distance in m from the last goal at which a person stands still, as in pysocialforce."""


def _check(parameters: object, *free: str) -> None:
    """Raise ValueError unless every number is finite and positive; those called ``free`` may be zero."""
    for parameter in fields(parameters):  # type: ignore[arg-type]
        value = getattr(parameters, parameter.name)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if number and not (np.isfinite(value) and (value > 0 or (value == 0 and parameter.name in free))):
            least = "a finite number, zero or more" if parameter.name in free else "a positive number"
            raise ValueError(f"{type(parameters).__name__}.{parameter.name} must be {least}, not {value}")


@dataclass(frozen=True, kw_only=True)
class Moussaid:
    """Repulsion of Moussaïd et al., Proc. R. Soc. B 276 (2009) 2755; defaults of pysocialforce.

    Parameters
    ----------
    factor : strength A in m/s².
    velocity_weight : λ in s/m, weight of the relative velocity in the interaction vector.
    reach : γ in m, range of the force for an interaction vector of length 1.
    side_sharpness, brake_sharpness : n and n', how fast turning aside and braking fade with the angle.
    """

    factor: float = 5.1
    velocity_weight: float = 2.0
    reach: float = 0.35
    side_sharpness: float = 2.0
    brake_sharpness: float = 3.0

    def __post_init__(self) -> None:
        _check(self, "factor", "velocity_weight", "side_sharpness", "brake_sharpness")


@dataclass(frozen=True, kw_only=True)
class HelbingMolnar:
    """Repulsion of Helbing & Molnár, Phys. Rev. E 51 (1995) 4282: elliptical potentials about everybody.

    Parameters
    ----------
    strength : V0 in m²/s².
    fall_off : σ in m.
    stride_time : Δt in s; the ellipse is as long as what the other walks in this time.
    view_angle : 2φ in degrees, the width of the field of view.
    unseen_weight : c, weight of people outside it.
    wall_strength : U0 in m²/s².
    wall_fall_off : R in m.
    """

    strength: float = 2.1
    fall_off: float = 0.3
    stride_time: float = 2.0
    view_angle: float = 200.0
    unseen_weight: float = 0.5
    wall_strength: float = 10.0
    wall_fall_off: float = 0.2

    def __post_init__(self) -> None:
        _check(self, "strength", "stride_time", "unseen_weight", "wall_strength")
        if self.view_angle > 360:
            raise ValueError(f"HelbingMolnar.view_angle must be at most 360 degrees, not {self.view_angle}")


@dataclass(frozen=True, kw_only=True)
class WallForce:
    """Walls next to `Moussaid`, as in pysocialforce: lines sampled at 10 points a metre, each of which repels.

    Parameters
    ----------
    factor : strength in m/s².
    fall_off : in m.
    reach : distance in m from the body's rim beyond which a point does nothing.
    body_radius : in m.
    """

    factor: float = 10.0
    fall_off: float = 0.2
    reach: float = 3.35
    body_radius: float = 0.35

    def __post_init__(self) -> None:
        _check(self, "factor", "body_radius")


@dataclass(frozen=True, kw_only=True)
class GroupForces:
    """What keeps a group together, as in pysocialforce, where these are the factors in effect.

    Parameters
    ----------
    cohesion : pull towards the centre of the group, in 1/s².
    gaze : walking on or waiting so that the others stay in view, in m/s².
    separation : push between members closer than ``personal_space``, in 1/s².
    personal_space : in m.
    """

    cohesion: float = 1.0
    gaze: float = 1.0
    separation: float = 1.0
    personal_space: float = 0.55

    def __post_init__(self) -> None:
        _check(self, "cohesion", "gaze", "separation", "personal_space")


@dataclass(frozen=True, kw_only=True)
class Model:
    """Everything that moves a crowd.

    Parameters
    ----------
    repulsion : how people keep apart.
    walls : how walls repel with `Moussaid`; `HelbingMolnar` has its own potential.
    groups : how groups keep together.
    relaxation_time : τ in s, to regain the desired velocity.
    top_speed : maximum speed, relative to the desired speed.
    arrival_radius : distance in m from a goal at which a person turns to the next one; at least 0.5.
    strict : compute what pysocialforce 1.1.2 computes: angles between directions are not wrapped, and both the desired
        and the top speed are ``top_speed`` times the speed at the start; ``Crowd.speeds`` is not looked at.
    """

    repulsion: Moussaid | HelbingMolnar = field(default_factory=Moussaid)
    walls: WallForce = field(default_factory=WallForce)
    groups: GroupForces = field(default_factory=GroupForces)
    relaxation_time: float = 0.5
    top_speed: float = 1.3
    arrival_radius: float = 1.0
    strict: bool = False

    def __post_init__(self) -> None:
        _check(self)
        if self.top_speed < 1:
            raise ValueError(f"Model.top_speed must be at least 1, not {self.top_speed}")
        if self.arrival_radius < STOP_RADIUS:
            raise ValueError(f"Model.arrival_radius must be at least {STOP_RADIUS} m, not {self.arrival_radius}")
        if self.strict and not isinstance(self.repulsion, Moussaid):
            raise ValueError("Model.strict is pysocialforce to the letter, which has the repulsion of Moussaid only")
