"""The joint problem of a rough camera: every slope is that of the energy, and eliminating people loses nothing."""

from collections.abc import Callable
from itertools import product

import numpy as np
import pytest

from tests.rough_crowd import Window, made_window
from vbbench.geometry import FloatArray
from vbbench_baselines.common.bearings import FEET_CUT, HEAD_CUT, SIDE_CUT
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.common.odometry import Motions
from vbbench_baselines.joint_map.motion.pace import add_pace, pace_of
from vbbench_baselines.joint_map.motion.walks import REACH, add_walk, reweigh
from vbbench_baselines.joint_map.optimiser.banded import BAND
from vbbench_baselines.joint_map.real_camera.certainty import HELD, MODEL_ERROR, spread_of
from vbbench_baselines.joint_map.real_camera.cholesky import factor, solve
from vbbench_baselines.joint_map.real_camera.cues import CUES, FRAME, Residuals, residuals_of, whiten
from vbbench_baselines.joint_map.real_camera.drift import add_drift, drift_deviance
from vbbench_baselines.joint_map.real_camera.elimination import SOMEWHERE
from vbbench_baselines.joint_map.real_camera.joint import Point, System, deviance_of, linearise
from vbbench_baselines.joint_map.real_camera.observer import LAWS, VEHICLE, moving_deviance, standing_deviance, step_of
from vbbench_baselines.joint_map.real_camera.observer_slopes import add_observer, level_deviance
from vbbench_baselines.joint_map.real_camera.past import PLACES, TOLD, Past, pull_of
from vbbench_baselines.joint_map.real_camera.recovery import follow
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.shares import Shares, shares_of

STEP = 1e-6
LAW_CHOSEN = 60.0
"""ln of by how much more probable a law is, so that it alone counts."""


@pytest.fixture(scope="module")
def window() -> Window:
    return made_window()


def shaken(window: Window, seed: int, scale: float = 1.0) -> Point:
    """The point some way off."""
    rng, point = np.random.default_rng(seed), window.point
    frames = point.frames + scale * rng.normal(0.0, (0.1, 0.1, 0.01, 0.01, 0.01, 0.05, 0.002), point.frames.shape)
    places = point.places + scale * rng.normal(0.0, 0.1, point.places.shape)
    people = point.people + scale * rng.normal(0.0, 0.02, point.people.shape)
    return Point(frames, places, people, point.variances.copy())


def under(window: Window, law: int) -> Window:
    """The same with one law of the observer, odometry into one frame, no pose that is given, and people with a past."""
    seen, frames = window.seen, len(window.point.frames)
    moved, information = np.zeros((frames, 3)), np.zeros((frames, 3, 3))
    moved[4], information[4] = (0.5, 0.1, 0.02), np.array(((90.0, 20.0, 5.0), (20.0, 60.0, 3.0), (5.0, 3.0, 900.0)))
    free = np.arange(frames) != 4
    odds = np.where(np.arange(LAWS) == law, LAW_CHOSEN, 0.0)
    past = past_of(window.point)
    seen = seen._replace(fixed=np.zeros(frames, np.bool_), free=free, motions=Motions(moved, information), past=past)
    return Window(window.point, seen, window.model._replace(odds=odds))


def past_of(point: Point) -> Past:
    """Something that earlier frames told of everybody's first places and numbers."""
    rng, people = np.random.default_rng(9), len(point.people)
    root = rng.normal(0.0, 3.0, (people, TOLD, TOLD))
    about = np.concatenate(
        (np.nan_to_num(point.places[:REACH].transpose(1, 0, 2)).reshape(people, -1), point.people), axis=1
    )
    return Past(root @ root.transpose(0, 2, 1), rng.normal(0.0, 1.0, (people, TOLD)), about)


def slope_of(energy: Callable[[FloatArray], float], at: FloatArray, step: float = STEP) -> FloatArray:
    """Central differences of ``energy`` over everything in ``at``."""
    slope = np.empty(at.size)
    for i in range(at.size):
        ends = []
        for sign in (1.0, -1.0):
            moved = at.copy()
            moved.flat[i] += sign * step
            ends.append(np.asarray(energy(moved)))
        slope[i] = (ends[0] - ends[1]) / (2.0 * step)
    return slope.reshape(at.shape)


