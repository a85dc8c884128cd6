"""The tier `tracked` in video: it loses and confuses as few people as published trackers do, also when it turns."""

import numpy as np
import pytest

from benchmarks.tracker_table import Tally
from vbbench.boxes import overlaps, suppress
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.exchange.matching import match_boxes, match_tracks
from vbbench.generation.tier import Observations, Sight, get_tier
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.sequence import Truth
from vbbench_generators._core import remaining, worths
from vbbench_generators.tiers.tracking.observing import carried, estimated_turns
from vbbench_generators.tiers.tracking.settings import get_tracking
from vbbench_generators.tiers.tracking.tracker import CentredDetections, Tracker, from_centres

CAMERAS = [PanoramaCamera(), PerspectiveCamera(), PanoramaCamera(pitch=0.1), PerspectiveCamera(pitch=-0.05, roll=0.03)]
DT = 0.4


def crowd(camera: Camera, frames: int = 30, people: int = 14, turn: float = 0.0) -> Sight:
    """People who cross a square, seen by somebody who walks slowly and turns by ``turn`` rad a frame."""
    rng = np.random.default_rng(2)
    time = DT * np.arange(frames)[:, None, None]
    positions = rng.uniform((3.0, -8.0), (18.0, 8.0), (people, 2)) + time * rng.normal(0.0, 0.6, (people, 2))
    poses = np.stack([0.3 * time[:, 0, 0], 0.0 * time[:, 0, 0], turn * np.arange(frames)], axis=-1)
    truth = Truth(poses=poses, positions=positions, heights=rng.normal(1.7, 0.07, people))
    seen, watched = np.ones((frames, people), bool), np.ones(frames, bool)
    return Sight(truth=truth, people=np.arange(people) + 3, seen=seen, watched=watched, camera=camera, dt=DT)


def observed(sight: Sight, seed: int = 5) -> Observations:
    return get_tier("tracked").observe(sight, np.random.default_rng(seed))


def tally(sight: Sight) -> Tally:
    counted = Tally()
    for seed in range(2):
        counted.add(sight, observed(sight, seed))
    return counted


@pytest.mark.parametrize("period", [None, 400.0], ids=["borders", "panorama"])
def test_boxes_overlap_and_suppress_boxes_as_the_rest_of_the_package_does(period: float | None) -> None:
    rng = np.random.default_rng(4)
    boxes = rng.uniform((0.0, 0.0, 20.0, 40.0), (400.0, 100.0, 60.0, 120.0), (2, 60, 4))
    scores, width = rng.random(60), period or 0.0
    one, other = from_centres(boxes)
    np.testing.assert_allclose(
        worths(boxes[0], boxes[1], np.ones(60), 0.0, width), overlaps(one, other, period), atol=1e-12
    )
    order = np.argsort(-scores, kind="stable")
    kept = order[remaining(boxes[0], order, 0.4, width)[order]]
    np.testing.assert_array_equal(kept, suppress(one, scores, 0.4, period))
    assert 5 < len(kept) < 55


@pytest.mark.parametrize("turn", [0.0, 0.5], ids=["straight", "turning"])
def test_few_are_missed_or_confused_at_the_rate_of_recordings(turn: float) -> None:
    counted = tally(crowd(PanoramaCamera(), turn=turn))
    assert counted.shown_found > 0.8 * counted.shown
    assert counted.found > 0.65 * counted.people
    assert counted.switches < 0.02 * counted.people
    assert counted.nobody < 0.05 * counted.people
    assert 0.78 < counted.overlap / counted.found < 0.9


def test_the_turn_taken_off_keeps_people_that_a_turning_camera_loses(monkeypatch: pytest.MonkeyPatch) -> None:
    sight = crowd(PanoramaCamera(), turn=0.5)
    steady = tally(sight)
    still = np.broadcast_to(np.eye(3), (10 * len(sight.watched), 3, 3))
    place = "vbbench_generators.tiers.tracking.observing.estimated_turns"
    monkeypatch.setattr(place, lambda yaw, *_: still[: len(yaw)])
    dizzy = tally(sight)
    assert steady.found > 1.4 * dizzy.found


