"""The functions of cpp/elementary.hpp against wider numbers, at special values, and in bits."""

import hashlib
from itertools import product
from math import copysign, inf, nan, pi

import numpy as np
import pytest
from numpy.typing import NDArray

from vbbench.errors import VbbenchError
from vbbench_generators._core import elementary

COUNT = 200_000
ENOUGH = 2.5
"""In units in the last place; most functions err by less than 1."""
SPECIAL = (0.0, -0.0, 1.0, -1.0, inf, -inf, nan, 5e-324, -5e-324, 1e-310, 1e300, -1e300, 710.0, -746.0)
WIDER = np.finfo(np.longdouble).nmant > np.finfo(np.float64).nmant


def spread(low: float, high: float) -> NDArray[np.float64]:
    """Numbers evenly spread, drawn once and for all."""
    return np.random.default_rng(0).uniform(low, high, COUNT)


def powers(low: float, high: float) -> NDArray[np.float64]:
    """Positive numbers of evenly spread exponents of 2."""
    return np.exp2(spread(low, high))


def signed(low: float, high: float) -> NDArray[np.float64]:
    """Numbers of evenly spread exponents of 2 and either sign."""
    return np.random.default_rng(1).choice([-1.0, 1.0], COUNT) * powers(low, high)


def turns() -> NDArray[np.float64]:
    """The numbers nearest to multiples of a quarter turn."""
    return np.arange(-100_000.0, 100_000.0) * (0.5 * pi)


@pytest.mark.skipif(not WIDER, reason="needs floating-point numbers of more bits")
@pytest.mark.parametrize(
    ("name", "x"),
    [
        ("exp", spread(-708.0, 709.7)),
        ("exp", spread(-1.0, 1.0)),
        ("exp", -powers(-60.0, 0.0)),
        ("log", powers(-1020.0, 1023.0)),
        ("log", spread(0.4, 2.1)),
        ("log1p", powers(-300.0, 300.0)),
        ("log1p", spread(-0.99, 1.0)),
        ("sin", spread(-8.0, 8.0)),
        ("sin", spread(-1e6, 1e6)),
        ("sin", powers(-300.0, 3.0)),
        ("sin", turns()),
        ("cos", spread(-8.0, 8.0)),
        ("cos", turns()),
        ("arctan2", signed(-3.0, 3.0)),
        ("arctan2", signed(-400.0, 400.0)),
    ],
)
def test_errors_are_within_the_last_places(name: str, x: NDArray[np.float64]) -> None:
    """Of `arctan2` by the numbers in turn."""
    *of, last = (x[0::2].copy(), x[1::2].copy()) if name == "arctan2" else (x,)
    exact = getattr(np, name)(*(values.astype(np.longdouble) for values in (*of, last)))
    found = elementary("atan2" if of else name, of[0] if of else last, last)
    off = np.abs(found - exact) / np.spacing(np.abs(exact.astype(np.float64)))
    assert off.max() < ENOUGH


@pytest.mark.parametrize("name", ["exp", "log", "log1p", "sin", "cos"])
def test_special_values_are_those_of_the_standard(name: str) -> None:
    x = np.array(SPECIAL)
    with np.errstate(all="ignore"):
        wanted = getattr(np, name)(x)
    near = np.abs(x) < 1e299 if name in ("sin", "cos") else np.full(len(x), True)
    assert_same(elementary(name, x, x)[near], wanted[near])


def test_directions_along_axes_are_those_of_the_standard() -> None:
    y, x = np.ascontiguousarray(np.transpose(list(product(SPECIAL, SPECIAL))))
    assert_same(elementary("atan2", y, x), np.arctan2(y, x))


def assert_same(found: NDArray[np.float64], wanted: NDArray[np.float64]) -> None:
    """Equal to the last places, with their signs."""
    np.testing.assert_allclose(found, wanted, rtol=5e-16, atol=0.0)
    known = ~np.isnan(wanted)
    assert [copysign(1.0, value) for value in found[known]] == [copysign(1.0, value) for value in wanted[known]]


def test_far_angles_are_those_of_a_number_within_half_an_ulp() -> None:
    x = powers(21.0, 60.0)
    with np.errstate(all="ignore"):
        off = np.abs(elementary("sin", x, x) - np.sin(x))
    assert np.all(off <= 0.51 * np.spacing(x) + 1e-15)


def test_answers_are_the_same_bits_everywhere() -> None:
    x = np.linspace(-30.0, 30.0, 10_001)
    numbers = {name: np.abs(x) if name in ("log", "log1p") else x for name in NAMES}
    found = b"".join(elementary(name, numbers[name], x[::-1].copy()).tobytes() for name in NAMES)
    assert hashlib.sha256(found).hexdigest() == BITS


NAMES = ("exp", "log", "log1p", "sin", "cos", "atan2")
BITS = "4c5832aebd30bf137bc73beb5d2e6fd14040923f5b3a83682d7a573d693d02fd"


def test_a_function_that_is_unknown_is_refused() -> None:
    with pytest.raises(VbbenchError, match="sinus"):
        elementary("sinus", np.zeros(1), np.zeros(1))