def symmetric(lower: FloatArray) -> FloatArray:
    """A matrix from its lower half, and blocks of frames that hold both; there may be more columns."""
    half = np.tril(lower[:, : len(lower)])
    return half + np.tril(half, -1).T


def residuals(window: Window, point: Point, k: int) -> Residuals:
    first, last = int(window.seen.first[k]), int(window.seen.last[k])
    track = point.places[first : last + 1, k].copy()
    return residuals_of(k, first, window.seen.boxes, point.frames, track, point.people[k], window.model.noise)


@pytest.mark.parametrize("cut", [0, FEET_CUT, HEAD_CUT, SIDE_CUT, FEET_CUT + HEAD_CUT + SIDE_CUT])
def test_residuals_move_as_their_slopes_say(window: Window, cut: int) -> None:
    boxes = window.seen.boxes._replace(cut=np.full_like(window.seen.boxes.cut, cut))
    window = Window(window.point, window.seen._replace(boxes=boxes), window.model)
    point = shaken(window, 0)
    k = int(np.argmax(window.seen.last - window.seen.first))
    found, first = residuals(window, point, k), int(window.seen.first[k])
    assert len(found.frame) > 4
    for i, frame in enumerate(found.frame):
        for part, slopes, at in (
            ("frames", found.by_frame, (first + frame,)),
            ("places", found.by_place, (first + frame, k)),
            ("people", found.by_person, (k,)),
        ):
            for j in range(CUES):

                def value(
                    moved: FloatArray, part: str = part, at: tuple[int, ...] = at, i: int = i, j: int = j
                ) -> float:
                    values = getattr(point, part).copy()
                    values[at] = moved
                    return float(residuals(window, point._replace(**{part: values}), k).value[i, j])

                numeric = slope_of(value, getattr(point, part)[at])
                np.testing.assert_allclose(slopes[i, j], numeric, rtol=1e-5, atol=1e-5)
    assert np.all((found.counts[:, 2] == 0.0) == bool(cut & FEET_CUT))
    assert np.all(found.counts[found.value[:, 1] >= 0.0, 1] == 1.0)
    shorter = found.value[:, 1] < 0.0
    assert np.all((found.counts[shorter, 1] < 1.0) == bool(cut & (FEET_CUT | HEAD_CUT)))


def test_cut_sides_count_less(window: Window) -> None:
    """The column of a box at the side is several times as uncertain; a box that fits is unchanged otherwise."""
    k = int(np.argmax(window.seen.last - window.seen.first))
    fits = residuals(window, window.point, k)
    boxes = window.seen.boxes._replace(cut=np.full_like(window.seen.boxes.cut, SIDE_CUT))
    aside = residuals(Window(window.point, window.seen._replace(boxes=boxes), window.model), window.point, k)
    np.testing.assert_allclose(4.0 * aside.value[:, 0], fits.value[:, 0], rtol=1e-12)
    np.testing.assert_allclose(aside.value[:, 1:], fits.value[:, 1:], rtol=1e-12)


def test_steps_have_the_slopes_of_their_parts() -> None:
    before, now = np.array((1.0, -2.0, 0.4)), np.array((1.8, -1.3, 0.9))
    step = step_of(before, now)
    poses = np.concatenate((before, now))
    for part, slopes in (("forward", step.forward_by), ("right", step.right_by)):
        numeric = slope_of(lambda moved, part=part: getattr(step_of(moved[:3].copy(), moved[3:].copy()), part), poses)
        np.testing.assert_allclose(slopes, numeric, atol=1e-8)
    assert step.turned == pytest.approx(0.5)
    back = step_of(now, before)
    assert (back.forward, back.right) == pytest.approx((-step.forward, -step.right))


@pytest.mark.parametrize("law", range(LAWS))
def test_the_observer_is_pulled_as_its_law_says(window: Window, law: int) -> None:
    case = under(window, law)
    assert pulls_as_told(shaken(case, law).frames, case).laws[law] > 1.0 - 1e-9


