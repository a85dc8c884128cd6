"""The split `sim` and its scenarios: who walks where, who observes, and that nothing but the seed decides."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vbbench.cli import main
from vbbench.errors import FileError, UnknownNameError, VbbenchError
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.generation.options_file import parse_people
from vbbench.registry import load
from vbbench_generators.crowds import scenario as simulation
from vbbench_generators.crowds.scenario import get_scenario, read_scenario, scenario_names
from vbbench_generators.crowds.sim import SimulationPlan


def plan(**options: Any) -> SimulationPlan:
    asked = {key: options.pop(key) for key in ("scenario", "sequences", "people") if key in options}
    made: SimulationPlan = load("generator", "sim").plan(Options(simulation=Simulation(**asked), **options))
    return made


def test_the_default_is_the_papers_split() -> None:
    sim = plan()
    assert (len(sim), sim.info.camera.kind, sim.info.dt, sim.info.height_std) == (500, "perspective", 0.4, 0.07)
    assert sim.scenario.step == 0.05
    for index in range(10):
        scene = sim.build(index).scene
        assert scene is not None
        assert (scene.frames, len(scene.people)) == (20, (10, 20, 30, 40, 50)[index % 5])


@pytest.mark.parametrize("people", [10, 50])
def test_people_start_apart_in_the_field_and_never_stop(people: int) -> None:
    sim = plan(people=(people,))
    for index in range(5):
        scene = sim.build(index).scene
        assert scene is not None
        start = scene.positions[0]
        apart = np.linalg.norm(start[:, None] - start, axis=-1)[~np.eye(people, dtype=bool)]
        assert np.abs(start).max() <= 8.0
        assert apart.min() >= 0.5
        ways = np.linalg.norm(np.diff(scene.positions, axis=0), axis=-1)
        assert ways[-1].min() > 0.05  # m in 0.4 s: nobody has arrived
        assert ways.max() <= 1.3 * (1.34 + 3 * 0.26) * 0.4 + 1e-9


def test_desired_speeds_are_normal_and_cut_off() -> None:
    from vbbench_generators.crowds.scenario import draw_speeds

    speeds = draw_speeds(get_scenario("open"), 100_000, np.random.default_rng(0))
    assert np.mean(speeds) == pytest.approx(1.34, abs=0.005)
    assert np.std(speeds) == pytest.approx(0.26 * 0.9866, abs=0.005)
    assert np.abs(speeds - 1.34).max() <= 3 * 0.26


def test_the_observer_sees_at_least_two_people_in_every_picture() -> None:
    sim = plan(height_std=0.0)
    for index in range(20):
        assert sim.build(index).sequence.observed.sum(axis=1).min() >= 2


def test_a_sequence_does_not_depend_on_what_was_built_before() -> None:
    sim, other = plan(tier="noisy"), plan(tier="noisy", limit=5)
    third = sim.build(3).sequence
    other.build(0)
    np.testing.assert_array_equal(other.build(3).sequence.observations, third.observations)


def test_the_spread_of_heights_changes_heights_alone() -> None:
    same, spread = plan(height_std=0.0), plan(height_std=0.3)
    for index in range(20):
        exact, tall = same.build(index), spread.build(index)
        assert exact.scene is not None
        assert tall.scene is not None
        assert np.all(exact.scene.heights == 1.70)
        assert np.std(tall.scene.heights) > 0.1
        np.testing.assert_array_equal(exact.scene.positions, tall.scene.positions)
        np.testing.assert_array_equal(exact.truth.poses, tall.truth.poses)


def test_every_sequence_has_a_scene_of_its_own(tmp_path: Path) -> None:
    made = generate("sim", tmp_path / "sim", Options(limit=6))
    np.testing.assert_array_equal(made.rows["scene"], np.arange(6))
    sequence = made.sequence(5)
    people, positions, _ = made.surroundings(sequence)
    column = int(np.searchsorted(people, sequence.observer))
    np.testing.assert_allclose(made.truth(sequence).poses[:, :2], positions[:, column], atol=1e-9)


def test_who_is_stuck_is_drawn_again(monkeypatch: pytest.MonkeyPatch) -> None:
    answers = iter([True, False])
    tried = []

    def once(positions: np.ndarray, speeds: np.ndarray, dt: float) -> np.ndarray:
        tried.append(positions)
        return np.array([next(answers)])

    monkeypatch.setattr(simulation, "is_stuck", once)
    scene = plan().build(0).scene
    assert scene is not None
    assert len(tried) == 2
    assert not np.array_equal(tried[0], tried[1])
    np.testing.assert_array_equal(scene.positions, tried[1])


def test_standing_still_is_being_stuck_and_turning_round_is_not() -> None:
    time = np.arange(20)[:, None] * 0.4
    walks = np.stack([1.3 * time, np.zeros_like(time)], axis=-1)
    stands = np.where(time[..., None] < 4.0, walks, walks[10])
    returns = np.where(time[..., None] < 4.0, walks, 2 * walks[10] - walks)
    stuck = simulation.is_stuck(np.concatenate([walks, stands, returns], axis=1), np.full(3, 1.3), 0.4)
    assert stuck.tolist() == [False, True, False]


def test_endless_redrawing_ends_in_one_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation, "is_stuck", lambda positions, speeds, dt: np.array([True]))
    monkeypatch.setattr(simulation, "ATTEMPTS", 3)
    with pytest.raises(VbbenchError, match="scenario 'open' with 10 people: in each of 3 crowds a person was stuck"):
        plan().build(0)


def test_a_crowd_that_does_not_fit_is_one_clear_error() -> None:
    with pytest.raises(VbbenchError, match=r"no place left in .* that is 0.5 m from all other people"):
        plan(people=(1500,)).build(0)


@pytest.mark.parametrize("name", scenario_names())
def test_every_scenario_can_be_built(name: str) -> None:
    built = plan(scenario=name, people=(20,)).build(0)
    assert built.scene is not None
    assert len(built.scene.people) == 20
    assert np.isfinite(built.scene.positions).all()
    assert built.sequence.observed.any()


def test_nobody_walks_through_the_walls_of_the_corridor() -> None:
    for index in range(3):
        scene = plan(scenario="corridor", people=(30,)).build(index).scene
        assert scene is not None
        assert np.abs(scene.positions[..., 1]).max() < 2.5


def test_the_street_is_the_photorealistic_splits_crowd() -> None:
    street = plan(scenario="street")
    scene = street.build(0).scene
    assert scene is not None
    assert (scene.frames, len(scene.people), scene.dt) == (400, 50, 0.1)
    assert (np.abs(scene.positions).max(axis=(0, 1)) < [11.0, 21.0]).all()
    late = np.linalg.norm(np.diff(scene.positions[300:], axis=0), axis=-1).sum(axis=0)
    assert late.min() > 0.1 * 10.0  # m in 10 s: who arrived has been given a new goal


@pytest.mark.parametrize(
    ("text", "counts"), [("30", (30,)), ("3:5", (3, 4, 5)), ("10:50:10", (10, 20, 30, 40, 50)), ("10:25:10", (10, 20))]
)
def test_numbers_of_people(text: str, counts: tuple[int, ...]) -> None:
    assert parse_people(text) == counts


@pytest.mark.parametrize("text", ["1", "0", "5:3", "10:", "a", "10:20:0", "-3", "2:3:4:5", ""])
def test_numbers_of_people_that_cannot_be(text: str) -> None:
    with pytest.raises(VbbenchError, match="numbers of people are a number from 2 to 10,000"):
        parse_people(text)


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


def test_a_scenario_of_ones_own(write: Callable[..., Path], tmp_path: Path) -> None:
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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["demo", "--options", "people=10"], "are for the splits sim and street"),
        (["sim", "--dt", "0.4"], "sim has no source"),
        (["sim", "--options", "people=1"], "numbers of people are a number from 2 to 10,000"),
        (["sim", "--sequences", "0"], "sequences must be 1 to 10,000,000, not 0"),
        (["sim", "--tier", "blurred"], "no tier is called 'blurred'"),
    ],
)
def test_mistakes_on_the_command_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, arguments: list[str], message: str
) -> None:
    assert main(["generate", *arguments, "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_an_unknown_scenario_suggests_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="no scenario is called 'plazza'; did you mean 'plaza'"):
        plan(scenario="plazza")


def test_a_scenario_file_that_is_not_there() -> None:
    with pytest.raises(FileError, match=r"nowhere.toml: cannot be read"):
        plan(scenario="nowhere.toml")
