"""BoxHeights that map-causal and map-batch read off boxes: exact where boxes are, as sure as they say where not."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.solver_runs import run, walk
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.geometry import FloatArray
from vbbench.solver import Problem
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.measurement.boxes import BoxHeights

CAMERAS: list[Camera] = [PanoramaCamera(), PerspectiveCamera()]


def mean_of(heights: BoxHeights) -> FloatArray:
    return heights.report()["heights"]


def variance_of(heights: BoxHeights) -> FloatArray:
    return heights.report()["height_variances"]


def problem_of(camera: Camera, people: int, pixel_std: float) -> Problem:
    facts = {"height_mean": 1.7, "height_std": 0.07, "pixel_std": pixel_std}
    return Problem(camera=camera, dt=0.4, tracks=np.arange(people), **facts)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
@settings(deadline=None)
@given(height=st.floats(1.4, 2.0), right=st.floats(-2, 2), forward=st.floats(3, 20))
def test_one_exact_box_tells(camera: Camera, height: float, right: float, forward: float) -> None:
    heights = BoxHeights(problem_of(camera, 1, 0.0))
    heights.learn(camera.project(np.array([[right, forward]]), np.array([height])))
    assert mean_of(heights)[0] == pytest.approx(height, abs=2e-6)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
def test_noisy_boxes_tell_as_much_as_is_said(camera: Camera) -> None:
    """Squared errors in units of the variance have mean one; five frames at six metres."""
    rng = np.random.default_rng(0)
    true = rng.normal(1.7, 0.07, 4000)
    boxes = camera.project(np.tile((1.0, 6.0), (5, 4000, 1)), np.tile(true, (5, 1)))
    top, bottom = rng.normal(0.0, 1.0, (2, 5, 4000))
    boxes[..., 1] += 0.5 * (top + bottom)
    boxes[..., 2] += bottom - top
    heights = BoxHeights(problem_of(camera, 4000, 1.0))
    heights.learn(boxes)
    assert np.mean((mean_of(heights) - true) ** 2 / variance_of(heights)) == pytest.approx(1.0, abs=0.07)
    assert np.sqrt(variance_of(heights)).mean() < 0.02


def test_frame_by_frame_is_all_at_once_and_nothing_seen_is_the_prior() -> None:
    boxes = PanoramaCamera().project(np.random.default_rng(1).uniform(2, 9, (4, 3, 2)), np.full((4, 3), 1.8))
    boxes[:, 2] = np.nan
    boxes[1, 1, 1] = -50.0  # a foot above the horizon
    problem = problem_of(PanoramaCamera(), 3, 1.0)
    once, often = BoxHeights(problem), BoxHeights(problem)
    once.learn(boxes)
    for frame in boxes:
        often.learn(frame)
    np.testing.assert_allclose(mean_of(once), mean_of(often))
    assert mean_of(once)[2] == pytest.approx(1.7)
    assert variance_of(once)[2] == pytest.approx(0.07**2)
    assert (variance_of(once)[:2] < 0.02**2).all()


@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
@pytest.mark.parametrize("protocol", ["one-step", "sequential"])
def test_solvers_report_them(solver: type[Any], protocol: str) -> None:
    truth = walk(4, frames=6)
    estimate = run(solver(), truth, protocol)
    assert estimate.heights is not None
    np.testing.assert_allclose(estimate.heights, truth.heights, atol=1e-4)
    assert run(MapCausal(feet=False), truth, protocol).heights is None