def test_a_vehicle_that_may_stand_is_pulled_by_how_probable_that_is(window: Window) -> None:
    case = under(window, VEHICLE)
    hasty = case.model._replace(observer=case.model.observer._replace(leaving=0.5))
    case = Window(case.point, case.seen, hasty)
    standing = pulls_as_told(setting_off(shaken(case, VEHICLE).frames), case).standing
    assert 0.1 < standing[2] < 0.9, "so that both states pull"
    assert standing[-1] < 0.01


def setting_off(frames: FloatArray) -> FloatArray:
    """The frames [T, 7] of a vehicle that hardly moves before the fourth, and may in it."""
    frames = frames.copy()
    frames[4:, :3] += frames[0, :3] - frames[3, :3]
    frames[1:4, :3] = frames[0, :3] + np.array(((0.001, 0.002, 0.0003), (0.002, 0.002, 0.0), (0.012, 0.008, 0.0)))
    return frames


def pulls_as_told(frames: FloatArray, case: Window) -> Shares:
    """Check gradient and Hessian at ``frames`` [T, 7], what does not depend on the steps held; returns this."""
    model, free, fixed = case.model, case.seen.free, case.seen.fixed
    blind = np.arange(len(frames)) == 3
    shares = shares_of(frames, free, fixed, model.observer, model.odds)

    def energy(frames: FloatArray) -> float:
        told = shares_of(frames, free, fixed, model.observer, model.odds).deviance
        return told + level_deviance(frames, free, blind, model.observer, shares)

    gradient, hessian = np.zeros(frames.size), np.zeros((frames.size, frames.size))
    add_observer(frames, free, blind, model.observer, shares, gradient, hessian)
    numeric = slope_of(energy, frames).ravel()
    np.testing.assert_allclose(gradient, numeric, rtol=1e-5, atol=1e-4)
    assert np.linalg.eigvalsh(symmetric(hessian)).min() > -1e-6
    return shares


def test_standing_is_as_probable_as_all_ways_to_stand_and_move_say(window: Window) -> None:
    """Against a sum over every way in which the steps may be standing or moving."""
    case = under(window, VEHICLE)
    frames, observer, odds = setting_off(shaken(case, VEHICLE).frames), case.model.observer, case.model.odds
    count = len(frames) - 1
    costs = [[of(frames, t + 1, observer) for of in (moving_deviance, standing_deviance)] for t in range(count)]
    cost, ways = np.array(costs), np.array(list(product((0, 1), repeat=count)))
    changes, least = np.count_nonzero(np.diff(ways, axis=1), axis=1), cost.min(axis=1).sum()
    weight = 0.5 * np.exp(least - cost[np.arange(count), ways].sum(axis=1))
    weight *= observer.leaving**changes * (1.0 - observer.leaving) ** (count - 1 - changes)
    shares = shares_of(frames, np.ones(count + 1, np.bool_), np.zeros(count + 1, np.bool_), observer, odds)
    np.testing.assert_allclose(shares.standing[1:], weight @ ways / weight.sum(), atol=1e-9)
    told = least - np.log(weight.sum()) - cost[0, 0] - observer.odds[VEHICLE] - odds[VEHICLE]
    assert shares.deviance == pytest.approx(told, abs=1e-6)


@pytest.mark.parametrize("known", [False, True])
def test_two_frames_at_rest_tell_of_standing_if_they_are_known_but_not_of_the_law(window: Window, known: bool) -> None:
    frames, observer = np.tile(window.point.frames[0], (2, 1)), window.model.observer
    shares = shares_of(frames, np.ones(2, np.bool_), np.full(2, known), observer, np.zeros(LAWS))
    np.testing.assert_allclose(shares.laws, np.exp(observer.odds), rtol=1e-9)
    assert shares.standing[1] == pytest.approx(0.5) or (known and shares.standing[1] > 0.99)


