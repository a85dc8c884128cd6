"""The experiment of a robot: drift against a plain loop, dead reckoning, the camera alone, and JRDB."""

from math import atan2, cos, hypot, pi, sin
from pathlib import Path

import numpy as np
import pytest

from tests.lib.jrdb_recording import Robot as MadeRobot
from tests.lib.jrdb_recording import recording
from vbbench.geometry import FloatArray, moved_as_one
from vbbench.registry import load
from vbbench.reproduction.grid import Making
from vbbench.reproduction.robot import (
    CameraAlone,
    RobotStudy,
    dead_reckoning,
    distances,
    drift,
    steps_around,
    with_and_without,
)
from vbbench.sequence import Odometry


def wander(seed: int, frames: int = 90) -> FloatArray:
    """A way [T, 3] with a stand in it."""
    rng = np.random.default_rng(seed)
    steps = np.where(np.arange(frames) // 10 == 3, 0.0, rng.uniform(0.1, 0.7, frames))
    yaw = np.cumsum(0.3 * rng.standard_normal(frames))
    places = np.cumsum(steps[:, None] * np.stack([np.cos(yaw), np.sin(yaw)], axis=-1), axis=0)
    return np.column_stack([places, (yaw + pi) % (2 * pi) - pi])


def by_loops(estimate: FloatArray, truth: FloatArray, length: float) -> list[tuple[float, float]]:
    """Shift and turn of every segment, a step after the other."""
    found = []
    for i in range(len(truth)):
        gone, j = 0.0, i
        while gone < length and j + 1 < len(truth):
            gone += hypot(*(truth[j + 1, :2] - truth[j, :2]))
            j += 1
        if gone < length or not np.isfinite(estimate[[i, j]]).all():
            continue
        ends = []
        for poses in (estimate, truth):
            dx, dy, yaw = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1], poses[i, 2]
            ends.append((cos(yaw) * dx + sin(yaw) * dy, cos(yaw) * dy - sin(yaw) * dx, poses[j, 2] - yaw))
        (x, y, a), (u, v, b) = ends
        found.append((hypot(x - u, y - v) / length, abs(atan2(sin(a - b), cos(a - b))) / length))
    return found


@pytest.mark.parametrize("length", [2.0, 5.0, 11.0, 1000.0])
def test_drift_is_what_a_plain_loop_finds(length: float) -> None:
    pairs = []
    for seed in range(3):
        truth = wander(seed)
        estimate = truth + np.cumsum(0.02 * np.random.default_rng(seed + 50).standard_normal(truth.shape), axis=0)
        estimate[[1, 40]] = np.nan
        pairs.append((estimate, truth))
    expected = np.array([one for pair in pairs for one in by_loops(*pair, length)]).reshape(-1, 2)
    found = drift(pairs, length)
    np.testing.assert_allclose(np.stack([found.shift, found.turn], axis=-1), expected, atol=1e-12)
    assert found.values["segments"] == len(expected)
    assert (found.values["mean"] is None) == (length == 1000.0)


def test_where_a_map_lies_does_not_count_and_its_scale_does() -> None:
    truth = wander(4)
    cos_, sin_ = np.cos(1.0), np.sin(1.0)
    moved = np.column_stack(
        [
            5.0 + cos_ * truth[:, 0] - sin_ * truth[:, 1],
            sin_ * truth[:, 0] + cos_ * truth[:, 1] - 3.0,
            truth[:, 2] + 1.0,
        ]
    )
    assert drift([(moved, truth)], 5.0).shift.max() < 1e-12
    np.testing.assert_allclose(moved_as_one(moved, moved[0], truth[0]), truth, atol=1e-9)
    straight = np.column_stack([np.arange(50.0), np.zeros((50, 2))])
    assert drift([(straight * [1.1, 1.0, 1.0], straight)], 10.0).shift.mean() == pytest.approx(0.1)
    np.testing.assert_allclose(distances(straight), np.arange(50.0))


def test_dead_reckoning_goes_the_way_that_was_measured() -> None:
    truth = wander(2)
    motions = np.full((len(truth), 3), np.nan)
    for t in range(1, len(truth)):
        (dx, dy, turn), yaw = truth[t] - truth[t - 1], truth[t - 1, 2]
        motions[t] = cos(yaw) * dx + sin(yaw) * dy, cos(yaw) * dy - sin(yaw) * dx, turn
    odometry = Odometry(motions=motions, covariances=np.zeros((len(truth), 3, 3)))
    np.testing.assert_allclose(dead_reckoning(odometry, truth[0]), truth, atol=1e-9)


def test_the_camera_alone_sees_the_same_without_odometry() -> None:
    simulated = RobotStudy(sequences=1).recordings()[0]
    whole = load("generator", simulated.split).plan(simulated.options)
    alone = CameraAlone(whole)
    assert alone.info.id != whole.info.id
    assert set(whole.tables) - set(alone.tables) == {"odometry"}
    mine, own = alone.build(0).sequence, whole.build(0).sequence
    np.testing.assert_array_equal(mine.observations, own.observations)
    np.testing.assert_array_equal(mine.given.positions, own.given.positions)
    assert mine.given.odometry is None
    assert own.given.odometry is not None


@pytest.mark.slow
@pytest.mark.extra("rosbags")
def test_jrdb_is_measured_where_bags_hold_its_motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = recording(robot=MadeRobot(seconds=25.0))
    root, bags = files.write(tmp_path / "jrdb"), files.write_bag(tmp_path / "bags")
    (entrant, _) = with_and_without("cv")
    study = RobotStudy(jrdb=root, bags=bags, entrants=(entrant,), protocols=("sequential",))
    jrdb = study.recordings()[-1]
    monkeypatch.setattr(RobotStudy, "recordings", lambda study: [jrdb])
    found = study.measure(tmp_path / "out", Making())
    (course,) = found.courses
    assert course.recording.name == "jrdb"
    reference, solved = course.paths
    assert reference.drifts[0].shift.mean() < 0.2
    assert len(solved.drifts[0].shift) > 0
    assert not found.missing
    (picture,) = study.report(found).pictures.values()
    assert {axes.get_label() for axes in picture.axes} == {"cv", "drift"}


def test_frames_around_one_hold_so_many_steps() -> None:
    around = steps_around(np.full(900, 4), 300)
    assert around.start < 300 < around.stop
    assert 500 <= 4 * (around.stop - around.start) < 510
    assert steps_around(np.full(20, 4), 3) == slice(0, 20)
