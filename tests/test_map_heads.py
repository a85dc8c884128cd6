"""The prior of the observer's head: its derivatives, what it believes of true heads, and that it helps where it may."""

import tomllib
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from tests.solver_runs import run, walk
from vbbench.geometry import FloatArray, wrap_angle
from vbbench.sequence import Truth
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.motion.heads import FOLLOWERS, evidence, head_of, judge, strays, turn, weigh
from vbbench_baselines.joint_map.motion.walks import walk_of
from vbbench_baselines.joint_map.one_step import own_terms
from vbbench_baselines.joint_map.prior import PRIORS, Prior, get_prior
from vbbench_baselines.joint_map.priors.turns import (
    AT_ONCE,
    FOLLOWING,
    HELD_OUT,
    LAGGING,
    LEAST_FOLLOW,
    LOOSE,
    WANDERING,
    fit_head,
)

DT = 0.4
PRIOR = Prior(lag=(0.8, 0.1), follow_scale=(0.03, 0.08), yaw_scale=0.15, following=(0.4, 0.2))
NOTHING = np.zeros(FOLLOWERS)
HEAD = walk_of(PRIOR, DT).head
METRES, ANGLES = st.floats(-2.0, 2.0), st.floats(-1.2, 1.2)
POSES = st.lists(st.tuples(METRES, METRES, ANGLES), min_size=2, max_size=2).map(np.array)


def headed(seed: int, *, lag: float = 0.8, wander: float = 0.0, frames: int = 30) -> FloatArray:
    """Poses [T, 3] of a walk in curves; the head follows the steps with a lag, or turns at random by ``wander``."""
    rng = np.random.default_rng(seed)
    course = np.cumsum(rng.normal(0.0, 0.25, frames))
    steps = 0.5 * np.column_stack((np.cos(course), np.sin(course)))
    places, yaw, gain = np.cumsum(steps, axis=0), course[0], 1.0 - np.exp(-DT / lag)
    poses = [(*places[0], yaw)]
    for place, towards in zip(places[1:], course[1:], strict=True):
        heading = (1.0 - gain) * np.exp(1j * yaw) + gain * np.exp(1j * towards)
        yaw = yaw + rng.normal(0.0, wander) if wander else float(np.angle(heading))
        poses.append((*place, yaw))
    return np.array(poses)


@settings(deadline=None)
@given(POSES, st.integers(0, FOLLOWERS - 1))
def test_derivatives_are_those_of_the_residual(pair: FloatArray, law: int) -> None:
    off, moved, slopes = turn(pair[0], pair[1], HEAD, law)
    residuals = np.empty(FOLLOWERS + 1)
    strays(pair[0], pair[1], HEAD, residuals)
    assert (residuals[law], residuals[-1]) == pytest.approx((off, moved), abs=1e-12)
    scale = max(1.0, np.abs(slopes).max() ** 2)
    for i in range(6):
        step = np.zeros(6)
        step[i] = 1e-6
        ahead, behind = pair + step.reshape(2, 3), pair - step.reshape(2, 3)
        numeric = wrap_angle(turn(ahead[0], ahead[1], HEAD, law)[0] - turn(behind[0], behind[1], HEAD, law)[0]) / 2e-6
        assert slopes[i] == pytest.approx(numeric, abs=1e-4 * scale)


@settings(deadline=None)
@given(POSES, st.floats(-np.pi, np.pi), METRES)
def test_a_head_turns_alike_wherever_it_is(pair: FloatArray, angle: float, shift: float) -> None:
    sin, cos = np.sin(angle), np.cos(angle)
    moved = pair.copy()
    moved[:, :2] = pair[:, :2] @ np.array(((cos, sin), (-sin, cos))) + shift
    moved[:, 2] += angle
    np.testing.assert_allclose(turn(moved[0], moved[1], HEAD, 0)[:2], turn(pair[0], pair[1], HEAD, 0)[:2], atol=1e-9)


def test_who_stands_holds_the_head() -> None:
    still = np.array(((0.0, 0.0, 0.3), (0.0, 0.001, 0.3)))
    off, moved, _ = turn(still[0], still[1], HEAD, 0)
    assert moved == 0.0
    assert abs(off) < 0.01


