"""The floor of the joint solvers: against closed forms, and in the order that information must have."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.map_floor import Floor, floor_of, mean_distance
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench_baselines.joint_map.prior import Prior

PRIOR = Prior(nu=5.0, sigma=0.05)


@pytest.fixture(scope="module")
def datasets(tmp_path_factory) -> dict[str, Dataset]:
    room: Path = tmp_path_factory.mktemp("floor")
    return {tier: generate("sim", room / tier, Options(tier=tier, limit=2)) for tier in ("ideal", "noisy")}


def test_mean_length_of_normal_errors():
    covariance = np.array(((0.09, 0.03), (0.03, 0.04)))
    drawn = np.random.default_rng(0).multivariate_normal((0.0, 0.0), covariance, 200_000)
    assert mean_distance(covariance) == pytest.approx(np.hypot(*drawn.T).mean(), rel=0.01)
    assert mean_distance(np.eye(2)) == pytest.approx(np.sqrt(np.pi / 2.0))


def test_one_step_with_exact_boxes_is_a_rigid_fit(datasets):
    """With ranges known, everybody's innovation is one of the pose's: the information is Σ JᵀJ (ν + 2)/(ν + 4)σ²."""
    dataset = datasets["ideal"]
    sequence = dataset.sequence(0)
    truth, t = dataset.truth(sequence), 6
    prior = replace(PRIOR, yaw_scale=1e3)
    spread = Floor(prior=prior, own_scale=False).spread(dataset.problem(sequence), sequence, truth, "one-step")
    information = np.diag((1.0, 1.0, 0.0))
    for k in np.flatnonzero(sequence.observed[: t + 1].all(axis=0)):
        x, y = truth.positions[t, k] - truth.poses[t, :2]
        jacobian = np.array(((1.0, 0.0, -y), (0.0, 1.0, x)))
        information += jacobian.T @ jacobian
    assert sequence.observed[t].sum() == sequence.observed[: t + 1].all(axis=0).sum()
    information *= (PRIOR.nu + 2.0) / ((PRIOR.nu + 4.0) * PRIOR.sigma**2)
    assert spread.poses[t] == pytest.approx(np.linalg.inv(information), rel=0.02, abs=1e-8)


def test_more_information_lowers_the_floor(datasets):
    def floor(tier: str, protocol: str, **how: bool) -> np.ndarray:
        return floor_of(datasets[tier], Floor(prior=PRIOR, **how), protocol, 2).mean(axis=0)

    causal = floor("ideal", "sequential")
    assert np.all(floor("ideal", "one-step") < causal)
    assert np.all(causal <= floor("ideal", "rollout") + 1e-9)
    assert np.all(floor("ideal", "sequential", batch=True) <= causal)
    assert np.all(causal <= floor("ideal", "sequential", feet=False) + 1e-9)
    assert np.all(causal < floor("noisy", "sequential"))
