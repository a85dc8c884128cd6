"""The naive baseline: exact where nothing errs, its fit and filters against closed forms, and whatever is missing."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, DT, answer, measured, run, see, showing, walk
from vbbench.camera import Camera
from vbbench.geometry import FloatArray, relative_to_world, wrap_angle
from vbbench.protocol import PROTOCOLS, get_protocol
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Estimate
from vbbench_baselines.ground_plane import ACCELERATION, FLOOR, SPEED, GroundPlane, rigid_fit

MEAN = 1.7
"""Of the heights of `problem_of`, in m."""
EXACT = 1e-6 * np.eye(3)
"""Covariance of odometry."""


def alike(seed: int, frames: int = 12) -> Truth:
    """People of mean height, who stand, about an observer who walks."""
    truth = walk(seed, frames)
    positions = np.broadcast_to(truth.positions[:1] + np.array((0.0, 6.0)), truth.positions.shape)
    return replace(truth, positions=np.array(positions), heights=np.full(len(truth.heights), MEAN))


def answers(sequence: Sequence, camera: Camera, **asked: Any) -> Estimate:
    return answer(GroundPlane(), sequence, camera=camera, **{"pixel_std": 0.0, "covariances": True, **asked})


@pytest.mark.parametrize("camera", CAMERAS)
def test_exact_boxes_and_odometry_give_the_exact_map_of_people_who_stand(camera: Camera) -> None:
    truth = alike(3)
    estimate = answers(see(truth, camera, odometry=measured(truth, EXACT)), camera)
    np.testing.assert_allclose(estimate.poses[:, :2], truth.poses[:, :2], atol=1e-9)
    np.testing.assert_allclose(wrap_angle(estimate.poses[:, 2] - truth.poses[:, 2]), 0.0, atol=1e-9)
    np.testing.assert_allclose(estimate.positions, truth.positions, atol=1e-6)


@pytest.mark.parametrize("camera", CAMERAS)
def test_one_step_follows_people_who_walk(camera: Camera) -> None:
    truth = replace(walk(4, 12), heights=np.full(6, MEAN))
    estimate = run(GroundPlane(), truth, "one-step", camera)
    assert np.hypot(*(estimate.poses - truth.poses)[2:, :2].T).max() < 0.05
    assert np.hypot(*np.moveaxis((estimate.positions - truth.positions)[2:], -1, 0)).max() < 0.05


def test_the_rigid_fit_recovers_a_motion() -> None:
    rng = np.random.default_rng(1)
    pose, relative = np.array((3.0, -2.0, 2.4)), rng.uniform((-4.0, 2.0), (4.0, 12.0), (5, 2))
    weights, vague = rng.uniform(1.0, 9.0, 5), (np.zeros(3), 1e-12)
    found, covariance = rigid_fit(relative, relative_to_world(relative, pose), weights, vague)
    np.testing.assert_allclose(found, pose, atol=1e-9)
    np.testing.assert_allclose(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_the_rigid_fit_minimises_the_weighted_squares() -> None:
    rng = np.random.default_rng(2)
    relative, places = rng.normal(0.0, 4.0, (2, 6, 2))
    weights, expected, trust = rng.uniform(0.5, 4.0, 6), np.array((0.5, 0.2, 0.3)), 7.0
    sides = np.array([[-1.0, 0.0], [1.0, 0.0]])

    def cost(pose: FloatArray) -> float:
        off = relative_to_world(relative, pose) - places
        away = relative_to_world(sides, pose) - relative_to_world(sides, expected)
        return float((weights * (off**2).sum(axis=1)).sum() + 0.5 * trust * (away**2).sum())

    found, _ = rigid_fit(relative, places, weights, (expected, trust))
    around = found + rng.normal(0.0, 0.05, (200, 3))
    assert all(cost(pose) > cost(found) for pose in around)


@pytest.mark.parametrize("seen", [(1, 1, 1, 1), (1, 0, 0, 1), (1, 1, 0, 1)])
def test_the_filter_is_the_conditional_distribution(seen: tuple[int, ...]) -> None:
    """Of a person's place, given all boxes, in closed form: an integrated Wiener process, conditioned."""
    camera, frames = CAMERAS[0], len(seen)
    truth = replace(walk(5, frames, people=1), heights=np.full(1, MEAN), poses=np.zeros((frames, 3)))
    rng = np.random.default_rng(0)
    path = np.column_stack([5.0 + rng.normal(0.0, 0.1, frames), rng.normal(0.0, 0.1, frames)])
    sequence = see(replace(truth, positions=path[:, None]), camera, odometry=measured(truth, EXACT))
    boxes = np.where(np.array(seen, bool)[:, None, None], sequence.observations, np.nan)
    sequence = showing(sequence, boxes)
    estimate = answers(sequence, camera, height_std=0.0)

    first, *others = np.flatnonzero(seen)
    since = DT * (np.array(others) - first)
    less, more = np.minimum(since[:, None], since), np.maximum(since[:, None], since)
    prior = SPEED**2 * less * more + ACCELERATION * less**2 * (3.0 * more - less) / 6.0 + FLOOR**2
    gain = prior @ np.linalg.inv(prior + FLOOR**2 * np.eye(len(others)))
    expected, spread = path[first] + gain @ (path[others] - path[first]), prior - gain @ prior
    np.testing.assert_allclose(estimate.positions[others[-1], 0], expected[-1], atol=1e-6)
    pose = 1e-4 + 1e-6 * others[-1]
    np.testing.assert_allclose(estimate.position_covariances[others[-1], 0, 0, 0], spread[-1, -1] + pose, rtol=2e-2)


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_no_warning_and_an_answer_for_everybody_whatever_is_missing(camera: Camera, protocol: str) -> None:
    truth = walk(6, 14)
    sequence = see(truth, camera, 1.0)
    boxes = sequence.observations.copy()
    boxes[4:7] = np.nan  # nobody
    boxes[8:, 1:] = np.nan  # one person
    boxes[2:, 0, 2] = 1e-3  # a box of no height
    sequence = showing(sequence, boxes)
    shown = truth if get_protocol(protocol).needs_truth else None
    with np.errstate(all="raise"):
        estimate = answers(sequence, camera, protocol=protocol, pixel_std=1.0, truth=shown)
    assert np.isfinite(estimate.poses).all()
    assert np.isfinite(estimate.positions[sequence.observed]).all()
    for spreads in (estimate.pose_covariances[1:], estimate.position_covariances[sequence.observed]):
        assert np.linalg.eigvalsh(spreads).min() > 0.0


