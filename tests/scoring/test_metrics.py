"""Metrics against evo, and against what must hold for any estimate."""

import numpy as np
import pytest
from evo.core import metrics as evo_metrics
from evo.core.trajectory import PosePath3D
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from vbbench.geometry import FloatArray
from vbbench.scoring import metrics

COORDINATES = st.floats(-100, 100)
POSES = arrays(np.float64, (5, 3), elements=COORDINATES)
PLACES = arrays(np.float64, (5, 4, 2), elements=COORDINATES)


def _evo_path(poses: FloatArray) -> PosePath3D:
    matrices = []
    for x, y, yaw in poses:
        matrix = np.eye(4)
        matrix[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
        matrix[:2, 3] = x, y
        matrices.append(matrix)
    return PosePath3D(poses_se3=matrices)


def _random_poses(seed: int) -> FloatArray:
    return np.random.default_rng(seed).uniform([-9, -9, -7], [9, 9, 7], (40, 3))


@pytest.mark.parametrize(
    ("metric", "relation"),
    [
        (metrics.translation_error, evo_metrics.PoseRelation.translation_part),
        (metrics.rotation_error, evo_metrics.PoseRelation.rotation_angle_rad),
    ],
)
def test_pose_errors_are_those_of_evo(metric, relation):
    estimate, truth = _random_poses(1), _random_poses(2)
    ape = evo_metrics.APE(relation)
    ape.process_data((_evo_path(truth), _evo_path(estimate)))
    np.testing.assert_allclose(metric(estimate, truth), ape.error, atol=1e-7)


@pytest.mark.parametrize(
    ("drift", "relation"),
    [
        (metrics.motion_drift, evo_metrics.PoseRelation.translation_part),
        (metrics.turn_drift, evo_metrics.PoseRelation.rotation_angle_rad),
    ],
)
def test_drift_is_the_relative_pose_error_of_evo(drift, relation):
    estimate, truth = _random_poses(3), _random_poses(4)
    step, seconds = 3, 1.2
    rpe = evo_metrics.RPE(relation, delta=step, delta_unit=evo_metrics.Unit.frames, all_pairs=True)
    rpe.process_data((_evo_path(truth), _evo_path(estimate)))
    ours = drift(estimate[:-step], estimate[step:], truth[:-step], truth[step:], seconds)
    np.testing.assert_allclose(ours * seconds, rpe.error, atol=1e-7)


@given(POSES)
def test_truth_has_no_error(poses):
    assert not metrics.translation_error(poses, poses).any()
    assert not metrics.rotation_error(poses, poses).any()


@given(POSES, POSES, st.integers(-3, 3))
def test_rotation_error_knows_no_full_turns(a, b, turns):
    shifted = a + np.array([0, 0, 2 * np.pi * turns])
    error = metrics.rotation_error(a, b)
    assert ((error >= 0) & (error <= np.pi)).all()
    np.testing.assert_allclose(metrics.rotation_error(shifted, b), error, atol=1e-9)
    np.testing.assert_allclose(metrics.rotation_error(b, a), error, atol=1e-9)
    np.testing.assert_allclose(error, np.arccos(np.clip(np.cos(a[:, 2] - b[:, 2]), -1, 1)), atol=1e-6)


@given(PLACES, PLACES, POSES, POSES, arrays(np.float64, 2, elements=COORDINATES))
def test_relative_error_is_blind_to_a_common_shift_and_absolute_is_not(places, truth, poses, true_poses, shift):
    pose, true_pose = poses[:, None], true_poses[:, None]
    moved_pose = pose + np.append(shift, 0)
    before = metrics.relative_position_error(places, pose, truth, true_pose)
    after = metrics.relative_position_error(places + shift, moved_pose, truth, true_pose)
    np.testing.assert_allclose(before, after, atol=1e-9)
    np.testing.assert_allclose(metrics.position_error(truth + shift, truth), np.hypot(*shift), atol=1e-9)


@given(PLACES, PLACES, POSES, POSES)
def test_relative_error_is_within_position_plus_pose_error(places, truth, poses, true_poses):
    pose, true_pose = poses[:, None], true_poses[:, None]
    relative = metrics.relative_position_error(places, pose, truth, true_pose)
    bound = metrics.position_error(places, truth) + metrics.translation_error(pose, true_pose)
    assert (relative <= bound + 1e-9).all()


@given(POSES, POSES)
def test_a_rigidly_moved_trajectory_does_not_drift(start, end):
    turn, shift = 0.7, np.array([3.0, -2.0])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])

    def moved(poses):
        return np.column_stack([poses[:, :2] @ rotation.T + shift, poses[:, 2] + turn])

    for drift in (metrics.motion_drift, metrics.turn_drift):
        np.testing.assert_allclose(drift(moved(start), moved(end), start, end, 1.0), 0, atol=1e-9)


def test_nothing_known_is_nan():
    nowhere = np.full((2, 3), np.nan)
    assert np.isnan(metrics.translation_error(nowhere, np.zeros((2, 3)))).all()
    assert np.isnan(metrics.rotation_error(nowhere, np.zeros((2, 3)))).all()
