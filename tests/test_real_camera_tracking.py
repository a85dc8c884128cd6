"""map-causal with a camera that is tilted, on a vehicle: as exact as the boxes allow, and sane whatever they show."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.rough_crowd import DT, Drive, drive, made_drive, photograph
from tests.test_odometry_in_solvers import measure
from vbbench.geometry import FloatArray, wrap_angle
from vbbench.sequence import Given, Truth
from vbbench.solver import Estimate
from vbbench.solving.runner import frames_of
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier

FRAMES = 20


@cache
def crowd(seed: int, **facts: float) -> Drive:
    return made_drive(drive(seed, FRAMES), photograph(drive(seed, FRAMES), seed=seed), **facts)


@cache
def answer(seed: int) -> Estimate:
    return crowd(seed).solved(MapCausal)


def lasting(made: Drive) -> FloatArray:
    """[T] errors in m of the scored frames."""
    return made.errors(made.solved(MapCausal))[2:]


@pytest.mark.parametrize(
    ("facts", "share"), [({}, 0.5), ({"box_std": 0.0, "tilt_std": 0.04}, 0.7), ({"box_std": 0.0}, 0.7)]
)
def test_it_is_far_better_than_solvers_that_believe_the_camera(facts: dict[str, float], share: float) -> None:
    """Told that boxes are rough, told that the tilt is, and told nothing."""
    own, other = [], []
    for seed in range(3):
        made = crowd(seed, **facts)
        own.append(lasting(made).mean())
        other.append(made.errors(made.solved(SocialForceBirdifier))[2:].mean())
    assert max(own) < 0.35
    assert np.mean(own) < share * np.mean(other)


def test_people_are_where_they_are() -> None:
    for seed in range(3):
        made, estimate = crowd(seed), answer(seed)
        near = made.sequence.observed & (
            np.linalg.norm(made.truth.positions - made.truth.poses[:, None, :2], axis=-1) < 15
        )
        near[:2] = False
        off = np.linalg.norm(estimate.positions - made.truth.positions, axis=-1)[near]
        assert np.median(off) < 0.5
        assert np.isfinite(off).all()
        assert estimate.heights is not None
        seen = made.sequence.observed.sum(axis=0) > 10
        heights = estimate.heights[-1] if estimate.heights.ndim > 1 else estimate.heights
        assert np.abs(heights - made.truth.heights)[seen].mean() < 0.1


def test_a_turned_and_shifted_world_gives_the_same_answer_turned_and_shifted() -> None:
    made, angle, shift = crowd(1), 2.0, np.array((30.0, -70.0))
    rotation = np.array(((np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))))

    def moved(poses: FloatArray, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
        turned = np.column_stack((poses[:, :2] @ rotation.T + shift, wrap_angle(poses[:, 2] + angle)))
        return turned, positions @ rotation.T + shift

    poses, positions = moved(made.truth.poses, made.truth.positions)
    truth = Truth(poses=poses, positions=positions, heights=made.truth.heights)
    there = made_drive(truth, made.sequence.observations).solved(MapCausal)
    poses, positions = moved(answer(1).poses, answer(1).positions)
    np.testing.assert_allclose(there.poses[:, :2], poses[:, :2], atol=5e-3)
    np.testing.assert_allclose(wrap_angle(there.poses[:, 2] - poses[:, 2]), 0.0, atol=1e-3)
    np.testing.assert_allclose(there.positions, positions, atol=0.06)  # as far as the descent goes


def test_other_columns_give_the_same_answer_in_other_columns() -> None:
    made, order = crowd(2), np.random.default_rng(0).permutation(25)
    truth = Truth(poses=made.truth.poses, positions=made.truth.positions[:, order], heights=made.truth.heights[order])
    permuted = made_drive(truth, made.sequence.observations[:, order]).solved(MapCausal)
    np.testing.assert_allclose(permuted.poses, answer(2).poses, atol=1e-6)
    np.testing.assert_allclose(permuted.positions, answer(2).positions[:, order], atol=1e-5)


def test_a_track_that_passes_to_somebody_else_does_not_drag_the_pose() -> None:
    """From the tenth frame on each of two tracks shows the other's person, far from its own."""
    for seed in range(3):
        made = crowd(seed)
        both = made.sequence.observed.all(axis=0)
        chosen = np.flatnonzero(both)
        place = made.truth.positions[10, chosen]
        apart = np.linalg.norm(place[:, None] - place, axis=-1)
        a, b = chosen[np.array(np.unravel_index(np.argmin(np.where(apart > 5.0, apart, np.inf)), apart.shape))]
        boxes = np.array(made.sequence.observations)
        boxes[10:, [a, b]] = boxes[10:, [b, a]]
        sequence = replace(made.sequence, observations=boxes)
        swapped = replace(made, sequence=sequence).solved(MapCausal)
        off = np.linalg.norm((swapped.poses - answer(seed).poses)[:, :2], axis=1)
        assert off.max() < 0.2
        others = np.linalg.norm(swapped.positions[10:, [b, a]] - made.truth.positions[10:, [a, b]], axis=-1)
        assert np.median(others) < 1.0


