"""Tables 2 and 3 of the paper: averages against pandas, golden figures on Hotel, stand-ins, and what is missing."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.cli.test_cli import run
from vbbench.errors import VbbenchError
from vbbench.paper import COLUMNS, PROTOCOLS, SIGMA_H, SPLITS, the_paper
from vbbench.reproduction.report import shown, write_report
from vbbench.reproduction.simulated_recording import STAND_INS, SimulatedRecording
from vbbench.reproduction.tables.solver_figure import PANELS, plot_solver_table
from vbbench.reproduction.tables.solver_report import solver_table_report
from vbbench.reproduction.tables.solver_tables import (
    COUNTERPARTS,
    SolverTable,
    SolverTableStudy,
    counterpart,
    measure_solver_table,
)

HOTEL = SolverTableStudy(table=2, splits=("hotel",), solvers=("cv", "vb-sf", "vb-sf-literal", "map-causal"), every=60)
"""Six sequences."""
DEMO = SolverTableStudy(table=2, splits=("demo",), solvers=("cv", "vb-cv", "map-causal", "map-batch"), every=16)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("table2")


@pytest.fixture(scope="module")
def found(out: Path) -> SolverTable:
    """Figures on the demo, as if the paper had it in Table 2."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(SPLITS, 2, ("demo",))
        return measure_solver_table(DEMO, out)


@pytest.fixture(scope="module")
def measured_hotel(tmp_path_factory: pytest.TempPathFactory) -> SolverTable:
    return measure_solver_table(HOTEL, tmp_path_factory.mktemp("hotel"))


@pytest.fixture
def hotel(data_folder: Path, request: pytest.FixtureRequest) -> SolverTable:
    """What was measured on Hotel, once for all tests, if there are recordings."""
    answer: SolverTable = request.getfixturevalue("measured_hotel")
    return answer


def frame_means(dataset: Path, submission: Path) -> dict[str, pd.Series]:
    """Δt, Δx and Δx̃ of every scored frame, from the tables alone: a scene's places moved to the sequence's world."""
    keys = ["sequence", "frame"]
    poses = pd.read_parquet(submission / "poses.parquet").merge(
        pd.read_parquet(dataset / "truth/poses.parquet"), on=keys, suffixes=("", "_true")
    )
    people = pd.read_parquet(submission / "positions.parquet")
    people = people.merge(pd.read_parquet(dataset / "sequences.parquet")[["sequence", "scene", "first_frame"]])
    people = people.merge(pd.read_parquet(dataset / "truth/tracks.parquet")[["sequence", "track", "person"]])
    people["at"] = people["frame"] + people["first_frame"]
    scenes = pd.read_parquet(dataset / "truth/scenes.parquet").rename(columns={"frame": "at"})
    people = people.merge(scenes, on=["scene", "at", "person"], suffixes=("", "_scene"))
    worlds = pd.read_parquet(dataset / "truth/frames.parquet")
    people = people.merge(worlds, on="sequence", suffixes=("", "_world")).merge(poses, on=keys, suffixes=("", "_pose"))
    cos, sin = np.cos(people["yaw"]), np.sin(people["yaw"])
    right = people["x"] - people["x_world"] - cos * people["x_scene"] + sin * people["y_scene"]
    up = people["y"] - people["y_world"] - sin * people["x_scene"] - cos * people["y_scene"]
    people["dx"] = np.hypot(right, up)
    people["dx_rel"] = np.hypot(right - people["x_pose"] + people["x_true"], up - people["y_pose"] + people["y_true"])
    poses["dt"] = np.hypot(poses["x"] - poses["x_true"], poses["y"] - poses["y_true"])
    return {"dt": poses["dt"], **{name: people.groupby(keys)[name].mean() for name in ("dx", "dx_rel")}}


@pytest.mark.slow
@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("sigma_h", [0.0, SIGMA_H])
def test_the_papers_way_is_a_plain_mean_over_frames(
    found: SolverTable, out: Path, protocol: str, sigma_h: float
) -> None:
    folder = out / f"demo-sigma-{sigma_h:g}"
    row = found.one("demo", protocol, sigma_h, "vb-cv")
    for metric, frames in frame_means(folder / "dataset", folder / f"{protocol}-vb-cv").items():
        own = row.summaries[metric]
        assert own.frame_mean == pytest.approx(frames.mean(), rel=1e-9)
        assert own.frame_std == pytest.approx(frames.std(ddof=0), rel=1e-9)