def test_a_vehicle_that_is_taken_to_move_stands_in_no_new_frame(window: Window) -> None:
    frames, free = np.tile(window.point.frames[0], (6, 1)), np.arange(6) != 2
    going = window.model.observer._replace(going=2)
    standing = shares_of(frames, free, np.arange(6) < 2, going, np.zeros(LAWS)).standing
    assert standing[1:4].min() > 0.1
    assert standing[4:].max() < 1e-9


def test_the_observer_is_pulled_to_rest_at_any_frame_rate(window: Window) -> None:
    """A standing vehicle's step is never so wide that what a moving one's would pull more."""
    walk = Settings().walk(1.0 / 60.0, cold=False)
    observer, frames, free = (
        Settings().observer(1.0 / 60.0, walk, cold=False),
        np.zeros((2, FRAME)),
        np.ones(2, np.bool_),
    )
    shares = shares_of(frames, free, free, observer, np.log((1.0, 1e-9, 1e-9, 1e-9)))
    gradient, hessian = np.zeros(frames.size), np.zeros((frames.size, frames.size))
    add_observer(frames, free, ~free, observer, shares, gradient, hessian)
    assert np.linalg.eigvalsh(symmetric(hessian)).min() > -1e-3


def test_what_is_unknown_of_the_camera_is_pulled_to_the_calibration(window: Window) -> None:
    frames, drift = shaken(window, 1).frames, window.model.drift
    gradient, hessian = np.zeros(frames.size), np.zeros((frames.size, frames.size))
    add_drift(frames, drift, gradient, hessian)
    numeric = slope_of(lambda moved: drift_deviance(moved, drift), frames).ravel()
    np.testing.assert_allclose(gradient, numeric, rtol=1e-5, atol=1e-4)
    assert np.linalg.eigvalsh(symmetric(hessian)).min() > -1e-6


def parts_alone(window: Window, point: Point) -> System:
    """The energy of the frames without anybody."""
    nobody = window.seen._replace(last=window.seen.first - 1)
    return linearise(point, nobody, window.model, 0.0)


def after_a_cold_start(window: Window) -> Window:
    """The same where people's pace counts, and what boxes tell of places, and a camera that goes backwards seldom."""
    told = np.random.default_rng(4).uniform(0.0, 2.0, window.seen.boxes.azimuth.shape)
    walk, observer = (
        window.model.walk._replace(pace=pace_of(0.4, share=1.0)),
        window.model.observer._replace(backing=9.0),
    )
    return Window(window.point, window.seen._replace(told=told), window.model._replace(walk=walk, observer=observer))


@pytest.mark.parametrize("cold", [False, True])
@pytest.mark.parametrize("law", [0, 2])
def test_at_people_s_best_places_the_gradient_is_the_energy_s(window: Window, law: int, cold: bool) -> None:
    """There the energy of frames alone has the slope of all of it, and nothing pulls at places and numbers."""
    case = after_a_cold_start(under(window, law)) if cold else under(window, law)
    point = shaken(case, 2, 0.3)
    for _ in range(400):
        deviance_of(point, case.seen, case.model)  # renews the variances
        places, people = point.places.copy(), point.people.copy()
        for person in linearise(point, case.seen, case.model, 0.0).people:
            track, numbers = follow(person, np.zeros_like(point.frames))
            places[person.first : person.first + len(track), person.number] += 0.7 * track
            people[person.number] += 0.7 * numbers
        point = point._replace(places=places, people=people)

    def energy(part: str) -> Callable[[FloatArray], float]:
        def changed(values: FloatArray) -> float:
            moved = point._replace(**{part: values}, variances=point.variances.copy())
            return float(deviance_of(moved, case.seen, case.model))

        return changed

    system = linearise(point, case.seen, case.model, 0.0)
    numeric = slope_of(energy("frames"), point.frames, 1e-5).ravel()
    np.testing.assert_allclose(system.gradient, numeric, rtol=1e-3, atol=0.02 * np.abs(numeric).max() / 10.0)
    known = np.arange(len(point.frames))[:, None] >= case.seen.first
    known &= np.arange(len(point.frames))[:, None] <= case.seen.last
    pulls = slope_of(energy("places"), np.where(known[..., None], point.places, 0.0), 1e-5)
    assert np.abs(pulls[known]).max() < 0.05
    assert np.abs(slope_of(energy("people"), point.people, 1e-5)).max() < 0.05


