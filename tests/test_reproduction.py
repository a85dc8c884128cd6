"""The figure over σ_h: grouping against pandas, taking over what is there, and the command as a stranger uses it."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.cli.test_cli import run
from vbbench.errors import VbbenchError
from vbbench.reproduction.making import Making
from vbbench.reproduction.report import shown, write_report
from vbbench.reproduction.sigma.figure import COLUMNS, plot_sigma, sigma_report
from vbbench.reproduction.sigma.study import (
    PANELS,
    PEOPLE,
    SIGMAS,
    SigmaFigure,
    SigmaStudy,
    compared_solvers,
    dataset_folder,
    measure_sigma,
)
from vbbench.scoring import score
from vbbench.scoring.block_bootstrap import Timeline, block_means
from vbbench.scoring.metrics import METRICS

SOLVERS = tuple(compared_solvers())
AS_IT_IS, PRIOR, FREE = SOLVERS
STUDY = SigmaStudy(sequences=10, sigmas=(0.0, 0.07), people=(8, 12))
SMALL = SigmaStudy(sequences=2, sigmas=(0.07,), people=(8, 12), solvers=("vb-cv",))


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("reproduction") / "figure"


@pytest.fixture(scope="module")
def figure(out: Path) -> SigmaFigure:
    return measure_sigma(STUDY, out)


def written(folder: Path) -> dict[str, int]:
    """When every file below the folder was written."""
    return {str(path): path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}


def test_the_study_is_the_papers() -> None:
    study = SigmaStudy()
    assert study.sigmas == SIGMAS == (0.0, 0.01, 0.03, 0.05, 0.07)
    assert study.people == PEOPLE == (10, 20, 30, 40, 50)
    assert (study.sequences, study.protocol, study.tier, study.camera) == (500, "one-step", "ideal", None)


@pytest.mark.slow
@pytest.mark.parametrize("solver", [AS_IT_IS, PRIOR, FREE])
@pytest.mark.parametrize("sigma_h", STUDY.sigmas)
def test_points_are_plain_groups_of_the_scored_sequences(
    figure: SigmaFigure, out: Path, tmp_path: Path, solver: str, sigma_h: float
) -> None:
    data = dataset_folder(out, sigma_h)
    submission = data.with_name(f"one-step-{solver.replace(':', '-')}")
    score(submission, data).write_per_sequence(tmp_path / "scored.csv")
    scored = pd.read_csv(tmp_path / "scored.csv").set_index("sequence")
    scene = pd.read_parquet(data / "sequences.parquet").set_index("sequence")["scene"]
    scored["people"] = scene.map(pd.read_parquet(data / "truth" / "people.parquet").groupby("scene").size())
    groups = scored.groupby("people")
    (curve,) = (c for c in figure.curves if c.solver == solver and c.sigma_h == sigma_h)
    assert [p.people for p in curve.points] == list(groups.groups) == [8, 12]
    assert [p.sequences for p in curve.points] == [5, 5]
    assert [p.coverage for p in curve.points] == [1.0, 1.0]
    assert [p.seen for p in curve.points] == pytest.approx(
        scored.assign(seen=scored["positions"] / scored["frames"]).groupby("people")["seen"].mean()
    )
    for metric in PANELS:
        own = [p.statistics[metric] for p in curve.points]
        assert [s.mean for s in own] == pytest.approx(groups[metric].mean())
        assert [s.median for s in own] == pytest.approx(groups[metric].median())
        for statistic, (_, rows) in zip(own, groups, strict=True):
            timeline = Timeline.of(*rows[["scene", "first_frame", "last_frame"]].to_numpy().T)
            ((low, high),) = block_means(timeline, rows[[metric]].to_numpy()).interval()
            assert (statistic.low, statistic.high) == pytest.approx((low, high))
        assert all(s.low < s.mean < s.high for s in own)


def test_known_heights_need_no_learning_and_unknown_ones_cost(figure: SigmaFigure) -> None:
    known, unknown = ({c.solver: c.points for c in figure.curves if c.sigma_h == s} for s in STUDY.sigmas)
    assert known[AS_IT_IS] == known[PRIOR]
    for learned, prior, free in zip(unknown[AS_IT_IS], unknown[PRIOR], unknown[FREE], strict=True):
        assert prior.statistics["dx"].mean > 2.0 * learned.statistics["dx"].mean
        assert free.statistics["dt"].mean > prior.statistics["dt"].mean


def test_what_is_there_is_taken_over(figure: SigmaFigure, out: Path) -> None:
    before = written(out)
    assert measure_sigma(STUDY, out) == figure
    assert written(out) == before


def test_only_what_is_missing_is_made_again(figure: SigmaFigure, out: Path) -> None:
    before, lost = written(out), dataset_folder(out, 0.07).with_name("one-step-vb-sf")
    shutil.rmtree(lost)
    assert measure_sigma(STUDY, out) == figure
    after = written(out)
    assert {path for path in after if after[path] != before[path]} == {str(path) for path in lost.iterdir()}


def test_files_hold_every_number(figure: SigmaFigure, out: Path) -> None:
    report = sigma_report(measure_sigma(STUDY, out))
    printed = shown(report, write_report(report, out))
    assert printed.endswith(
        "\n".join(str(out / f"figure-sigma{suffix}") for suffix in (".md", ".json", ".csv", ".png"))
    )
    assert printed.startswith((out / "figure-sigma.md").read_text("utf-8"))
    table = pd.read_csv(out / "figure-sigma.csv")
    assert tuple(table.columns) == COLUMNS
    assert len(table) == len(SOLVERS) * 2 * 2 * len(PANELS)
    row = table[(table.solver == FREE) & (table.sigma_h == 0.07) & (table.people == 12) & (table.metric == "dr")].iloc[
        0
    ]
    statistic = figure.solvers[FREE][1].points[1].statistics["dr"]
    assert tuple(row[["mean", "low", "high", "median"]]) == tuple(
        vars(statistic)[k] for k in ("mean", "low", "high", "median")
    )
    assert f"{statistic.mean:.4f} [{statistic.low:.4f}, {statistic.high:.4f}]" in printed


def test_table_tells_units_and_change(figure: SigmaFigure) -> None:
    table = sigma_report(figure).markdown
    assert table.count("| Δr (rad) |") == table.count("| Δx̃ (m) |") == len(SOLVERS) * 2
    first, last = (point.statistics["dt"] for point in figure.solvers[FREE][1].points)
    change = f"{last.mean / first.mean - 1:+.0%} ({last.median / first.median - 1:+.0%})"
    (row,) = (line for line in table.split(FREE)[1].splitlines() if line.startswith("| Δt (m) | 0.07 "))
    assert row.endswith(f"| {change} |")


def test_picture_has_a_panel_for_each_solver_and_metric(figure: SigmaFigure) -> None:
    drawn = plot_sigma(figure)
    assert [axes.get_label() for axes in drawn.axes] == [f"{s} {m}" for s in SOLVERS for m in PANELS]
    for axes in drawn.axes:
        solver, _, metric = axes.get_label().rpartition(" ")
        assert axes.get_ylim()[0] == 0.0
        assert METRICS[metric].unit in axes.get_ylabel()
        means, medians = axes.lines[::2], axes.lines[1::2]
        for curve, mean, median in zip(figure.solvers[solver], means, medians, strict=True):
            own = [point.statistics[metric] for point in curve.points]
            np.testing.assert_array_equal(mean.get_ydata(), [s.mean for s in own])
            np.testing.assert_array_equal(median.get_ydata(), [s.median for s in own])
            assert f"{curve.sigma_h:g} m" in str(mean.get_label())


def test_another_definition_is_refused_unless_it_may_overwrite(tmp_path: Path) -> None:
    out = tmp_path / "out"
    measure_sigma(SMALL, out)
    other = SigmaStudy(**{**vars(SMALL), "seed": 1})
    with pytest.raises(VbbenchError, match=r"is dataset \w{16}, wanted is \w{16}; .* set .overwrite. to replace it"):
        measure_sigma(other, out)
    assert measure_sigma(other, out, Making(overwrite=True)).study == other


def test_an_answer_to_something_else_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    measure_sigma(SMALL, out)
    info = dataset_folder(out, 0.07).with_name("one-step-vb-cv") / "submission.json"
    info.write_text(info.read_text("utf-8").replace('"solver": "vb-cv"', '"solver": "cv"'), "utf-8")
    with pytest.raises(VbbenchError, match=r"is of cv .*; wanted is vb-cv .*set .overwrite."):
        measure_sigma(SMALL, out)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"solvers": ("vb-fs",)}, "did you mean 'vb-sf'"),
        ({"solvers": ()}, "name a solver"),
        ({"sigmas": ()}, "name a solver"),
        ({"sigmas": (0.07, -0.01)}, "height_std, the spread of people.s heights, must be 0 to 0.3 m"),
        ({"protocol": "onestep"}, "onestep"),
        ({"sequences": 0}, "sequences must be 1 to 10,000,000, not 0"),
        ({"people": (1,)}, "people must be 2 to 10,000, not 1"),
        ({"seed": -1}, "seed must be 0 to"),
        ({"tier": "blurred"}, "blurred"),
    ],
)
def test_mistakes_are_found_before_anything_is_made(changes: dict[str, object], message: str, tmp_path: Path) -> None:
    study = SigmaStudy(**{**vars(SMALL), **changes})
    with pytest.raises(VbbenchError, match=message):
        measure_sigma(study, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_way_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("mine", "utf-8")
    with pytest.raises(VbbenchError, match="is not a folder"):
        measure_sigma(SMALL, path)
    assert path.read_text("utf-8") == "mine"


@pytest.mark.slow
def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "figure"
    arguments = ["reproduce", "figure-sigma", "--out", out, "--sequences", 2, "--solver", "vb-cv", "cv"]
    status, printed, _ = run(capsys, *arguments, "--camera", "panorama", "--protocol", "sequential")
    assert status == 0
    assert "split sim (panorama, ideal), sequential/2, seed 0, 2 sequences at each σ_h" in printed
    assert "## vb-cv" in printed
    assert "## cv" in printed
    assert (out / "figure-sigma.png").read_bytes()[:4] == b"\x89PNG"
    assert {path.name for path in out.iterdir()} == {
        *(f"figure-sigma{suffix}" for suffix in (".md", ".json", ".csv", ".png")),
        *(f"sigma-{sigma_h:g}" for sigma_h in SIGMAS),
    }


def test_an_unknown_figure_suggests_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    status, _, complaint = run(capsys, "reproduce", "figure-sgima")
    assert status == 2
    assert "did you mean 'reproduce figure-sigma'?" in complaint
