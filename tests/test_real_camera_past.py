"""What frames that have left the window of a rough camera told of people, and how sure what follows is."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.rough_crowd import Window, drive, made_drive, made_window, photograph
from vbbench.geometry import FloatArray
from vbbench.solving.runner import given_at
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.joint_map.motion.walks import REACH
from vbbench_baselines.joint_map.real_camera.behind import add_behind, carried
from vbbench_baselines.joint_map.real_camera.cues import CUES, LENGTH, residuals_of
from vbbench_baselines.joint_map.real_camera.joint import let_first_go
from vbbench_baselines.joint_map.real_camera.past import TOLD, nothing_past
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.tracking import Tracking


@pytest.fixture(scope="module")
def window() -> Window:
    return made_window()


def followed(window: Window) -> int:
    """Somebody who has a box in each of the first frames that a place looks ahead."""
    seen = ~np.isnan(window.seen.boxes.azimuth[: REACH + 1]).any(axis=0) & (window.seen.first == 0)
    return int(np.flatnonzero(seen & (window.seen.last >= REACH))[0])


def jacobian_of(values: Callable[[FloatArray], FloatArray], at: FloatArray) -> FloatArray:
    steps = 1e-6 * np.eye(len(at))
    return np.stack([(values(at + step) - values(at - step)) / 2e-6 for step in steps], axis=1)


@pytest.mark.parametrize(("given", "told"), [(False, 0.0), (True, 0.0), (False, 1.3)])
def test_a_place_that_leaves_is_schur_s_complement_of_its_box_and_its_step(
    window: Window, given: bool, told: float
) -> None:
    """Against a dense problem of five places and two numbers, with slopes by differences."""
    k, model, point = followed(window), window.model, window.point
    seen = window.seen._replace(past=nothing_past(len(window.seen.first)))
    places = seen.given.copy()
    places[0, k] = point.places[0, k] + 0.02 if given else np.nan
    seen = seen._replace(given=places, told=np.full_like(seen.told, told))
    at = np.concatenate((point.places[: REACH + 1, k].ravel(), point.people[k]))

    def residuals(at: FloatArray) -> FloatArray:
        track = at[:-2].reshape(-1, 2).copy()
        return residuals_of(k, 0, seen.boxes, point.frames, track, at[-2:].copy(), model.noise).value

    def pushed(at: FloatArray) -> FloatArray:
        found = residuals_of(k, 0, seen.boxes, point.frames, at[:2].reshape(1, 2).copy(), at[-2:].copy(), model.noise)
        return np.asarray(-told * (found.value[0, LENGTH] * found.scale[0, LENGTH] + at[-2]))[None]

    def added(at: FloatArray) -> FloatArray:
        value = residuals(at)
        return np.asarray(value[0] - np.exp(-model.dt / model.noise.tau) * value[1])

    def stepped(at: FloatArray) -> FloatArray:
        return np.asarray(model.walk.filters[REACH] @ at[:-2].reshape(-1, 2)) / model.walk.spreads[REACH]

    track = point.places[: REACH + 1, k].copy()
    counts = residuals_of(k, 0, seen.boxes, point.frames, track, point.people[k].copy(), model.noise).counts
    assert np.all(counts[:2] == 1.0), "so that the box is one that counts, and knows of the next"
    rho, nu = np.exp(-model.dt / model.noise.tau), model.noise.nu
    weights = np.diag((nu + 1.0) / (nu * (1.0 - rho**2) + added(at) ** 2))
    by_box, by_step = jacobian_of(added, at), jacobian_of(stepped, at)
    walked = (model.walk.nu + 2.0) / (model.walk.nu * point.variances[k] + stepped(at) @ stepped(at))
    hessian = by_box.T @ weights @ by_box + walked * by_step.T @ by_step
    gradient = by_box.T @ weights @ added(at) + walked * by_step.T @ stepped(at)
    if given:
        hessian[:2, :2] += np.eye(2) / ANCHOR_STD**2
        gradient[:2] += (point.places[0, k] - places[0, k]) / ANCHOR_STD**2
    gradient += jacobian_of(pushed, at)[0]
    share = hessian[2:, :2] @ np.linalg.inv(hessian[:2, :2])

    let_first_go(point, seen, model, 0)

    assert by_box.shape == (CUES, TOLD + 2)
    np.testing.assert_allclose(seen.past.about[k], at[2:])
    wanted = hessian[2:, 2:] - share @ hessian[:2, 2:]
    np.testing.assert_allclose(seen.past.information[k], wanted, rtol=1e-4, atol=1e-5 * np.abs(wanted).max())
    pull = gradient[2:] - share @ gradient[:2]
    np.testing.assert_allclose(seen.past.slope[k], pull, rtol=1e-4, atol=1e-5 * np.abs(pull).max())


def test_who_is_not_followed_any_more_leaves_nothing(window: Window) -> None:
    people = len(window.seen.first)
    past = nothing_past(people)
    past.information[:] = np.eye(TOLD)
    past.slope[:] = 1.0
    let_first_go(window.point, window.seen._replace(past=past, last=np.zeros(people, np.int64)), window.model, 0)
    here = window.seen.first <= 0
    assert here.any()
    np.testing.assert_array_equal(past.information[here], 0.0)
    np.testing.assert_array_equal(past.slope[here], 0.0)


@pytest.mark.slow
def test_short_windows_that_carry_on_are_as_good_as_long_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """And much better than those that forget."""

    def error(window: int) -> float:
        total = 0.0
        for seed in range(6):
            truth = drive(seed, frames=40, people=12, speed=1.0, wander=0.01)
            made = made_drive(truth, photograph(truth, seed=seed))
            tracking = Tracking(replace(Settings(), window=window), made.problem)
            for t, boxes in enumerate(made.sequence.observations):
                answer = tracking.step(boxes, given_at(made.sequence.given, t))
                off = answer.positions - truth.positions[t]
                total += float(np.nanmean(np.hypot(off[:, 0], off[:, 1])))
        return total

    short, long = error(12), error(40)
    assert short < 1.3 * long
    monkeypatch.setattr("vbbench_baselines.joint_map.real_camera.tracking.let_first_go", lambda *_: None)
    assert short < 0.9 * error(12)


def test_errors_of_what_is_held_turn_all_that_follows_about_it() -> None:
    """Against a linear map by differences: a pose moved and turned moves what is seen from it."""
    held, poses, places = np.array((1.0, 2.0, 0.3)), np.array(((4.0, 3.0, 0.5),)), np.array((((6.0, 0.0), (1.0, 5.0)),))
    root = np.array(((0.2, 0.0, 0.0), (0.05, 0.1, 0.0), (0.01, 0.02, 0.03)))
    covariance = root @ root.T

    def moved(error: FloatArray, place: FloatArray) -> FloatArray:
        turn = np.array(((np.cos(error[2]), -np.sin(error[2])), (np.sin(error[2]), np.cos(error[2]))))
        return np.asarray(held[:2] + error[:2] + turn @ (place - held[:2]))

    spread, everyone = np.zeros((1, 3, 3)), np.zeros((1, 2, 2, 2))
    add_behind(covariance, held, poses, places, spread, everyone)
    for place, found in (
        (poses[0, :2], spread[0, :2, :2]),
        (places[0, 0], everyone[0, 0]),
        (places[0, 1], everyone[0, 1]),
    ):
        slopes = jacobian_of(lambda error, place=place: moved(error, place), np.zeros(3))
        np.testing.assert_allclose(found, slopes @ covariance @ slopes.T, atol=1e-8)
    assert spread[0, 2, 2] == pytest.approx(covariance[2, 2])


def test_errors_of_steps_add_up() -> None:
    """As wrong speeds do, whose errors are alike: standard deviations add, not variances."""
    step = np.diag((0.04, 0.01, 0.0))
    once = carried(np.zeros((3, 3)), np.zeros(3), np.array((1.0, 0.0, 0.0)), step, measured=False)
    np.testing.assert_allclose(once, step, atol=1e-12)
    for measured, sum_ in ((False, 4.0), (True, 2.0)):
        twice = carried(once, np.zeros(3), np.zeros(3), step, measured)
        np.testing.assert_allclose(twice, sum_ * step, atol=1e-12)
