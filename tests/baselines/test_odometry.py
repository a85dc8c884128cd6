"""Odometry in the solvers that use it: it holds the pose where it is accurate, and else changes nothing."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.session_coverage import run as run_session
from tests.baselines.test_cold_start import crossing
from tests.lib.solver_runs import CAMERAS, DT, answer, measured, see
from vbbench import PerspectiveCamera, Session
from vbbench.geometry import motion_between, wrap_angle
from vbbench.sequence import Odometry, Sequence, Truth
from vbbench.solver import Estimate
from vbbench_baselines.common.motion import newest_measured
from vbbench_baselines.joint_map import MapBatch, MapCausal
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

SOLVERS: list[Callable[[], Any]] = [ConstantVelocityBirdifier, SocialForceBirdifier, MapCausal, MapBatch]
PRECISE = np.diag((0.01, 0.01, 0.003)) ** 2


def measure(truth: Truth, seed: int = 0, missing: slice = slice(0, 1)) -> Odometry:
    return measured(truth, PRECISE, seed, missing)


def seen(truth: Truth, odometry: Odometry | None) -> Sequence:
    return see(truth, CAMERAS[0], 1.0, odometry=odometry)


def error(estimate: Estimate, truth: Truth) -> float:
    return float(np.hypot(*(estimate.poses - truth.poses)[2:, :2].T).mean())


def test_a_motion_leads_to_the_pose_that_it_was_measured_from() -> None:
    before, now = np.array((1.0, -2.0, 3.0)), np.array((1.4, -1.7, -3.1))
    odometry = Odometry(motions=motion_between(before, now)[None], covariances=PRECISE[None])
    found = newest_measured(odometry, before)
    np.testing.assert_allclose(found.pose[:2], now[:2])
    assert wrap_angle(found.pose[2] - now[2]) == pytest.approx(0.0)


@pytest.mark.parametrize("protocol", ["cold-start", "rollout"])
@pytest.mark.parametrize("make", SOLVERS)
def test_accurate_odometry_ends_the_drift(make: Callable[[], Any], protocol: str) -> None:
    errors = []
    for seed in range(5):
        truth = crossing(seed, 1.5)
        sequences = (seen(truth, odometry) for odometry in (None, measure(truth, seed)))
        errors.append([error(answer(make(), sequence, protocol), truth) for sequence in sequences])
    without, by_odometry = np.mean(errors, axis=0)
    assert by_odometry < 0.05
    assert by_odometry < 0.7 * without


@pytest.mark.parametrize("make", SOLVERS)
@pytest.mark.parametrize("protocol", ["cold-start", "rollout", "sequential"])
def test_odometry_that_measured_nothing_changes_nothing(make: Callable[[], Any], protocol: str) -> None:
    truth = crossing(2)
    frames = len(truth.poses)
    nothing = Odometry(motions=np.full((frames, 3), np.nan), covariances=np.full((frames, 3, 3), np.nan))
    without, empty = (answer(make(), seen(truth, odometry), protocol) for odometry in (None, nothing))
    np.testing.assert_array_equal(without.poses, empty.poses)
    np.testing.assert_array_equal(without.positions, empty.positions)


@pytest.mark.parametrize("make", [MapCausal, MapBatch])
def test_odometry_counts_as_much_as_its_covariance_says(make: Callable[[], Any]) -> None:
    """Next to nothing if it is vague; and one frame of it holds that frame's step alone."""
    truth = crossing(2)
    without = answer(make(), seen(truth, None), "rollout")
    vague = measure(truth)
    vague = replace(vague, covariances=1e6 * vague.covariances / PRECISE[0, 0])
    np.testing.assert_allclose(answer(make(), seen(truth, vague), "rollout").poses, without.poses, atol=0.02)
    once = measure(truth)
    motions = np.where(np.arange(len(truth.poses))[:, None] == 5, once.motions, np.nan)
    estimate = answer(make(), seen(truth, replace(once, motions=motions)), "rollout")
    before, now = estimate.poses[4:6]
    if make is MapBatch:  # the causal solver has reported frame 4 before it knew
        np.testing.assert_allclose(motion_between(before, now), once.motions[5], atol=0.04)


@pytest.mark.parametrize("make", SOLVERS)
def test_odometry_makes_a_cold_start_sure_of_its_pose(make: Callable[[], Any]) -> None:
    truth = crossing(3)
    spreads = []
    for odometry in (None, measure(truth)):
        estimate = answer(make(), seen(truth, odometry), "cold-start", covariances=True)
        spreads.append(np.sqrt(np.trace(estimate.pose_covariances[-1, :2, :2])))
    assert spreads[1] < 0.2 * spreads[0]


@pytest.mark.parametrize("make", [ConstantVelocityBirdifier, SocialForceBirdifier, MapCausal])
def test_gaps_of_odometry_are_not_one_long_gap(make: Callable[[], Any]) -> None:
    """How fast all move together is known again after each."""
    truth = crossing(3)

    def spread(missing: slice) -> float:
        sequence = seen(truth, measure(truth, missing=missing))
        covariances = answer(make(), sequence, "cold-start", covariances=True).pose_covariances
        return float(np.sqrt(np.trace(covariances[-1, :2, :2])))

    middle = len(truth.poses) // 2
    gaps = len(range(2, len(truth.poses) - 1, 4))
    assert spread(slice(2, -1, 4)) < 0.7 * spread(slice(middle, middle + gaps))


@pytest.mark.parametrize("solver", ["vb-cv", "vb-sf", "vb-former"])
def test_where_nobody_is_in_sight_a_pose_is_as_sure_as_odometry_is(solver: str) -> None:
    camera = PerspectiveCamera(width=1280, height=720, focal=910.0, cx=640.0, cy=360.0, mount_height=1.2)
    session, moved = Session(solver, camera, dt=0.1), np.array((0.05, 0.0, 0.002))
    session.step({})
    for _ in range(50):
        last = session.step({}, (moved, np.diag((0.01, 0.01, 0.002)) ** 2))
    sigma = np.sqrt(last.pose_covariance.diagonal())
    assert sigma[:2] == pytest.approx(0.01 * np.sqrt(50.0), rel=0.3)
    assert sigma[2] == pytest.approx(0.002 * np.sqrt(50.0), rel=0.3)


def test_a_car_with_odometry_is_where_it_is() -> None:
    """10 m/s among people who stand or walk, and at a third of the frames no odometry."""
    truth = crossing(8, 10.0)
    standing = np.random.default_rng(1).uniform(-20.0, 60.0, (1, 6, 2)) + 0.0 * truth.positions
    truth = replace(truth, positions=standing)
    estimate = answer(MapCausal(), seen(truth, measure(truth, missing=slice(3, None, 3))), "cold-start")
    assert error(estimate, truth) < 1.5
    assert DT * 10.0 * len(truth.poses) > 50.0


def test_an_observer_who_walks_as_nobody_expects_is_as_sure_as_right() -> None:
    """It always turns left; where odometry is sure the priors of walk and head, which know better, are left out."""
    _, _, poses, positions = run_session(5, 60, 0, True)
    assert poses > 0.8
    assert positions > 0.8
