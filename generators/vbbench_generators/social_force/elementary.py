"""Exponential and arc tangent out of additions and multiplications, so that loops over them are vectorised.

Calls of the C library would keep loops scalar, and its last digits differ between machines.
"""

from vbbench_generators.social_force.compiled import kernel

TINY = 1e-200
"""Stands in for zero where something is divided by a length."""

UNDERFLOW = -32.0
"""Exponents below it are raised to it: exp(-32) is 1e-14."""


@kernel
def exp_negative(x: float) -> float:
    """exp(x) of x ≤ 0 to within 1e-14: Taylor's series of exp(x/256), squared eight times."""
    y = (x if x > UNDERFLOW else UNDERFLOW) * (1.0 / 256.0)
    e = 1.0 / 720.0 + y * (1.0 / 5040.0)
    e = 1.0 / 24.0 + y * (1.0 / 120.0 + y * e)
    e = 1.0 + y * (1.0 + y * (0.5 + y * (1.0 / 6.0 + y * e)))
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
    p = -0.003195461834616629 + u * 0.00041923393867625194
    p = -0.02600614172204219 + u * (0.011427729645781124 + u * p)
    p = -0.06022205218890623 + u * (0.043646729133535726 + u * p)
    p = -0.09049180114773321 + u * (0.07495266091119122 + u * p)
    p = -0.1428522562534094 + u * (0.11105306907877154 + u * p)
    p = -0.33333332951665584 + u * (0.19999978337002625 + u * p)
    return r * (0.999999999988737 + u * p)
