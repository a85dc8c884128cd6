"""map-batch with a camera that is tilted: no worse than frame by frame, in blocks as at once, from a cold start."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from tests.rough_crowd import DT, LEVEL, Drive, drive, made_drive, made_window, photograph
from vbbench.geometry import FloatArray, wrap_angle
from vbbench.sequence import Given
from vbbench.solver import Estimate
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.real_camera import smoothing
from vbbench_baselines.joint_map.real_camera.descent import copied

FRAMES, SEEDS = 20, range(3)


@cache
def crowd(seed: int) -> Drive:
    truth = drive(seed, FRAMES, turning=0.0, wander=0.03)
    return made_drive(truth, photograph(truth, seed=seed), covariances=True)


@cache
def answer(seed: int) -> Estimate:
    return crowd(seed).solved(MapBatch)


def off(made: Drive, estimate: Estimate) -> FloatArray:
    """Errors in m of people's places that were not given."""
    known = made.sequence.observed & np.isnan(made.sequence.given.positions[..., 0])
    distances: FloatArray = np.linalg.norm(estimate.positions - made.truth.positions, axis=-1)[known]
    return distances


def test_it_is_at_least_as_good_as_frame_by_frame() -> None:
    poses, places = [], []
    for seed in SEEDS:
        made = crowd(seed)
        causal = made.solved(MapCausal)
        poses.append([made.errors(estimate)[2:].mean() for estimate in (answer(seed), causal)])
        places.append([off(made, estimate).mean() for estimate in (answer(seed), causal)])
    batch, causal_mean = np.mean(poses, axis=0)
    assert batch < 1.02 * causal_mean
    assert batch < 0.3
    batch, causal_mean = np.mean(places, axis=0)
    assert batch < 0.97 * causal_mean


def test_a_sequence_of_nobody_says_how_unsure_it_is() -> None:
    problem = replace(crowd(0).problem, tracks=np.arange(0))
    poses = np.full((FRAMES, 3), np.nan)
    poses[0] = 0.0
    estimate = MapBatch().solve(
        problem, np.zeros((FRAMES, 0, 3)), Given(poses=poses, positions=np.zeros((FRAMES, 0, 2)))
    )
    assert estimate.pose_covariances is not None
    assert estimate.pose_covariances[-1, 0, 0] > estimate.pose_covariances[2, 0, 0] > 0.0


def test_a_camera_that_moves_is_not_held_where_it_is_taken_to_stand() -> None:
    made = made_window(FRAMES, 12)
    found = [
        smoothing._settle_block(
            copied(made.point), made.seen, made.model, np.full(FRAMES, still), FRAMES, covariances=False
        )
        for still in (False, True)
    ]
    moved = [settled.point.frames[-1, :2] - settled.point.frames[1, :2] for settled in found]
    np.testing.assert_allclose(moved[1], moved[0], atol=0.1)
    assert np.linalg.norm(moved[0]) > 1.0


def test_what_is_given_stays_and_covariances_are_definite() -> None:
    for seed in SEEDS:
        made, estimate = crowd(seed), answer(seed)
        np.testing.assert_allclose(estimate.poses[:2], made.truth.poses[:2], atol=1e-9)
        given = made.sequence.given.positions
        known = ~np.isnan(given[..., 0])
        assert np.abs(estimate.positions - given)[known].max() < 0.05
        assert estimate.pose_covariances is not None
        assert estimate.position_covariances is not None
        assert np.linalg.eigvalsh(estimate.pose_covariances[2:]).min() > 0.0
        assert np.linalg.eigvalsh(estimate.position_covariances[made.sequence.observed]).min() > 0.0


