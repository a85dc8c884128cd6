"""The split `street` with its two inputs, and the tier `tracked` from the command line to the score."""

from pathlib import Path

import numpy as np
import pytest

from tests.lib.answers import submit, true_answers
from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.geometry import world_to_relative, wrap_angle
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_generators.crowds.sim import SimulationPlan
from vbbench_generators.splits import demo, sim, street
from vbbench_generators.views.looking import limit_turns

SMALL = Simulation(sequences=2, people=(16,))


def plan(tier: str = "ideal", **options: object) -> SimulationPlan:
    return street.plan(Options(tier=tier, **options))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("street", tmp_path_factory.mktemp("street") / "tracked", Options(tier="tracked", limit=1))


def test_street_is_the_scenario_with_people_hidden() -> None:
    made, whole = plan(), sim.plan(Options(simulation=Simulation(scenario="street")))
    assert (len(made), made.info.camera, made.info.dt) == (10, whole.info.camera, 0.1)
    hidden, seen = made.build(0), whole.build(0)
    np.testing.assert_array_equal(hidden.truth.poses[:, :2], seen.truth.poses[:, :2])
    assert hidden.sequence.frames == 400
    assert np.nanmin(hidden.sequence.visible) >= 0.25
    relative = world_to_relative(hidden.truth.positions, hidden.truth.poses)
    boxes = made.info.camera.project(relative, np.broadcast_to(hidden.truth.heights, relative.shape[:-1]))
    there = hidden.sequence.observed
    np.testing.assert_allclose(hidden.sequence.observations[there], boxes[there])  # whole boxes
    assert 0.4 < there.sum() / seen.sequence.observed.sum() < 0.9


def test_street_is_the_papers_geometry() -> None:
    """50 people who come from four corners of a field of 20 m x 40 m, seen at 90° for 400 frames."""
    made = plan()
    assert made.scenario.people == (50,)
    assert made.scenario.frames == 400
    assert isinstance(made.info.camera, PerspectiveCamera)
    assert np.degrees(2.0 * np.arctan(0.5 * made.info.camera.width / made.info.camera.focal)) == pytest.approx(90.0)
    corners = [flow.start for flow in made.scenario.flow]
    ends = np.array([*corners, *(flow.goal for flow in made.scenario.flow)])
    np.testing.assert_array_equal(ends[:, :2].min(axis=0), [-10.0, -20.0])
    np.testing.assert_array_equal(ends[:, 2:].max(axis=0), [10.0, 20.0])
    built = made.build(3)
    assert built.scene is not None
    assert built.scene.positions.shape == (400, 50, 2)
    assert built.sequence.frames == 400
    start = built.scene.positions[0]
    there = [((start >= corner[:2]) & (start <= corner[2:])).all(axis=1).sum() for corner in corners]
    assert there == [13, 13, 12, 12]


def test_the_camera_turns_no_faster_than_people() -> None:
    made = plan()
    turns = [np.abs(wrap_angle(np.diff(made.build(index).truth.poses[:, 2]))).max() for index in range(4)]
    assert max(turns) <= 0.1 * made.scenario.turn_rate + 1e-9
    np.testing.assert_allclose(limit_turns(np.array([0.0, 0.1, 3.0]), 1.0, 5.0), [0.0, 0.1, 3.0])
    slow = limit_turns(np.array([3.0, 3.0, -3.0, -3.0]), 0.1, 2.0)  # the short way round
    np.testing.assert_allclose(slow, [3.0, 3.0, 3.2, 2 * np.pi - 3.0])


def test_the_definition_names_the_input() -> None:
    inputs = {tier: plan(tier).info.definition["input"] for tier in ("ideal", "noisy", "occluded", "tracked")}
    assert inputs == {"ideal": "cline", "noisy": "cline", "occluded": "occluded", "tracked": "tracked"}
    assert plan("tracked").info.definition["tracking"]["tracker"]["high"] == 0.6
    assert plan("ideal").info.definition["hiding"]["cut"] is False
    assert len({plan(tier).info.id for tier in ("ideal", "noisy", "occluded", "tracked")}) == 4


