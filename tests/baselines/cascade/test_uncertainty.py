"""Covariances: the inverse Hessian of the energy, and how errors spread from pose to people."""

import numpy as np
import pytest

from tests.baselines.cascade.test_ego_motion import pose_energy, random_terms
from vbbench.geometry import FloatArray
from vbbench_baselines._core import fit_pose, localise, pose_covariance, position_covariances
from vbbench_baselines.cascade import Factors


def hessian(pose: FloatArray, terms: Factors, h: float = 1e-4) -> FloatArray:
    """Second differences [3, 3] of the energy at ``pose``."""
    steps = h * np.eye(3)

    def slope(at: FloatArray) -> FloatArray:
        return np.array([pose_energy(at + d, *terms) - pose_energy(at - d, *terms) for d in steps]) / (2 * h)

    return np.array([slope(pose + d) - slope(pose - d) for d in steps]) / (2 * h)


@pytest.mark.parametrize("seed", range(5))
def test_the_pose_covariance_inverts_the_hessian_where_residuals_vanish(seed: int) -> None:
    terms = random_terms(seed)
    pose = terms.walk
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    terms = terms._replace(expected=pose[:2] + terms.relative @ np.array(((sin, -cos), (cos, sin))))
    found = pose_covariance(pose, terms)
    np.testing.assert_allclose(np.linalg.inv(found), 0.5 * hessian(pose, terms), rtol=1e-4, atol=1e-4)


def test_covariances_are_those_of_many_draws() -> None:
    relative, covariance, _, std, pose, ego_std = random_terms(3, depth_std=0.2)
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    truth = pose[:2] + relative @ np.array(((sin, -cos), (cos, sin)))
    rng, draws = np.random.default_rng(0), 4000
    rr, rf, ff = covariance.T
    root = np.linalg.cholesky(np.stack((np.stack((rr, rf), -1), np.stack((rf, ff), -1)), -2))
    poses, places = np.empty((draws, 3)), np.empty((draws, len(std), 2))
    for n in range(draws):
        seen = relative + (root @ rng.normal(size=(len(std), 2, 1)))[..., 0]
        walked = truth + std[:, None] * rng.normal(size=truth.shape)
        walk = np.append(pose[:2] + ego_std * rng.normal(size=2), pose[2])
        drawn = Factors(seen, covariance, walked, std, walk, ego_std)
        poses[n] = fit_pose(drawn)
        places[n] = localise(poses[n], drawn)
    true = Factors(relative, covariance, truth, std, pose, ego_std)
    sigma = pose_covariance(pose, true)
    scale = np.sqrt(np.diag(sigma))
    np.testing.assert_allclose(np.cov(poses.T) / np.outer(scale, scale), sigma / np.outer(scale, scale), atol=0.1)
    found = position_covariances(pose, sigma, true)
    spread = np.einsum("nki,nkj->kij", places - truth, places - truth) / draws
    size = np.trace(found, axis1=1, axis2=2)[:, None, None]
    np.testing.assert_allclose(spread / size, found / size, atol=0.1)