def at_speeds(seed: int, speeds: FloatArray) -> Drive:
    """A vehicle straight ahead at ``speeds`` [T] in m/s among the people of `drive`."""
    truth = drive(seed, len(speeds), speed=0.0, turning=0.0)
    poses = np.array(truth.poses)
    poses[:] = poses[0]
    poses[:, :2] += (np.cumsum(speeds) * DT)[:, None] * (np.cos(poses[0, 2]), np.sin(poses[0, 2]))
    truth = replace(truth, poses=poses)
    return made_drive(truth, photograph(truth, seed=seed))


def test_a_camera_that_stands_stays() -> None:
    for seed in range(3):
        off = lasting(at_speeds(seed, np.zeros(FRAMES)))
        assert off.max() < 0.1
        assert np.median(off) < 0.01


def test_a_camera_that_stood_is_followed_when_it_sets_off() -> None:
    for seed in range(3):
        made = at_speeds(seed, np.repeat((0.0, 0.5, 1.0, 1.5), (8, 1, 1, FRAMES - 10)))
        estimate = made.solved(MapCausal)
        assert made.errors(estimate)[2:8].max() < 0.03
        assert made.errors(estimate)[8:].max() < 0.6
        gone = np.linalg.norm(estimate.poses[-1, :2] - estimate.poses[7, :2])
        assert gone == pytest.approx(np.linalg.norm(made.truth.poses[-1, :2] - made.truth.poses[7, :2]), rel=0.1)


def test_a_camera_that_sees_nobody_drives_on() -> None:
    """Standing would be more certain; it is not more probable for that."""
    made = at_speeds(0, np.full(FRAMES, 1.5))
    boxes = np.array(made.sequence.observations)
    boxes[8:] = np.nan
    blind = replace(made, sequence=replace(made.sequence, observations=boxes)).solved(MapCausal)
    steps = np.linalg.norm(np.diff(blind.poses[8:, :2], axis=0), axis=1)
    assert steps.min() > 0.5 * 1.5 * DT


def measured(made: Drive, covariance: FloatArray, missing: slice = slice(0)) -> Drive:
    """With odometry of this covariance [3, 3], but for the frames that are ``missing``."""
    odometry = measure(made.truth, covariance)
    motions = np.array(odometry.motions)
    motions[missing] = np.nan
    given = replace(made.sequence.given, odometry=replace(odometry, motions=motions))
    return replace(made, sequence=replace(made.sequence, given=given))


def test_odometry_holds_the_pose() -> None:
    known = measured(crowd(0), 1e-6 * np.eye(3))
    assert lasting(known).max() < 0.05
    few = replace(known, sequence=replace(known.sequence, observations=np.full((FRAMES, 25, 3), np.nan)))
    assert lasting(few).max() < 0.05


def test_with_odometry_a_pose_is_about_as_sure_as_odometry_is() -> None:
    """What is wrong with one measured step is not wrong with the next."""
    frames, covariance = 100, np.diag((0.005, 0.005, 0.002)) ** 2
    made = measured(at_speeds(0, np.zeros(frames)), covariance)
    estimate = replace(made, problem=replace(made.problem, covariances=True)).solved(MapCausal)
    assert estimate.pose_covariances is not None
    sigma = np.sqrt(estimate.pose_covariances[-1].diagonal())
    assert (sigma < 3.0 * np.sqrt(frames * covariance.diagonal())).all()
    assert (sigma > 0.2 * np.sqrt(frames * covariance.diagonal())).all()


def test_gaps_of_odometry_do_not_add_up_to_one_long_gap() -> None:
    """How fast all move together is known again after each."""
    frames, covariance = 80, np.diag((0.005, 0.005, 0.002)) ** 2

    def spread(missing: slice) -> float:
        made = measured(at_speeds(0, np.zeros(frames)), covariance, missing)
        estimate = replace(made, problem=replace(made.problem, covariances=True)).solved(MapCausal, "cold-start")
        assert estimate.pose_covariances is not None
        return float(np.sqrt(estimate.pose_covariances[-1, 0, 0]))

    now_and_then, at_once = spread(slice(5, None, 10)), spread(slice(40, 48))
    assert now_and_then < 0.7 * at_once


def blank(boxes: FloatArray) -> None:
    boxes[8:11] = np.nan


def one_person(boxes: FloatArray) -> None:
    boxes[:, np.arange(25) != np.argmax((~np.isnan(boxes[..., 2])).sum(axis=0))] = np.nan


def nobody(boxes: FloatArray) -> None:
    boxes[:] = np.nan


def nobody_after_the_first(boxes: FloatArray) -> None:
    boxes[2:] = np.nan


def one_frame_each(boxes: FloatArray) -> None:
    boxes[np.arange(FRAMES)[:, None] % 25 != np.arange(25)] = np.nan


def gaps(boxes: FloatArray) -> None:
    boxes[np.random.default_rng(0).random(boxes.shape[:2]) < 0.5] = np.nan


