"""Densities on a grid: entropies, marginals and tails against closed forms and independent sums."""

import numpy as np
import pytest

from vbbench.geometry import FloatArray
from vbbench.reproduction.density import find_density
from vbbench.reproduction.posterior import one_turn

MEAN = np.array([3.0, -2.0, 0.4])
FACTOR = np.array([[0.3, 0.0, 0.0], [0.28, 0.02, 0.0], [-0.1, 0.05, 0.01]])
COVARIANCE = FACTOR @ FACTOR.T
"""Narrow and slanted."""


def entropy_of_normal(covariance: FloatArray) -> float:
    return float(0.5 * np.log(np.linalg.det(2.0 * np.pi * np.e * covariance)))


def normal(points: FloatArray) -> FloatArray:
    off = np.linalg.solve(FACTOR, (points - MEAN).T)
    return 0.5 * np.asarray((off**2).sum(axis=0))


def bent(points: FloatArray) -> FloatArray:
    """Heavy tails, and a ridge that curves with the third coordinate."""
    x, y, yaw = points.T
    return np.sqrt(1.0 + 40.0 * (x - 0.3 * np.sin(3.0 * yaw)) ** 2) + 3.0 * np.hypot(y, 0.1) + 8.0 * (yaw - 0.2) ** 2


@pytest.mark.parametrize("guess", [0.01, 1.0, 50.0])
def test_a_normal_density_has_its_closed_form_whatever_the_guess(guess: float) -> None:
    found = find_density(normal, MEAN + 0.01, guess * COVARIANCE)
    assert found.mass.sum() == pytest.approx(1.0)
    assert found.entropy == pytest.approx(entropy_of_normal(COVARIANCE), abs=1e-3)
    mean, covariance = found.moments()
    np.testing.assert_allclose(mean, MEAN, atol=1e-4)
    np.testing.assert_allclose(covariance, COVARIANCE, rtol=2e-3)
    place = found.marginal().finer()
    assert place.entropy == pytest.approx(entropy_of_normal(COVARIANCE[:2, :2]), abs=1e-3)
    beyond, kurtosis = place.tails()
    assert beyond == pytest.approx(np.exp(-4.5), abs=5e-4)
    assert kurtosis == pytest.approx(0.0, abs=0.01)


def test_a_density_with_exponential_tails_has_its_entropy_and_heavier_tails() -> None:
    found = find_density(lambda points: np.hypot(*points.T), np.array([0.01, 0.0]), np.eye(2), points=81)
    assert found.entropy == pytest.approx(np.log(2.0 * np.pi) + 2.0, abs=0.01)  # exp(−r)/2π: mean of r is 2
    beyond, kurtosis = found.tails()
    exact = 120.0 / 9.0 - 8.0  # E r⁴ = 5!, and 3 is the variance
    assert 0.9 * exact < kurtosis < exact  # beyond six standard deviations nothing counts
    reach = 3.0 * np.sqrt(3.0)
    assert beyond == pytest.approx((1.0 + reach) * np.exp(-reach), abs=2e-3)


def test_the_marginal_of_the_place_is_an_independent_integral_over_the_yaw() -> None:
    found = find_density(bent, np.array([0.17, 0.0, 0.2]), np.diag([0.1, 0.2, 0.06]), points=41)
    place = found.marginal()
    yaws = np.linspace(-2.0, 2.4, 2001)
    points, density = place.points()[::5, ::5].reshape(-1, 2), place.mass[::5, ::5].ravel()
    integral = np.array(
        [np.trapezoid(np.exp(-bent(np.column_stack([np.tile(p, (len(yaws), 1)), yaws]))), yaws) for p in points]
    )
    inner = density > 1e-3 * density.max()
    ratio = density[inner] / integral[inner]
    assert inner.sum() > 10
    np.testing.assert_allclose(ratio, ratio.mean(), rtol=2e-3)


def test_a_yaw_that_is_open_is_spread_over_one_turn() -> None:
    def ring(points: FloatArray) -> FloatArray:
        return np.asarray(0.5 * (points[:, :2] ** 2).sum(axis=1))

    found = find_density(one_turn(ring, 0.4), np.array([0.0, 0.0, 0.4]), np.eye(3), points=61)
    _, covariance = found.moments()
    assert np.sqrt(covariance[2, 2]) == pytest.approx(np.pi / np.sqrt(3.0), rel=0.1)
    expected = entropy_of_normal(np.eye(2)) + np.log(2.0 * np.pi)
    assert found.entropy == pytest.approx(expected, abs=0.1)


def test_contours_of_a_normal_density_hold_their_share() -> None:
    place = find_density(normal, MEAN, COVARIANCE).marginal().finer()
    for share in (0.5, 0.95):
        assert place.level(share) == pytest.approx((1.0 - share) * place.mass.max(), rel=0.03)  # p = 1 − exp(−r²/2)
