"""Whom the boxes of a rough camera show: tracks that change hands do not throw anybody."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.rough_crowd import Drive, drive, made_drive, made_window, photograph
from vbbench.geometry import FloatArray, IntArray
from vbbench.solver import Estimate
from vbbench_baselines.common.bearings import FEET_CUT
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.real_camera.cues import residuals_of, whiten
from vbbench_baselines.joint_map.real_camera.identity import expect, is_doubtful, tell_apart
from vbbench_baselines.joint_map.real_camera.window import SOMEBODY

FRAMES, CHANGE = 20, 10


def told(shown: list[list[float]], otherwise: list[float], boxes: list[int]) -> tuple[list[int], FloatArray]:
    """Whom the boxes show, if a track changes hands at a tenth of its boxes."""
    whom, doubts = tell_apart(np.array(shown), np.array(otherwise), np.array(boxes), 0.1)
    return whom.tolist(), doubts


def test_boxes_show_whom_they_showed_before_unless_others_are_much_likelier() -> None:
    assert told([[0.0, 1.0], [1.0, 0.0]], [1.0, 1.0], [0, 1])[0] == [0, 1]
    assert told([[-20.0, 0.0], [0.0, -20.0]], [-5.0, -5.0], [0, 1])[0] == [1, 0]
    assert told([[-20.0, -20.0], [-20.0, 0.0]], [-5.0, -5.0], [0, 1])[0] == [SOMEBODY, 1]


def test_nobody_is_in_two_boxes() -> None:
    whom, doubts = told([[0.0, -9.0], [0.5, -9.0]], [-8.0, -8.0], [0, 1])
    assert sorted(whom) == sorted({*whom})
    assert whom.count(0) == 1
    assert (doubts >= 0.0).all()


def test_a_close_decision_is_a_doubtful_one() -> None:
    far = np.log(0.9 / (0.1 * 0.75))  # as likely as somebody else
    _, sure = told([[0.0]], [-9.0], [0])
    _, doubtful = told([[-far]], [0.0], [0])
    assert sure[0] < 0.01
    np.testing.assert_allclose(doubtful[0], 0.5, atol=1e-6)


@cache
def swapped(seed: int) -> tuple[Drive, IntArray]:
    """A drive in which two tracks show each other's people from a frame on: beside each other, one farther off."""
    truth = drive(seed, FRAMES)
    made = made_drive(truth, photograph(truth, seed=seed))
    relative = truth.positions - truth.poses[:, None, :2]
    reach = np.linalg.norm(relative, axis=-1)[CHANGE]
    angle = np.arctan2(relative[CHANGE, :, 1], relative[CHANGE, :, 0])
    seen = np.asarray(made.sequence.observed[CHANGE - 4 : CHANGE + 4].all(axis=0))
    apart = np.abs(angle[:, None] - angle) + 10.0 * (np.abs(reach[:, None] - reach) < 4.0)
    apart += 10.0 * ~np.logical_and.outer(seen, seen)
    pair = np.array(np.unravel_index(np.argmin(apart), apart.shape))
    boxes = np.array(made.sequence.observations)
    boxes[CHANGE:, pair] = boxes[CHANGE:, pair[::-1]]
    return replace(made, sequence=replace(made.sequence, observations=boxes)), pair


def off_after(seed: int, estimate: Estimate) -> FloatArray:
    """Errors in m of the two, from where their tracks change hands."""
    made, pair = swapped(seed)
    error = np.linalg.norm(estimate.positions[:, pair[::-1]] - made.truth.positions[:, pair], axis=-1)
    return np.asarray(error[CHANGE : CHANGE + 4])


@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
def test_people_whose_tracks_change_hands_stay_where_they_are(solver: type) -> None:
    off = np.stack([off_after(seed, swapped(seed)[0].solved(solver)) for seed in range(3)])
    assert off.max() < 1.5
    assert np.median(off) < 0.5


def test_who_was_believed_elsewhere_is_expected_where_it_is_told_that_they_were() -> None:
    """And the noise of their last box is what it is there, not what it would have been."""
    window = made_window()
    k, newest = int(np.argmax(window.seen.last - window.seen.first)), len(window.point.frames) - 1
    seen = window.seen._replace(first=window.seen.first.copy(), given=window.seen.given.copy())
    place = window.point.places[newest - 1, k].copy()
    seen.first[k], seen.given[newest - 1, k] = newest - 1, place
    seen.boxes.azimuth[newest] = np.nan

    def expected(share: float) -> tuple[FloatArray, FloatArray]:
        """With the person believed to be at so many times the distance."""
        places, camera = window.point.places.copy(), window.point.frames[newest - 1, :2]
        places[newest - 1, k] = camera + share * (place - camera)
        found = expect(window.point._replace(places=places), seen, window.model)
        return found.place[k], found.behind[k]

    for share in (0.7, 1.5):
        for far, near in zip(expected(share), expected(1.0), strict=True):
            np.testing.assert_allclose(far, near, atol=0.02)


def test_a_box_that_ends_at_the_border_puts_nobody_at_the_camera() -> None:
    """How near somebody is whose feet are cut is known to a factor or so."""
    window = made_window()
    boxes = window.seen.boxes._replace(cut=np.full_like(window.seen.boxes.cut, FEET_CUT))
    k = int(np.argmax(window.seen.last - window.seen.first))
    first, frames = int(window.seen.first[k]), window.point.frames
    frame, place = frames[first, :2], window.point.places[first, k]

    def deviance(share: float) -> float:
        track = (frame + share * (place - frame))[None]
        found = residuals_of(k, first, boxes, frames, track, window.point.people[k], window.model.noise)
        return float(whiten(found, window.model.noise, window.model.dt).deviance)

    assert deviance(0.2) > deviance(1.0) + 1.0
    assert deviance(0.8) < deviance(1.0) + 0.5


def test_what_is_left_of_a_cut_box_does_not_tell_whom_it_shows() -> None:
    window = made_window()
    seen = window.seen
    moved = seen.boxes._replace(azimuth=seen.boxes.azimuth + 0.5 * (np.arange(len(seen.boxes.azimuth)) == 6)[:, None])
    whole, cut = (moved._replace(cut=np.full_like(moved.cut, flag)) for flag in (0, FEET_CUT))
    assert is_doubtful(window.point, seen._replace(boxes=whole), window.model).any()
    assert not is_doubtful(window.point, seen._replace(boxes=cut), window.model).any()
