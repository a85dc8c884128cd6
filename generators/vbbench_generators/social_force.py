"""Simulation of crowds by social force."""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray, freeze, frozen_array
from vbbench.parsing.numbers import Checked, Within
from vbbench_generators import _core

__all__ = ["Crowd", "Model", "Moussaid", "WallForce", "simulate"]


@dataclass(frozen=True, kw_only=True)
class Crowd:
    """The initial state of one crowd.

    Raises ValueError if a shape does not fit, a number is not finite, a speed is negative or there is no goal.

    Parameters
    ----------
    positions : [K, 2] in m.
    velocities : [K, 2] in m/s.
    speeds : [K] desired speeds in m/s.
    goals : [K, G, 2] in m, the goals of each person in turn; people stay at the last one.
    """

    positions: FloatArray
    velocities: FloatArray
    speeds: FloatArray
    goals: FloatArray

    def __post_init__(self) -> None:
        people = len(np.atleast_1d(self.positions))
        freeze(self, positions=(people, 2), velocities=(people, 2), speeds=(people,), goals=(people, None, 2))
        for name, values in vars(self).items():
            if not np.all(np.isfinite(values)):
                raise ValueError(f"{name} must be finite; they hold NaN or infinity")
        if np.any(self.speeds < 0):
            raise ValueError("speeds must not be negative")
        if self.goals.shape[1] == 0:
            raise ValueError("goals must have shape [K, G, 2] with G of at least 1: each person needs a goal")

    @property
    def people(self) -> int:
        """Number of people K."""
        return len(self.positions)


STOP_RADIUS = 0.5
"""Distance in m from the last goal at which a person stands still, as in pysocialforce."""
_LARGEST = 1e300
Positive = Annotated[float, Within(1e-300, _LARGEST)]
NotNegative = Annotated[float, Within(0.0, _LARGEST)]


@dataclass(frozen=True, kw_only=True)
class Moussaid(Checked):
    """Repulsion of Moussaïd et al., Proc. R. Soc. B 276 (2009) 2755; defaults of pysocialforce.

    Parameters
    ----------
    factor : strength A in m/s².
    velocity_weight : λ in s/m, weight of the relative velocity in the interaction vector.
    reach : γ in m, range of the force for an interaction vector of length 1.
    side_sharpness, brake_sharpness : n and n', the decay of evasion and braking with the angle.
    """

    factor: NotNegative = 5.1
    velocity_weight: NotNegative = 2.0
    reach: Positive = 0.35
    side_sharpness: NotNegative = 2.0
    brake_sharpness: NotNegative = 3.0


@dataclass(frozen=True, kw_only=True)
class WallForce(Checked):
    """Repulsion of walls, as in pysocialforce: lines are sampled at 10 points per metre, each of which repels.

    Parameters
    ----------
    factor : strength in m/s².
    fall_off : decay length of the force in m.
    reach : distance in m from the body's rim beyond which there is no force.
    body_radius : radius of a body in m.
    """

    factor: NotNegative = 10.0
    fall_off: Positive = 0.2
    reach: Positive = 3.35
    body_radius: NotNegative = 0.35


@dataclass(frozen=True, kw_only=True)
class Model(Checked):
    """The forces of a crowd.

    Parameters
    ----------
    repulsion : repulsion between people.
    walls : repulsion of walls.
    relaxation_time : τ in s, within which the desired velocity is regained.
    top_speed : maximum speed, relative to the desired speed.
    arrival_radius : distance in m from a goal at which a person turns to the next one; at least 0.5.
    """

    repulsion: Moussaid = field(default_factory=Moussaid)
    walls: WallForce = field(default_factory=WallForce)
    relaxation_time: Positive = 0.5
    top_speed: Annotated[float, Within(1.0, _LARGEST)] = 1.3
    arrival_radius: Annotated[float, Within(STOP_RADIUS, _LARGEST)] = 1.0


NO_WALLS: tuple[tuple[float, float, float, float], ...] = ()


def simulate(
    crowd: Crowd, model: Model, *, frames: int, dt: float, substeps: int, walls: ArrayLike = NO_WALLS
) -> FloatArray:
    """Simulate one crowd.

    Raises ValueError if a number is out of range.

    Parameters
    ----------
    crowd, model : the people at the start, and the forces that move them.
    frames : number of frames T; the first one is the start.
    dt : seconds per frame.
    substeps : integration steps per frame.
    walls : [M, 4] line segments x0, y0, x1, y1 in m.

    Returns
    -------
    [T, K, 2] positions in m.
    """
    if frames < 1 or substeps < 1:
        raise ValueError(f"frames and substeps must be at least 1, not {frames} and {substeps}")
    if not (np.isfinite(dt) and dt > 0):
        raise ValueError(f"dt must be a positive number of seconds, not {dt}")
    segments = np.asarray(walls, dtype=np.float64)
    segments = frozen_array("walls", segments if segments.size else np.empty((0, 4)), (None, 4))
    if not np.all(np.isfinite(segments)):
        raise ValueError("walls must be finite; they hold NaN or infinity")
    paths: FloatArray = np.empty((frames, crowd.people, 2))
    numbers = {f"wall_{name}": number for name, number in vars(model.walls).items()}
    numbers |= {"body_radius": model.walls.body_radius, "stop_radius": STOP_RADIUS}
    _core.march(
        states=np.ascontiguousarray(np.column_stack((crowd.positions, crowd.velocities)).T),
        speeds=crowd.speeds,
        goals=crowd.goals,
        walls=segments,
        numbers={**vars(model), **vars(model.repulsion), **numbers},
        dt=float(dt),
        substeps=int(substeps),
        paths=paths,
    )
    return paths