def test_every_combination_has_a_row_in_order(found: SolverTable) -> None:
    ways = [(row.protocol, row.sigma_h, row.solver) for row in found.rows]
    assert ways == [(p, s, solver) for p in PROTOCOLS for s in (0.0, SIGMA_H) for solver in DEMO.solvers]
    assert all(row.coverage == 1.0 for row in found.rows)
    assert found.measured["demo"].sequences == 8
    assert not found.missing


def test_figures_on_the_demo(found: SolverTable) -> None:
    """Golden: Δx in m over frames with heights known and unknown."""
    golden = {
        ("one-step", "cv"): (0.03157, 0.03157),
        ("one-step", "vb-cv"): (0.01585, 0.01585),
        ("one-step", "map-causal"): (0.00615, 0.00602),
        ("one-step", "map-batch"): (0.00615, 0.00601),
        ("sequential", "cv"): (1.9214, 1.9214),
        ("sequential", "vb-cv"): (0.03948, 0.09352),
        ("sequential", "map-causal"): (0.00991, 0.00965),
        ("sequential", "map-batch"): (0.00401, 0.00409),
    }
    for (protocol, solver), figures in golden.items():
        own = [found.one("demo", protocol, sigma_h, solver).summaries["dx"].frame_mean for sigma_h in (0.0, SIGMA_H)]
        assert own == pytest.approx(figures, rel=0.02, abs=2e-5)


@pytest.mark.slow
def test_figures_on_hotel(hotel: SolverTable) -> None:
    """Golden: Δx in m over frames, and by how many times it is the paper's."""
    figures = {
        (row.protocol, row.solver): row.summaries["dx"].frame_mean for row in hotel.rows if row.sigma_h == SIGMA_H
    }
    assert figures == pytest.approx(
        {
            ("one-step", "cv"): 0.08524,
            ("one-step", "vb-sf"): 0.04147,
            ("one-step", "vb-sf-literal"): 0.08173,
            ("one-step", "map-causal"): 0.03443,
            ("sequential", "cv"): 0.46999,
            ("sequential", "vb-sf"): 0.14853,
            ("sequential", "vb-sf-literal"): 0.34080,
            ("sequential", "map-causal"): 0.08282,
        },
        rel=0.02,
    )
    row = hotel.one("hotel", "sequential", SIGMA_H, "vb-sf-literal")
    assert row.times_the_paper() == pytest.approx(row.summaries["dx"].frame_mean / 0.052)
    assert row.times_the_paper("dt") == pytest.approx(row.summaries["dt"].frame_mean / 0.062)
    assert np.isnan(hotel.one("hotel", "sequential", 0.0, "vb-sf").times_the_paper())
    assert np.isnan(hotel.one("hotel", "sequential", SIGMA_H, "cv").times_the_paper("dt"))


@pytest.mark.slow
def test_the_report_quotes_the_paper_beside_ours(hotel: SolverTable, tmp_path: Path) -> None:
    report = solver_table_report(hotel)
    printed = shown(report, write_report(report, tmp_path))
    assert "| the paper | 0.07 | VB-SF | 0.049 | 0.052 | 0.016 | 0.062 |" in printed
    assert "| the paper | 0.07 | CV | | 0.294 | | |" in printed
    row = hotel.one("hotel", "one-step", SIGMA_H, "vb-sf")
    cells = [
        f"{own.frame_mean:.4f} ± {own.frame_std:.4f} ({own.frame_mean / row.compared_with[metric]:.2f})"
        for metric in COLUMNS
        for own in (row.summaries[metric],)
    ]
    assert f"| one-step | 0.07 | `vb-sf` | {' | '.join(cells)} |" in printed
    own = row.summaries["dx"]
    assert f"{own.mean:.4f} [{own.ci95[0]:.4f}–{own.ci95[1]:.4f}]" in printed
    values = json.loads((tmp_path / "table2.json").read_text("utf-8"))
    assert values["paper"]["hotel"]["VB-SF"] == {"dx_rel": 0.049, "dx": 0.052, "dr": 0.016, "dt": 0.062}
    assert len(values["rows"]) == len(hotel.rows)
    assert values["rows"][1]["figures"]["dx"]["frame_mean"] == hotel.rows[1].summaries["dx"].frame_mean
    assert values["recordings"]["hotel"]["sequences"] == 6


