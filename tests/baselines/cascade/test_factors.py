"""The terms of a frame: what boxes measure of places and heights, and the social force on walks."""

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, see, walk
from vbbench.camera import Camera, PerspectiveCamera
from vbbench.sequence import Given
from vbbench_baselines._core import measure
from vbbench_baselines.cascade import Heights
from vbbench_baselines.common.bearings import sight
from vbbench_baselines.common.motion import History
from vbbench_baselines.motion_models import SocialForceWalk, Walkers


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
def test_the_covariance_of_a_measurement_is_that_of_samples(camera: Camera) -> None:
    rng = np.random.default_rng(0)
    heights = np.full(40_000, 1.7) + rng.normal(0, 0.05, 40_000)
    exact = camera.project(np.array((2.0, 5.0)), np.array(1.7))
    boxes = exact + rng.normal(0, 1.0, (40_000, 3)) * (1.0, 1.0, np.sqrt(2.0))
    _, (n, *_) = measure(sight(camera, exact[None], 1.0), np.array([1.7]), np.array([0.05**2]))
    sampled = np.cov(camera.unproject(boxes, heights).T)
    np.testing.assert_allclose(n, sampled[(0, 0, 1), (0, 1, 1)], rtol=0.05)


def test_the_height_of_a_single_exact_frame_is_exact() -> None:
    truth, camera = walk(6, frames=2), PerspectiveCamera()
    sequence, history = see(truth, camera), History(6)
    heights = Heights(6, 1.7, 0.07, (1.4, 2.0), 0.0)
    for t in (0, 1):
        row = [np.full_like(sequence.given.positions[0], np.nan)] * 2 + [sequence.given.positions[t]]
        poses = [np.full(3, np.nan)] * 2 + [sequence.given.poses[t]]
        history.advance(Given(poses=np.array(poses), positions=np.array(row)))
    heights.learn(history, sight(camera, sequence.observations[0], 0.0))
    np.testing.assert_allclose(heights.mean, truth.heights, atol=1e-7)


def test_the_implicit_force_is_the_one_that_acts_at_t() -> None:
    rng, dt = np.random.default_rng(1), 0.4
    last, velocity = rng.uniform(-1, 1, (6, 2)), rng.normal(size=(6, 2))
    moved = SocialForceWalk(relaxation=0.5, radius=1.0).displace(Walkers(last, velocity, dt))
    x = last + velocity * dt + moved
    near = np.linalg.norm(last[:, None] - last[None], axis=-1) < 1.0
    mean = np.array([velocity[row].mean(axis=0) for row in near])
    force = (mean - (x - last) / dt) / 0.5
    np.testing.assert_allclose(moved / dt**2, force, atol=1e-12)
