"""Several submissions in one table: the figures of each score, the best marked, faults told, strangers kept apart."""

import csv
import io
import json
import re
import shutil
from pathlib import Path
from typing import get_args

import pytest

from tests.lib.answers import submit, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from tests.test_table import check_latex
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.scoring.comparison import score_several
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scores import score
from vbbench.table import Format

HOSTILE = "a|b **c** \\input{x} 5%"


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset, submissions of two qualities to it, one with a fault, and strangers."""
    root = tmp_path_factory.mktemp("several")
    write_dataset(root / "data", Crowd(scenes=8, frames=24, people=9, seed=3, caution="made up"))
    write_dataset(root / "others", Crowd(scenes=2, frames=24, people=9, seed=4))
    for name, noise, protocol in (("fine", 0.02, "sequential"), ("poor", 0.3, "sequential"), ("roll", 0.1, "rollout")):
        submit(root / name, root / "data", true_answers(root / "data", noise, seed=1), solver=name, protocol=protocol)
    submit(root / "hostile", root / "data", true_answers(root / "data", 0.3, seed=2), solver=HOSTILE)
    submit(root / "else", root / "others", true_answers(root / "others", 0.1, seed=1), solver="else")
    shutil.copytree(root / "fine", root / "broken")
    (root / "broken" / "positions.parquet").unlink()
    return root


def run(room: Path, *names: str, **options: str) -> tuple[str, ...]:
    more = [word for name, value in options.items() for word in (f"--{name}", value)]
    return ("score", *(str(room / name) for name in names), "--dataset", str(room / "data"), *more)


def test_one_submission_prints_as_ever(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(run(room, "fine")) == 0
    assert capsys.readouterr().out == score(room / "fine", room / "data").table() + "\n"
    assert main([*run(room, "fine"), "--json"]) == main(run(room, "fine", format="json")) == 0
    assert capsys.readouterr().out == 2 * (score(room / "fine", room / "data").to_json() + "\n")


def test_the_table_has_every_score_with_its_interval(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(run(room, "poor", "fine")) == 0
    title, head, poor, fine, *notes = capsys.readouterr().out.splitlines()
    one = score(room / "fine", room / "data")
    assert f"{one.info.dataset}), sequential/2: {one.sequences} of {one.total_sequences} sequences scored" in title
    assert head.split()[0] == "solver"
    assert head.split()[-3:] == ["failed", "coverage", "µs/frame"]
    figures, (low, high) = one.summaries["dx"], one.summaries["dx"].capped_ci95
    assert f"{figures.capped:.3f}* ({low:.3f}–{high:.3f})" in fine
    lost = score(room / "poor", room / "data").summaries["dx"].failure_rate
    assert fine.count("*") == 4 + (lost > one.summaries["dx"].failure_rate)
    assert "*" not in poor
    said = " ".join(notes)
    assert "min(error, 2 m or 0.5 rad)" in said
    assert "Caution: made up" in said
    assert "Intervals: block bootstrap over time" in said


def test_csv_holds_every_digit(room: Path) -> None:
    table = score_several([room / "fine", room / "poor"], room / "data")
    rows = list(csv.DictReader(io.StringIO(table.write("csv"))))
    assert [row["submission"] for row in rows] == [str(room / "fine"), str(room / "poor")]
    for row, one in zip(rows, table.scores.values(), strict=True):
        assert (row["solver"], row["dataset"], row["protocol"]) == (one.info.solver, one.info.dataset, "sequential/2")
        assert float(row["coverage"]) == one.coverage
        for name in METRICS:
            own = one.summaries[name]
            assert (float(row[name]), float(row[f"{name}_low"])) == (own.capped, own.capped_ci95[0])
            assert float(row[f"{name}_mean"]) == own.mean


def test_json_holds_the_scores(room: Path) -> None:
    values = json.loads(score_several([room / "fine", room / "poor"], room / "data").write("json"))
    assert [one["metrics"] for one in values["submissions"]] == [
        json.loads(score(room / name, room / "data").to_json())["metrics"] for name in ("fine", "poor")
    ]


def test_the_faults_of_every_submission_are_listed(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(run(room, "fine", "broken", "nowhere")) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert re.search(r"(?s)not all of these can be scored.*broken: 1 fault.*nowhere: 1 fault", shown.err)


@pytest.mark.parametrize(("stranger", "what"), [("else", "dataset"), ("roll", "protocol")])
def test_one_table_holds_one_dataset_and_one_protocol(room: Path, stranger: str, what: str) -> None:
    with pytest.raises(
        VbbenchError, match=rf"fine answers {what} \S+, .*{stranger} {what} .*one table holds one {what}"
    ):
        score_several([room / "fine", room / stranger], room / "data")


def test_nobodys_name_is_a_mark(room: Path) -> None:
    table = score_several([room / "fine", room / "hostile"], room / "data")
    assert r"a\|b \*\*c\*\* \\input{x} 5%" in table.write("markdown")
    assert HOSTILE in table.write("text")
    body = table.write("latex").partition(r"\midrule")[2].partition(r"\bottomrule")[0]
    for line in body.strip().splitlines():
        for cell in line.strip().removesuffix(r" \\").split(" & "):
            check_latex(cell.replace(r"{\tiny ", "{"))


def test_two_of_one_name_go_by_their_folders(room: Path, tmp_path: Path) -> None:
    shutil.copytree(room / "fine", tmp_path / "again")
    text = score_several([room / "fine", tmp_path / "again"], room / "data").write("text")
    assert f"fine ({room / 'fine'})" in text
    assert f"fine ({tmp_path / 'again'})" in text


@pytest.mark.parametrize("form", get_args(Format))
def test_every_format_of_one_submission(room: Path, form: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(run(room, "fine", format=form)) == 0
    assert "fine" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("score", "--dataset", "x"), "which submission? give one folder or more"),
        (("score", "a", "b", "--dataset", "x", "--per-sequence", "y.csv"), "--per-sequence is of one submission"),
        (("score", "a", "b", "--dataset", "x", "--format", "tex"), "--format: cannot be 'tex'"),
    ],
)
def test_mistakes_are_said_in_one_line(
    arguments: tuple[str, ...], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert complaint in said
    assert said.count("\n") == 1
