"""Figures of errors: what is drawn is what the score counts, and nothing that is missing is hidden."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from tests.lib.answers import submit, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.pictures.colours import SOLVERS_ON_LIGHT, solver_colour, solver_looks
from vbbench.pictures.plotting.error_figure import plot_errors, plot_errors_to_file
from vbbench.pictures.plotting.figure import plot_to_file
from vbbench.scoring import score
from vbbench.scoring.error_tables import ErrorTables, error_tables, errors_in_time
from vbbench.scoring.scorecard import known

SEQUENCE = 3
CAUTION = "made up for tests. " + "Every word of this must be readable on the picture, however long it is. " * 6


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("errors")
    write_dataset(folder / "data", Crowd(scenes=3, frames=40, people=8, stay=(8, 20), caution=CAUTION))
    return folder


@pytest.fixture(scope="module")
def answers(folder: Path) -> list[Path]:
    data = folder / "data"
    good = submit(folder / "good", data, true_answers(data, 0.1, seed=1), solver="vb-cv")
    bad = submit(folder / "bad", data, true_answers(data, 0.6, seed=2), solver="cv")
    poses, positions = true_answers(data, 0.3, seed=3)
    gaps = (poses["frame"] != 5) | (poses["sequence"] != SEQUENCE)
    holes = submit(folder / "gaps", data, (poses[gaps], positions), solver="vb-cv", failure_policy="hold")
    return [good, bad, holes]


@pytest.fixture(scope="module")
def tables(folder: Path, answers: list[Path]) -> ErrorTables:
    return error_tables(Dataset(folder / "data"), answers)


@pytest.fixture(scope="module")
def figure(tables: ErrorTables) -> Figure:
    return plot_errors(tables)


def part(figure: Figure, name: str) -> Any:
    return next(axes for axes in figure.axes if axes.get_label() == name)


def drawn(axes: Any, gid: str) -> Any:
    return next(artist for artist in axes.get_children() if artist.get_gid() == gid)


def words(figure: Figure) -> str:
    return " ".join(text.get_text() for text in figure.findobj(Text))


def test_the_shares_and_the_table_are_those_of_the_score(folder: Path, answers: list[Path], figure: Figure):
    for n, answer in enumerate(answers):
        own = score(answer, folder / "data")
        for metric in ("dx_rel", "dx", "dr", "dt"):
            line = drawn(part(figure, f"{metric} cumulative"), f"line-{n}")
            np.testing.assert_allclose(line.get_xdata(), np.sort(known(own.per_sequence.figures[metric])))
            assert line.get_ydata()[-1] == 1.0
    cell = drawn(part(figure, "table"), "cell-1-3").get_text()
    assert cell.startswith(f"{score(answers[0], folder / 'data').summaries['dx'].capped:.3f}")


def test_medians_over_time_are_those_of_the_frames(folder: Path, answers: list[Path], figure: Figure):
    own = errors_in_time(answers[0], Dataset(folder / "data"))
    line = drawn(part(figure, "dt over-time"), "line-0")
    seconds, medians = np.array(line.get_xdata()), np.array(line.get_ydata())
    assert seconds[0] == pytest.approx(own.dataset.dt)
    for moment, median in zip(seconds, medians, strict=True):
        if np.isfinite(median):
            assert median == pytest.approx(np.median(own.frames["dt"][own.seconds == moment]))


def test_the_frames_of_one_sequence_average_to_its_figure(folder: Path, answers: list[Path]):
    data = Dataset(folder / "data")
    whole = score(answers[0], folder / "data").per_sequence
    one = errors_in_time(answers[0], data, only=SEQUENCE)
    figures = {name: values[whole.sequence == SEQUENCE][0] for name, values in whole.figures.items()}
    for metric in ("dt", "dr"):
        assert one.frames[metric].mean() == pytest.approx(figures[metric])
    assert one.per_sequence.figures["dx"][0] == pytest.approx(figures["dx"])
    drawing = plot_errors(error_tables(data, answers[:1], only=SEQUENCE))
    line = drawn(part(drawing, "dt over-time"), "line-0")
    np.testing.assert_allclose(line.get_ydata(), one.frames["dt"])


def test_cap_and_failure_limit_are_marked(tables: ErrorTables, figure: Figure):
    rules = tables.errors[0].protocol
    assert drawn(part(figure, "dx cumulative"), "cap").get_xdata()[0] == rules.caps["dx"]
    assert drawn(part(figure, "dx cumulative"), "failed").get_xdata()[0] == rules.failures["dx"]
    assert "failed" not in {artist.get_gid() for artist in part(figure, "dr cumulative").get_children()}


def test_missing_rows_are_told_and_marked(folder: Path, answers: list[Path], figure: Figure):
    assert "of the rows of vb-cv" in words(figure)
    drawing = plot_errors(error_tables(Dataset(folder / "data"), answers, only=SEQUENCE))
    missing = drawn(part(drawing, "dt over-time"), "missing-2")
    dt = Dataset(folder / "data").info.dt
    np.testing.assert_allclose(missing.get_xdata(), [(5 - 1) * dt])


def test_a_solver_has_one_colour_and_a_second_answer_other_dashes(figure: Figure):
    lines = [drawn(part(figure, "dx cumulative"), f"line-{n}") for n in range(3)]
    assert to_hex(lines[0].get_color()) == to_hex(lines[2].get_color()) == solver_colour("vb-cv")
    assert lines[0].get_linestyle() != lines[2].get_linestyle()
    assert to_hex(lines[1].get_color()) == solver_colour("cv")


def test_colours_do_not_depend_on_who_else_is_shown_nor_on_the_process():
    assert solver_looks(["a robot", "cv"])[1].colour == solver_looks(["cv"])[0].colour
    assert solver_colour("a robot") == "#4694b4"
    bundled = ["cv", "sf", "vb-cv", "vb-sf", "vb-sf-literal", "map-causal", "map-batch"]
    assert len({solver_colour(name) for name in bundled}) == len(bundled)
    assert not {solver_colour(f"solver {n}") for n in range(50)} & {solver_colour(name) for name in bundled}
    assert {solver_colour(f"solver {n}") for n in range(50)} <= set(SOLVERS_ON_LIGHT)


def test_a_long_caution_is_whole_and_inside(figure: Figure):
    lines = [text for text in figure.texts if (text.get_gid() or "").startswith("caution-")]
    told = " ".join(line.get_text() for line in lines)
    assert " ".join(CAUTION.split()) in told
    for line in lines:
        box = line.get_window_extent()
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.width
        assert box.y0 >= 0
        assert all(box.y1 <= axes.get_window_extent().y0 for axes in figure.axes)


@pytest.mark.slow
@pytest.mark.parametrize(("ending", "begin"), [("png", b"\x89PNG\r\n\x1a\n"), ("pdf", b"%PDF-"), ("svg", b"<?xml")])
def test_formats_by_ending_have_the_same_bytes_each_time(
    tables: ErrorTables, tmp_path: Path, ending: str, begin: bytes
):
    small = ErrorTables(names=tables.names, errors=tables.errors, metrics=("dx",))
    first, second = (plot_errors_to_file(small, tmp_path / f"{n}.{ending}").read_bytes() for n in (1, 2))
    assert first == second
    assert first.startswith(begin)
    if ending == "pdf":
        assert b"/FontFile2" in first
        assert b"CreationDate" not in first
    if ending == "svg":
        assert ">share of sequences</text>" in first.decode()
        assert "<dc:date>" not in first.decode()


def test_json_holds_what_is_drawn(tables: ErrorTables, figure: Figure):
    values = json.loads(tables.to_json())
    assert values["unit"] == "sequences"
    own = values["submissions"][0]["metrics"]["dx"]
    line = drawn(part(figure, "dx cumulative"), "line-0")
    np.testing.assert_allclose(own["cumulative"]["error"], line.get_xdata())


def test_the_command(folder: Path, answers: list[Path], tmp_path: Path, capsys: Any, mistake: Callable[..., str]):
    estimates = ["--estimate", *map(str, answers)]
    out = ["--out", str(tmp_path / "x.png")]
    options = ["--metric", "dt", "--json"]
    assert main(["plot-errors", str(folder / "data"), *estimates, *out, *options]) == 0
    values = json.loads(capsys.readouterr().out)
    assert list(values["submissions"][0]["metrics"]) == ["dt"]
    assert (tmp_path / "x.png").stat().st_size > 5000
    for wrong, message in (
        ([*estimates, "--out", "x.bmp"], "PNG, PDF or SVG"),
        ([*estimates, *out, "--metric", "dy"], "no metric is called 'dy'"),
        ([*estimates, *out, "--sequence", "999"], "999"),
        (["--estimate", *out], "at least one submission"),
    ):
        assert message in mistake("plot-errors", folder / "data", *wrong)


def test_an_answer_to_another_dataset_is_refused_in_one_line(folder: Path, answers: list[Path]):
    write_dataset(folder / "other", Crowd(scenes=1, seed=9))
    with pytest.raises(VbbenchError, match=r"answers dataset .*, .*other is [0-9a-f]+$"):
        error_tables(Dataset(folder / "other"), answers)


def test_several_answers_and_one_with_faults_in_one_picture(folder: Path, answers: list[Path], monkeypatch):
    shown: list[Figure] = []
    monkeypatch.setattr("vbbench.pictures.plotting.figure.save_picture", lambda drawing, _: shown.append(drawing))
    data, (poses, positions) = folder / "data", true_answers(folder / "data", 0.2)
    careless = submit(folder / "careless", data, (poses[poses["frame"] != 4], positions), solver="careless")
    plot_to_file(Dataset(data), SEQUENCE, "x.png", submissions=[*answers[:2], careless])
    (drawing,) = shown
    own = score(answers[0], data).per_sequence
    figure = own.figures["dt"][own.sequence == SEQUENCE][0]
    assert drawn(part(drawing, "table"), "cell-1-5").get_text() == f"{figure:.3f}"
    observer = part(drawing, "map-0")
    truth = Dataset(data).truth(Dataset(data).sequence(SEQUENCE))
    np.testing.assert_allclose(drawn(observer, "true-path").get_xdata(), truth.poses[:, 0])
    assert to_hex(drawn(observer, "path-cv").get_color()) == solver_colour("cv")
    assert "careless is not scored: poses.parquet" in words(drawing)
    assert CAUTION.split(". ")[1] in words(drawing)


def test_matplotlib_is_not_loaded_for_help():
    code = "import sys; from vbbench.cli import main\ntry: main(['plot-errors', '--help'])\nexcept SystemExit: pass\n"
    done = subprocess.run([sys.executable, "-c", code + "assert 'matplotlib' not in sys.modules"], check=False)
    assert done.returncode == 0
