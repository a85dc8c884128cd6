"""Where a robot was by its wheels and gyro: how far off, and whether the filter knows."""

import numpy as np
import pytest

from tests.lib.jrdb_recording import RATE, Robot, drive
from vbbench.generation.footage import joined_odometry
from vbbench.geometry import world_to_relative
from vbbench_generators.footage.jrdb.motion import shared_out
from vbbench_generators.footage.odometry_filter import Readings, clock_offset, filter_motion

SEEDS = range(60)


def frames_of(driven):
    return np.arange(1.0, driven.times[-1] - 1.0, 1.0 / RATE)


def followed(robot, seed, *, gyro=True):
    driven = drive(robot, seed)
    times = frames_of(driven)
    return driven, driven.poses(times), filter_motion(times, driven.speed, driven.turn, driven.gyro if gyro else None)


def in_ellipse(errors, covariances):
    """Share of errors [T, 2] within their 95 % ellipse."""
    return np.mean(np.einsum("ti,ti->t", errors, np.linalg.solve(covariances, errors[..., None])[..., 0]) < 5.991)


@pytest.mark.parametrize("robot", [Robot(), Robot(speed_slip=0.02, turn_slip=0.1)], ids=["some slip", "twice the slip"])
def test_the_end_is_within_two_percent_of_the_way_and_the_ellipses_hold(robot):
    off, held = [], []
    for seed in SEEDS:
        driven, truth, motion = followed(robot, seed)
        errors = (motion.poses - truth)[:, :2]
        off.append(np.linalg.norm(errors[-1]) / driven.distance)
        held.append(in_ellipse(errors[30::30], motion.covariances[30::30, :2, :2]))
    assert np.mean(off) < 0.02
    assert 0.9 < np.mean(held) < 0.995


def test_wheels_alone_know_how_little_they_know_of_turns():
    held, yaw_off, with_gyro = [], [], []
    for seed in SEEDS:
        _, truth, motion = followed(Robot(), seed, gyro=False)
        held.append(np.abs(motion.poses - truth)[30::30, 2] < 1.96 * np.sqrt(motion.covariances[30::30, 2, 2]))
        yaw_off.append(motion.poses[-1, 2] - truth[-1, 2])
        with_gyro.append(followed(Robot(), seed)[2].poses[-1, 2] - truth[-1, 2])
    assert np.mean(held) > 0.9
    assert np.std(yaw_off) > 2.0 * np.std(with_gyro)


def test_motions_from_frame_to_frame_add_up_to_the_poses_and_their_ellipses_hold():
    held = []
    for seed in SEEDS:
        driven, truth, motion = followed(Robot(), seed)
        moved, spreads = motion.odometry.motions, motion.odometry.covariances
        assert np.isnan(moved[0]).all()
        cos, sin = np.cos(truth[:-1, 2]), np.sin(truth[:-1, 2])
        dx, dy = np.diff(truth[:, :2], axis=0).T
        held.append(
            in_ellipse(moved[1:, :2] - np.stack([cos * dx + sin * dy, cos * dy - sin * dx], -1), spreads[1:, :2, :2])
        )
        cos, sin = np.cos(motion.poses[:-1, 2]), np.sin(motion.poses[:-1, 2])
        ahead, left, turn = moved[1:].T
        added = np.stack([cos * ahead - sin * left, sin * ahead + cos * left, turn], axis=-1)
        drift = np.linalg.norm((added.sum(axis=0) - motion.poses[-1])[:2])  # later readings correct poses, too
        assert drift < 0.04 * driven.distance
    assert 0.9 < np.mean(held) < 0.995


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 6, 15])
def test_motions_between_kept_frames_are_as_uncertain_as_they_are(every):
    """Slip lasts for many frames: errors that are alike do not average out."""
    held = []
    for seed in SEEDS:
        driven, truth, motion = followed(Robot(), seed, gyro=False)
        kept = filter_motion(frames_of(driven)[::every], driven.speed, driven.turn, None)
        moved = joined_odometry(shared_out(motion.odometry, kept.odometry, every), every)
        expected = world_to_relative(truth[::every][1:, None, :2], truth[::every][:-1])[:, 0, ::-1] * [1.0, -1.0]
        held.append(in_ellipse(moved.motions[1:, :2] - expected, moved.covariances[1:, :2, :2]))
    assert 0.9 < np.mean(held) < 0.995


def test_a_robot_that_stands_stays_where_it_is():
    times = np.arange(0.0, 30.0, 0.02)
    still = Readings(times=times, values=np.zeros(len(times)))
    rng = np.random.default_rng(0)
    gyro = Readings(times=times[::3], values=0.02 + rng.normal(0.0, 0.006, len(times[::3])))
    motion = filter_motion(np.arange(1.0, 29.0, 0.1), still, still, gyro)
    assert np.abs(motion.poses).max() < 0.01


def test_a_wheel_that_spins_once_counts_little():
    driven = drive(Robot(speed_slip=0.0, spins=0), 3)
    spun = driven.speed.values.copy()
    spun[500:503] += 5.0
    ends = [
        filter_motion(frames_of(driven), Readings(times=driven.speed.times, values=values), driven.turn, driven.gyro)
        for values in (driven.speed.values, spun)
    ]
    assert np.linalg.norm(ends[0].poses[-1] - ends[1].poses[-1]) < 0.02


@pytest.mark.parametrize("late", [-0.3, -0.07, 0.0, 0.12, 0.4])
def test_the_offset_of_clocks_is_found_from_turning(late):
    found = [
        clock_offset(driven.turn, driven.gyro)
        for driven in (drive(Robot(gyro_offset=late), seed) for seed in range(10))
    ]
    np.testing.assert_allclose([one for one in found if one is not None], late, atol=0.02)
    assert len([one for one in found if one is not None]) >= 8


def test_no_offset_is_made_up_where_nothing_turns():
    times = np.arange(0.0, 20.0, 0.05)
    rng = np.random.default_rng(0)
    noise = [Readings(times=times, values=rng.normal(0.0, spread, len(times))) for spread in (0.01, 0.2, 0.2)]
    assert clock_offset(noise[0], noise[0]) is None
    assert clock_offset(noise[1], noise[2]) is None
    assert clock_offset(noise[1], Readings(times=times[:10], values=np.zeros(10))) is None
