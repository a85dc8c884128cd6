"""Whose feet are hidden is told by boxes alone, and nobody's are where boxes are of whole people."""

from typing import Any

import numpy as np
import pytest

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.geometry import BoolArray, FloatArray
from vbbench.solver import Problem
from vbbench_baselines.joint_map.measurement.boxes import UNTOLD, BoxHeights, Eye, with_feet
from vbbench_baselines.joint_map.measurement.hiding import Hiding
from vbbench_generators.tiers.occlusion import enough, see

CAMERAS: list[Camera] = [PanoramaCamera(), PerspectiveCamera()]
PEOPLE, FRAMES = 24, 40


def problem_of(camera: Camera, pixel_std: float = 0.0) -> Problem:
    facts: dict[str, Any] = {"height_mean": 1.7, "height_std": 0.07, "pixel_std": pixel_std}
    return Problem(camera=camera, dt=0.4, tracks=np.arange(PEOPLE), **facts)


def crowd(camera: Camera, seed: int, hide: bool) -> tuple[FloatArray, BoolArray]:
    """Boxes [T, K, 3] of people who walk about a camera that stands, and whose feet are hidden, if people ``hide``."""
    rng = np.random.default_rng(seed)
    heights = np.clip(rng.normal(1.7, 0.07, PEOPLE), 1.45, 2.0)
    start, speed = rng.uniform((-3.0, 2.0), (3.0, 9.0), (PEOPLE, 2)), rng.normal(0.0, 0.3, (PEOPLE, 2))
    places = start + 0.4 * np.arange(FRAMES)[:, None, None] * speed
    whole = camera.project(places, np.broadcast_to(heights, places.shape[:2]))
    if not hide:
        return whole, np.zeros(whole.shape[:2], np.bool_)
    poses = np.tile((0.0, 0.0, 0.5 * np.pi), (FRAMES, 1))
    showing = see(places, heights, poses, camera)
    boxes = np.where(enough(showing, 0.25)[..., None], showing.boxes, np.nan)
    boxes[np.isnan(whole[..., 0])] = np.nan
    cut = (whole[..., 1] + 0.5 * whole[..., 2]) - (boxes[..., 1] + 0.5 * boxes[..., 2]) > 1.0
    return boxes, cut


@pytest.mark.parametrize("camera", CAMERAS)
def test_most_hidden_feet_are_found(camera: Camera) -> None:
    found = cut = wrong = boxes = 0
    for seed in range(12):
        seen, truly = crowd(camera, seed, hide=True)
        hidden = Hiding(problem_of(camera)).hidden(seen)
        there = ~np.isnan(seen[..., 0])
        found, cut = found + int((hidden & truly).sum()), cut + int(truly.sum())
        wrong, boxes = wrong + int((hidden & ~truly & there).sum()), boxes + int(there.sum())
    assert cut > 200
    assert found > 0.9 * cut
    assert wrong < 0.02 * boxes


@pytest.mark.parametrize("pixel_std", [0.0, 1.0])
@pytest.mark.parametrize("camera", CAMERAS)
def test_whole_boxes_are_believed(camera: Camera, pixel_std: float) -> None:
    """Whoever stands before whom: a box that ends inside a nearer outline tells that nobody is cut."""
    hidden = boxes = 0
    for seed in range(12):
        seen, _ = crowd(camera, seed, hide=False)
        seen += np.random.default_rng(seed).normal(0.0, pixel_std, seen.shape) * (1.0, np.sqrt(0.5), np.sqrt(2.0))
        hidden += int(Hiding(problem_of(camera, pixel_std)).hidden(seen).sum())
        boxes += int((~np.isnan(seen[..., 0])).sum())
    assert hidden < 0.01 * boxes


@pytest.mark.parametrize("camera", CAMERAS)
def test_frames_one_by_one_are_as_all_at_once(camera: Camera) -> None:
    boxes, _ = crowd(camera, 3, hide=True)
    one_by_one = Hiding(problem_of(camera))
    expected = Hiding(problem_of(camera)).hidden(boxes)
    np.testing.assert_array_equal([one_by_one.hidden(frame) for frame in boxes], expected)


def one(v: float, length: float) -> FloatArray:
    """A frame with a box of the first person only."""
    boxes = np.full((PEOPLE, 3), np.nan)
    boxes[0] = 640.0, v, length
    return boxes


def test_a_box_at_the_lower_border_has_no_feet() -> None:
    hiding = Hiding(problem_of(PerspectiveCamera()))
    assert hiding.hidden(one(720.0 - 150.0, 300.0))[0]
    assert not hiding.hidden(one(719.0 - 100.0 - 150.0, 300.0))[0]


def test_who_seems_to_grow_has_no_feet_unless_somebody_else_is_meant() -> None:
    hiding = Hiding(problem_of(PerspectiveCamera()))
    whole, cut = one(500.0, 300.0), one(470.0, 240.0)
    assert not hiding.hidden(whole)[0]
    assert hiding.hidden(cut)[0]
    hiding.forget(np.array([0]))
    assert not hiding.hidden(cut)[0]


def test_hidden_feet_tell_of_a_direction_alone() -> None:
    camera = PerspectiveCamera()
    eye, cut = Eye(problem_of(camera, 1.0), feet=True), one(720.0 - 150.0, 300.0)
    seen = eye.sight(cut)
    assert seen.stretch[0] == UNTOLD
    assert abs(seen.sideways[0] @ seen.rays[0]) < 1e-9
    assert np.isnan(with_feet(cut, seen)).all()


def test_heights_are_not_learned_from_hidden_feet() -> None:
    """A cut box makes somebody whose head is above the camera a giant."""
    problem = problem_of(PerspectiveCamera())
    eye, heights = Eye(problem, feet=True), BoxHeights(problem)
    for boxes in (one(500.0, 300.0), one(470.0, 240.0)):
        heights.learn(with_feet(boxes, eye.sight(boxes)))
    alone = BoxHeights(problem)
    alone.learn(one(500.0, 300.0))
    np.testing.assert_array_equal(heights.report()["heights"], alone.report()["heights"])
