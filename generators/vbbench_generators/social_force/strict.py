"""The repulsion of pysocialforce 1.1.2 as it is: the angle is the plain difference of two atan2, which may pass π.

Each ordered pair is computed by itself. This is slower than `moussaid`, and paths depend on how the world is turned; it
exists to compare with the library.
"""

import math

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_generators.social_force.layout import VX, VY, X, Y


@kernel
def strict_rows(people: FloatArray, first: int, stride: int, numbers: FloatArray, forces: FloatArray) -> None:
    """Add the force (m/s²) of everybody on i to ``forces`` [2, K], for i = first, first + stride, ..."""
    for i in range(first, people.shape[1], stride):
        for j in range(people.shape[1]):
            if j != i:
                fx, fy = _strict_pair(people, i, j, numbers)
                forces[0, i] += fx
                forces[1, i] += fy


@kernel
def _strict_pair(people: FloatArray, i: int, j: int, numbers: FloatArray) -> tuple[float, float]:
    """Force (m/s²) of j on i; none where the library gets 0/0, of people with the same place and velocity."""
    settings = numbers[0]
    ex, ey, distance = _direction(people[X, i] - people[X, j], people[Y, i] - people[Y, j])
    tx, ty, length = _direction(
        settings.velocity_weight * (people[VX, j] - people[VX, i]) + ex,
        settings.velocity_weight * (people[VY, j] - people[VY, i]) + ey,
    )
    if length == 0.0:
        return 0.0, 0.0
    scale = settings.reach * length
    angle = math.atan2(ty, tx) - math.atan2(ey, ex)
    ahead = math.exp(-distance / scale - (settings.brake_sharpness * scale * angle) ** 2)
    aside = math.exp(-distance / scale - (settings.side_sharpness * scale * angle) ** 2)
    aside = math.copysign(aside, angle) if angle != 0.0 else 0.0
    return settings.factor * (ahead * tx + aside * ty), settings.factor * (ahead * ty - aside * tx)


@kernel
def _direction(x: float, y: float) -> tuple[float, float, float]:
    """Unit vector and length; zeros stay zeros."""
    length = math.sqrt(x * x + y * y)
    return (x / length, y / length, length) if length > 0.0 else (0.0, 0.0, 0.0)
