"""Time between frames: a sight at the rate of a video agrees with its frames, and is smooth between them."""

import numpy as np
import pytest

from vbbench.camera import PanoramaCamera
from vbbench.generation.tier import Sight
from vbbench.geometry import BoolArray, FloatArray
from vbbench.sequence import Truth
from vbbench_generators.tiers.tracking.observing import finer

DT = 0.4


def sight_of(
    positions: FloatArray, poses: FloatArray, seen: BoolArray | None = None, *, watched: BoolArray | None = None
) -> Sight:
    people = positions.shape[1]
    return Sight(
        truth=Truth(poses=poses, positions=positions, heights=np.full(people, 1.7)),
        people=np.arange(people),
        seen=~np.isnan(positions[..., 0]) if seen is None else seen,
        watched=np.ones(len(poses), bool) if watched is None else watched,
        camera=PanoramaCamera(),
        dt=DT,
    )


def walks(frames: int = 12, people: int = 5) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(3)
    steps = rng.normal(0.4, 0.1, (frames, people + 1, 2))
    places = rng.uniform(-9, 9, (people + 1, 2)) + np.cumsum(steps, axis=0)
    yaw = np.cumsum(rng.normal(0.0, 0.8, frames))
    return places[:, 1:], np.concatenate([places[:, 0], np.arctan2(np.sin(yaw), np.cos(yaw))[:, None]], axis=1)


@pytest.mark.parametrize(("rate", "steps"), [(25.0, 10), (2.5, 1), (1.0, 1), (7.0, 3), (5.0, 2)])
def test_every_so_many_fine_frames_one_is_a_frame_to_the_last_bit(rate: float, steps: int) -> None:
    positions, poses = walks()
    positions[:4, 0] = positions[9:, 1] = positions[5, 2] = np.nan
    seen = ~np.isnan(positions[..., 0])
    seen[3, 4] = False
    watched = np.arange(12) != 6
    fine, found = finer(sight_of(positions, poses, seen, watched=watched), rate)
    assert found == steps
    assert len(fine.seen) == len(fine.watched) == len(fine.truth.poses) == 11 * steps + 1
    assert fine.dt == pytest.approx(DT / steps)
    np.testing.assert_array_equal(fine.truth.positions[::steps], positions)
    np.testing.assert_array_equal(fine.truth.poses[::steps], poses)
    np.testing.assert_array_equal(fine.seen[::steps], seen)
    np.testing.assert_array_equal(fine.watched[::steps], watched)


def test_who_walks_evenly_walks_evenly_between_frames_and_who_turns_does_not_jump() -> None:
    time = DT * np.arange(10)
    straight = np.stack([1.3 * time, -0.4 * time], axis=-1)
    angle = 0.5 * time
    round_corner = 3.0 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    poses = np.stack([time, 0.0 * time, 0.3 * time], axis=-1)
    fine, steps = finer(sight_of(np.stack([straight, round_corner], axis=1), poses))
    between = DT / steps * np.arange(len(fine.watched))
    np.testing.assert_allclose(fine.truth.positions[:, 0], np.stack([1.3 * between, -0.4 * between], axis=-1))
    np.testing.assert_allclose(fine.truth.poses[:, 2], 0.3 * between)
    inside = slice(steps, -steps)  # velocities of the first and last frame are of one side only
    exact = 3.0 * np.stack([np.cos(0.5 * between), np.sin(0.5 * between)], axis=-1)
    np.testing.assert_allclose(fine.truth.positions[inside, 1], exact[inside], atol=1e-3)


def test_the_camera_turns_the_shorter_way() -> None:
    poses = np.zeros((4, 3))
    poses[:, 2] = [3.0, 3.1, -3.1, -3.0]
    fine, _ = finer(sight_of(np.zeros((4, 1, 2)), poses))
    turned = np.unwrap(fine.truth.poses[:, 2])
    assert np.all(np.diff(turned) > 0.0)
    assert turned[-1] == pytest.approx(2.0 * np.pi - 3.0)


def test_who_comes_and_goes_is_there_half_a_frame_longer_and_walks_straight_on() -> None:
    positions = np.full((6, 2, 2), np.nan)
    positions[2:4, 0] = [[0.0, 0.0], [0.4, 0.0]]
    positions[3, 1] = [5.0, 5.0]  # there in a single frame: nobody knows how fast
    fine, steps = finer(sight_of(positions, np.zeros((6, 3))))
    there = np.flatnonzero(fine.seen[:, 0])
    assert there.tolist() == list(range(2 * steps - steps // 2, 4 * steps - steps // 2))
    np.testing.assert_array_equal(~np.isnan(fine.truth.positions[..., 0]), fine.seen)
    np.testing.assert_allclose(fine.truth.positions[there, 0, 0], 0.04 * (there - 2 * steps), atol=1e-12)
    np.testing.assert_array_equal(fine.truth.positions[fine.seen[:, 1], 1], np.full((steps, 2), 5.0))


def test_nobody_and_a_single_frame() -> None:
    empty, steps = finer(sight_of(np.empty((3, 0, 2)), np.zeros((3, 3))))
    assert empty.truth.positions.shape == (2 * steps + 1, 0, 2)
    single, _ = finer(sight_of(np.zeros((1, 2, 2)), np.zeros((1, 3))))
    assert single.truth.positions.shape == (1, 2, 2)
