"""Terms of the cascade's energy, drawn at random, and the energy of a pose written out."""

from typing import Any

import numpy as np

from vbbench.geometry import FloatArray, relative_to_world, world_to_relative
from vbbench_baselines.cascade import Factors


def random_terms(seed: int, people: int = 5, depth_std: float = 1.0) -> Factors:
    rng = np.random.default_rng(seed)
    pose = np.append(rng.normal(0, 3, 2), rng.uniform(-3, 3))
    relative = rng.normal(0, 5, (people, 2))
    axes = rng.normal(0, depth_std, (people, 2, 2))
    covariance = (axes @ axes.transpose(0, 2, 1)).reshape(people, 4)[:, [0, 1, 3]]
    expected = relative_to_world(relative, pose) + rng.normal(0, 0.3, (people, 2))
    std = rng.uniform(0.05, 0.3, people)
    return Factors(relative, np.ascontiguousarray(covariance), expected, std, pose + rng.normal(0, 0.3, 3), 0.1)


def matrices(covariance: FloatArray) -> FloatArray:
    """[K, 2, 2] of the rows (rr, rf, ff) [K, 3]."""
    return covariance[:, [[0, 1], [1, 2]]]


def pose_energy(pose: FloatArray, *terms: Any) -> float:
    """E(c, R) of ``ego_motion.hpp``."""
    relative, covariance, expected, std, predicted, ego_std = terms
    off = relative - world_to_relative(expected, pose)
    weights = np.linalg.inv(matrices(covariance) + std[:, None, None] ** 2 * np.eye(2))
    walked = np.sum((pose[:2] - predicted[:2]) ** 2) / ego_std**2
    return float(walked + np.einsum("ki,kij,kj->", off, weights, off))