def dense(window: Window, point: Point) -> tuple[FloatArray, FloatArray]:
    """Gradient and Hessian of frames, then everybody's places and numbers, from residuals by central differences."""
    seen, model, base = window.seen, window.model, point.frames.size
    spans = [(int(a), int(b)) for a, b in zip(seen.first, seen.last, strict=True)]
    size = base + sum(2 * (last - first + 1) + 2 for first, last in spans)
    alone = parts_alone(window, point)
    gradient, hessian = np.zeros(size), np.zeros((size, size))
    gradient[:base], hessian[:base, :base] = alone.gradient, symmetric(alone.hessian)
    at = base
    for k, (first, last) in enumerate(spans):
        n = last - first + 1
        own = np.concatenate((point.frames.ravel(), point.places[first : last + 1, k].ravel(), point.people[k]))
        where = np.concatenate((np.arange(base), at + np.arange(2 * n + 2)))

        def values(own: FloatArray, k: int = k, first: int = first, n: int = n) -> FloatArray:
            track = own[base : base + 2 * n].reshape(n, 2).copy()
            frames = own[:base].reshape(-1, FRAME).copy()
            return residuals_of(k, first, seen.boxes, frames, track, own[-2:].copy(), model.noise).value.ravel()

        jacobian = np.stack(
            [(values(own + STEP * e) - values(own - STEP * e)) / (2.0 * STEP) for e in np.eye(len(own))], axis=1
        )
        found = residuals(window, point, k)
        white, omega = whiten(found, model.noise, model.dt), np.zeros((found.value.size,) * 2)
        for i in range(len(found.frame)):
            for j in range(CUES):
                omega[CUES * i + j, CUES * i + j] = white.diagonal[i, j]
                if i > 0:
                    omega[CUES * i + j, CUES * i + j - CUES] = omega[CUES * i + j - CUES, CUES * i + j] = white.beside[
                        i, j
                    ]
        np.testing.assert_allclose(omega @ found.value.ravel(), white.force.ravel(), atol=1e-9)
        gradient[where] += jacobian.T @ white.force.ravel()
        hessian[np.ix_(where, where)] += jacobian.T @ omega @ jacobian
        weights, band = np.zeros(n), np.zeros((n, 5))
        track = point.places[first : last + 1, k].copy()
        reweigh(track, model.walk, model.walk.sigma, weights, point.variances[k])
        add_walk(weights, model.walk, band)
        walked = sum(np.diag(band[e:, e], -e) + np.diag(band[e:, e], e) * (e > 0) for e in range(min(5, n)))
        known = ~np.isnan(seen.given[first : last + 1, k, 0])
        for a in range(2):
            axis = at + a + 2 * np.arange(n)
            off = np.where(known, track[:, a] - np.nan_to_num(seen.given[first : last + 1, k, a]), 0.0)
            gradient[axis] += walked @ track[:, a] + off / ANCHOR_STD**2
            hessian[np.ix_(axis, axis)] += walked + np.diag(known / ANCHOR_STD**2 + SOMEWHERE)
        paced, pushed = np.zeros((2 * n + BAND, 2 * BAND + 1)), np.zeros(2 * n)
        add_pace(track, model.walk.pace, paced, pushed)
        gradient[at : at + 2 * n] += pushed
        for row, below in enumerate(paced[: 2 * n]):
            for e, value in enumerate(below[: 2 * n - row]):
                hessian[at + row + e, at + row] += value
                hessian[at + row, at + row + e] += value * (e > 0)
        numbers = at + 2 * n + np.arange(2)
        told = np.concatenate((at + np.arange(min(2 * n, PLACES)), numbers))
        kept = np.concatenate((np.arange(min(2 * n, PLACES)), PLACES + np.arange(2)))
        pull, _ = pull_of(seen.past, k, track, point.people[k])
        gradient[told] += pull[kept]
        hessian[np.ix_(told, told)] += seen.past.information[k][np.ix_(kept, kept)]
        gradient[numbers] += (point.people[k] - model.people.mean) / model.people.std**2
        hessian[numbers, numbers] += 1.0 / model.people.std**2
        at += 2 * n + 2
    return gradient, hessian


