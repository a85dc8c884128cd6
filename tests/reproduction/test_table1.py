"""Table 1: counts without a dataset are those of the dataset, figures of the recordings, and what is missing."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tests.lib import motsynth_recording
from vbbench.camera import PerspectiveCamera
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import summary
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.paper import the_paper
from vbbench.registry import load
from vbbench.reproduction.grid import Making
from vbbench.reproduction.table1 import Counted, Table1Study, Tally, all_rows, count_people


def counted(split: str, options: Options | None = None) -> Tally:
    return count_people(load("generator", split).plan(options or Options()))


def cells(found: list[Counted], title: str) -> list[list[str]]:
    """The two lines of a row: the paper's and ours."""
    rows = [list(row) for row in Table1Study().report(found).tables[0].rows]
    first = next(number for number, row in enumerate(rows) if row[0] == title)
    return rows[first : first + 2]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("split", "options"),
    [
        ("demo", Options()),
        ("demo", Options(camera=PerspectiveCamera())),
        ("demo", Options(tier="noisy")),
        ("demo", Options(observer="vehicle")),
        ("sim", Options(simulation=Simulation(sequences=4, people=(8, 12)))),
    ],
    ids=["seen before boxes", "perspective", "noisy", "vehicle", "sim"],
)
def test_counts_are_those_of_the_dataset(split: str, options: Options, tmp_path: Path) -> None:
    tally, dataset = counted(split, options), generate(split, tmp_path / "d", options)
    assert tally.row == summary(dataset.info)
    np.testing.assert_array_equal(tally.spans, dataset.rows["frames"])
    np.testing.assert_array_equal(tally.passing, dataset.rows["people"])
    assert Counter(tally.seen.tolist()) == boxes_by_frame(dataset)
    assert (tally.crowd is None) == (split == "demo")
    if tally.crowd is not None:
        assert tally.crowd.tolist() == [8, 12, 8, 12]


def boxes_by_frame(dataset: Dataset) -> Counter[int]:
    table = dataset.to_pandas("observations")
    return Counter(table.groupby(["sequence", "frame"]).size().tolist())


@pytest.mark.parametrize(
    ("split", "sequences", "frames", "people"),
    [
        ("demo", 125, 21.888, (9, 14.732, 19)),
        ("hotel", 340, 14.791, (3, 6.303, 16)),
        ("eth", 347, 14.372, (3, 9.270, 26)),
        ("students", 849, 45.839, (13, 44.286, 75)),
    ],
)
def test_golden_rows(
    request: pytest.FixtureRequest, split: str, sequences: int, frames: float, people: tuple[int, float, int]
) -> None:
    """To .001: counts of recordings, and of a crowd that is the same to the last bit on every machine tried."""
    if split != "demo":
        request.getfixturevalue("data_folder")
    row = counted(split).row
    found = tuple(row[name] for name in ("sequences", "mean_frames", "people_min", "people_mean", "people_max"))
    assert found == pytest.approx((sequences, frames, *people), abs=1e-3)


@pytest.mark.slow
def test_golden_row_of_sim(tmp_path: Path) -> None:
    """The paper's numbers of people exactly; what a camera sees of them to .05 people."""
    found = Table1Study(splits=("sim",)).measure(tmp_path, Making())
    (paper, ours) = cells(found, "Sim")
    assert paper[2:5] == ["500", "20", "10 to 50"]
    assert ours[2:6] == ["500", "20.00", "10 / 30.00 / 50", "of the scene"]
    tally = found[0].tally
    assert tally.seen.mean() == pytest.approx(11.26, abs=0.05)


def test_rows_are_the_papers_and_quoted() -> None:
    rows = {row.split: row for row in all_rows()}
    order = ("sim", "hotel", "eth", "students", "shibuya01", "shibuya02", "street", "motsynth")
    assert tuple(rows) == tuple(Table1Study().splits) == order
    for split, printed in the_paper().table1.items():
        assert (rows[split].printed.people, rows[split].printed.frames) == (printed.people, printed.frames)
    np.testing.assert_equal(the_paper().table1["sim"].bounds, (10.0, np.nan, 50.0))


def test_a_row_counts_whom_the_paper_counts() -> None:
    tally = counted("sim", Options(simulation=Simulation(sequences=2, people=(8, 12))))
    assert tally.people("of the scene") is tally.crowd
    assert tally.people("during a sequence") is tally.passing
    np.testing.assert_array_equal(tally.people("in a frame"), tally.seen)


def test_the_observer_counts_where_the_recipe_says_so(data_folder: Path) -> None:
    tally = counted("students", Options(source=data_folder, limit=20))
    np.testing.assert_array_equal(tally.people("in a frame"), tally.seen + 1)


def test_what_is_missing_is_said_with_the_command(no_data: Path, tmp_path: Path) -> None:
    found = Table1Study(splits=("hotel", "eth", "motsynth")).measure(tmp_path / "out", Making())
    assert cells(found, "Hotel")[1][1] == "missing: `vbbench fetch hotel`"
    assert cells(found, "GTAV, as MOTSynth")[1][1] == "missing: your own download, named with `--motsynth DIR`"
    report = Table1Study().report(found)
    assert [row["missing"] for row in report.values["rows"]] == [
        "vbbench fetch hotel",
        "vbbench fetch eth",
        "your own download, named with --motsynth DIR",
    ]
    assert not (tmp_path / "out").exists()


def test_motsynth_is_counted_where_its_folder_is_named(tmp_path: Path) -> None:
    folder = motsynth_recording.write(tmp_path / "s", motsynth_recording.recording(frames=60))
    study = Table1Study(splits=("motsynth",), motsynth=folder)
    found = study.measure(tmp_path / "out", Making())
    tally = found[0].tally
    assert tally.crowd is None
    assert cells(found, "GTAV, as MOTSynth")[1][4:6] == ["6 / 6.00 / 6", "in a frame"]


def test_a_named_folder_without_the_source_is_an_error(tmp_path: Path) -> None:
    study = Table1Study(splits=("motsynth",), motsynth=tmp_path)
    with pytest.raises(VbbenchError, match="no annotation files of MOTSynth"):
        study.measure(tmp_path / "out", Making())


def test_a_source_that_is_here_and_damaged_is_an_error(no_data: Path, tmp_path: Path) -> None:
    (no_data / "biwi_hotel.txt").write_text("0 1 0.0 0.0\n", "utf-8")
    with pytest.raises(FileError, match="SHA-256"):
        Table1Study(splits=("hotel",)).measure(tmp_path / "out", Making())


def test_every_number_is_in_the_values(data_folder: Path, tmp_path: Path) -> None:
    (row,) = Table1Study(splits=("hotel",)).run(tmp_path).values["rows"]
    assert row["ours"]["observations"] == 31700
    assert row["people"] == {"least": 3, "mean": pytest.approx(6.303, abs=1e-3), "most": 16}
