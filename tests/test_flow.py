"""People's pace, and the worlds that it tells apart after a cold start."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.rough_crowd import BOX_STD, drive, made_drive
from vbbench.geometry import BoolArray, FloatArray
from vbbench.sequence import Odometry
from vbbench_baselines.common.odometry import stray
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.flow import Flow, flow_of, is_untold, ways_of
from vbbench_baselines.joint_map.motion.pace import Pace, add_pace, density, pace_deviance, pace_of
from vbbench_baselines.joint_map.optimiser.banded import BAND
from vbbench_baselines.joint_map.real_camera.settings import Settings

DT, FRAMES, PEOPLE = 0.4, 30, 12


def test_the_density_of_a_velocity_integrates_to_one() -> None:
    """In all, but for what of the walkers' ring is left out; most likely are a walker's speed, and standing."""
    axis = np.linspace(-6.0, 6.0, 481)
    total = sum(density(x, y) for x in axis for y in axis) * (axis[1] - axis[0]) ** 2
    assert total == pytest.approx(1.0, abs=0.02)
    speeds = np.array([density(0.6 * speed, 0.8 * speed) for speed in (0.0, 0.6, 1.3, 2.5)])
    assert (speeds[[0, 2]] > 1.5 * speeds[1]).all()
    assert speeds[3] < 0.1 * speeds[2]


def bent_track() -> FloatArray:
    """Somebody who walks, turns and stands, [9, 2] in m."""
    steps = np.array(
        ((0.5, 0.1), (0.55, 0.0), (0.4, 0.3), (0.2, 0.2), (0.02, 0.01), (0.0, 0.0), (-0.3, 0.1), (0.9, 0.4))
    )
    return np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0)))


def test_the_pace_of_a_track_pulls_as_its_density_does() -> None:
    track, pace = bent_track(), Pace(0.3, DT)
    lower, pull = np.zeros((track.size + BAND, 2 * BAND + 1)), np.zeros(track.size)
    add_pace(track, pace, lower, pull)
    step = 1e-6
    for i in range(track.size):
        ends = []
        for sign in (1.0, -1.0):
            moved = track.copy()
            moved.flat[i] += sign * step
            ends.append(pace_deviance(moved, pace))
        assert pull[i] == pytest.approx((ends[0] - ends[1]) / (2.0 * step), abs=1e-5)
    n = track.size
    curvature = sum(np.diag(lower[: n - d, d], -d) + np.diag(lower[: n - d, d], d) * (d > 0) for d in range(BAND))
    assert np.linalg.eigvalsh(curvature).min() > -1e-9
    assert np.linalg.eigvalsh(curvature).max() > 1.0


def test_pace_counts_after_a_cold_start_only() -> None:
    lower, pull = np.zeros((18 + BAND, 2 * BAND + 1)), np.zeros(18)
    add_pace(bent_track(), pace_of(DT, share=0.0), lower, pull)
    assert not lower.any()
    assert not pull.any()
    assert pace_deviance(bent_track(), pace_of(DT, share=0.0)) == 0.0
    assert pace_deviance(bent_track(), pace_of(DT, share=1.0)) > 0.0


def crossing(speed: float, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """Poses [T, 3] of a camera at so many m/s, and places [T, K, 2] of people who walk every way."""
    rng, seconds = np.random.default_rng(seed), DT * np.arange(FRAMES)
    yaw = 0.4 + 0.02 * np.arange(FRAMES)
    steps = speed * DT * np.column_stack((np.cos(yaw), np.sin(yaw)))
    poses = np.column_stack((np.cumsum(steps, axis=0), yaw))
    way, pace = rng.uniform(0.0, 2.0 * np.pi, PEOPLE), rng.normal(1.3, 0.15, PEOPLE)
    velocity = pace[:, None] * np.column_stack((np.cos(way), np.sin(way)))
    return poses, rng.uniform(-5.0, 15.0, (PEOPLE, 2)) + seconds[:, None, None] * velocity


def faster(poses: FloatArray, places: FloatArray, speed: float) -> tuple[FloatArray, FloatArray]:
    """The same world with all moving so much faster along the camera's heading."""
    moved = ways_of(speed, poses, DT)
    return np.column_stack((poses[:, :2] + moved, poses[:, 2])), places + moved[:, None]


@pytest.mark.parametrize(("speed", "drives"), [(2.0, True), (0.0, True), (1.3, False)])
@pytest.mark.parametrize("wrong", [-1.6, 0.0, 2.4])
def test_the_world_in_which_people_walk_as_people_do_is_found(speed: float, drives: bool, wrong: float) -> None:
    truth = crossing(speed)
    poses, places = faster(*truth, wrong)
    shown, flow = np.ones(places.shape[:2], np.bool_), Flow(DT, drives)
    for end in range(1, FRAMES + 1):
        start = max(0, end - 12)
        moved = flow.follow(poses[start:end], places[start:end], shown[start:end])
        if moved is not None:
            assert not moved[0].any()
            heading = np.array((np.cos(poses[end - 1, 2]), np.sin(poses[end - 1, 2])))
            onwards = ways_of(float((moved[-1] - moved[-2]) @ heading) / DT, poses[start:], DT)
            np.testing.assert_allclose(onwards[: end - start], moved, atol=1e-9)
            poses[start:, :2] += onwards
            places[start:] += onwards[:, None]
    found, true = (np.hypot(*(path[-1, :2] - path[-9, :2])) / (8 * DT) for path in (poses, truth[0]))
    assert found == pytest.approx(true, abs=0.25)
    np.testing.assert_allclose(places - poses[:, None, :2], truth[1] - truth[0][:, None, :2], atol=1e-9)
    whole = flow_of(*faster(*truth, wrong), shown, DT, drives)
    heading = np.array((np.cos(poses[-1, 2]), np.sin(poses[-1, 2])))
    assert (whole[-1] - whole[-2]) @ heading / DT == pytest.approx(-wrong, abs=0.3)


