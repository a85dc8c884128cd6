"""What one-step learns from the revealed past: that it is what walks were made of, and that it is used."""

import numpy as np
import pytest

from tests.solver_runs import run, walk
from vbbench.geometry import FloatArray, wrap_angle
from vbbench_baselines.common.ego_motion import Factors, fit_pose
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.motion.learning import Lessons, learn, nothing_learned, taught
from vbbench_baselines.joint_map.motion.walks import REACH, Walk, walk_of
from vbbench_baselines.joint_map.one_step import PAST, foresee
from vbbench_baselines.joint_map.prior import Prior

FITTED = Prior(b=(-0.3, -0.1), sigma=0.05, nu=6.0, a0=8.0)


def walks(b: tuple[float, float], sigma: float, frames: int, people: int) -> FloatArray:
    """Walks [T, K, 2] with normal innovations."""
    e = np.random.default_rng(1).normal(0.0, sigma, (frames, people, 2))
    a = np.zeros_like(e)
    for t in range(2, frames):
        a[t] = b[0] * a[t - 1] + b[1] * a[t - 2] + e[t]
    return np.asarray(np.cumsum(np.cumsum(a, axis=0), axis=0))


def lesson(places: FloatArray, fitted: Walk) -> tuple[Walk, Lessons]:
    """What follows from places [T, K, 2], the last of which is the observer's."""
    lessons = nothing_learned(places.shape[1] - 1, fitted, FITTED)
    for t in range(1, len(places) + 1):
        past = places[max(t - PAST, 0) : t]
        poses = np.column_stack((past[:, -1], np.zeros(len(past))))
        learn(np.ascontiguousarray(past[:, :-1]), poses, fitted, lessons)
    return taught(fitted, lessons), lessons


def coefficients(walk: Walk) -> tuple[float, float]:
    return -2.0 - walk.filters[REACH, 1], -walk.filters[REACH, 4]


def test_nothing_revealed_leaves_the_fitted_prior() -> None:
    fitted = walk_of(FITTED, 0.4)
    walk, lessons = lesson(np.full((4, 3, 2), np.nan), fitted)
    assert coefficients(walk) == pytest.approx(FITTED.b)
    assert walk.sigma == pytest.approx(FITTED.sigma)
    np.testing.assert_allclose(lessons.variances, FITTED.sigma**2)


def test_many_walks_teach_what_they_were_made_of() -> None:
    walk, lessons = lesson(walks((-0.6, -0.3), 0.1, 60, 30), walk_of(FITTED, 0.4))
    assert coefficients(walk) == pytest.approx((-0.6, -0.3), abs=0.05)
    # Normal innovations under a Student-t law: the scale that fits is a little below the deviation.
    assert walk.sigma == pytest.approx(0.1, rel=0.2)
    np.testing.assert_allclose(np.sqrt(lessons.variances), walk.sigma, rtol=0.25)


def test_straight_lines_do_not_leave_the_stationary_walks() -> None:
    """Walks at exactly constant second differences would make b one, and all innovations nought."""
    times = np.arange(30.0)[:, None, None]
    walk, _ = lesson(np.tile(0.5 * 0.2 * times**2, (1, 4, 2)), walk_of(FITTED, 0.4))
    b1, b2 = coefficients(walk)
    assert abs(b2) < 1.0
    assert abs(b1) < 1.0 - b2
    assert np.isfinite(walk.spreads).all()
    assert walk.sigma > 0.0


def test_a_blank_frame_is_foreseen_and_its_error_carried_on() -> None:
    walk = walk_of(FITTED, 0.4)
    track = walks(FITTED.b, FITTED.sigma, 6, 1)[:, 0]
    filled = track.copy()
    filled[5] = foresee(track[:5], walk, 0.01)[:2]
    track[5] = np.nan
    *place, std = foresee(track, walk, 0.01)
    np.testing.assert_allclose(place, foresee(filled, walk, 0.01)[:2])
    assert std == pytest.approx(0.1 * np.hypot(1.0, 2.0 + FITTED.b[0]))
    track[4] = np.nan
    assert np.isnan(foresee(track, walk, 0.01)).all()


def test_the_spread_across_a_blank_frame_is_that_of_walks() -> None:
    prior = Prior(b=(-0.5, -0.2), sigma=0.1)
    walk, errors = walk_of(prior, 0.4), []
    for track in walks(prior.b, prior.sigma, 7, 4000).transpose(1, 0, 2):
        past = track[:6].copy()
        past[5] = np.nan
        *place, std = foresee(past, walk, prior.sigma**2)
        errors.append(track[6] - place)
    assert np.std(errors) == pytest.approx(std, rel=0.05)


@pytest.mark.parametrize("information", [0.0, 1.0, 1e8])
def test_known_yaw_holds_the_pose_as_much_as_it_is_worth(information: float) -> None:
    rng = np.random.default_rng(0)
    places, predicted = rng.uniform(-5, 5, (5, 2)), np.array((0.0, 0.0, 0.3))
    seen = rng.uniform(-5, 5, (5, 2))
    terms = Factors(seen, np.tile((0.01, 0.0, 0.01), (5, 1)), places, np.full(5, 0.1), predicted, 0.1)
    free, held = fit_pose(terms), fit_pose(terms, information)
    assert abs(wrap_angle(held[2] - 0.3)) <= abs(wrap_angle(free[2] - 0.3)) + 1e-6
    if information > 1e6:
        assert held[2] == pytest.approx(0.3, abs=1e-3)


def test_map_batch_on_a_known_past_is_map_causal() -> None:
    truth = walk(3, frames=10, wobble=0.03)
    causal = run(MapCausal(), truth, "one-step", pixel_std=1.0)
    batch = run(MapBatch(), truth, "one-step", pixel_std=1.0)  # type: ignore[arg-type]
    np.testing.assert_allclose(batch.poses[2:], causal.poses[2:], atol=1e-12)
    np.testing.assert_allclose(batch.positions[2:], causal.positions[2:], atol=1e-12)
