"""vb-sf: robust, on the rays, and open about what it did; vb-sf-literal against the paper's energies."""

from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.lib.solver_runs import DT, pairs, run, see, walk
from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.registry import make_solver
from vbbench.sequence import Truth
from vbbench_baselines._core import potential
from vbbench_baselines.social_force_birdifier import LiteralBirdifier, SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier


def test_one_stray_walker_does_not_bend_the_pose() -> None:
    truth = pairs(4)
    positions = truth.positions.copy()
    positions[4, 0] += (0.0, 2.0)
    estimate = run(SocialForceBirdifier(ego_prior=False), replace(truth, positions=positions), "one-step")
    squared = run(ConstantVelocityBirdifier(ego_prior=False), replace(truth, positions=positions), "one-step")
    error, bent = (np.linalg.norm(e.poses[4, :2] - truth.poses[4, :2]) for e in (estimate, squared))
    assert error < 0.3 * bent


def test_people_of_known_height_stay_on_their_rays_whatever_the_force() -> None:
    truth = walk(5, wobble=0.05)
    weak, strong = (run(SocialForceBirdifier(strength=s), truth, "one-step") for s in (0.0, 50.0))
    np.testing.assert_allclose(weak.positions[2:], strong.positions[2:], atol=1e-6)


def test_unknown_heights_are_found_on_the_rays() -> None:
    truth = pairs(6)
    estimate = run(SocialForceBirdifier(calibrate=False), truth, "one-step")
    right, forward = np.moveaxis(world_to_relative(estimate.positions, estimate.poses)[2:], -1, 0)
    seen = world_to_relative(truth.positions, truth.poses)[2:]
    np.testing.assert_allclose(np.arctan2(right, forward), np.arctan2(seen[..., 0], seen[..., 1]), atol=1e-6)
    mean = seen * (1.7 / truth.heights)[:, None]
    taken, found = (np.linalg.norm(z - seen, axis=-1).mean() for z in (mean, np.stack((right, forward), axis=-1)))
    assert found < 0.7 * taken


@pytest.mark.parametrize(("people", "fallback"), [(0, True), (1, True), (2, False)])
@pytest.mark.parametrize("solver", [ConstantVelocityBirdifier, SocialForceBirdifier])
def test_too_few_people_are_reported(solver: type[Any], people: int, fallback: bool) -> None:
    estimate = run(solver(), walk(8, people=people), "one-step")
    np.testing.assert_array_equal(estimate.fallback[2:], fallback)


def test_beyond_the_limit_the_rest_do_not_decide() -> None:
    truth = walk(3, people=12)
    solver = SocialForceBirdifier(most_people=5)
    before = run(solver, truth, "one-step")
    far = np.argsort(np.linalg.norm(truth.positions[5] - truth.poses[5, :2], axis=1))[-3:]
    moved = truth.positions.copy()
    moved[5, far] += 0.5
    after = run(solver, replace(truth, positions=moved), "one-step")
    np.testing.assert_allclose(after.poses[5], before.poses[5], atol=1e-9)
    assert np.isfinite(after.positions[5]).all()


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_beyond_its_limit_fewer_interact_and_everybody_decides(noise: float) -> None:
    truth = walk(3, people=12)
    whole = run(SocialForceBirdifier(), truth, "one-step", None, noise, covariances=True)
    few = run(SocialForceBirdifier(most_interacting=5), truth, "one-step", None, noise, covariances=True)
    np.testing.assert_array_equal(few.poses, whole.poses)
    np.testing.assert_array_equal(few.pose_covariances, whole.pose_covariances)
    np.testing.assert_allclose(few.positions, whole.positions, atol=0.1)
    assert np.array_equal(np.isnan(few.positions), np.isnan(whole.positions))


def test_heights_and_covariances_are_reported() -> None:
    estimate = run(SocialForceBirdifier(), pairs(1), "one-step", None, 1.0, covariances=True)
    np.testing.assert_allclose(estimate.heights, pairs(1).heights, atol=0.05)
    assert np.all(np.linalg.eigvalsh(estimate.pose_covariances[2:]) > 0)
    assert np.all(np.linalg.eigvalsh(estimate.position_covariances[2:]) > 0)
    assert run(SocialForceBirdifier(), pairs(1), "one-step").pose_covariances is None


# The paper's text, written down once more without any of the solver's code

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
def test_its_potential_is_the_gradient_of_a_normal_density(d: float) -> None:
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
