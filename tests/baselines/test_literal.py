"""vb-sf-literal against the paper's energies, written down once more without any of the solver's code."""

from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.lib.solver_runs import DT, run, see
from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray
from vbbench.registry import make_solver
from vbbench.sequence import Truth
from vbbench_baselines._core import potential
from vbbench_baselines.social_force_birdifier import LiteralBirdifier

CAMERA = PanoramaCamera()
MEAN, STD, ETA, RADIUS, LAST = 1.7, 0.07, 0.5, 1.0, 3


def crowd(seed: int) -> Truth:
    """Five people within three metres of one another, some within one, who do not walk quite straight."""
    rng = np.random.default_rng(seed)
    start = np.array(((-0.9, 5.0), (-0.4, 5.4), (0.5, 4.9), (0.9, 6.1), (0.1, 6.4)))
    velocity = np.array((0.1, 1.0)) + rng.normal(0.0, 0.2, (5, 2))
    steps = np.arange(LAST + 1)[:, None, None] * DT
    positions = start + velocity * steps + rng.normal(0.0, 0.04, (LAST + 1, 5, 2))
    poses = np.column_stack(
        (rng.normal(0.0, 0.02, LAST + 1), np.arange(LAST + 1) * DT, np.pi / 2 + rng.normal(0.0, 0.05, LAST + 1))
    )
    return Truth(poses=poses, positions=positions, heights=rng.normal(MEAN, STD, 5))


class Printed:
    """The energies of frame `LAST` as the paper prints them: people on their rays, at the height h that they have."""

    def __init__(self, truth: Truth) -> None:
        u, _, box = see(truth, CAMERA).observations[LAST].T
        azimuth = 2.0 * np.pi * u / CAMERA.width - np.pi
        self.ray = CAMERA.focal / box[:, None] * np.column_stack((np.sin(azimuth), np.cos(azimuth)))
        self.before, self.last = truth.positions[LAST - 2], truth.positions[LAST - 1]
        walkers = np.vstack((self.last, truth.poses[LAST - 1, :2]))
        velocities = np.vstack((self.last - self.before, truth.poses[LAST - 1, :2] - truth.poses[LAST - 2, :2])) / DT
        near = np.linalg.norm(self.last[:, None] - walkers[None], axis=2) < RADIUS
        self.w = np.array([velocities[row].mean(axis=0) for row in near])

    def places(self, pose: FloatArray, heights: FloatArray) -> Any:
        right, forward = (self.ray * heights[:, None]).T
        sin, cos = np.sin(pose[2]), np.cos(pose[2])
        return np.column_stack((pose[0] + right * sin + forward * cos, pose[1] - right * cos + forward * sin))

    def own(self, pose: FloatArray, heights: FloatArray) -> Any:
        """D_k − ln p(h_k) of each person."""
        x = self.places(pose, heights)
        force = (self.w - (x - self.last) / DT) / ETA
        acceleration = (x - 2.0 * self.last + self.before) / DT**2
        return np.linalg.norm(force - acceleration, axis=1) + 0.5 * ((heights - MEAN) / STD) ** 2

    def first(self, pose: FloatArray) -> float:
        """The first stage's energy, over heights as they suit each person best: each term is convex in its own."""
        low, high = np.full(len(self.ray), 1.2), np.full(len(self.ray), 2.2)
        for _ in range(60):
            third = (high - low) / 3.0
            rises = self.own(pose, low + third) < self.own(pose, high - third)
            low, high = np.where(rises, low, low + third), np.where(rises, high - third, high)
        return float(np.sum(self.own(pose, low)))

    def second(self, pose: FloatArray, heights: FloatArray) -> float:
        """The second stage's: with V_ik = ‖∇ exp(−d²/2)/√(2π)‖ of all pairs."""
        x = self.places(pose, heights)
        apart = np.array([np.linalg.norm(x[i] - x[k]) for i, k in combinations(range(len(x)), 2)])
        return float(np.sum(self.own(pose, heights)) + np.sum(apart * np.exp(-0.5 * apart**2)) / np.sqrt(2.0 * np.pi))


def test_it_is_registered_and_takes_every_departure_back() -> None:
    solver = make_solver("vb-sf-literal")
    assert isinstance(solver, LiteralBirdifier)
    assert not solver.calibrate
    assert not solver.ego_prior


@pytest.mark.parametrize("d", [0.2, 1.0, 2.3])
def test_its_potential_is_the_slope_of_a_normal_density(d: float) -> None:
    density = [np.exp(-0.5 * (d + side) ** 2) / np.sqrt(2.0 * np.pi) for side in (-1e-6, 1e-6)]
    solver = LiteralBirdifier()
    run(solver, crowd(0), "one-step")
    weight = solver.strength / solver.acceleration_std
    assert weight * potential(d * d, solver.sigma) == pytest.approx((density[0] - density[1]) / 2e-6, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_the_pose_has_the_least_printed_energy(seed: int) -> None:
    truth = crowd(seed)
    printed, pose = Printed(truth), run(LiteralBirdifier(), truth, "one-step").poses[LAST]
    found = printed.first(pose)
    rng = np.random.default_rng(seed)
    for size in (1e-3, 1e-2, 1e-1):
        for _ in range(3):
            assert printed.first(pose + rng.normal(0.0, size, 3)) > found - 1e-4
    best: Any = minimize(printed.first, truth.poses[LAST], method="Nelder-Mead", options={"maxfev": 150})
    assert found < best.fun + 1e-3


@pytest.mark.parametrize("seed", range(1))
def test_people_have_the_least_printed_energy_given_the_pose(seed: int) -> None:
    truth = crowd(seed)
    estimate = run(LiteralBirdifier(), truth, "one-step")
    printed, pose = Printed(truth), estimate.poses[LAST]
    unit = printed.places(pose, np.ones(5)) - pose[:2]
    heights = np.sum((estimate.positions[LAST] - pose[:2]) * unit, axis=1) / np.sum(unit**2, axis=1)
    np.testing.assert_allclose(printed.places(pose, heights), estimate.positions[LAST], atol=1e-9)
    found = printed.second(pose, heights)
    rng = np.random.default_rng(seed)
    for start in (np.full(5, MEAN), truth.heights, *rng.normal(MEAN, STD, (2, 5))):
        best: Any = minimize(partial(printed.second, pose), start, method="Nelder-Mead", options={"maxiter": 600})
        assert found < best.fun + 2e-3
