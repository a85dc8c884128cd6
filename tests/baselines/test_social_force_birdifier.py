"""vb-sf: exact on exact data, robust, on the rays, and open about what it did."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, DT, assert_close, run, walk
from vbbench.camera import Camera
from vbbench.geometry import world_to_relative
from vbbench.protocol import PROTOCOLS, get_protocol
from vbbench.sequence import Truth
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier


def pairs(seed: int, frames: int = 8) -> Truth:
    """Walkers more than a metre apart, at constant velocity but for two who walk together exactly alike."""
    rng = np.random.default_rng(seed)
    start = np.array(((-5.0, 8), (-3, 11), (0, 9), (0.5, 9.3), (3, 10), (5, 8)))
    velocity = np.array((0.0, 1.0)) + rng.uniform(-0.2, 0.2, (6, 2))
    velocity[3] = velocity[2]
    positions = start + velocity * np.arange(frames)[:, None, None] * DT
    yaw = np.pi / 2 + np.cumsum(rng.normal(0.0, 0.03, frames))
    poses = np.column_stack((np.zeros(frames), np.arange(frames) * DT, yaw))
    return Truth(poses=poses, positions=positions, heights=np.clip(rng.normal(1.7, 0.07, 6), 1.45, 1.95))


@pytest.mark.parametrize("ego_prior", [True, False])
@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
@pytest.mark.parametrize("protocol", [name for name in PROTOCOLS if get_protocol(name).given != "origin"])
def test_exact_data_give_the_truth(protocol: str, camera: Camera, ego_prior: bool) -> None:
    truth = pairs(0)
    estimate = run(SocialForceBirdifier(ego_prior=ego_prior), truth, protocol, camera)
    assert_close(estimate, truth.poses, truth.positions, 1e-5)


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
