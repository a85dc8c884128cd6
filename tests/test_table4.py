"""The paper's Table 4: its inputs, its figures on one sequence, the ratio of its rows, and the report."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.cli.test_cli import run
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation.generator import Options, Simulation
from vbbench.paper import COLUMNS, PROTOCOLS
from vbbench.reproduction.tables.table4.inputs import Input, LinkedByTruth, linked_by_truth
from vbbench.reproduction.tables.table4.report import table4_report
from vbbench.reproduction.tables.table4.study import Table4, Table4Study, measure_table4
from vbbench.sequence import NOBODY
from vbbench_generators.splits import demo, street

STUDY = Table4Study(solvers=("vb-cv",), jitter=(0.0, 2.0), sequences=1)
LINE, ROUGH, TRACKED, USUAL, LINKED = STUDY.inputs
GOLDEN = {
    LINE: (0.000489, 0.000693, 0.000426, 0.00138),
    ROUGH: (0.036545, 0.034889, 0.000995, 0.003315),
    TRACKED: (0.097721, 0.096787, 0.003986, 0.002516),
    USUAL: (0.097611, 0.096674, 0.003989, 0.002529),
    LINKED: (0.062619, 0.061741, 0.003924, 0.002505),
}
"""Means of vb-cv, one-step, on the first sequence: Δx̃, Δx, Δr, Δt."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("table4")


@pytest.fixture(scope="module")
def found(folder: Path) -> Table4:
    return measure_table4(STUDY, folder)


def test_inputs_are_lines_by_hand_and_tracks_by_the_papers_rule() -> None:
    assert [one.name for one in Table4Study().inputs] == [
        *("cline-0px", "cline-1px", "cline-2px", "cline-4px", "tracked-4", "tracked", "linked-4")
    ]
    assert (LINE.options(0, None).tier, ROUGH.options(0, None).tier) == ("ideal", "noisy")
    assert (ROUGH.options(0, None).noise, TRACKED.options(0, None).least_track) == (2.0, 4)
    assert [one.label for one in STUDY.inputs] == [
        "cline, exact",
        "cline, 2 px",
        "tracked, 4 frames or more",
        "tracked",
        "tracked, true ids",
    ]


@pytest.mark.slow
def test_figures_are_as_they_were(found: Table4) -> None:
    for source, golden in GOLDEN.items():
        own = found.figures("one-step", "vb-cv", source)
        assert [own[metric].mean for metric in COLUMNS] == pytest.approx(golden, rel=0.02, abs=2e-5), source.name


@pytest.mark.slow
def test_the_tracker_costs_much_beside_exact_lines_and_little_beside_rough_ones_with_true_ids(found: Table4) -> None:
    exact, rough, linked = (
        found.times("one-step", "vb-cv", tracked, line)["dx"]["sequences"]
        for tracked, line in ((TRACKED, LINE), (TRACKED, ROUGH), (LINKED, ROUGH))
    )
    assert exact > 10.0 > rough > linked > 1.0


def test_true_ids_are_the_same_boxes_with_a_track_for_each_person(found: Table4, folder: Path) -> None:
    one, other = found.counts[TRACKED], found.counts[LINKED]
    assert other.boxes == one.boxes - one.nobody
    assert (other.tracks, other.switches, other.nobody) == (other.people, 0, 0)
    assert other.people == one.people
    tracked, linked = (Dataset(folder / f"{name}-4" / "dataset") for name in ("tracked", "linked"))
    assert "as written" in verify(linked.folder)
    boxes = [data.sequence(0).observations[..., 2] for data in (tracked, linked)]
    real = tracked.track_persons(tracked.sequence(0)) != NOBODY
    np.testing.assert_array_equal(
        np.sort(np.where(real, boxes[0], np.nan), axis=1)[:, : boxes[1].shape[1]], np.sort(boxes[1], axis=1)
    )


