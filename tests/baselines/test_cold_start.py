"""Cold starts of every solver: nothing given but the observer's pose in frame 0, and starts that are hard."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, DT, answer, problem_of, see, walk
from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray
from vbbench.protocol import get_protocol
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Estimate
from vbbench.solving.runner import frames_of
from vbbench_baselines.extrapolation import ConstantVelocity, SocialForce
from vbbench_baselines.joint_map import MapBatch, MapCausal
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

BIRDIFIERS = (ConstantVelocityBirdifier, SocialForceBirdifier, MapCausal, MapBatch)
SOLVERS: list[Callable[[], Any]] = [ConstantVelocity, SocialForce, *BIRDIFIERS]
FARTHEST = 50.0
"""In m: no answer may be further off."""

FRAMES, PEOPLE = 14, 6
COLD = get_protocol("cold-start")


def cold(truth: Truth, camera: Camera, pixel_std: float = 1.0) -> Sequence:
    """What the camera sees of ``truth``, with its pose in frame 0 given."""
    sequence = see(truth, camera, pixel_std)
    return replace(sequence, given=COLD.select_given(sequence.given))


def crossing(seed: int, speed: float = 1.0) -> Truth:
    """People who walk every way before an observer of this speed in m/s."""
    truth = walk(seed, FRAMES, PEOPLE, wobble=0.01)
    rng, time = np.random.default_rng(seed), DT * np.arange(FRAMES)
    along = np.stack((np.zeros(FRAMES), time), axis=-1)
    poses = np.concatenate((speed * along, truth.poses[:, 2:]), axis=1)
    start = np.column_stack((rng.uniform(-2.0, 2.0, PEOPLE), rng.uniform(6.0, 12.0, PEOPLE)))
    velocity = rng.normal(0.0, 0.7, (PEOPLE, 2))
    positions = start + time[:, None, None] * velocity + 0.5 * speed * along[:, None]
    return Truth(poses=poses, positions=positions + rng.normal(0.0, 0.01, positions.shape), heights=truth.heights)


def only(shown: BoolArray) -> Callable[[Truth], Truth]:
    """Leaves out whoever is not ``shown`` [T, K]."""
    return lambda truth: replace(truth, positions=np.where(shown[..., None], truth.positions, np.nan))


T, K = np.arange(FRAMES)[:, None], np.arange(PEOPLE)[None]
HARD: dict[str, Callable[[Truth], Truth]] = {
    "everybody": lambda truth: truth,
    "nobody in frame 0": only((T > 0) & (K >= 0)),
    "nobody in the first five frames": only((T > 4) & (K >= 0)),
    "nobody at all after frame 1": only((T < 2) & (K >= 0)),
    "a lone person": only((K == 0) & (T >= 0)),
    "a lone person now and then": only((K == 0) & (T % 3 == 0)),
    "each for one frame": only(K == T % PEOPLE),
    "each for two frames": only(K == T // 2 % PEOPLE),
    "others in frame 1": only((K < 3) == (T == 0)),
    "all gone for a while": only((T < 4) | (T > 9) | (K < 0)),
    "a car": lambda truth: replace(truth, poses=truth.poses + 9.0 * DT * np.arange(FRAMES)[:, None] * (0.0, 1.0, 0.0)),
    "on top of each other": lambda truth: replace(truth, positions=np.repeat(truth.positions[:, :1], PEOPLE, axis=1)),
}


@pytest.mark.slow
@pytest.mark.parametrize("start", HARD)
@pytest.mark.parametrize("make", SOLVERS)
def test_no_start_is_too_hard(make: Callable[[], Any], start: str) -> None:
    truth, camera = HARD[start](crossing(3)), CAMERAS[list(HARD).index(start) % 2]
    sequence = cold(truth, camera)
    estimate = answer(make(), sequence, "cold-start", camera, covariances=True)
    seen = sequence.observed
    assert np.abs(estimate.poses - truth.poses)[:, :2].max() < FARTHEST
    assert np.abs(estimate.positions - truth.positions)[seen].max(initial=0.0) < FARTHEST
    np.testing.assert_allclose(estimate.poses[0], truth.poses[0], atol=1e-9)
    if estimate.pose_covariances is not None and estimate.position_covariances is not None:
        assert np.isfinite(estimate.pose_covariances).all()
        assert np.isfinite(estimate.position_covariances[seen]).all()
        assert (np.linalg.eigvalsh(estimate.position_covariances[seen]) > 0.0).all()


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
@pytest.mark.parametrize("make", SOLVERS)
def test_boxes_that_are_not_finite_are_not_seen(make: Callable[[], Any], camera: Camera) -> None:
    """As if they were not there; a submission still needs an answer for them, so the solver is asked directly."""
    sequence = cold(crossing(5), camera)
    broken, absent = np.array(sequence.observations), np.array(sequence.observations)
    for t, k, value in ((0, 1, np.inf), (1, 2, -np.inf), (3, 0, np.nan), (4, 4, 1e300)):
        broken[t, k, k % 3], absent[t, k] = value, np.nan
    problem = problem_of(sequence, camera, 1.0)
    answers = [_solve(make(), problem, boxes, sequence) for boxes in (broken, absent)]
    np.testing.assert_array_equal(answers[0].poses, answers[1].poses)
    assert np.isfinite(answers[0].poses).all()


def _solve(solver: Any, problem: Any, boxes: FloatArray, sequence: Sequence) -> Estimate:
    if hasattr(solver, "solve"):
        estimate: Estimate = solver.solve(problem, boxes, sequence.given)
        return estimate
    solver.start(problem)
    shown = replace(sequence, observations=boxes)
    return Estimate.of_frames([solver.step(frame) for frame in frames_of(shown, shown.given, shown.given)])


@pytest.mark.parametrize("make", SOLVERS)
def test_people_who_stand_show_how_the_observer_moves(make: Callable[[], Any]) -> None:
    """People as tall as expected who do not move; solvers cannot know that they all stand.

    Where the joint solvers take people who stand for people who walk, their covariances include the truth.
    """
    for speed in (0.0, 1.0, 3.0):
        truth = crossing(7, speed)
        standing = np.broadcast_to(truth.positions[0], truth.positions.shape)
        truth = replace(truth, positions=standing, heights=np.full(PEOPLE, 1.7))
        joint, way = make in (MapCausal, MapBatch), speed * DT * (FRAMES - 1)
        estimate = answer(make(), cold(truth, CAMERAS[0], 0.0), covariances=joint)
        off = (estimate.poses - truth.poses)[-1, :2]
        if joint:
            assert off @ np.linalg.solve(estimate.pose_covariances[-1, :2, :2], off) < 9.0
        assert np.hypot(*off) < (1.2 * way if joint and speed == 1.0 else 1.5 + 0.6 * way)
    assert way > 15.0


@pytest.mark.parametrize("make", BIRDIFIERS)
def test_where_people_are_from_the_observer_is_known_from_the_boxes(make: Callable[[], Any]) -> None:
    errors = []
    for seed in range(4):
        truth = crossing(seed)
        estimate = answer(make(), cold(truth, CAMERAS[0]))
        away = (estimate.positions - estimate.poses[:, None, :2]) - (truth.positions - truth.poses[:, None, :2])
        errors.append(np.nanmean(np.hypot(*np.moveaxis(away[2:], -1, 0))))
    assert np.mean(errors) < 1.5


def test_the_unknown_velocity_of_all_is_in_the_covariance() -> None:
    """The pose becomes less sure with time, and is off by about what its covariance says."""
    growth, normalised = [], []
    for seed in range(12):
        truth = crossing(seed)
        estimate = answer(MapCausal(), cold(truth, CAMERAS[0]), covariances=True)
        place = estimate.pose_covariances[:, :2, :2]
        growth.append(np.trace(place[-1]) / np.trace(place[2]))
        off = (estimate.poses - truth.poses)[-1, :2]
        normalised.append(off @ np.linalg.solve(place[-1], off))
    assert min(growth) > 1.0
    assert np.median(growth) > 5.0
    assert 0.1 < np.mean(normalised) < 6.0


@pytest.mark.parametrize("make", [ConstantVelocity, SocialForce, ConstantVelocityBirdifier])
def test_where_nobody_is_seen_the_observer_comes_to_rest(make: Callable[[], Any]) -> None:
    truth, later = crossing(3, 3.0), 40
    poses = np.concatenate((truth.poses, np.repeat(truth.poses[-1:], later, axis=0)))
    positions = np.concatenate((truth.positions, np.full((later, PEOPLE, 2), np.nan)))
    sequence = cold(replace(truth, poses=poses, positions=positions), CAMERAS[0])
    steps = np.hypot(*np.diff(answer(make(), sequence).poses[:, :2], axis=0).T)
    assert steps[-1] < 0.3 * steps[FRAMES - 2]
