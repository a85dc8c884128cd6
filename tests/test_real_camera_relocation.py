"""A rough camera that has lost its way is found again by several people whose places are given."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.rough_crowd import LEVEL, Drive, drive, made_drive, photograph
from vbbench.geometry import FloatArray, carried_along, moved_as_one, relative_to_world, wrap_angle
from vbbench_baselines.common.bearings import bearings_of
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.real_camera.relocation import Relocation, relocate

FRAMES, TURNING, AFTER = 30, 8, 18
STRANGER = np.array((np.log(1.7), 0.45))


def relocated(
    off: tuple[float, float, float], given: int, at: int = -1, seed: int = 0
) -> tuple[Relocation | None, FloatArray]:
    """What is found of a camera that is believed ``off``, with so many people ``given`` in a frame, and its pose."""
    truth = drive(seed, 6, people=12)
    boxes = photograph(truth, LEVEL, seed=seed)
    places = np.full(truth.positions.shape, np.nan)
    seen = np.flatnonzero(~np.isnan(boxes[..., 0]).any(axis=0))
    places[at, seen[:given]] = truth.positions[at, seen[:given]]
    frames = np.zeros((6, 7))
    frames[:, :3] = moved_as_one(truth.poses, truth.poses[-1], truth.poses[-1] + np.array(off))
    return relocate(frames, places, bearings_of(LEVEL, boxes), np.ones(6, np.bool_), STRANGER), truth.poses[-1]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("off", [(0.0, 0.0, 0.8), (3.0, -4.0, -0.6), (-6.0, 5.0, -2.5)])
def test_several_people_find_a_camera(off: tuple[float, float, float], seed: int) -> None:
    found, pose = relocated(off, given=5, seed=seed)
    assert found is not None
    assert found.since == 0
    error = found.pose - pose
    assert np.hypot(error[0], error[1]) < 1.0
    assert abs(wrap_angle(error[2])) < 0.1


def test_a_camera_is_moved_no_farther_than_it_must() -> None:
    found, pose = relocated((0.0, 0.0, 0.5), given=2)
    assert found is not None
    assert np.hypot(*(found.pose - pose)[:2]) < 0.3


def test_one_person_does_not_find_it_nor_several_who_agree_with_it_or_are_given_no_more() -> None:
    assert relocated((4.0, 4.0, 0.8), given=1)[0] is None
    assert relocated((0.0, 0.0, 0.0), given=5)[0] is None
    assert relocated((4.0, 4.0, 0.8), given=5, at=3)[0] is None


def test_people_who_do_not_agree_with_each_other_find_nothing() -> None:
    truth = drive(1, 6, people=12)
    boxes = photograph(truth, LEVEL)
    seen = np.flatnonzero(~np.isnan(boxes[..., 0]).any(axis=0))[:6]
    places = np.full(truth.positions.shape, np.nan)
    places[-1, seen] = truth.positions[-1, np.roll(seen, 1)]
    frames = np.zeros((6, 7))
    frames[:, :3] = moved_as_one(truth.poses, truth.poses[-1], truth.poses[-1] + np.array((0.0, 0.0, 1.0)))
    assert relocate(frames, places, bearings_of(LEVEL, boxes), np.ones(6, np.bool_), STRANGER) is None


@cache
def misled(seed: int) -> Drive:
    """A drive that turns by a radian with two companions, who hide it; those who arrive then are others than before."""
    truth = drive(seed, FRAMES, people=62)
    poses = truth.poses.copy()
    poses[:, 2] += np.clip((np.arange(FRAMES) - TURNING) / (AFTER - TURNING), 0.0, 1.0)
    late = np.arange(62) >= 30
    places = truth.positions.copy()
    places[:, late] = carried_along(places[:, late], truth.poses, poses)
    beside = np.array(((-2.0, 8.0), (1.5, 9.0)))
    places[:, -2:] = relative_to_world(np.broadcast_to(beside, (FRAMES, 2, 2)), poses)
    truth = replace(truth, poses=poses, positions=places)
    boxes = photograph(truth, seed=seed)
    late[-2:] = False
    boxes[:AFTER, late], boxes[TURNING:, :30] = np.nan, np.nan
    return made_drive(truth, boxes)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
def test_those_who_arrive_find_a_camera_that_was_misled(solver: type, seed: int) -> None:
    made = misled(seed)
    estimate = made.solved(solver)
    turned = np.abs(wrap_angle(estimate.poses[:, 2] - made.truth.poses[:, 2]))
    assert turned[AFTER:].max() < 0.15
    assert made.errors(estimate)[AFTER:].max() < 1.5


def test_nobody_is_as_fast_as_a_track_that_changes_hands_between_its_given_frames() -> None:
    truth = drive(2, 12)
    near = relative_to_world(np.broadcast_to((0.6, 1.9), (12, 1, 2)), truth.poses)[:, 0]
    far = relative_to_world(np.broadcast_to((-3.0, 16.0), (12, 1, 2)), truth.poses)[:, 0]
    places = truth.positions.copy()
    places[0, 0], places[1:, 0] = far[0], near[1:]
    truth = replace(truth, positions=places)
    estimate = made_drive(truth, photograph(truth)).solved(MapCausal)
    assert np.linalg.norm(estimate.positions[2:, 0] - places[2:, 0], axis=-1).max() < 2.0