def test_given_places_after_a_gap_bring_the_pose_back() -> None:
    truth = walk(7, 40)
    sequence = see(truth, CAMERAS[0], 1.0)
    boxes, given = sequence.observations.copy(), np.array(sequence.given.positions)
    boxes[3:30] = np.nan
    given[30] = truth.positions[30]
    sequence = showing(sequence, boxes, given=replace(sequence.given, positions=given))
    estimate = answers(sequence, CAMERAS[0], protocol="sequential", pixel_std=1.0)
    assert not estimate.converged[29]
    assert estimate.converged[30]
    assert np.hypot(*(estimate.poses - truth.poses)[30, :2]) < 0.6


def test_covariances_hold_most_errors_of_people_with_odometry() -> None:
    squares = []
    for seed in range(20):
        truth = walk(seed, 20)
        sequence = see(truth, CAMERAS[1], 1.0, seed, measured(truth, EXACT))
        estimate = answers(sequence, CAMERAS[1], pixel_std=1.0)
        off = estimate.positions - truth.positions
        seen = sequence.observed
        spread = estimate.position_covariances[seen]
        squares.append(np.einsum("ni,nij,nj->n", off[seen], np.linalg.inv(spread), off[seen]))
    assert 0.8 < (np.concatenate(squares) < 6.18).mean() < 1.0
