"""Columns that stand for one person after the other: what a solver that runs for hours forgets, and what it costs."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.bench_streaming import times
from tests.baselines.test_cold_start import FRAMES, cold, crossing
from tests.lib.solver_runs import CAMERAS, problem_of, showing
from vbbench.sequence import Sequence
from vbbench.solver import Estimate
from vbbench.solving.runner import frames_of
from vbbench_baselines.extrapolation import ConstantVelocity
from vbbench_baselines.former.solver import VbFormer
from vbbench_baselines.ground_plane import GroundPlane
from vbbench_baselines.joint_map import MapCausal
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

CLASSES = (ConstantVelocity, ConstantVelocityBirdifier, SocialForceBirdifier, MapCausal, GroundPlane, VbFormer)
SOLVERS: list[Callable[[], Any]] = [*CLASSES]
GONE, BACK = 3, 10
"""Frames in which person 0 leaves, and in which another one comes."""


def relay() -> Sequence:
    """Column 0 stands for one person up to `GONE` and for one of another height elsewhere from `BACK` on."""
    truth = crossing(9)
    heights = np.array(truth.heights)
    heights[0] = 1.9
    boxes = np.array(cold(replace(truth, heights=heights), CAMERAS[0]).observations)
    heights[0], positions = 1.5, np.array(truth.positions)
    positions[:, 0] += (-3.0, 1.0)
    sequence = cold(replace(truth, positions=positions, heights=heights), CAMERAS[0])
    boxes[GONE:, 0] = np.nan
    boxes[BACK:, 0] = sequence.observations[BACK:, 0]
    return replace(sequence, observations=boxes)


def apart(sequence: Sequence) -> Sequence:
    """The same with a column of its own for whoever comes at `BACK`."""
    boxes = np.concatenate((sequence.observations, sequence.observations[:, :1]), axis=1)
    boxes[BACK:, 0] = boxes[:BACK, -1] = np.nan
    given = sequence.given.positions
    given = replace(sequence.given, positions=np.concatenate((given, given[:, :1]), axis=1))
    return showing(sequence, boxes, tracks=np.arange(boxes.shape[1]), given=given)


def steps(solver: Any, sequence: Sequence, forgotten: dict[int, list[int]]) -> Estimate:
    """A solver that is told before these frames which columns to forget."""
    solver.start(problem_of(sequence, CAMERAS[0], 1.0, covariances=True))
    answers = []
    for frame in frames_of(sequence, sequence.given, sequence.given):
        if frame.index in forgotten:
            solver.forget(np.array(forgotten[frame.index], np.int64))
        answers.append(solver.step(frame))
    return Estimate.of_frames(answers)


@pytest.mark.parametrize("make", SOLVERS)
def test_a_forgotten_column_is_as_good_as_a_new_one(make: Callable[[], Any]) -> None:
    solvers = [MapCausal(size=BACK - GONE - 1) if make is MapCausal else make() for _ in range(2)]
    reused, own = steps(solvers[0], relay(), {BACK: [0]}), steps(solvers[1], apart(relay()), {BACK: []})
    atol = 1e-4 if make is VbFormer else 1e-6  # the network computes in float32
    np.testing.assert_allclose(reused.poses, own.poses, atol=atol)
    positions = np.where(np.isnan(own.positions[:, :1]), own.positions[:, -1:], own.positions[:, :1])
    np.testing.assert_allclose(reused.positions[:, :1], positions, atol=atol)
    np.testing.assert_allclose(reused.positions[:, 1:], own.positions[:, 1:-1], atol=atol)
    if reused.heights is not None and own.heights is not None:
        heights = np.append(own.heights[-1], own.heights[1:-1])
        np.testing.assert_allclose(reused.heights, heights, atol=1e-6 if make is VbFormer else 1e-9)


@pytest.mark.parametrize("make", SOLVERS)
def test_people_still_in_sight_can_be_forgotten(make: Callable[[], Any]) -> None:
    """Everybody, in every frame: the answer is rough but sane."""
    sequence = relay()
    estimate = steps(make(), sequence, {t: list(range(len(sequence.tracks))) for t in range(3, FRAMES)})
    assert np.abs(estimate.poses[:, :2]).max() < 20.0
    assert np.abs(estimate.positions[sequence.observed]).max() < 40.0


def test_absent_columns_change_nothing() -> None:
    """A step is that of the people in the window, whatever other columns there are."""
    sequence = relay()
    boxes = np.full((FRAMES, 40, 3), np.nan)
    boxes[:, 30:36] = sequence.observations
    given = replace(sequence.given, positions=np.full((FRAMES, 40, 2), np.nan))
    wide = showing(sequence, boxes, tracks=np.arange(40), given=given)
    many = steps(MapCausal(size=8), wide, {})
    few = steps(MapCausal(size=8), sequence, {})
    np.testing.assert_array_equal(many.poses, few.poses)
    np.testing.assert_array_equal(many.positions[:, 30:36], few.positions)


@pytest.mark.slow
def test_a_long_run_stays_sane_and_its_window_small() -> None:
    solver = MapCausal()
    poses = np.array([pose for _, pose in times(solver, people=12, columns=24, frames=600)])
    assert np.isfinite(poses).all()
    speed = np.hypot(*(poses[30:, :2] - poses[:-30, :2]).T) / 3.0
    assert np.median(speed) < 4.0
    assert len(solver.ages()) <= 20
