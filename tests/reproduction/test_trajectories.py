"""The sheet of trajectories: which sequence is shown, what is drawn of it, and golden errors."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex

from tests.lib import jrdb_recording
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation.datasets import write_dataset
from vbbench.generation.generator import Options
from vbbench.generation.planning import Single
from vbbench.geometry import FloatArray
from vbbench.pictures.plotting import style
from vbbench.registry import load
from vbbench.reproduction.grid import Making
from vbbench.reproduction.trajectories import (
    MOST_PEOPLE,
    USERS_OWN,
    Trajectories,
    TrajectoriesStudy,
    shown_splits,
    typical_sequence,
)
from vbbench.scoring import score
from vbbench.solving import solve

DEMO = TrajectoriesStudy(splits=("demo",))


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("trajectories") / "figure"


@pytest.fixture(scope="module")
def found(out: Path) -> Trajectories:
    return DEMO.measure(out, Making())


def test_the_choice_is_the_rule_in_words() -> None:
    plan = load("generator", "demo").plan(Options())
    looked_at = sorted({round(number) for number in np.linspace(0, len(plan) - 1, 60)})
    lengths, people, ways = {}, {}, {}
    for number in looked_at:
        data = plan.build(number)
        lengths[number], people[number] = data.sequence.frames, data.sequence.observed.sum(axis=1).mean()
        ways[number] = np.linalg.norm(data.truth.poses[-1, :2] - data.truth.poses[0, :2])

    def off(values: dict[int, float], number: int) -> float:
        return float(abs(np.log(values[number] / np.median(list(values.values())))))

    walking = [number for number in looked_at if ways[number] >= np.median(list(ways.values()))]
    assert typical_sequence(plan) == min(walking, key=lambda number: off(lengths, number) + off(people, number))


def test_one_sequence_of_a_plan_is_that_sequence(tmp_path: Path) -> None:
    plan = load("generator", "demo").plan(Options())
    one = Single(plan, 61)
    data, whole = one.build(0), plan.build(61)
    assert (len(one), data.sequence.index) == (1, 0)
    np.testing.assert_array_equal(data.sequence.observations, whole.sequence.observations)
    np.testing.assert_array_equal(data.truth.poses, whole.truth.poses)
    assert one.info.id not in (plan.info.id, Single(plan, 60).info.id)
    write_dataset(one, tmp_path / "d")
    assert "are as written" in verify(tmp_path / "d")


def test_golden_errors_of_hotel(data_folder: Path, tmp_path: Path) -> None:
    """Sequence 11 of Hotel, sequential: as measured when the sheet was new, to 5 %."""
    (example,) = TrajectoriesStudy(splits=("hotel",)).measure(tmp_path, Making()).examples
    assert (example.number, example.values["frames"], example.values["people"]) == (11, 16, 8)
    errors = [example.errors[name] for name in ("dx_rel", "dx", "dr", "dt")]
    assert errors == pytest.approx([0.0416, 0.0796, 0.0130, 0.0754], rel=0.05)


def test_errors_are_those_of_the_sequence_solved_apart(found: Trajectories, out: Path, tmp_path: Path) -> None:
    dataset = Dataset(out / "demo" / "dataset")
    own = score(solve(dataset, "vb-sf", "sequential", tmp_path / "s"), dataset.folder)
    assert found.examples[0].errors == {name: one.mean for name, one in own.summaries.items() if np.isfinite(one.mean)}


def lines(found: Trajectories, colour: str) -> list[FloatArray]:
    """The lines [N, 2] of that colour in the map of the first example."""
    drawn = DEMO.plot(found).axes[0].lines
    return [np.asarray(line.get_xydata()) for line in drawn if to_hex(line.get_color()) == colour]


def test_the_observer_gets_from_left_to_right_in_metres(found: Trajectories) -> None:
    (truth,) = lines(found, style.TRUTH)
    replay = found.examples[0].replay
    real = replay.truth.poses[:, :2]
    np.testing.assert_allclose(
        np.linalg.norm(np.diff(truth, axis=0), axis=1), np.linalg.norm(np.diff(real, axis=0), axis=1)
    )
    across, up = truth[-1] - truth[0]
    assert across > 0.0
    assert up == pytest.approx(0.0, abs=1e-9)
    words = [text.get_text() for text in DEMO.plot(found).texts]
    assert {"demo", "26 people, 18 frames", "Δx 0.02  Δt 0.04 m"} <= set(words)


def test_estimates_lie_as_far_from_the_truth_as_they_are(found: Trajectories) -> None:
    (truth,), (estimate, _end) = lines(found, style.TRUTH), lines(found, style.ESTIMATE)
    scored = np.linalg.norm(estimate - truth, axis=1)[2:]
    assert scored.mean() == pytest.approx(found.examples[0].errors["dt"], rel=1e-6)


def test_of_a_large_crowd_the_nearest_are_drawn(found: Trajectories) -> None:
    replay = found.examples[0].replay
    distance = np.where(replay.sequence.observed, replay.distances, np.inf).min(axis=0)
    nearest = np.argsort(distance)[:MOST_PEOPLE]
    assert len(nearest) == MOST_PEOPLE < len(distance)
    truth, estimate, _ends = DEMO.plot(found).axes[0].collections
    assert len(truth.get_paths()) == len(estimate.get_paths()) == MOST_PEOPLE
    lengths = sorted(way_length(path.vertices) for path in estimate.get_paths())
    np.testing.assert_allclose(lengths, sorted(way_length(replay.estimated[:, column]) for column in nearest))


def way_length(places: object) -> float:
    """In m, over steps of which both ends are known."""
    return float(np.nansum(np.linalg.norm(np.diff(np.asarray(places), axis=0), axis=1)))


def test_missing_splits_are_named_with_the_command(no_data: Path, tmp_path: Path) -> None:
    found = TrajectoriesStudy(splits=("demo", "eth", "jrdb")).measure(tmp_path / "out", Making())
    assert found.missing == {"eth": "`vbbench fetch eth`", "jrdb": "your own download, named with `--jrdb DIR`"}
    report = DEMO.report(found)
    assert report.values["missing"]["eth"] == "vbbench fetch eth"
    assert "| eth | missing: `vbbench fetch eth` |" in report.markdown
    note = " ".join(text.get_text() for text in report.pictures[""].texts)
    assert "eth: vbbench fetch eth" in note
    assert "--jrdb DIR" in note


def test_nothing_to_show_is_an_error(no_data: Path, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match="nothing to show: the source of eth, hotel is not here"):
        TrajectoriesStudy(splits=("eth", "hotel")).run(tmp_path / "out")


def test_footage_of_which_only_relative_places_are_known(tmp_path: Path) -> None:
    folder = jrdb_recording.recording().write(tmp_path / "jrdb")
    study = TrajectoriesStudy(splits=("jrdb",), jrdb=folder)
    found = study.measure(tmp_path / "out", Making())
    (example,) = found.examples
    assert example.replay.info.truth == "relative"
    assert "dt" not in example.errors
    assert f"Δx̃ {example.errors['dx_rel']:.2f} m" in [text.get_text() for text in DEMO.plot(found).texts]


def test_every_split_but_the_users_own_has_a_place() -> None:
    splits = shown_splits()
    assert not set(USERS_OWN) & set(splits)
    assert splits[:3] == ["sim", "hotel", "eth"]
    assert {"kitti", "jrdb", "motsynth", "street", "demo", "zara01", "shibuya02"} < set(splits)