def test_normal_laws_touch_the_deviance_from_above() -> None:
    poses, away = headed(1), headed(2, wander=0.1)
    for point in (poses, away):
        weights = np.empty((len(point), FOLLOWERS + 1))
        here = judge(point, HEAD, NOTHING, weights)
        rng = np.random.default_rng(3)

        def quadratic(poses: FloatArray, weights: FloatArray = weights) -> float:
            residuals = np.empty((len(poses), FOLLOWERS + 1))
            for before, now, row in zip(poses[:-1], poses[1:], residuals[1:], strict=True):
                strays(before, now, HEAD, row)
            return float(0.5 * np.sum(weights[1:] * residuals[1:] ** 2))

        for size in (1e-3, 1e-2, 0.1):
            near = point + rng.normal(0.0, size, point.shape)
            change = judge(near, HEAD, NOTHING, np.empty_like(weights)) - here
            assert change <= quadratic(near) - quadratic(point) + 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_a_sequence_tells_whether_the_head_follows(seed: int) -> None:
    assert evidence(headed(seed), HEAD)[0] > 10.0
    assert evidence(headed(seed, wander=0.3), HEAD).max() < -5.0
    loose = evidence(headed(seed, lag=0.02, wander=0.0), HEAD)
    assert loose[1] > max(loose[0], 0.0)
    never = HEAD._replace(odds=np.full(FOLLOWERS, -np.inf))
    weights = np.empty((30, FOLLOWERS + 1))
    judge(headed(seed), never, NOTHING, weights)
    assert not weights[:, :-1].any()
    weigh(np.zeros(FOLLOWERS + 1), np.array((50.0, 0.0)), HEAD, weights[0])
    assert weights[0, 1:] == pytest.approx(0.0, abs=1e-12)


def test_evidence_of_parts_adds_up() -> None:
    poses = headed(4)
    assert evidence(poses, HEAD) == pytest.approx(evidence(poses[:13], HEAD) + evidence(poses[12:], HEAD))
    one, both = np.empty((18, FOLLOWERS + 1)), np.empty((30, FOLLOWERS + 1))
    judge(poses, HEAD, NOTHING, both)
    judge(poses[12:], HEAD, evidence(poses[:13], HEAD), one)
    np.testing.assert_allclose(one[1:], both[13:])


def test_the_observers_terms_are_derivatives_of_their_deviance() -> None:
    numbers, before, expected = walk_of(PRIOR, DT), np.array((0.0, 0.0, 0.2)), np.array((0.5, 0.1, 0.2))

    def deviance(pose: FloatArray) -> float:
        far = np.sum((pose[:2] - expected[:2]) ** 2) / (numbers.nu * 0.1**2)
        head = judge(np.stack((before, pose)), numbers.head, NOTHING, np.empty((2, FOLLOWERS + 1)))
        return float(0.5 * (numbers.nu + 2.0) * np.log1p(far) + head)

    for pose in (np.array((0.52, 0.05, 0.25)), np.array((0.4, 0.3, 0.5))):
        gradient, hessian = own_terms(pose, before, expected, 0.1, numbers)
        steps = 1e-6 * np.eye(3)
        numeric = [(deviance(pose + step) - deviance(pose - step)) / 2e-6 for step in steps]
        np.testing.assert_allclose(gradient, numeric, rtol=1e-4, atol=1e-4)
        assert np.linalg.eigvalsh(hessian)[0] > 0.0


def test_one_step_ends_where_nothing_is_likelier() -> None:
    """Against SciPy's minimum over the pose of the same deviance, people's places eliminated by hand."""
    poses = headed(5, frames=8)
    rng = np.random.default_rng(6)
    places = rng.uniform(-6.0, 6.0, (5, 2)) + rng.normal(0.0, 0.05, (8, 5, 2))
    truth = Truth(poses=poses, positions=places, heights=np.full(5, 1.7))
    prior = replace(PRIOR, nu=1e9, a0=1e9)
    found = run(MapCausal(prior=prior, learns=False), truth, "one-step").poses[7]
    numbers = walk_of(prior, DT)
    filters = numbers.filters[4, 1:, None]
    expected = -np.sum(filters[:, None] * places[6:2:-1], axis=0)
    walked = -np.sum(filters * poses[6:2:-1, :2], axis=0)
    cos, sin = np.cos(poses[7, 2]), np.sin(poses[7, 2])
    relative = (places[7] - poses[7, :2]) @ np.array(((cos, -sin), (sin, cos)))

    def deviance(pose: FloatArray) -> float:
        turned = np.array(((np.cos(pose[2]), np.sin(pose[2])), (-np.sin(pose[2]), np.cos(pose[2]))))
        off = np.sum((pose[:2] + relative @ turned - expected) ** 2) + np.sum((pose[:2] - walked) ** 2)
        return float(
            0.5 * off / prior.sigma**2
            + judge(np.stack((poses[6], pose)), numbers.head, NOTHING, np.empty((2, FOLLOWERS + 1)))
        )

    best = minimize(deviance, poses[7], method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-10})
    np.testing.assert_allclose(found, best.x, atol=2e-3)


