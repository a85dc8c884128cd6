"""The window of a rough camera: columns that are used again, tracks that begin anew, and what a long run keeps."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_sequence import sequence_of
from tests.rough_crowd import DT, LEVEL, drive, made_drive, photograph, problem_of
from vbbench.geometry import FloatArray
from vbbench.sequence import Given, Odometry
from vbbench.solving.runner import given_at
from vbbench_baselines.common.bearings import Bearings, bearings_of
from vbbench_baselines.joint_map.real_camera.cues import FRAME
from vbbench_baselines.joint_map.real_camera.gaps import fill
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.tracking import Tracking
from vbbench_baselines.joint_map.real_camera.window import NOBODY, SOMEBODY, Window, last_before

FIRST = np.array((np.log(1.7), 0.45))
VARIANCE = 0.01


def seen_of(*tracks: int, total: int = 6) -> Bearings:
    """One frame in which these tracks have boxes, the azimuth of each being its number."""
    rows = np.full(total, np.nan)
    rows[list(tracks)] = tracks
    return Bearings(rows, rows + 0.1, rows + 0.2, rows + 100.0, rows + 0.3, np.zeros(total, np.int64))


def nothing_given(total: int = 6) -> Given:
    return Given(poses=np.full((3, 3), np.nan), positions=np.full((3, total, 2), np.nan))


def pushed(*frames: tuple[int, ...], size: int = 3) -> Window:
    rows = Window(size, 6, FIRST, VARIANCE)
    for tracks in frames:
        push(rows, *tracks)
    return rows


def push(rows: Window, *tracks: int) -> None:
    rows.leave()
    rows.push(seen_of(*tracks), nothing_given(), np.zeros(FRAME))


def test_columns_of_those_who_left_are_used_again() -> None:
    rows = pushed((0, 1), (0,), (0,), (0,), (0, 4))
    assert rows.column[1] == NOBODY
    assert sorted(rows.column[[0, 4]]) == [0, 1]
    assert rows.places.shape == (3, 2, 2)
    column = rows.column[4]
    np.testing.assert_array_equal(rows.boxes.azimuth[:, column], (np.nan, np.nan, 4.0))
    np.testing.assert_array_equal(rows.numbers[column], FIRST)
    assert rows.variances[column] == VARIANCE


def test_somebody_new_knows_nothing_of_whom_the_column_was() -> None:
    rows = pushed((0, 1), (0,))
    column = rows.column[1]
    rows.numbers[column], rows.variances[column], rows.places[:, column] = 0.0, 7.0, 3.0
    for tracks in ((0,), (0,), (0, 5)):
        push(rows, *tracks)
    assert rows.column[5] == column
    np.testing.assert_array_equal(rows.numbers[column], FIRST)
    assert rows.variances[column] == VARIANCE
    assert np.isnan(rows.places[:, column]).all()


def test_a_track_that_is_back_within_the_window_is_the_same_person() -> None:
    rows = pushed((0, 1), (0,))
    column = rows.column[1]
    push(rows, 0, 1)
    assert rows.column[1] == column
    np.testing.assert_array_equal(rows.boxes.azimuth[:, column], (1.0, np.nan, 1.0))


def test_a_track_that_shows_somebody_else_goes_on_anew_and_its_past_is_kept() -> None:
    rows = pushed((0, 1), (0, 1), (0, 1))
    old = rows.column[1]
    rows.reseat({1: SOMEBODY})
    new = rows.column[1]
    assert new != old
    np.testing.assert_array_equal(rows.boxes.azimuth[:, old], (1.0, 1.0, np.nan))
    np.testing.assert_array_equal(rows.boxes.azimuth[:, new], (np.nan, np.nan, 1.0))
    np.testing.assert_array_equal(rows.numbers[new], FIRST)
    push(rows, 0, 1)
    np.testing.assert_array_equal(rows.boxes.azimuth[:, new], (np.nan, 1.0, 1.0))


def test_two_tracks_change_hands() -> None:
    rows = pushed((0, 1), (0, 1))
    zero, one = rows.column[[0, 1]]
    rows.reseat({0: one, 1: zero})
    assert rows.column[:2].tolist() == [one, zero]
    np.testing.assert_array_equal(rows.boxes.azimuth[:, one], (1.0, 0.0))
    np.testing.assert_array_equal(rows.boxes.azimuth[:, zero], (0.0, 1.0))


def test_a_track_that_shows_whom_another_lost_takes_the_person_over() -> None:
    rows = pushed((0, 1), (0, 1), (0,))
    zero, one = rows.column[[0, 1]]
    names = rows.names.copy()
    rows.reseat({0: one})
    assert rows.column[:2].tolist() == [one, NOBODY]
    np.testing.assert_array_equal(rows.boxes.azimuth[:, one], (1.0, 1.0, 0.0))
    push(rows, 0, 1)
    assert rows.column[1] not in (zero, one)  # whom the other shows now is somebody new
    assert rows.names[rows.column[1]] not in names


def test_given_places_are_those_of_whom_the_track_showed_then() -> None:
    rows = pushed((0, 1), (0, 1))
    old = rows.column[1]
    rows.reseat({1: SOMEBODY})
    given = np.full((3, 6, 2), np.nan)
    given[:, 1] = ((1.0, 0.0), (2.0, 0.0), (3.0, 0.0))
    rows.push(seen_of(0, 1), replace(nothing_given(), positions=given), np.zeros(FRAME))
    np.testing.assert_array_equal(rows.given[:, old, 0], (1.0, np.nan, np.nan))
    np.testing.assert_array_equal(rows.given[:, rows.column[1], 0], (np.nan, 2.0, 3.0))


def test_the_last_frame_with_a_box_before_the_newest() -> None:
    azimuth = np.array(((0.0, np.nan, 0.0), (0.0, np.nan, np.nan), (np.nan, 0.0, 0.0)))
    found = last_before(azimuth)
    assert found[[0, 2]].tolist() == [1, 0]
    assert found[1] < -1000


def test_a_forgotten_column_is_somebody_new() -> None:
    rows = pushed((0, 1), (0, 1))
    old = rows.column[1]
    rows.forget(np.array([1]))
    push(rows, 0, 1)
    assert rows.column[1] not in (old, NOBODY)
    assert rows.column[0] == 0


def test_many_tracks_show_somebody_else_at_once_and_come_at_once() -> None:
    rows = pushed((0, 1, 2), (0, 1, 2, 3, 4, 5))
    before = rows.column.copy()
    rows.reseat(dict.fromkeys((0, 3, 5), SOMEBODY))
    assert len(set(rows.column.tolist())) == 6
    assert before[0] not in rows.column[[0, 3, 5]]  # of whom there is a past
    np.testing.assert_array_equal(rows.boxes.azimuth[-1, rows.column], np.arange(6.0))


def test_kernels_get_whom_anything_is_known_of_and_from_when_to_when() -> None:
    rows = pushed((0,), (0, 2), (2,))
    seen, _ = rows.seen(held=1)
    assert (seen.first.tolist(), seen.last.tolist()) == ([0, 1], [1, 2])
    assert seen.fixed.tolist() == [True, False, False]
    part, chosen = rows.seen(slice(2, 3), 1)
    assert (chosen.tolist(), part.first.tolist(), part.last.tolist(), part.fixed.tolist()) == ([1], [0], [0], [True])


def test_given_poses_are_taken_over_without_a_whole_turn() -> None:
    rows = Window(3, 6, FIRST, VARIANCE)
    start = np.zeros(FRAME)
    start[2] = 3.1
    rows.push(seen_of(0), nothing_given(), start)
    given = nothing_given()
    poses = np.array(given.poses)
    poses[-1] = (1.0, 2.0, -3.1)
    rows.push(seen_of(0), replace(given, poses=poses), start)
    np.testing.assert_allclose(rows.frames[-1, :3], (1.0, 2.0, 2.0 * np.pi - 3.1))
    assert rows.seen()[0].fixed.tolist() == [False, True]


def test_odometry_takes_its_place() -> None:
    rows = Window(3, 6, FIRST, VARIANCE)
    moved = np.array(((np.nan,) * 3, (np.nan,) * 3, (0.5, 0.0, 0.1)))
    told = Odometry(motions=moved, covariances=np.stack([np.full((3, 3), np.nan)] * 2 + [1e-4 * np.eye(3)]))
    for odometry in (None, told):
        rows.push(seen_of(0), replace(nothing_given(), odometry=odometry), np.zeros(FRAME))
    seen, _ = rows.seen()
    np.testing.assert_array_equal(seen.motions.moved, (np.zeros(3), moved[2]))
    assert seen.free.tolist() == [True, False]


def test_places_not_known_yet_are_filled_in() -> None:
    """Given, as walked, between known ones, or as high as the box says."""
    truth = drive(0, frames=4, people=3)
    boxes = photograph(truth, LEVEL, 0.0)
    rows = Window(4, 3, FIRST, VARIANCE)
    for t in range(4):
        given = Given(poses=np.full((3, 3), np.nan), positions=np.full((3, 3, 2), np.nan))
        shown = boxes[t].copy()
        shown[1:, :] = np.where(t in (0, 3), shown[1:, :], np.nan)
        rows.push(bearings_of(LEVEL, shown), given, np.concatenate((truth.poses[t], (0.0, 0.0, 1.6, 0.0))))
    rows.places[0], rows.places[3, 1] = truth.positions[0], truth.positions[3, 1]
    rows.places[1, 0] = truth.positions[1, 0]
    rows.numbers[:, 0] = np.log(truth.heights)
    places = rows.places.copy()
    fill(places, rows.frames, rows.seen()[0], rows.numbers)
    assert not np.isnan(places).any()
    np.testing.assert_allclose(places[2, 0], 2.0 * truth.positions[1, 0] - truth.positions[0, 0])
    np.testing.assert_allclose(places[3, 2], truth.positions[3, 2], atol=0.02)  # as high as the box says
    ends = truth.positions[[0, 3], 1]
    np.testing.assert_allclose(places[1:3, 1], [(2 * ends[0] + ends[1]) / 3, (ends[0] + 2 * ends[1]) / 3])


def relay(frames: int, people: int) -> FloatArray:
    """Boxes [T, K, 3] of a crowd seen by a camera that stands; each track comes and goes."""
    truth = drive(1, frames, people, speed=0.0, turning=0.0)
    around = np.array((0.0, 12.0)) + 4.0 * np.sin(0.05 * truth.positions + np.arange(people)[:, None])
    poses = np.tile((0.0, 0.0, np.pi / 2), (frames, 1))
    boxes = photograph(replace(truth, positions=around, poses=poses))
    there = (np.arange(frames)[:, None] + 13 * np.arange(people)) % 60 < 12
    boxes[~there] = np.nan
    return boxes


@pytest.mark.slow
@pytest.mark.parametrize("forgets", [False, True])
def test_memory_is_that_of_the_window(forgets: bool) -> None:
    frames, people = 500, 20
    boxes = relay(frames, people)
    given = Given(poses=np.full((frames, 3), np.nan), positions=np.full((frames, people, 2), np.nan))
    poses = np.array(given.poses)
    poses[:2] = (0.0, 0.0, np.pi / 2)
    given = replace(given, poses=poses)
    sequence = sequence_of(drive(1, frames, people), boxes)
    tracking, answers, widest = Tracking(Settings(window=8), problem_of(sequence)), [], 0
    for t in range(frames):
        if forgets and t % 7 == 0:
            tracking.forget(np.arange(t % 5, people, 5))
        answers.append(tracking.step(boxes[t], given_at(given, t)))
        widest = max(widest, tracking.rows.places.shape[1])
    at_once = max(np.count_nonzero((~np.isnan(boxes[t : t + 8, :, 2])).any(axis=0)) for t in range(frames - 8))
    assert widest <= (2 * at_once if forgets else 1.25 * (at_once + 2))
    assert {len(rows) for rows in (*tracking.rows.boxes, tracking.rows.frames, tracking.rows.given)} == {8}
    found = np.array([answer.pose for answer in answers])
    assert np.abs(found[:, :2]).max() < 2.0
    assert np.hypot(*np.diff(found[:, :2], axis=0).T).max() < 2.0 * DT


def test_the_window_slides_as_a_whole() -> None:
    """What is kept of frames is that of the newest, in their order."""
    made = made_drive(drive(2, frames=12))
    tracking = Tracking(Settings(window=5), made.problem)
    for t, boxes in enumerate(made.sequence.observations):
        tracking.step(boxes, given_at(made.sequence.given, t))
        newest = np.nan_to_num(bearings_of(LEVEL, boxes).size)
        here = tracking.rows.column[newest > 0.0]
        np.testing.assert_array_equal(tracking.rows.boxes.size[-1, here], newest[newest > 0.0])
        assert len(tracking.rows.frames) == min(t + 1, 5)