def cut_by_all_borders(boxes: FloatArray) -> None:
    boxes[5:, :4] = (640.0, 360.0, 720.0)


def above_the_horizon(boxes: FloatArray) -> None:
    boxes[5:9, :, 1] -= 300.0


@pytest.mark.parametrize(
    "change",
    [
        blank,
        one_person,
        nobody,
        nobody_after_the_first,
        one_frame_each,
        gaps,
        cut_by_all_borders,
        above_the_horizon,
    ],
)
@pytest.mark.parametrize("facts", [{}, {"box_std": 0.0}])
def test_whatever_boxes_show_the_answer_is_sane(change: Callable[[FloatArray], None], facts: dict[str, float]) -> None:
    made = crowd(0, **facts)
    boxes = np.array(made.sequence.observations)
    change(boxes)
    positions = np.where(np.isnan(boxes[..., :1]), np.nan, made.sequence.given.positions)
    given = Given(poses=made.sequence.given.poses, positions=positions)
    sequence = replace(made.sequence, observations=boxes, given=given)
    estimate = replace(made, sequence=sequence, problem=replace(made.problem, covariances=True)).solved(MapCausal)
    assert np.isfinite(estimate.poses).all()
    assert np.abs(estimate.poses[:, :2]).max() < 100.0
    assert estimate.pose_covariances is not None
    definite(estimate.pose_covariances[2:])


@pytest.mark.parametrize("length", [1e-3, 0.4, 1.0])
def test_whoever_is_hardly_seen_is_far_away(length: float) -> None:
    made = crowd(0)
    solver = MapCausal()
    solver.start(made.problem)
    for frame in frames_of(made.sequence, made.sequence.given, made.sequence.given):
        boxes = np.array(frame.observations)
        if frame.index > 4:
            boxes[0] = (640.0, 365.0, length)
        answer = solver.step(replace(frame, observations=boxes))
    assert 50.0 < np.hypot(*(answer.positions[0] - answer.pose[:2])) < 1e6


@pytest.mark.parametrize("box", [(np.nan, 400.0, 100.0), (640.0, 400.0, 0.0), (640.0, 400.0, -20.0), (1e9, 0.0, 1e9)])
def test_boxes_that_are_none_do_no_harm(box: tuple[float, float, float]) -> None:
    """They are as if they were not there."""
    made, gone = crowd(0), np.full(3, np.nan)
    answers = []
    for shown in (box, gone):
        solver, poses = MapCausal(), []
        solver.start(made.problem)
        for frame in frames_of(made.sequence, made.sequence.given, made.sequence.given):
            boxes = np.array(frame.observations)
            if frame.index > 4:
                boxes[:4] = shown
            poses.append(solver.step(replace(frame, observations=boxes)).pose)
        answers.append(np.array(poses))
    np.testing.assert_array_equal(*answers)


def test_arrivals_after_gaps_are_welcome() -> None:
    """All are gone for six frames, and most of those who come then are new, with their places given twice."""
    made = crowd(0)
    boxes = np.array(made.sequence.observations)
    boxes[7:13] = np.nan
    boxes[:13, 6:] = np.nan
    off = lasting(made_drive(made.truth, boxes))
    assert off.max() < 0.6


def definite(covariances: FloatArray) -> None:
    """Checks covariances [..., n, n] that they are, to rounding."""
    np.testing.assert_allclose(covariances, np.swapaxes(covariances, -1, -2), rtol=1e-6, atol=1e-9)
    values = np.linalg.eigvalsh(covariances)
    assert (values.min(axis=-1) > -1e-12 * values.max(axis=-1)).all()


@pytest.mark.slow
def test_covariances_are_definite_and_as_large_as_the_errors() -> None:
    """The mean squared error in units of the covariance, per degree of freedom, is about one."""
    poses, places = [], []
    for seed in range(8):
        truth = drive(seed, FRAMES, turning=0.0, wander=0.05)
        made = made_drive(truth, photograph(truth, seed=100 + seed), covariances=True)
        estimate = made.solved(MapCausal)
        assert estimate.converged is not None
        assert estimate.converged.mean() > 0.3
        assert estimate.pose_covariances is not None
        assert estimate.position_covariances is not None
        definite(estimate.pose_covariances[2:])
        seen = made.sequence.observed & np.isnan(made.sequence.given.positions[..., 0])
        definite(estimate.position_covariances[seen])
        off = estimate.poses[-1] - truth.poses[-1]
        off[2] = wrap_angle(off[2])
        poses.append(off @ np.linalg.solve(estimate.pose_covariances[-1], off) / 3.0)
        off = (estimate.positions - truth.positions)[-1][seen[-1]]
        inverse = np.linalg.inv(estimate.position_covariances[-1][seen[-1]])
        places += (np.einsum("ki,kij,kj->k", off, inverse, off) / 2.0).tolist()
    assert 0.3 < np.mean(poses) < 2.0
    assert 0.3 < np.mean(places) < 3.0