@pytest.mark.parametrize("protocol", ["one-step", "sequential"])
def test_a_head_that_follows_tells_of_the_path(protocol: str) -> None:
    """In curves, people far and near at unsteady walks."""
    errors = np.zeros(2)
    for seed in range(12):
        poses, rng = headed(seed, frames=16), np.random.default_rng(seed)
        around = poses[:, None, :2] + rng.uniform(-6.0, 6.0, (5, 2)) + rng.normal(0.0, 0.04, (16, 5, 2))
        truth = Truth(poses=poses, positions=around, heights=np.full(5, 1.7))
        for i, following in enumerate(((0.0, 0.0), (0.3, 0.3))):
            solver = MapCausal(prior=replace(get_prior("default"), following=following))
            found = run(solver, truth, protocol).poses
            errors[i] += np.hypot(*(found - truth.poses)[2:, :2].T).mean()
    assert errors[1] < 0.9 * errors[0]


@pytest.mark.slow
def test_a_wandering_head_is_told_from_a_following_one() -> None:
    """Where the head has nothing to do with the path, believing that it may costs little."""
    errors = np.zeros((24, 2))
    for seed in range(24):
        truth = walk(seed, frames=30, wobble=0.04)
        yaw = truth.poses[:, 2] + np.cumsum(np.random.default_rng(seed).normal(0.0, 0.25, 30))
        truth = replace(truth, poses=np.column_stack((truth.poses[:, :2], yaw)))
        for i, following in enumerate(((0.0, 0.0), get_prior("default").following)):
            solver = MapCausal(prior=replace(get_prior("default"), following=following))
            found = run(solver, truth, "sequential").poses
            errors[seed, i] = np.hypot(*(found - truth.poses)[2:, :2].T).mean()
    assert errors[:, 1].mean() < 1.2 * errors[:, 0].mean()
    assert np.median(errors[:, 1]) < 1.2 * np.median(errors[:, 0])


def test_the_fit_finds_lag_and_scales() -> None:
    following = np.concatenate([pairs(headed(seed, lag=1.2)) for seed in range(40)])
    wandering = np.concatenate([pairs(headed(seed, wander=0.3)) for seed in range(40)])
    loose = np.concatenate([pairs(headed(seed, lag=0.05)) for seed in range(40)])
    prior = fit_head([{"motion": following, "sway": loose, "wander": wandering}], Prior())
    assert prior.lag == pytest.approx((1.2, AT_ONCE), rel=0.15)
    assert prior.follow_scale == LEAST_FOLLOW
    assert 0.1 < prior.yaw_scale < 0.3
    assert prior.following == FOLLOWING


def test_a_law_of_which_nothing_is_seen_is_not_believed_in() -> None:
    loose = np.concatenate([pairs(headed(seed, lag=0.3)) for seed in range(10)])
    prior = fit_head([{"ahead": loose}], Prior())
    assert prior.following == (0.0, FOLLOWING[1])
    assert head_of(prior).odds[0] == -np.inf


@pytest.mark.parametrize("name", PRIORS)
def test_one_way_of_looking_is_held_out_of_every_committed_fit(name: str) -> None:
    text = (files("vbbench_baselines") / "joint_map" / "priors" / f"{name}.toml").read_text("utf-8")
    for split in tomllib.loads(text)["fitted_on"]:
        assert HELD_OUT not in split["heads"]
        assert len(split["heads"]) == len((*LAGGING, *LOOSE, *WANDERING)) - 1


def pairs(poses: FloatArray) -> FloatArray:
    return np.stack((poses[:-1], poses[1:]), axis=1)
