"""Whose feet are hidden is told by boxes alone, and nobody's are where boxes are of whole people."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.geometry import BoolArray, FloatArray
from vbbench.protocol import get_protocol
from vbbench.sequence import Given, Sequence
from vbbench.solver import Frame, Problem
from vbbench.solving.runner import run_sequence
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.measurement.boxes import UNTOLD, BoxHeights, Eye
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
        hidden = Hiding(problem_of(camera), level=True).hidden(seen)
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
        hidden += int(Hiding(problem_of(camera, pixel_std), level=True).hidden(seen).sum())
        boxes += int((~np.isnan(seen[..., 0])).sum())
    assert hidden < 0.01 * boxes


@pytest.mark.parametrize("camera", CAMERAS)
def test_frames_one_by_one_are_as_all_at_once(camera: Camera) -> None:
    boxes, _ = crowd(camera, 3, hide=True)
    one_by_one = Hiding(problem_of(camera), level=True)
    expected = Hiding(problem_of(camera), level=True).hidden(boxes)
    np.testing.assert_array_equal([one_by_one.hidden(frame) for frame in boxes], expected)


def one(v: float, length: float) -> FloatArray:
    """A frame with a box of the first person only."""
    boxes = np.full((PEOPLE, 3), np.nan)
    boxes[0] = 640.0, v, length
    return boxes


def test_a_box_at_the_lower_border_has_no_feet() -> None:
    hiding = Hiding(problem_of(PerspectiveCamera()), level=True)
    assert hiding.hidden(one(720.0 - 150.0, 300.0))[0]
    assert not hiding.hidden(one(719.0 - 100.0 - 150.0, 300.0))[0]


def test_who_seems_to_grow_has_no_feet_unless_somebody_else_is_meant() -> None:
    hiding = Hiding(problem_of(PerspectiveCamera()), level=True)
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
    assert np.isnan(eye.with_feet(cut)).all()


def test_heights_are_not_learned_from_hidden_feet() -> None:
    """A cut box makes somebody whose head is above the camera a giant."""
    problem = problem_of(PerspectiveCamera())
    eye, heights = Eye(problem, feet=True), BoxHeights(problem)
    for boxes in (one(500.0, 300.0), one(470.0, 240.0)):
        eye.sight(boxes)
        heights.learn(eye.with_feet(boxes))
    alone = BoxHeights(problem)
    alone.learn(one(500.0, 300.0))
    np.testing.assert_array_equal(heights.report()["heights"], alone.report()["heights"])


def test_an_implied_height_that_stays_is_believed_after_all() -> None:
    """Once its head was hidden, or somebody stooped: how far boxes are cut changes, how tall people are does not."""
    hiding = Hiding(problem_of(PerspectiveCamera()), level=True)
    assert not hiding.hidden(one(506.0, 288.0))[0]
    assert [bool(hiding.hidden(one(500.0, 300.0))[0]) for _ in range(5)] == [True, True, False, False, False]


@pytest.mark.parametrize("camera", CAMERAS)
def test_people_behind_cut_ones_do_not_tell_that_people_hide_one_another(camera: Camera) -> None:
    """Boxes of whole people that are clipped to the picture: whoever stands behind a clipped one is whole."""
    hidden = boxes = 0
    for seed in range(6):
        whole, _ = crowd(camera, seed, hide=False)
        bottom, top = whole[..., 1] + 0.5 * whole[..., 2], whole[..., 1] - 0.5 * whole[..., 2]
        clipped = bottom > camera.picture_size[1]
        bottom = np.minimum(bottom, camera.picture_size[1])
        seen = np.stack((whole[..., 0], 0.5 * (top + bottom), bottom - top), axis=-1)
        hidden += int((Hiding(problem_of(camera), level=True).hidden(seen) & ~clipped).sum())
        boxes += int((~np.isnan(whole[..., 0])).sum())
    assert hidden < 0.01 * boxes


def test_where_the_ground_is_not_trusted_neither_are_implied_heights() -> None:
    hiding = Hiding(problem_of(PerspectiveCamera()), level=False)
    assert not hiding.hidden(one(500.0, 300.0))[0]
    assert not hiding.hidden(one(470.0, 240.0))[0]


@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
def test_a_sequence_of_nobody_is_solved(solver: type[Any]) -> None:
    problem = replace(problem_of(PanoramaCamera()), tracks=np.arange(0))
    sequence = Sequence(
        index=0,
        scene=0,
        observer=0,
        first_frame=0,
        tracks=np.arange(0),
        observations=np.zeros((4, 0, 3)),
        visible=np.zeros((4, 0)),
        given=Given(poses=np.zeros((4, 3)), positions=np.zeros((4, 0, 2))).first_frames(2),
    )
    answer, _ = run_sequence(solver(), problem, sequence, get_protocol("sequential"), None)
    assert np.isfinite(answer.poses).all()


def test_a_new_person_in_a_column_is_not_held_to_the_old_one() -> None:
    solver = MapCausal()
    solver.start(problem_of(PerspectiveCamera()))
    given = Given(poses=np.zeros((3, 3)), positions=np.full((3, PEOPLE, 2), np.nan))
    solver.step(Frame(index=0, observations=one(500.0, 300.0), given=given))
    solver.forget(np.array([0]))
    solver.step(Frame(index=1, observations=one(470.0, 240.0), given=given))
    assert not np.isnan(solver._eye.with_feet(one(470.0, 240.0))[0]).any()