def test_eliminating_people_is_schur_s_complement_of_everything(window: Window) -> None:
    case = under(window, 0)
    point = shaken(case, 5, 0.5)
    gradient, hessian = dense(case, point)
    system, base = linearise(point, case.seen, case.model, 0.0), point.frames.size
    share = hessian[:base, base:] @ np.linalg.inv(hessian[base:, base:])
    reduced = hessian[:base, :base] - share @ hessian[base:, :base]
    scale = np.sqrt(np.outer(np.diag(reduced), np.diag(reduced)))
    np.testing.assert_allclose(symmetric(system.hessian) / scale, reduced / scale, atol=1e-5)
    pull = gradient[:base] - share @ gradient[base:]
    np.testing.assert_allclose(system.gradient, pull, rtol=1e-4, atol=1e-4 * np.abs(pull).max())
    assert np.linalg.eigvalsh(symmetric(system.hessian)).min() > 0.0
    step = np.random.default_rng(0).normal(0.0, 0.01, base)
    others = -np.linalg.solve(hessian[base:, base:], gradient[base:] + hessian[base:, :base] @ step)
    followed = [follow(person, step.reshape(-1, FRAME)) for person in system.people]
    together = np.concatenate([np.concatenate((track.ravel(), numbers)) for track, numbers in followed])
    np.testing.assert_allclose(together, others, atol=1e-4)


def test_covariances_are_blocks_of_the_inverse_of_everything(window: Window) -> None:
    case, newest = under(window, 0), len(window.point.frames) - 1
    point = shaken(case, 5, 0.5)
    inverse = np.linalg.inv(dense(case, point)[1])
    poses, places, early = spread_of(linearise(point, case.seen, case.model, 0.0), case.seen, newest, True)
    here = slice(FRAME * newest, FRAME * newest + 3)
    np.testing.assert_allclose(poses, MODEL_ERROR[0] * inverse[None, here, here], rtol=1e-3, atol=1e-9)
    here = slice(FRAME * HELD, FRAME * HELD + 3)
    np.testing.assert_allclose(early, MODEL_ERROR[0] * inverse[here, here], rtol=1e-3, atol=1e-9)
    at, shown = point.frames.size, ~np.isnan(case.seen.boxes.azimuth[newest])
    assert shown.any()
    for k, (first, last) in enumerate(zip(case.seen.first, case.seen.last, strict=True)):
        if shown[k]:
            own = slice(at + 2 * (newest - first), at + 2 * (newest - first) + 2)
            np.testing.assert_allclose(places[0, k], MODEL_ERROR[1] * inverse[own, own], rtol=1e-3, atol=1e-9)
        else:
            assert np.isnan(places[0, k]).all()
        at += 2 * (last - first + 1) + 2


def test_given_poses_do_not_move(window: Window) -> None:
    fixed = np.arange(len(window.point.frames)) < 2
    system = linearise(shaken(window, 1), window.seen._replace(fixed=fixed), window.model, 0.0)
    for p in (0, 1, 2, FRAME, FRAME + 2):
        assert system.gradient[p] == 0.0
        row = symmetric(system.hessian)[p].copy()
        row[p] -= 1.0
        np.testing.assert_array_equal(row, 0.0)


def test_cholesky_s_factor_solves_and_says_if_there_is_none() -> None:
    rng = np.random.default_rng(0)
    half = rng.normal(size=(20, 20))
    matrix = half @ half.T + np.eye(20)
    lower, right = matrix.copy(), rng.normal(size=20)
    wanted = np.linalg.solve(matrix, right)
    assert factor(lower)
    solve(lower, right)
    np.testing.assert_allclose(right, wanted, rtol=1e-9)
    np.testing.assert_allclose(np.tril(lower).T @ np.tril(lower), matrix, rtol=1e-9, atol=1e-9)
    assert not factor(matrix - 200.0 * np.eye(20))
    assert not factor(np.full((3, 3), np.nan))