def test_the_picture_has_a_mark_a_row_and_the_papers_bars(hotel: SolverTable) -> None:
    drawn = plot_solver_table(hotel, "six sequences")
    assert [axes.get_label() for axes in drawn.axes] == [f"hotel {metric}" for metric in PANELS]
    for axes, metric in zip(drawn.axes, PANELS, strict=True):
        marks = sorted(float(line.get_xdata()[0]) for line in axes.lines if len(line.get_xdata()) == 1)
        assert marks == sorted(row.summaries[metric].mean for row in hotel.rows)
        bars = [
            float(line.get_xdata()[0]) for line in axes.lines if line.get_linewidth() == 2.4 and len(line.get_xdata())
        ]
        expected = (the_paper().figures("hotel", counterpart(solver)).get(metric) for solver in HOTEL.solvers)
        assert bars == [figure for figure in expected if figure is not None]


def test_whose_row_of_the_paper_a_solver_is_compared_with() -> None:
    assert {COUNTERPARTS[name] for name in COUNTERPARTS} == {row.solver for row in the_paper().select("hotel")}
    assert counterpart("mine:Solver") == "VB-SF"
    assert the_paper().figures("demo", "VB-SF") == {}


def test_what_is_missing_is_said_with_its_command(no_data: Path, tmp_path: Path) -> None:
    found = measure_solver_table(SolverTableStudy(table=2, splits=("hotel", "eth"), solvers=("cv",)), tmp_path / "out")
    assert not found.rows
    report = solver_table_report(found)
    assert "`eth` is not here: `vbbench fetch eth` gets it." in report.markdown
    assert json.loads(report.json)["missing"].keys() == {"hotel", "eth"}
    assert not report.pictures
    with pytest.raises(VbbenchError, match="vbbench fetch hotel"):
        measure_solver_table(SolverTableStudy(table=2, splits=("hotel",), source=no_data), tmp_path / "out")


@pytest.mark.slow
def test_a_simulated_crowd_stands_in_for_a_missing_recording(no_data: Path, tmp_path: Path) -> None:
    few = replace(STAND_INS["shibuya02"], people=40, every=20)
    study = SolverTableStudy(table=3, splits=("shibuya02",), solvers=("cv",), stand_ins={"shibuya02": few})
    found = measure_solver_table(study, tmp_path / "out")
    own = found.measured["shibuya02"]
    assert own.simulated
    assert own.title == "Simulated crowd of 40 people, lifted like shibuya02"
    assert found.name("shibuya02") == "shibuya02 (simulated)"
    report = solver_table_report(found)
    assert "**`shibuya02` is a stand-in**" in report.markdown
    assert "## shibuya02 (simulated), the paper's way" in report.markdown
    one_step, sequential = (found.one("shibuya02", p, SIGMA_H, "cv").summaries["dx"].mean for p in PROTOCOLS)
    assert one_step < 0.01 < 0.1 < sequential
    made = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*") if path.is_file()}
    assert solver_table_report(measure_solver_table(study, tmp_path / "out")).json == report.json
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*") if path.is_file()} == made


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"splits": ("hotle",)}, "did you mean 'hotel'"),
        ({"splits": ("shibuya01",)}, "split of the paper's Table 2"),
        ({"splits": ()}, "nothing to measure"),
        ({"every": 0}, "every must be 1 or more, not 0"),
        ({"solvers": ("vb-fs",)}, "did you mean 'vb-sf'"),
        ({"protocols": ("onestep",)}, "onestep"),
    ],
)
def test_mistakes_are_found_before_anything_is_made(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match=message):
        measure_solver_table(replace(HOTEL, **changes), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_table2_without_recordings_is_the_papers_alone(
    no_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, printed, _ = run(capsys, "reproduce", "table2", "--out", tmp_path / "out")
    assert status == 0
    assert printed.startswith((tmp_path / "out" / "table2.md").read_text("utf-8"))
    status, _, said = run(capsys, "reproduce", "table2", "--split", "shibuya01", "--out", tmp_path / "out")
    assert status == 2
    assert "split of the paper's Table 2" in said


@pytest.mark.slow
def test_table3_simulates_what_is_missing(
    no_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(STAND_INS, "shibuya01", SimulatedRecording(people=40, every=30))
    command = ["reproduce", "table3", "--split", "shibuya01", "--solver", "cv", "--out", tmp_path / "out", "--json"]
    status, printed, _ = run(capsys, *command)
    assert status == 0
    values = json.loads(printed)
    assert values["recordings"]["shibuya01"]["simulated"]
    assert values["paper"]["shibuya01"]["CV"] == {"dx": 0.221}
    assert (tmp_path / "out" / "table3.png").read_bytes()[:4] == b"\x89PNG"
