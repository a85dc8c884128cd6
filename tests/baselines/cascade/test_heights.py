"""What boxes measure of places and heights."""

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, see, walk
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.sequence import Given
from vbbench_baselines._core import measure
from vbbench_baselines.cascade.heights import Heights
from vbbench_baselines.common.motion import History
from vbbench_baselines.common.sightings import sight


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
    nowhere = np.full((6, 2), np.nan), np.full(6, np.nan)
    heights.learn(history, sight(camera, sequence.observations[0], 0.0), *nowhere)
    np.testing.assert_allclose(heights.mean, truth.heights, atol=1e-7)


def test_a_confidently_expected_place_teaches_a_height_as_far_as_it_is_trusted() -> None:
    truth, camera = walk(4, frames=2, people=4), PanoramaCamera()
    sequence, history = see(truth, camera), History(4)
    nothing = np.full((4, 2), np.nan)
    for t in (0, 1):
        poses = np.array([np.full(3, np.nan)] * 2 + [truth.poses[t]])
        history.advance(Given(poses=poses, positions=np.array([nothing] * 3)))
    heights = Heights(4, 1.7, 0.07, (1.4, 2.0), 0.0)
    std = np.array([0.0, 0.05, 5.0, np.nan])
    heights.learn(history, sight(camera, sequence.observations[0], 0.0), truth.positions[0], std)
    assert abs(heights.mean[0] - truth.heights[0]) < 1e-7
    assert 1e-9 < heights.variance[0] + 1e-8 < heights.variance[1] < heights.variance[2] < heights.variance[3]
    assert (heights.mean[3], heights.variance[3]) == (1.7, 0.07**2)
