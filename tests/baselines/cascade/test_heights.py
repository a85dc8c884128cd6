"""What boxes measure of places and heights."""

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, see, walk
from vbbench.camera import Camera, PerspectiveCamera
from vbbench.sequence import Given
from vbbench_baselines._core import measure
from vbbench_baselines.cascade import Heights
from vbbench_baselines.common.bearings import sight
from vbbench_baselines.common.motion import History


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
def test_the_covariance_of_a_measurement_is_that_of_samples(camera: Camera) -> None:
    rng = np.random.default_rng(0)
    heights = np.full(40_000, 1.7) + rng.normal(0, 0.05, 40_000)
    boxes = np.tile(camera.project(np.array((2.0, 5.0)), np.array(1.7)), (40_000, 1))
    boxes += rng.normal(0, 1.0, boxes.shape) * (1.0, 1.0, np.sqrt(2.0))
    _, (n, *_) = measure(
        sight(camera, boxes[:1] * 0 + camera.project(np.array((2.0, 5.0)), np.array(1.7)), 1.0),
        np.array([1.7]),
        np.array([0.05**2]),
    )
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