def test_blocks_agree_with_all_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A later block begins with two poses of the one before, and knows no more of it: close, but not the same."""
    apart = []
    for seed in SEEDS:
        made = crowd(seed)
        monkeypatch.setattr(smoothing, "BLOCK", 16)
        monkeypatch.setattr(smoothing, "STRIDE", 8)
        blocks = made.solved(MapBatch)
        monkeypatch.undo()
        apart.append(np.linalg.norm((blocks.poses - answer(seed).poses)[:, :2], axis=1))
        assert np.isfinite(off(made, blocks)).all()
        assert blocks.pose_covariances is not None
        assert np.isfinite(blocks.pose_covariances).all()
    assert np.max(np.array(apart)[:, :8]) < 0.1
    assert np.mean(apart) < 0.2


@pytest.mark.slow
def test_a_sequence_longer_than_a_block() -> None:
    """People go to and fro before a camera that hardly moves."""
    frames, people = smoothing.BLOCK + 6, 5
    truth = drive(5, frames, people, speed=0.1, turning=0.0)
    phase = 0.1 * np.arange(frames)[:, None] + np.arange(people)
    around = np.stack((3.0 * np.sin(phase), 10.0 + 2.0 * np.cos(phase) + np.arange(people)), axis=-1)
    truth = replace(truth, positions=around)
    made = made_drive(truth, photograph(truth))
    errors = made.errors(made.solved(MapBatch))
    assert errors.max() < 4.0
    assert np.abs(np.diff(errors)).max() < 0.4


def test_a_cold_start_works() -> None:
    """Nothing is given but the first pose: the way is found but for what heights and slow people leave open."""
    for make in (MapBatch, MapCausal):
        made = crowd(2)
        estimate = made.solved(make, "cold-start")
        assert np.isfinite(estimate.poses).all()
        moved = np.linalg.norm(np.diff(estimate.poses[:, :2], axis=0), axis=1).sum()
        way = np.linalg.norm(np.diff(made.truth.poses[:, :2], axis=0), axis=1).sum()
        assert abs(moved - way) < 0.4 * way
        assert estimate.pose_covariances is not None
        assert estimate.pose_covariances[-1, 0, 0] > answer(2).pose_covariances[-1, 0, 0]  # type: ignore[index]


def test_it_is_sane_whatever_boxes_show() -> None:
    made = crowd(0)
    for frames in (slice(2, FRAMES), slice(8, 12), slice(0, FRAMES)):
        boxes = np.array(made.sequence.observations)
        boxes[frames] = np.nan
        positions = np.where(np.isnan(boxes[..., :1]), np.nan, made.sequence.given.positions)
        given = replace(made.sequence.given, positions=positions)
        estimate = replace(made, sequence=replace(made.sequence, observations=boxes, given=given)).solved(MapBatch)
        assert np.isfinite(estimate.poses).all()
        assert np.abs(estimate.poses[:, :2]).max() < 100.0


def test_a_track_that_is_two_people_has_two_places() -> None:
    made = crowd(1)
    both = np.flatnonzero(made.sequence.observed.all(axis=0))
    place = made.truth.positions[10, both]
    apart = np.linalg.norm(place[:, None] - place, axis=-1)
    a, b = both[np.array(np.unravel_index(np.argmin(np.where(apart > 5.0, apart, np.inf)), apart.shape))]
    boxes = np.array(made.sequence.observations)
    boxes[10:, [a, b]] = boxes[10:, [b, a]]
    swapped = replace(made, sequence=replace(made.sequence, observations=boxes)).solved(MapBatch)
    truth = made.truth.positions
    for track, before, after in ((a, a, b), (b, b, a)):
        assert np.linalg.norm(swapped.positions[2:10, track] - truth[2:10, before], axis=-1).max() < 1.0
        assert np.median(np.linalg.norm(swapped.positions[11:, track] - truth[11:, after], axis=-1)) < 1.5
    assert made.problem.camera == LEVEL


def test_a_single_frame_is_answered_with_covariances() -> None:
    truth = drive(0, 1)
    estimate = made_drive(truth, photograph(truth), covariances=True).solved(MapBatch)
    assert estimate.pose_covariances is not None
    assert np.isfinite(estimate.pose_covariances).all()


@pytest.mark.parametrize("make", [MapCausal, MapBatch])
def test_after_a_cold_start_place_and_heading_become_less_sure(make: Callable[[], Any]) -> None:
    """By what all may have in common, and within what the truth is."""
    truth = drive(2, 30)
    made = made_drive(truth, photograph(truth, seed=2))
    problem = replace(made.problem, covariances=True)
    estimate = replace(made, problem=problem).solved(make, "cold-start")
    assert estimate.pose_covariances is not None
    spread = estimate.pose_covariances
    seconds = DT * np.arange(len(spread))
    assert (spread[1:, 2, 2] > (0.02**2 * seconds)[1:]).all()
    assert np.trace(spread[-1, :2, :2]) > 4.0 * np.trace(spread[5, :2, :2])
    turned = wrap_angle(estimate.poses[:, 2] - truth.poses[:, 2])
    assert (np.abs(turned) < 3.0 * np.sqrt(spread[:, 2, 2]) + 1e-6).all()