def test_the_same_seed_gives_the_same_tracks_in_the_frames_of_the_dataset() -> None:
    sight = crowd(PerspectiveCamera())
    one, same, other = observed(sight), observed(sight), observed(sight, 6)
    np.testing.assert_array_equal(one.boxes, same.boxes)
    np.testing.assert_array_equal(one.persons, same.persons)
    assert one.boxes.shape != other.boxes.shape or not np.array_equal(one.boxes, other.boxes, equal_nan=True)
    assert len(one.boxes) == len(sight.watched)
    assert ((~np.isnan(one.boxes[..., 2])).sum(axis=0) >= get_tracking().tracker.least_boxes).all()


# The camera's turn


def far_boxes(camera: Camera, yaw: float) -> FloatArray:
    """Boxes [N, 4] of people so far away that walking does not move them."""
    azimuth = np.linspace(-0.6, 0.6, 7)
    places = 40.0 * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    u, v, length = camera.project(world_to_relative(places, np.array([0.0, 0.0, yaw])), np.full(7, 1.7)).T
    return np.stack([u, v, 0.36 * length, length], axis=-1)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: f"{camera.kind} {camera.pitch}")
@pytest.mark.parametrize("turn", [0.05, -0.1])
def test_boxes_are_carried_to_where_the_turned_camera_sees_them(camera: Camera, turn: float) -> None:
    rotation = estimated_turns(np.array([1.0, 1.0 + turn]), camera, 0.0, np.random.default_rng(0))[1]
    moved, seen = carried(far_boxes(camera, 0.0), rotation, camera), far_boxes(camera, turn)
    np.testing.assert_allclose(moved[:, [0, 1, 3]], seen[:, [0, 1, 3]], atol=0.02)


def test_what_is_behind_a_camera_with_borders_is_nowhere_and_waits_unharmed() -> None:
    camera = PerspectiveCamera()
    back = estimated_turns(np.array([0.0, np.pi]), camera, 0.0, np.random.default_rng(0))[1]
    assert np.isnan(carried(far_boxes(camera, 0.0), back, camera)).all()
    tracker = Tracker(get_tracking().tracker, 0.04)
    people = CentredDetections(np.array([[600.0, 360.0, 36.0, 100.0]]), np.array([0.9]))
    for _ in range(3):
        tracker.step(people)
    assert not len(tracker.step(CentredDetections(np.empty((0, 4)), np.empty(0)), lambda boxes: boxes * np.nan).ids)
    assert [len(tracker.step(people).ids) for _ in range(2)] == [0, 1]


def test_the_turn_is_as_uncertain_as_the_settings_say() -> None:
    camera = PanoramaCamera()
    turns = estimated_turns(np.zeros(4000), camera, 0.5, np.random.default_rng(1))
    px = np.arctan2(turns[:, 0, 2], turns[:, 0, 0]) * camera.focal
    assert px.std() == pytest.approx(0.5, rel=0.05)


# Who is behind a track


def test_of_two_side_by_side_the_one_does_not_become_the_other() -> None:
    camera = PerspectiveCamera()
    true = np.array([[100.0, 100.0, 36.0, 100.0], [108.0, 100.0, 36.0, 100.0]])
    swapped = true[::-1] * [1.0, 1.0, 1.0, 0.99]
    found = np.stack([true, swapped, true])
    people, real = np.array([4, 9]), np.stack([true] * 3)
    assert match_tracks(found, real, people, camera).tolist() == [[4, 9], [9, 4], [4, 9]]
    assert match_tracks(found, real, people, camera, staying=True).tolist() == [[4, 9]] * 3
    apart = np.stack([true, swapped + 200.0 * np.eye(4)[0], true])
    assert match_tracks(apart, real, people, camera, staying=True)[1].tolist() == [-1, -1]
    kept = match_boxes(swapped, true, camera, paired=np.array([[True, False], [False, False]]))
    assert [rows.tolist() for rows in kept] == [[0, 1], [0, 1]]
