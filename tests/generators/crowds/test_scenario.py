"""Scenario files, and what is drawn of them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vbbench.errors import FileError
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench_generators.crowds import draw_speeds, get_scenario, is_stuck, read_scenario

SMALL = """name = "mine"
title = "two people"
sequences = 2
people = [2]
frames = 5
dt = 0.4
[[flow]]
start = [0.0, 0.0, 4.0, 4.0]
goal = [8.0, 0.0, 12.0, 4.0]
beyond = true
"""


def test_desired_speeds_are_normal_and_cut_off() -> None:
    speeds = draw_speeds(get_scenario("open"), 100_000, np.random.default_rng(0))
    assert np.mean(speeds) == pytest.approx(1.34, abs=0.005)
    assert np.std(speeds) == pytest.approx(0.26 * 0.9866, abs=0.005)
    assert np.abs(speeds - 1.34).max() <= 3 * 0.26


def test_standing_still_is_being_stuck_and_turning_round_is_not() -> None:
    time = np.arange(20)[:, None] * 0.4
    walks = np.stack([1.3 * time, np.zeros_like(time)], axis=-1)
    stands = np.where(time[..., None] < 4.0, walks, walks[10])
    returns = np.where(time[..., None] < 4.0, walks, 2 * walks[10] - walks)
    stuck = is_stuck(np.concatenate([walks, stands, returns], axis=1), np.full(3, 1.3), 0.4)
    assert stuck.tolist() == [False, True, False]


def test_a_users_scenario_is_simulated(write: Callable[..., Path], tmp_path: Path) -> None:
    made = generate("sim", tmp_path / "mine", Options(simulation=Simulation(scenario=str(write(SMALL, "mine.toml")))))
    assert (len(made), made.info.definition["scenario"]["name"]) == (2, "mine")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("frames = 5", "frame = 5", "unknown key 'frame'; did you mean 'frames'"),
        ("frames = 5", "frames = 0", "frames must be 1 to 1,000,000, not 0"),
        ("dt = 0.4", "dt = 0.4\nwarm_up = -2.0", "warm_up must be 0 to 3,600 s, not -2"),
        ("dt = 0.4", "dt = 0.4\nspeed_std = -0.1", "speed_std must be 0 to 3 m/s, not -0.1"),
        ("people = [2]", "people = [1]", "people must be 2 to 10,000, not 1"),
        ("people = [2]", "people = []", "people must be one number or more"),
        ("people = [2]\nframes = 5", "people = [10000]\nframes = 1000000", "10,000 people in 1,000,000 frames"),
        ("dt = 0.4", "dt = 0.4\nwalls = [[0.0, 0.0, 9e4, 9e4]]", "the walls are 127,279 m long, more than 100,000 m"),
        ("dt = 0.4", "dt = 0.41", "not a whole number of steps"),
        ("[0.0, 0.0, 4.0, 4.0]", "[4.0, 0.0, 0.0, 4.0]", "is not a rectangle"),
        ("beyond = true", "beyond = true\nthen = [[0.0, 0.0, 1.0, 1.0]]", "never arrive"),
        ("dt = 0.4", "dt = 0.4\nspeed_std = 1.0", "walk backwards"),
        ("dt = 0.4", "dt = 0.4\nwalls = [[1.0, 2.0]]", "a wall is four numbers"),
        ("[[flow]]", "[flow]", r"each with the heading \[\[flow\]\]: double brackets"),
    ],
)
def test_bad_scenario_files_are_named(write: Callable[..., Path], old: str, new: str, message: str) -> None:
    path = write(SMALL.replace(old, new), "bad.toml")
    with pytest.raises(FileError, match=message) as caught:
        read_scenario(path)
    assert str(path) in str(caught.value)