def flow_among(ways: FloatArray, believed: float, seed: int) -> float:
    """By how many m/s a camera is found to be faster than believed, off by ``believed``, among people on these ways."""
    rng = np.random.default_rng(seed)
    velocity = 1.3 * np.column_stack((np.cos(ways), np.sin(ways))) - (believed, 0.0)
    velocity += rng.normal(0.0, 0.3, velocity.shape)
    places = rng.uniform(-5.0, 15.0, velocity.shape) + DT * np.arange(FRAMES)[:, None, None] * velocity
    shown = np.ones(places.shape[:2], np.bool_)
    return float(flow_of(np.zeros((FRAMES, 3)), places, shown, DT, drives=True)[-1, 0] / (DT * (FRAMES - 1)))


@pytest.mark.parametrize("seed", range(6))
def test_a_crowd_that_walks_all_ways_tells_that_a_camera_walks(seed: int) -> None:
    """Each of them tells, though a vehicle that stands is likelier than one that is slower than a walker."""
    ways = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 25)
    assert flow_among(ways, 0.8, seed) == pytest.approx(0.8, abs=0.3)


@pytest.mark.parametrize("people", [3, 10, 100])
def test_a_stream_of_people_who_walk_one_way_does_not_move_a_camera_that_stands(people: int) -> None:
    assert flow_among(np.zeros(people), 0.0, 2) == pytest.approx(0.0, abs=0.3)


def test_where_nobody_is_seen_nothing_is_moved() -> None:
    poses, places = faster(*crossing(1.0), -3.0)
    flow, nobody = Flow(DT, drives=True), np.zeros(places.shape[:2], np.bool_)
    for start, end in pairwise(range(0, FRAMES, 2)):
        assert flow.follow(poses[start:end], places[start:end], nobody[start:end]) is None
    assert not flow_of(poses, places, nobody, DT, drives=True).any()


@pytest.mark.parametrize(("dt", "rows"), [(1.0 / 30.0, 8), (0.1, 12), (2.0, 12)])
def test_worlds_are_told_apart_at_every_frame_rate(dt: float, rows: int) -> None:
    """In windows that are shorter than velocities are measured for, and where a frame takes longer."""
    rng, frames = np.random.default_rng(1), 60
    way, seconds = rng.uniform(0.0, 2.0 * np.pi, PEOPLE), dt * np.arange(frames)
    velocity = 1.3 * np.column_stack((np.cos(way), np.sin(way))) + (2.4, 0.0)
    places = rng.uniform(-5.0, 15.0, (PEOPLE, 2)) + seconds[:, None, None] * velocity
    poses = np.column_stack((2.4 * seconds, np.zeros((frames, 2))))
    shown, flow = np.ones((frames, PEOPLE), np.bool_), Flow(dt, drives=True)
    moves = [
        flow.follow(poses[max(0, end - rows) : end], places[max(0, end - rows) : end], shown[max(0, end - rows) : end])
        for end in range(1, frames + 1)
    ]
    first = next(moved for moved in moves if moved is not None)
    assert first[-1, 0] / dt / (len(first) - 1) == pytest.approx(-2.4, abs=0.6)


def test_what_else_tells_how_fast_all_move_is_heard() -> None:
    poses, places, motions = np.full((4, 3), np.nan), np.full((4, 2, 2), np.nan), np.full((4, 3), np.nan)
    poses[0], motions[0] = 0.0, 1.0
    assert is_untold(poses, places, motions)
    for told in (poses, places, motions):
        told[2] = 1.0
        assert not is_untold(poses, places, motions)
        told[2] = np.nan


@pytest.mark.parametrize("rough", [False, True])
def test_once_told_the_world_stays(rough: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Odometry that ends leaves velocities that are known better than pace tells them."""
    made = made_drive(drive(1, 24), box_std=BOX_STD if rough else 0.0)
    motions = np.full((24, 3), np.nan)
    motions[4:9] = [stray(before, now, np.zeros(3))[0] for before, now in pairwise(made.truth.poses[3:9])]
    odometry = Odometry(motions=motions, covariances=np.where(np.isnan(motions[..., None]), np.nan, 1e-4 * np.eye(3)))
    sequence = replace(made.sequence, given=replace(made.sequence.given, odometry=odometry))
    asked: list[int] = []
    follow = Flow.follow

    def counted(flow: Flow, poses: FloatArray, places: FloatArray, shown: BoolArray) -> FloatArray | None:
        asked.append(len(poses))
        return follow(flow, poses, places, shown)

    monkeypatch.setattr(Flow, "follow", counted)
    solver = MapCausal(real=Settings() if rough else None)
    replace(made, sequence=sequence).solved(lambda: solver, "cold-start")
    assert 0 < len(asked) <= 4
