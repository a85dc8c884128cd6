"""A robot as observer: it follows one of the people, and its odometry is nearly right and knows how nearly."""

from pathlib import Path

import numpy as np
import pytest

from tests.generators.test_odometry_filter import in_ellipse
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_checks import ALWAYS
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.geometry import FloatArray, world_to_relative, wrap_angle
from vbbench.sequence import NO_OBSERVER
from vbbench_generators.splits import demo, sim
from vbbench_generators.views.vehicle import follow, get_robot

DT = 0.4
FEW = Options(observer="robot", simulation=Simulation(scenario="plaza", sequences=3, people=(8,)))


def walk(seed: int, frames: int = 100) -> FloatArray:
    """Somebody who wanders about at 1 m/s."""
    heading = np.cumsum(0.25 * np.random.default_rng(seed).standard_normal(frames))
    return np.cumsum(DT * np.stack([np.cos(heading), np.sin(heading)], axis=-1), axis=0)


def moved(poses: FloatArray) -> FloatArray:
    """[T − 1, 3] (forward, left, turn) between poses [T, 3]."""
    right, forward = world_to_relative(poses[1:, None, :2], poses[:-1])[:, 0].T
    return np.stack([forward, -right, wrap_angle(np.diff(poses[:, 2]))], axis=-1)


def test_it_follows_a_person_as_wheels_allow() -> None:
    model = get_robot()
    for seed in range(5):
        path = walk(seed)
        poses, _ = follow(path, DT, np.random.default_rng(seed))
        forward, left, turn = moved(poses).T
        assert np.hypot(*(poses[10:, :2] - path[10:]).T).mean() < 0.3
        assert forward.max() <= model.top_speed * DT + 1e-9
        assert np.abs(turn).max() <= model.turn_rate * DT + 1e-9
        assert np.abs(left).max() < 0.5 * model.turn_rate * DT * model.top_speed * DT


def test_its_odometry_is_as_far_off_as_it_says() -> None:
    off, held = [], []
    for seed in range(20):
        poses, odometry = follow(walk(seed), DT, np.random.default_rng(100 + seed))
        assert np.isnan(odometry.motions[0]).all()
        errors = odometry.motions[1:] - moved(poses)
        errors[:, 2] = wrap_angle(errors[:, 2])
        off.append(np.abs(errors[:, 0]).sum() / moved(poses)[:, 0].sum())
        held.append(in_ellipse(errors[:, :2], odometry.covariances[1:, :2, :2]))
    assert 0.002 < np.mean(off) < 0.05
    assert 0.9 < np.mean(held) <= 1.0


def test_a_dataset_of_it_has_odometry_and_everybody_else(tmp_path: Path) -> None:
    made = generate("sim", tmp_path / "whole", FEW)
    verify(made.folder)
    assert set(made.info.tables) == {*ALWAYS, "odometry"}
    assert made.info.definition["robot"]["speed_slip"] == get_robot().speed_slip
    for sequence in made.sequences():
        truth, odometry = made.truth(sequence), sequence.given.odometry
        assert sequence.observer == NO_OBSERVER
        assert len(sequence.tracks) == 7
        assert odometry is not None
        np.testing.assert_allclose(odometry.motions[1:, :2], moved(truth.poses)[:, :2], atol=0.12)
    some = generate("sim", tmp_path / "some", Options(**{**vars(FEW), "stride": 2}))
    np.testing.assert_array_equal(
        some.sequence(1).given.odometry.motions,  # type: ignore[union-attr]
        made.sequence(2).given.odometry.motions,  # type: ignore[union-attr]
    )


def test_walkers_walk_as_they_did_and_measure_nothing(tmp_path: Path) -> None:
    made = generate("sim", tmp_path / "out", Options(simulation=FEW.simulation, limit=1))
    assert "odometry" not in made.info.tables
    assert Dataset(made.folder).sequence(0).given.odometry is None


def test_it_is_refused_where_nobody_makes_way() -> None:
    with pytest.raises(VbbenchError, match="a robot drives among simulated people: `observer` robot is not for demo"):
        demo.plan(Options(observer="robot"))
    with pytest.raises(VbbenchError, match="a robot looks where it drives; remove `look`"):
        sim.plan(Options(observer="robot", look="wander"))
