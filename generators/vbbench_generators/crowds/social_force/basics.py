"""What all kernels share: rows of plain arrays that are a crowd, one record of numbers that is a model, and functions.

Exponential and arc tangent are made of additions and multiplications, so that loops over them are vectorised.
Polynomials are written in pairs of terms, which the processor computes at the same time. Calls of the C library would
keep loops scalar, and its last digits differ between machines.
"""

import numpy as np

from vbbench.kernels import kernel

X, Y, VX, VY, TARGET_X, TARGET_Y, TARGET_DISTANCE = range(7)
"""Rows of ``people`` [7, K]: place (m), velocity (m/s), unit vector to the current goal, distance (m) from it."""

PEOPLE_ROWS = 7

PAIRS = 1024
"""Pairs whose forces are computed at a time: few enough for the processor's first cache."""

NUMBERS = """
    desired_factor relaxation_time top_speed arrival_radius factor velocity_weight reach side_sharpness
    brake_sharpness fall_off stride_time view_cosine unseen_weight wall_factor wall_fall_off wall_reach body_radius
    cohesion gaze separation personal_space
"""
"""Names of a model's numbers; lengths are in m, times in s."""
SETTINGS = np.dtype([("kind", np.int64), *((name, np.float64) for name in NUMBERS.split())])
"""A `Model` as kernels read it."""

MOUSSAID, HELBING_MOLNAR, PYSOCIALFORCE = range(3)
"""The kinds of repulsion."""


TINY = 1e-60
"""Stands in for a length of zero in m where something is divided by it; its cube is still a number."""

UNDERFLOW = -32.0
"""Exponents below it are raised to it: exp(-32) is 1e-14."""


@kernel
def exp_negative(x: float) -> float:
    """exp(x) of x ≤ 0 to within 5e-13: Taylor's series of exp(x/256), squared eight times."""
    y = (x if x > UNDERFLOW else UNDERFLOW) * (1.0 / 256.0)
    z = y * y
    e = (1.0 + y) + z * ((0.5 + y * (1.0 / 6.0)) + z * (1.0 / 24.0 + y * (1.0 / 120.0)))
    e *= e
    e *= e
    e *= e
    e *= e
    e *= e
    e *= e
    e *= e
    e *= e
    return e


@kernel
def atan_unit(r: float) -> float:
    """atan(r) of 0 ≤ r ≤ 1 to within 6e-12: atan(r)/r interpolated in r² at Chebyshev's points, degree 12."""
    u = r * r
    v = u * u
    w = v * v
    low = (0.999999999988737 - u * 0.33333332951665584) + v * (0.19999978337002625 - u * 0.1428522562534094)
    mid = (0.11105306907877154 - u * 0.09049180114773321) + v * (0.07495266091119122 - u * 0.06022205218890623)
    top = (0.043646729133535726 - u * 0.02600614172204219) + v * (0.011427729645781124 - u * 0.003195461834616629)
    return r * ((low + w * mid) + w * w * (top + w * 0.00041923393867625194))