def test_true_ids_keep_everybody_where_the_scene_says() -> None:
    data = street.plan(Options(tier="tracked", simulation=Simulation(sequences=1, people=(12,)))).build(0)
    linked = linked_by_truth(data)
    assert linked.persons is not None
    assert data.scene is not None
    seen = linked.sequence.observed
    frame, track = np.nonzero(seen)
    np.testing.assert_array_equal(
        linked.truth.positions[frame, track], data.scene.positions[frame, linked.persons[frame, track]]
    )
    assert [np.unique(column[column != NOBODY]).size for column in linked.persons.T] == [1] * seen.shape[1]
    assert (~np.isnan(linked.sequence.given.positions[..., 0])).sum(axis=0).max() == 2


def test_only_tracks_of_a_simulated_crowd_get_true_ids() -> None:
    plan = LinkedByTruth(demo.plan(Options(tier="tracked")))
    with pytest.raises(VbbenchError, match="only tracks of a simulated crowd can be linked by truth"):
        plan.build(0)


def test_the_papers_rule_leaves_out_the_shortest_tracks(found: Table4, folder: Path) -> None:
    kept, all_ = found.counts[TRACKED], found.counts[USUAL]
    assert 0 < all_.tracks - kept.tracks < 0.2 * all_.tracks
    assert all_.boxes - kept.boxes == 3 * (all_.tracks - kept.tracks)
    lengths = Dataset(folder / "tracked-4" / "dataset").sequence(0).observed.sum(axis=0)
    assert lengths.min() == 4


def test_the_report_has_the_papers_rows_both_protocols_and_all_ratios(found: Table4) -> None:
    report = table4_report(found)
    text, values = report.markdown, json.loads(report.json)
    assert text.count("| the paper | tracked | 0.491 | 0.530 | 0.016 | 0.101 |") == 2
    assert "| the paper | | by hand | 1.11 | 1.08 | 1.07 | 1.04 | | |" in text
    for protocol in PROTOCOLS:
        assert f"## Errors, {protocol}" in text
    assert text.count("| `vb-cv` | cline, 2 px |") == 2
    assert len(values["ratios"]) == len(PROTOCOLS) * len(STUDY.jitter)
    one = found.figures("one-step", "vb-cv", TRACKED)["dx"], found.figures("one-step", "vb-cv", ROUGH)["dx"]
    (ratio,) = (each for each in values["ratios"] if (each["protocol"], each["jitter"]) == ("one-step", 2.0))
    assert ratio["tracked"]["dx"]["frames"] == pytest.approx(one[0].frame_mean / one[1].frame_mean)
    assert f"({one[0].frame_mean:.4f} ± {one[0].frame_std:.4f})" in text or one[0].mean >= 0.1
    assert "4 frames or more | 3 frames or more" in text


def test_the_picture_shows_both_inputs_and_a_panel_a_metric(found: Table4) -> None:
    figure = table4_report(found).pictures[""]
    axes = {one.get_label(): one for one in figure.axes}
    assert list(axes) == ["lines", "boxes", *COLUMNS]
    example = found.example
    assert len(axes["lines"].collections[0].get_paths()) == len(example.lines)
    assert len(axes["boxes"].patches) == 2 + 2 * len(example.boxes)
    assert (~example.first & ~example.nobody).any()
    assert [text.get_text() for text in axes["dx"].texts] == ["× 1.08"]


@pytest.mark.slow
def test_the_command_reuses_what_is_there(capsys: pytest.CaptureFixture[str], found: Table4, folder: Path) -> None:
    command = ["reproduce", "table4", "--sequences", "1", "--solver", "vb-cv", "--jitter", "0", "2"]
    status, printed, _ = run(capsys, *command, "--out", str(folder))
    assert status == 0
    assert printed.startswith(table4_report(found).markdown)
    assert (folder / "table4.png").stat().st_size > 20_000


@pytest.mark.parametrize(
    ("study", "message"),
    [
        (Table4Study(solvers=()), "nothing to measure: name a solver"),
        (Table4Study(jitter=()), "jitter is one or more different numbers"),
        (Table4Study(jitter=(1.0, 1.0)), r"not \[1.0, 1.0\]"),
        (Table4Study(jitter=(-1.0,)), "0 or more"),
    ],
)
def test_what_cannot_be_measured_is_refused(study: Table4Study, message: str, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match=message):
        measure_table4(study, tmp_path)


def test_an_input_has_a_folder_of_its_own() -> None:
    assert Input(kind="cline", jitter=0.5).name == "cline-0.5px"
