"""The newest frames of a joint problem alone, and the descent that solves them."""

import numpy as np
import pytest

from tests.rough_crowd import Window, made_window
from vbbench_baselines.joint_map.motion.walks import REACH
from vbbench_baselines.joint_map.real_camera.cues import FRAME
from vbbench_baselines.joint_map.real_camera.descent import DAMPING, Settled, descend, settle
from vbbench_baselines.joint_map.real_camera.joint import KNOWN, Point, deviance_of
from vbbench_baselines.joint_map.real_camera.newest import NEWEST, newest_of, with_newest

FRAMES = 24
BLOCK = NEWEST + REACH


def solved(point: Point, window: Window, rounds: int, since: int = FRAMES) -> Settled:
    """The descent from a copy of ``point``."""
    start = Point(*(part.copy() for part in point))
    return settle(start, window.seen, window.model, rounds, since, True)


@pytest.fixture(scope="module")
def window() -> Window:
    """24 frames where the descent ends."""
    made = made_window(FRAMES, 12)
    return Window(solved(made.point, made, 50).point, made.seen, made.model)


def pushed(window: Window) -> Point:
    """The point with the poses of the frames that are solved alone, and all places in them, some way off."""
    rng, point = np.random.default_rng(0), window.point
    frames, places = point.frames.copy(), point.places.copy()
    frames[-NEWEST:, :2] += rng.normal(0.0, 0.1, (NEWEST, 2))
    places[-NEWEST:] += rng.normal(0.0, 0.1, places[-NEWEST:].shape)
    return point._replace(frames=frames, places=places)


def alone(point: Point, window: Window) -> Settled:
    """Where the descent of the newest frames alone ends."""
    start, part, model = newest_of(point, window.seen, window.model)
    return settle(start, part, model, 50, len(start.frames), False)


def test_alone_they_are_where_all_frames_have_them(window: Window) -> None:
    """If the frames before are where they were found, whatever the newest begin with."""
    for start in (window.point, pushed(window)):
        found = alone(start, window).point
        np.testing.assert_allclose(found.frames[:, :2], window.point.frames[-BLOCK:, :2], atol=0.02)
        np.testing.assert_allclose(found.frames[:, 2], window.point.frames[-BLOCK:, 2], atol=2e-3)
        shown = ~np.isnan(window.seen.boxes.azimuth[-BLOCK:])
        np.testing.assert_allclose(found.places[shown], window.point.places[-BLOCK:][shown], atol=0.1)


def test_what_is_known_of_the_frames_before_stays(window: Window) -> None:
    start = pushed(window)
    held = start.frames[-BLOCK:-NEWEST].copy()
    found = with_newest(start, alone(start, window).point)
    np.testing.assert_array_equal(found.frames[-BLOCK:-NEWEST, :3], held[:, :3])
    np.testing.assert_array_equal(found.frames[:-BLOCK], window.point.frames[:-BLOCK])
    np.testing.assert_array_equal(found.places[:-BLOCK], window.point.places[:-BLOCK])
    shown = ~np.isnan(window.seen.boxes.azimuth[-BLOCK:-NEWEST])
    off = (found.places - window.point.places)[-BLOCK:-NEWEST][shown]
    assert np.abs(off).max() < 0.02
    known = window.seen.first < FRAMES - NEWEST
    assert known.any()
    np.testing.assert_allclose(found.people[known], window.point.people[known], atol=3.0 * KNOWN)


def test_steps_before_them_still_tell_how_the_camera_moves(window: Window) -> None:
    """The laws' shares are those of all steps."""
    shares = alone(window.point, window).shares.laws
    np.testing.assert_allclose(shares, solved(window.point, window, 1).shares.laws, atol=0.05)
    start, part, model = newest_of(window.point, window.seen, window.model)
    assert not np.allclose(model.odds, window.model.odds)
    assert len(start.frames) == len(part.fixed) == BLOCK


def test_few_frames_are_all_newest() -> None:
    window = made_window(BLOCK, 4)
    point, seen, model = newest_of(window.point, window.seen, window.model)
    assert seen is window.seen
    assert model.odds is window.model.odds
    np.testing.assert_array_equal(point.frames, window.point.frames)
    assert point.variances is not window.point.variances  # a descent renews them


def test_every_round_leads_down(window: Window) -> None:
    point, deviance, damping = pushed(window), np.inf, DAMPING
    deviance = deviance_of(point, window.seen, window.model)
    reached = [deviance]
    for _ in range(4):
        done = descend(point, window.seen, window.model, deviance, damping)
        point, deviance, damping = done.point, done.deviance, done.damping
        reached.append(deviance)
    assert np.all(np.diff(reached) <= 1e-6)
    assert reached[0] - reached[-1] > 100.0
    assert solved(pushed(window), window, 4).deviance == pytest.approx(reached[-1], abs=0.2)


def test_a_descent_has_converged_where_it_gains_little(window: Window) -> None:
    assert not solved(pushed(window), window, 1).converged
    assert solved(pushed(window), window, 50).converged
    assert solved(window.point, window, 1).converged


def test_covariances_are_of_the_frames_asked_for(window: Window) -> None:
    everybody = window.seen.boxes.azimuth.shape[1]
    assert solved(window.point, window, 1).pose_covariances.shape == (0, 3, 3)
    whole, newest = (solved(window.point, window, 1, since) for since in (0, FRAMES - 1))
    assert whole.pose_covariances.shape == (FRAMES, 3, 3)
    assert newest.place_covariances.shape == (1, everybody, 2, 2)
    np.testing.assert_allclose(newest.pose_covariances[0], whole.pose_covariances[-1], rtol=1e-9)
    np.testing.assert_allclose(newest.place_covariances[0], whole.place_covariances[-1], rtol=1e-9)
    assert window.point.frames.shape == (FRAMES, FRAME)
