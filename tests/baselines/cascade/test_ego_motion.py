"""The plain fit of the pose: the least of its energy, found exactly; and people placed from it."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from vbbench.geometry import FloatArray, relative_to_world, world_to_relative, wrap_angle
from vbbench_baselines._core import fit_pose, localise
from vbbench_baselines.cascade import Factors


def pose_energy(pose: FloatArray, *terms: Any) -> float:
    """E(c, R) of ``ego_motion.hpp``, person by person."""
    relative, covariance, expected, std, predicted, ego_std = terms
    total = float(np.sum((pose[:2] - predicted[:2]) ** 2)) / ego_std**2
    residuals = relative - world_to_relative(expected, pose)
    for r, (rr, rf, ff), s in zip(residuals, covariance, std, strict=True):
        total += float(r @ np.linalg.inv(np.array(((rr + s * s, rf), (rf, ff + s * s)))) @ r)
    return float(total)


def random_terms(seed: int, people: int = 5, depth_std: float = 1.0) -> Factors:
    rng = np.random.default_rng(seed)
    pose = np.append(rng.normal(0, 3, 2), rng.uniform(-3, 3))
    relative = rng.normal(0, 5, (people, 2))
    axes = rng.normal(0, depth_std, (people, 2, 2))
    spread = axes @ axes.transpose(0, 2, 1)
    covariance = np.stack((spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]), axis=1)
    expected = relative_to_world(relative, pose) + rng.normal(0, 0.3, (people, 2))
    return Factors(relative, covariance, expected, rng.uniform(0.05, 0.3, people), pose + rng.normal(0, 0.3, 3), 0.1)


@pytest.mark.parametrize("seed", range(4))
def test_the_pose_is_the_least_that_scipy_finds(seed: int) -> None:
    terms = random_terms(seed)
    pose = fit_pose(terms)
    starts = [np.append(terms.walk[:2], yaw) for yaw in np.linspace(-np.pi, np.pi, 6)]
    best = min((minimize(pose_energy, start, terms, options={"gtol": 1e-9}) for start in starts), key=lambda r: r.fun)
    assert pose_energy(pose, *terms) <= best.fun + 1e-9
    np.testing.assert_allclose(
        np.append(pose[:2], wrap_angle(pose[2] - best.x[2])), np.append(best.x[:2], 0), atol=1e-5
    )


def test_with_exact_heights_the_fit_is_the_closed_rigid_one() -> None:
    terms = random_terms(1)._replace(covariance=np.zeros((5, 3)), walk_std=np.inf)
    relative, _, expected, std, _, _ = terms
    pose = fit_pose(terms)
    weight = std**-2 / np.sum(std**-2)
    a, b = relative - weight @ relative, expected - weight @ expected
    # world = (right sin + forward cos, forward sin − right cos) = Rot(yaw) (forward, −right)
    a = np.column_stack((a[:, 1], -a[:, 0]))
    yaw = np.arctan2(weight @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), weight @ np.sum(a * b, axis=1))
    assert pose[2] == pytest.approx(yaw, abs=1e-6)


@pytest.mark.parametrize("seed", range(10))
def test_the_yaw_is_the_least_of_the_circle(seed: int) -> None:
    """Of an observer whose place is known, among people who contradict one another."""
    terms = random_terms(seed, people=3, depth_std=3.0)
    relative = terms.relative + np.random.default_rng(seed).normal(0.0, 3.0, (3, 2))
    terms = terms._replace(relative=relative, walk_std=1e-8)
    rr, rf, ff = (terms.covariance + np.outer(terms.std**2, (1.0, 0.0, 1.0))).T
    weights = np.linalg.inv(np.stack((np.stack((rr, rf), -1), np.stack((rf, ff), -1)), -2))

    def energy(yaws: FloatArray) -> FloatArray:
        poses = np.column_stack((np.tile(terms.walk[:2], (len(yaws), 1)), yaws))
        off = relative - world_to_relative(np.tile(terms.expected, (len(yaws), 1, 1)), poses)
        return np.asarray(np.einsum("nki,kij,nkj->n", off, weights, off))

    least = energy(fit_pose(terms, 0.0)[2:])[0]
    assert least <= energy(np.linspace(-np.pi, np.pi, 20_001)).min() * (1.0 + 1e-6)


def test_a_person_stands_between_measurement_and_expectation() -> None:
    terms = random_terms(7)
    relative, covariance, expected, std, pose, _ = terms
    found = world_to_relative(localise(pose, terms), pose)
    for x, z, e, (rr, rf, ff), s in zip(
        found, relative, world_to_relative(expected, pose), covariance, std, strict=True
    ):
        information = np.linalg.inv(np.array(((rr, rf), (rf, ff))))
        np.testing.assert_allclose(x, np.linalg.solve(information + np.eye(2) / s**2, information @ z + e / s**2))
