"""A vehicle or robot as observer: how it moves, what it sees and measures, and where it is refused."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.files.dataset_checks import ALWAYS
from vbbench.files.generate_command import generate_command
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Card, Options, Simulation
from vbbench.geometry import FloatArray, motion_between, world_to_relative
from vbbench.scene import Scene
from vbbench.sequence import NO_OBSERVER, SequenceData
from vbbench_generators.crowds.sim import record_plaza
from vbbench_generators.recordings.recipe import Rules
from vbbench_generators.splits import demo, sim, street
from vbbench_generators.views import Reprojection, plan_reprojection
from vbbench_generators.views.vehicle import drive, find_windows, follow, get_robot, get_vehicle

MODEL = get_vehicle()
CARD = Card(name="made", title="Synthetic crowds", licence="", citation="", sources=())


def plan(options: Options) -> Reprojection:
    scenes = [record_plaza(0, index, 24, 120) for index in range(2)]
    return plan_reprojection(CARD, Rules(), scenes, options, {})


def reach(data: SequenceData) -> FloatArray:
    """[T, K] distance of tracks in m."""
    return np.hypot(*np.moveaxis(world_to_relative(data.truth.positions, data.truth.poses), -1, 0))


def test_it_is_nobody_of_the_scene_and_sees_people_for_a_while() -> None:
    made = plan(Options(tier="noisy", observer="vehicle"))
    seen = set()
    for index in range(len(made)):
        data = made.build(index)
        sequence = data.sequence
        assert sequence.observer == NO_OBSERVER
        assert MODEL.shortest <= sequence.frames <= MODEL.longest
        assert sequence.observed.sum(axis=1).min() >= MODEL.fewest
        assert np.nanmin(reach(data)) >= MODEL.clearance
        seen |= set(sequence.tracks.tolist())
        scene, frames = made.scenes[sequence.scene], slice(sequence.first_frame, sequence.first_frame + sequence.frames)
        np.testing.assert_array_equal(
            np.isnan(scene.positions[frames][:, np.searchsorted(scene.people, sequence.tracks), 0]),
            np.isnan(data.truth.positions[..., 0]),
        )
    assert len(made) == 2 * 9  # windows of 40 of 120 frames, 10 apart
    assert len(seen) > 24


@pytest.mark.parametrize("split", [sim, street])
def test_it_drives_in_simulated_crowds(split: object) -> None:
    options = Options(observer="vehicle", simulation=Simulation(sequences=2, people=(20,)))
    laid_out = split.plan(options)  # type: ignore[attr-defined]
    data = laid_out.build(1)
    assert data.sequence.observer == NO_OBSERVER
    assert 2 < data.sequence.frames <= MODEL.longest
    np.testing.assert_array_equal(data.truth.poses, laid_out.build(1).truth.poses)
    assert not np.array_equal(data.truth.poses[:3], laid_out.build(0).truth.poses[:3])


def still_crowd(frames: int = 40) -> FloatArray:
    """A few people in the middle of nowhere, so that every way sees them for some time."""
    return np.broadcast_to(np.random.default_rng(0).uniform(-2, 2, (5, 2)), (frames, 5, 2)).copy()


def test_it_moves_as_the_model_says() -> None:
    rng, crowd, dt = np.random.default_rng(0), still_crowd(), 0.4
    free = replace(MODEL, clearance=0.0, horizon=1e4, shortest=1, fewest=1)
    ways = [drive(crowd, np.ones((40, 5), bool), dt, PanoramaCamera(), free, rng)[1] for _ in range(600)]
    steps = np.array([np.hypot(*np.diff(way[:, :2], axis=0).T) for way in ways]) / dt
    turns = np.array([np.diff(np.unwrap(way[:, 2])) for way in ways]) / dt
    stands = steps.max(axis=1) == 0.0
    assert stands.mean() == pytest.approx(MODEL.standing, abs=0.06)
    assert np.median(steps[~stands].mean(axis=1)) == pytest.approx(0.5 * (MODEL.slowest + MODEL.fastest), abs=0.25)
    assert turns[~stands][steps[~stands] > 0.0].std() == pytest.approx(MODEL.yaw_rate_std, rel=0.05)
    headings = np.array([np.arctan2(*np.diff(way[:, :2], axis=0)[0, ::-1]) for way in np.array(ways)[~stands]])
    moving = steps[~stands][:, 0] > 0.0
    off = np.angle(np.exp(1j * (headings - np.array(ways)[~stands][:, 0, 2])))[moving]
    np.testing.assert_allclose(off, 0.0, atol=1e-9)  # it looks where it drives


def test_the_crowd_is_ahead_at_the_distance_of_the_model() -> None:
    rng, crowd = np.random.default_rng(0), still_crowd()
    standing = replace(MODEL, standing=1.0)
    middle = crowd[0].mean(axis=0)
    for _ in range(20):
        _, way = drive(crowd, np.ones((40, 5), bool), 0.4, PerspectiveCamera(), standing, rng)
        relative = world_to_relative(middle[None], way[0])
        np.testing.assert_allclose(relative[0, 0], 0.0, atol=1e-9)
        assert MODEL.nearest_crowd <= relative[0, 1] <= MODEL.farthest_crowd


def test_the_nearest_person_is_as_far_as_the_model_says() -> None:
    """Not as far as people stay in view for longest."""
    made = sim.plan(Options(observer="vehicle", simulation=Simulation(sequences=40, people=(20,))))
    nearest = np.array([np.median(_nearest(made.build(index))) for index in range(len(made))])
    assert np.mean((nearest > MODEL.nearest_person - 0.5) & (nearest < MODEL.farthest_person + 0.5)) > 0.8
    assert np.mean(nearest) == pytest.approx(0.5 * (MODEL.nearest_person + MODEL.farthest_person), abs=0.8)


def _nearest(data: SequenceData) -> FloatArray:
    """[T] m to the nearest person who is seen."""
    return np.nanmin(np.where(data.sequence.observed, reach(data), np.nan), axis=1)


def test_in_a_dense_crowd_it_stands_aside_and_sees_everybody() -> None:
    grid = np.stack(np.meshgrid(np.arange(-30.0, 31, 3), np.arange(-30.0, 31, 3)), axis=-1).reshape(-1, 2)
    crowd = np.broadcast_to(grid, (12, len(grid), 2)).copy()
    camera = PerspectiveCamera()
    there = np.ones(crowd.shape[:2], bool)
    first, way = drive(crowd, there, 0.4, camera, replace(MODEL, clearance=4.0), np.random.default_rng(0))
    assert (first, len(way)) == (0, 12)
    right, forward = world_to_relative(crowd[0], way[0]).T
    azimuth = np.arctan2(right, forward)
    assert camera.view[0] - 1e-9 <= azimuth.min() <= azimuth.max() <= camera.view[1] + 1e-9


def test_windows_have_people() -> None:
    positions = np.full((100, 4, 2), np.nan)
    positions[50:70] = 0.0
    scene = Scene(name="s", dt=0.4, people=np.arange(4), positions=positions, heights=np.full(4, np.nan))
    windows = find_windows(scene, 3, scene.present)
    assert [(window.scene, window.first, len(window.counted)) for window in windows] == [
        (3, first, 40) for first in (30, 40, 50)
    ]


def test_a_dataset_says_who_carries_the_camera(tmp_path: Path) -> None:
    options = Options(
        tier="field", detector=False, observer="vehicle", simulation=Simulation(sequences=2, people=(12,))
    )
    data = generate("sim", tmp_path / "sim", options)
    definition = data.info.definition
    assert (definition["observer"], definition["vehicle"]["standing"]) == ("vehicle", MODEL.standing)
    assert "look" not in definition
    command = generate_command(json.loads(data.info.to_json()), "x")
    assert command.endswith("--observer vehicle --no-detector --people 12 --out x")
    assert "--camera" not in command
    assert "--sigma-h" not in command
    assert "2 sequences are as written" in verify(data.folder)


DT = 0.4
FEW = Options(observer="robot", stride=2, simulation=Simulation(scenario="plaza", sequences=4, people=(8,)))


def walk(seed: int, frames: int = 100) -> FloatArray:
    """A person who wanders about at 1 m/s."""
    heading = np.cumsum(0.25 * np.random.default_rng(seed).standard_normal(frames))
    return np.cumsum(DT * np.stack([np.cos(heading), np.sin(heading)], axis=-1), axis=0)


def test_a_robot_follows_a_person_as_wheels_allow() -> None:
    model = get_robot()
    for seed in range(5):
        path = walk(seed)
        poses, _ = follow(path, DT, np.random.default_rng(seed))
        forward, left, turn = motion_between(poses[:-1], poses[1:]).T
        assert np.hypot(*(poses[10:, :2] - path[10:]).T).mean() < 0.3
        assert forward.max() <= model.top_speed * DT + 1e-9
        assert np.abs(turn).max() <= model.turn_rate * DT + 1e-9
        assert np.abs(left).max() < 0.5 * model.turn_rate * DT * model.top_speed * DT


def test_a_robots_odometry_is_as_far_off_as_it_says() -> None:
    off, held = [], []
    for seed in range(20):
        poses, odometry = follow(walk(seed), DT, np.random.default_rng(100 + seed))
        assert np.isnan(odometry.motions[0]).all()
        true = motion_between(poses[:-1], poses[1:])
        errors = odometry.motions[1:] - true
        off.append(np.abs(errors[:, 0]).sum() / true[:, 0].sum())
        whitened = np.linalg.solve(odometry.covariances[1:, :2, :2], errors[:, :2, None])[..., 0]
        held.append(np.mean((errors[:, :2] * whitened).sum(axis=1) < 5.991))
    assert 0.002 < np.mean(off) < 0.05
    assert 0.9 < np.mean(held) <= 1.0


def test_a_dataset_of_a_robot_has_odometry_and_everybody_else(tmp_path: Path) -> None:
    made = generate("sim", tmp_path / "whole", FEW)
    verify(made.folder)
    assert set(made.info.tables) == {*ALWAYS, "odometry"}
    assert made.info.definition["robot"]["speed_slip"] == get_robot().speed_slip
    for sequence in made.sequences():
        poses, odometry = made.truth(sequence).poses, sequence.given.odometry
        assert sequence.observer == NO_OBSERVER
        assert len(sequence.tracks) == 7
        assert odometry is not None
        true = motion_between(poses[:-1], poses[1:])
        np.testing.assert_allclose(odometry.motions[1:, :2], true[:, :2], atol=0.12)
    plan = sim.plan(replace(FEW, observer="walker"))
    assert plan.tables == ALWAYS
    assert plan.build(0).sequence.given.odometry is None


@pytest.mark.parametrize(
    ("split", "options", "message"),
    [
        (demo, {"observer": "robot"}, "a robot drives among simulated people: `observer` robot is not for demo"),
        (sim, {"observer": "robot", "look": "wander"}, "a robot looks where it drives; remove `look`"),
        (sim, {"observer": "vehicle", "look": "wander"}, "a vehicle looks where it drives; remove `look`"),
    ],
)
def test_what_cannot_be_is_refused(split: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(VbbenchError, match=message):
        split.plan(Options(**options))
