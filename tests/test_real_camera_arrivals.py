"""People who arrive tell a rough camera of the poses that it holds, and how sure it may be of them afterwards."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given as of
from hypothesis import strategies as st
from scipy.optimize import least_squares

from tests.rough_crowd import LEVEL, Drive, drive, made_drive, photograph
from vbbench.geometry import FloatArray, moved_as_one, relative_to_world, world_to_relative
from vbbench_baselines.common.bearings import Bearings, bearings_of
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.real_camera.alone import ACROSS, ALONG, places_alone, spread_alone
from vbbench_baselines.joint_map.real_camera.arrivals import UncertainPose, corrected

STRANGER = np.array((np.log(1.7), 0.45))
HELD, NEWEST = np.array((2.0, -1.0, 0.6)), np.array((3.0, 1.5, 0.9))
SHOWN = np.array(((-2.0, 9.0), (3.0, 12.0), (0.5, 6.0)))
"""Where three people stand before the newest pose."""


def spread(scale: float, seed: int) -> FloatArray:
    """A covariance [3, 3] of a pose."""
    root = np.random.default_rng(seed).normal(0.0, scale, (3, 3)) * (1.0, 1.0, 0.1)
    return np.asarray(root.T @ root + 1e-4 * np.eye(3))


def seen(frames: int = 2) -> Bearings:
    """Boxes of the three in the newest frame alone."""
    boxes = np.full((frames, len(SHOWN), 3), np.nan)
    boxes[-1] = LEVEL.project(SHOWN, np.full(len(SHOWN), 1.7))
    return bearings_of(LEVEL, boxes)


def shown(boxes: Bearings) -> FloatArray:
    return places_alone(boxes.azimuth[-1], boxes.length[-1], STRANGER)


def placed(places: FloatArray) -> FloatArray:
    return np.stack((np.full(places.shape, np.nan), places))


def best(held: UncertainPose, newest: UncertainPose, places: FloatArray, boxes: Bearings) -> FloatArray:
    """The move [3] of the pose held that is most probable with the one [3] of the newest that it leaves open."""
    roots = [np.linalg.cholesky(np.linalg.inv(pose.covariance)).T for pose in (held, newest)]
    alone = shown(boxes)
    reach = np.linalg.norm(alone, axis=1)
    rays = alone / reach[:, None]

    def residuals(moves: FloatArray) -> FloatArray:
        moved = newest.pose + moves[3:]
        moved = moved_as_one(moved[None], held.pose, held.pose + moves[:3])[0]
        off = world_to_relative(places, moved) - alone
        along, across = (off * rays).sum(axis=1), off[:, 0] * rays[:, 1] - off[:, 1] * rays[:, 0]
        own = (along / (ALONG * reach), across / (ACROSS * reach))
        return np.concatenate((roots[0] @ moves[:3], roots[1] @ moves[3:], *own))

    return np.asarray(least_squares(residuals, np.zeros(6), xtol=1e-14, ftol=1e-14, gtol=1e-14).x[:3])


@of(seed=st.integers(0, 1000))
def test_the_pose_held_is_moved_to_where_it_is_most_probable(seed: int) -> None:
    held, newest = UncertainPose(HELD, spread(0.3, seed)), UncertainPose(NEWEST, spread(0.1, seed + 1))
    off = 1e-3 * np.random.default_rng(seed + 2).normal(0.0, 1.0, SHOWN.shape)
    boxes = seen()
    places = relative_to_world(shown(boxes) + off, NEWEST)
    found = corrected(held, newest, placed(places), boxes, STRANGER)
    assert found is not None
    np.testing.assert_allclose(found.pose - HELD, best(held, newest, places, boxes), rtol=0.02, atol=1e-5)


@of(seed=st.integers(0, 1000))
def test_it_is_surer_afterwards(seed: int) -> None:
    held, newest = UncertainPose(HELD, spread(1.0, seed)), UncertainPose(NEWEST, spread(0.1, seed + 1))
    found = corrected(held, newest, placed(relative_to_world(SHOWN, NEWEST)), seen(), STRANGER)
    assert found is not None
    assert np.linalg.eigvalsh(held.covariance - found.covariance).min() > -1e-9
    assert np.linalg.eigvalsh(found.covariance).min() > 0.0
    assert found.covariance.trace() < 0.5 * held.covariance.trace() or held.covariance.trace() < 0.5


def test_arrivals_that_can_hardly_be_true_count_less() -> None:
    held, newest = UncertainPose(HELD, spread(0.3, 1)), UncertainPose(NEWEST, spread(0.1, 2))
    boxes, moves = seen(), []
    for far in (0.1, 1.0, 10.0, 100.0):
        places = relative_to_world(shown(boxes) + np.array((far, 0.0)), NEWEST)
        found = corrected(held, newest, placed(places), boxes, STRANGER)
        assert found is not None
        moves.append(np.hypot(*(found.pose - HELD)[:2]) / far)
    assert moves[0] > 2.0 * moves[2] > 10.0 * moves[3] > 0.0


def test_nobody_tells_who_was_there_before_or_is_not_seen_or_whom_a_sure_pose_sees() -> None:
    held, newest = UncertainPose(HELD, spread(0.3, 1)), UncertainPose(NEWEST, spread(0.1, 2))
    places = relative_to_world(SHOWN + 1.0, NEWEST)
    assert corrected(held, newest, np.stack((places, places)), seen(), STRANGER) is None
    boxes = bearings_of(LEVEL, np.full((2, len(SHOWN), 3), np.nan))
    assert corrected(held, newest, placed(places), boxes, STRANGER) is None
    sure = UncertainPose(HELD, np.zeros((3, 3)))
    assert corrected(sure, newest, placed(places), seen(), STRANGER) is None


def test_a_box_alone_is_off_along_its_ray_most() -> None:
    rr, rf, ff = spread_alone(np.array(((0.0, 10.0),)))[0]
    np.testing.assert_allclose((rr, rf, ff), ((10.0 * ACROSS) ** 2, 0.0, (10.0 * ALONG) ** 2))


def relay(seed: int, frames: int = 120, stay: int = 9) -> Drive:
    """A drive on which somebody new is met ahead every third frame, and seen for ``stay`` frames."""
    people, rng = frames // 3, np.random.default_rng(seed)
    truth = drive(seed, frames, people)
    places, hidden = truth.positions.copy(), np.ones((frames, people), np.bool_)
    for k in range(people):
        here = np.arange(3 * k, min(3 * k + stay, frames))
        met = relative_to_world(rng.uniform((-4.0, 6.0), (4.0, 12.0), (1, 2)), truth.poses[3 * k])
        places[here, k] = met + np.arange(len(here))[:, None] * rng.normal(0.0, 0.2, 2)
        hidden[here, k] = False
    truth = replace(truth, positions=places)
    boxes = photograph(truth, seed=seed)
    boxes[hidden] = np.nan
    return made_drive(truth, boxes, covariances=True)


@pytest.mark.parametrize("seed", range(4))
def test_arrivals_keep_a_long_drive_as_sure_as_a_short_one(seed: int) -> None:
    made = relay(seed)
    estimate = made.solved(MapCausal)
    assert estimate.pose_covariances is not None
    sigma = np.sqrt(estimate.pose_covariances[:, 0, 0] + estimate.pose_covariances[:, 1, 1])
    assert sigma[100:].max() < 2.0 * sigma[30:60].max()
    assert (made.errors(estimate)[30:] < 3.0 * sigma[30:]).mean() > 0.9