def test_what_street_does_not_take() -> None:
    with pytest.raises(VbbenchError, match="`scenario` is for the split 'sim'"):
        plan(simulation=Simulation(scenario="open"))
    with pytest.raises(VbbenchError, match="street has no source"):
        plan(dt=0.1)
    with pytest.raises(VbbenchError, match=r"no tier is called 'ocluded'; did you mean 'occluded'\?"):
        plan("ocluded")
    assert len(plan(simulation=Simulation(sequences=3, people=(20,)))) == 3


def test_tracks_are_as_files_promise(tracked: Dataset) -> None:
    assert "8 tables and 1 sequences are as written" in verify(tracked.folder)
    sequence = tracked.sequence(0)
    persons, truth = tracked.track_persons(sequence), tracked.truth(sequence)
    assert np.all(sequence.observed.sum(axis=0) >= 3)
    assert np.all(np.isnan(truth.positions[..., 0]) == (persons < 0))
    somebody = (persons >= 0).any(axis=0)
    assert np.array_equal(~np.isnan(truth.heights), somebody)
    assert np.all(np.abs(truth.heights[somebody] - 1.7) < 0.4)
    persons = np.where(sequence.observed, persons, -1)
    first_two = (persons >= 0) & (np.cumsum(persons >= 0, axis=0) <= 2)
    assert np.array_equal(~np.isnan(sequence.given.positions[..., 0]), first_two)
    switched = [len(set(column[column >= 0])) > 1 for column in persons.T]
    assert any(switched)
    assert len(sequence.tracks) > len(set(persons[persons >= 0]))  # tracks break


def test_the_truth_scores_zero_and_false_alarms_count_for_nothing(tracked: Dataset, tmp_path: Path) -> None:
    folder = tracked.folder
    result = score(submit(tmp_path / "true", folder, true_answers(folder)), folder)
    for name in ("dx_rel", "dx", "dr", "dt"):
        assert result.summaries[name].mean == pytest.approx(0.0, abs=1e-9)
    assert result.coverage == 1.0


@pytest.mark.parametrize("protocol", ["one-step", "sequential", "rollout"])
def test_solvers_answer_tracks(tracked: Dataset, protocol: str, tmp_path: Path) -> None:
    result = score(solve(tracked, "vb-cv", protocol, tmp_path / "answers"), tracked.folder)
    assert result.coverage == 1.0
    if protocol == "one-step":
        assert result.summaries["dx"].mean < 0.491  # Table 4 of the paper


@pytest.mark.slow
@pytest.mark.parametrize("split", ["street", "demo"])
def test_the_bytes_do_not_depend_on_jobs(split: str, tmp_path: Path) -> None:
    options = Options(tier="tracked", limit=40, simulation=SMALL if split == "street" else None)
    for jobs in (1, 2):
        generate(split, tmp_path / str(jobs), options, jobs=jobs)
    for name in ("observations", "given", "sequences", "truth/tracks", "truth/poses"):
        assert (tmp_path / f"1/{name}.parquet").read_bytes() == (tmp_path / f"2/{name}.parquet").read_bytes()
    assert "as written" in verify(tmp_path / "1")


@pytest.mark.slow
def test_short_recordings_may_have_no_track_at_all(tmp_path: Path) -> None:
    made = demo.plan(Options(tier="tracked"))
    counts = [made.build(index).sequence.observed.sum() for index in range(0, len(made), 5)]
    assert max(counts) > 0
    assert all(np.isfinite(counts))


def test_tracks_in_the_panorama() -> None:
    made = plan("tracked", camera=PanoramaCamera(), simulation=SMALL).build(0)
    sequence = made.sequence
    assert np.all(sequence.observations[sequence.observed][:, 0] >= 0)
    assert np.all(sequence.observations[sequence.observed][:, 0] < 1440)
    assert made.persons is not None
    assert (made.persons >= 0).sum() > 0.9 * sequence.observed.sum()
