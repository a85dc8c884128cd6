"""The splits `demo`, `sim` and `street`: who walks where, who observes, and that nothing but the seed decides."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vbbench_generators.crowds as simulation
from vbbench.camera import PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.geometry import world_to_relative, wrap_angle
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench.sequence import SequenceData
from vbbench_generators.crowds import scenario_names
from vbbench_generators.crowds.sim import HALF_SIDE, PEOPLE, SimulationPlan, record_plaza

FASTEST = 1.3 * (1.34 + 3 * 0.26)
"""m/s: the cap of the model times the greatest desired speed."""


def plan(split: str = "sim", **options: Any) -> SimulationPlan:
    asked = {key: options.pop(key) for key in ("scenario", "sequences", "people") if key in options}
    crowd = Simulation(**asked) if asked else None
    made: SimulationPlan = load("generator", split).plan(Options(simulation=crowd, **options))
    return made


def scene_of(data: SequenceData) -> Scene:
    assert data.scene is not None
    return data.scene


def test_the_default_is_the_papers_split() -> None:
    sim = plan()
    assert (len(sim), sim.info.camera.kind, sim.info.dt, sim.info.height_std) == (500, "perspective", 0.4, 0.07)
    assert sim.scenario.step == 0.05
    for index in range(10):
        scene = scene_of(sim.build(index))
        assert (scene.frames, len(scene.people)) == (20, (10, 20, 30, 40, 50)[index % 5])


@pytest.mark.parametrize("people", [10, 50])
def test_people_start_apart_in_the_field_and_never_stop(people: int) -> None:
    sim = plan(people=(people,))
    for index in range(5):
        positions = scene_of(sim.build(index)).positions
        start = positions[0]
        apart = np.linalg.norm(start[:, None] - start, axis=-1)[~np.eye(people, dtype=bool)]
        assert np.abs(start).max() <= 8.0
        assert apart.min() >= 0.5
        ways = np.linalg.norm(np.diff(positions, axis=0), axis=-1)
        assert ways[-1].min() > 0.05  # m in 0.4 s: nobody has arrived
        assert ways.max() <= FASTEST * 0.4 + 1e-9


def test_the_observer_sees_at_least_two_people_in_every_picture() -> None:
    sim = plan(height_std=0.0)
    for index in range(20):
        assert sim.build(index).sequence.observed.sum(axis=1).min() >= 2


def test_the_spread_of_heights_changes_heights_alone() -> None:
    same, spread = plan(height_std=0.0), plan(height_std=0.3)
    for index in range(20):
        exact, tall = same.build(index), spread.build(index)
        assert np.all(scene_of(exact).heights == 1.70)
        assert np.std(scene_of(tall).heights) > 0.1
        np.testing.assert_array_equal(scene_of(exact).positions, scene_of(tall).positions)
        np.testing.assert_array_equal(exact.truth.poses, tall.truth.poses)


def test_every_sequence_has_its_own_scene(tmp_path: Path) -> None:
    made = generate("sim", tmp_path / "sim", Options(limit=6))
    np.testing.assert_array_equal(made.rows["scene"], np.arange(6))
    sequence = made.sequence(5)
    people, positions, _ = made.surroundings(sequence)
    column = int(np.searchsorted(people, sequence.observer))
    np.testing.assert_allclose(made.truth(sequence).poses[:, :2], positions[:, column], atol=1e-9)


def test_who_is_stuck_is_drawn_again(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[np.ndarray] = []

    def first_time(positions: np.ndarray, _speeds: np.ndarray, _dt: float) -> np.ndarray:
        tried.append(positions)
        return np.array([len(tried) == 1])

    monkeypatch.setattr(simulation, "is_stuck", first_time)
    scene = scene_of(plan().build(0))
    assert len(tried) == 2
    assert not np.array_equal(tried[0], tried[1])
    np.testing.assert_array_equal(scene.positions, tried[1])


def test_endless_redrawing_ends_in_one_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(simulation, "is_stuck", lambda positions, speeds, dt: np.array([True]))
    monkeypatch.setattr(simulation, "ATTEMPTS", 3)
    with pytest.raises(VbbenchError, match="scenario 'open' with 10 people: in each of 3 crowds a person was stuck"):
        plan().build(0)


@pytest.mark.parametrize("name", scenario_names())
def test_every_scenario_can_be_built(name: str) -> None:
    built = plan(scenario=name, people=(20,)).build(0)
    assert len(scene_of(built).people) == 20
    assert np.isfinite(scene_of(built).positions).all()
    assert built.sequence.observed.any()


def test_nobody_walks_through_the_walls_of_the_corridor() -> None:
    for index in range(3):
        scene = scene_of(plan(scenario="corridor", people=(30,)).build(index))
        assert np.abs(scene.positions[..., 1]).max() < 2.5


# The split `street`


def test_street_is_the_papers_geometry() -> None:
    """50 people who come from four corners of a field of 20 m x 40 m, seen at 90° for 400 frames."""
    street = plan("street")
    assert (len(street), street.info.dt, street.scenario.people) == (10, 0.1, (50,))
    assert isinstance(street.info.camera, PerspectiveCamera)
    assert np.degrees(2.0 * np.arctan(0.5 * street.info.camera.width / street.info.camera.focal)) == pytest.approx(90.0)
    corners = [flow.start for flow in street.scenario.flow]
    ends = np.array([*corners, *(flow.goal for flow in street.scenario.flow)])
    np.testing.assert_array_equal(ends[:, :2].min(axis=0), [-10.0, -20.0])
    np.testing.assert_array_equal(ends[:, 2:].max(axis=0), [10.0, 20.0])
    built = street.build(3)
    positions = scene_of(built).positions
    assert positions.shape == (400, 50, 2)
    assert built.sequence.frames == 400
    start = positions[0]
    there = [((start >= corner[:2]) & (start <= corner[2:])).all(axis=1).sum() for corner in corners]
    assert there == [13, 13, 12, 12]
    late = np.linalg.norm(np.diff(positions[300:], axis=0), axis=-1).sum(axis=0)
    assert late.min() > 0.1 * 10.0  # m in 10 s: who arrived has been given a new goal
    turns = np.abs(wrap_angle(np.diff(built.truth.poses[:, 2])))
    assert turns.max() <= 0.1 * street.scenario.turn_rate + 1e-9


def test_street_is_its_scenario_with_people_hidden() -> None:
    made = plan("street")
    hidden, seen = made.build(0), plan(scenario="street").build(0)
    np.testing.assert_array_equal(hidden.truth.poses[:, :2], seen.truth.poses[:, :2])
    assert np.nanmin(hidden.sequence.visible) >= 0.25
    relative = world_to_relative(hidden.truth.positions, hidden.truth.poses)
    boxes = made.info.camera.project(relative, np.broadcast_to(hidden.truth.heights, relative.shape[:-1]))
    there = hidden.sequence.observed
    np.testing.assert_allclose(hidden.sequence.observations[there], boxes[there])  # whole boxes
    assert 0.4 < there.sum() / seen.sequence.observed.sum() < 0.9


def test_the_definition_names_the_input() -> None:
    infos = {tier: plan("street", tier=tier).info for tier in ("ideal", "noisy", "occluded", "tracked")}
    inputs = {tier: info.definition["input"] for tier, info in infos.items()}
    assert inputs == {"ideal": "cline", "noisy": "cline", "occluded": "occluded", "tracked": "tracked"}
    assert infos["tracked"].definition["tracking"]["tracker"]["high"] == 0.6
    assert infos["ideal"].definition["hiding"]["cut"] is False
    assert len({info.id for info in infos.values()}) == 4


@pytest.mark.parametrize(
    ("split", "options", "message"),
    [
        ("street", {"scenario": "open"}, "`scenario` is for the split 'sim'"),
        ("street", {"dt": 0.1}, "street has no source"),
        ("street", {"tier": "ocluded"}, r"no tier is called 'ocluded'; did you mean 'occluded'\?"),
        ("sim", {"scenario": "plazza"}, "no scenario is called 'plazza'; did you mean 'plaza'"),
        ("sim", {"scenario": "nowhere.toml"}, r"nowhere.toml: cannot be read"),
        ("sim", {"sequences": 0}, "sequences must be 1 to 10,000,000, not 0"),
        ("sim", {"dt": 0.4}, "sim has no source"),
        ("demo", {"people": (10,)}, "are for the splits sim and street"),
    ],
)
def test_what_a_split_does_not_take_is_one_clear_error(split: str, options: dict[str, Any], message: str) -> None:
    with pytest.raises(VbbenchError, match=message) as caught:
        plan(split, **options)
    assert "\n" not in str(caught.value)


def test_a_crowd_that_does_not_fit_is_one_clear_error() -> None:
    with pytest.raises(VbbenchError, match=r"no place left in .* that is 0.5 m from all other people"):
        plan(people=(1500,)).build(0)


# The crowd of the split `demo`


@pytest.fixture(scope="module")
def scene() -> Scene:
    return record_plaza(0, 0, PEOPLE, 80)


def test_only_the_square_is_recorded(scene: Scene) -> None:
    assert np.nanmax(np.abs(scene.positions)) <= HALF_SIDE
    present = scene.present.sum(axis=1)
    assert 5 <= present.min() <= present.max() <= PEOPLE


def test_people_come_and_go_and_nobody_comes_back_or_jumps(scene: Scene) -> None:
    assert len(scene.people) > PEOPLE
    changes = np.abs(np.diff(scene.present.astype(int), axis=0)).sum(axis=0)
    assert changes.max() <= 2
    assert scene.present.any(axis=0).all()
    assert np.all(np.diff(scene.present.argmax(axis=0)) >= 0)
    ways = np.linalg.norm(np.diff(scene.positions, axis=0), axis=-1)
    assert np.nanmax(ways) <= FASTEST * scene.dt + 1e-9


def test_a_scene_follows_from_seed_and_index() -> None:
    scenes = [record_plaza(seed, index, 10, 6).positions for seed, index in ((0, 0), (0, 0), (0, 1), (1, 0))]
    np.testing.assert_array_equal(scenes[0], scenes[1])
    for other in scenes[2:]:
        assert scenes[0].shape != other.shape or not np.array_equal(scenes[0], other, equal_nan=True)
