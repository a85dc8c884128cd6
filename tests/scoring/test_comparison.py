"""Submissions compared: two by pairs of sequences, several in one table with the best marked and faults named."""

import csv
import io
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from tests.lib.answers import submit, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from tests.test_table import check_latex
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.scoring.comparison import Comparison, compare, score_several
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
    for name, noise, protocol in (("fine", 0.02, "sequential"), ("poor", 0.1, "sequential"), ("roll", 0.1, "rollout")):
        submit(root / name, root / "data", true_answers(root / "data", noise, seed=1), solver=name, protocol=protocol)
    submit(root / "hostile", root / "data", true_answers(root / "data", 0.1, seed=2), solver=HOSTILE)
    submit(root / "else", root / "others", true_answers(root / "others", 0.1, seed=1), solver="else")
    shutil.copytree(root / "fine", root / "broken")
    (root / "broken" / "positions.parquet").unlink()
    return root


@pytest.fixture(scope="module")
def better(room: Path) -> Comparison:
    return compare(room / "fine", room / "poor", room / "data")


@pytest.mark.slow
def test_identical_submissions_do_not_differ(room: Path) -> None:
    result = compare(room / "poor", room / "poor", room / "data")
    for difference in result.differences.values():
        assert (difference.difference, difference.ci95, difference.p_value) == (0.0, (0.0, 0.0), 1.0)


def test_a_better_submission_is_clearly_better_by_sequences_and_the_other_way_round_clearly_worse(
    room: Path, better: Comparison
) -> None:
    other = compare(room / "poor", room / "fine", room / "data").differences
    assert set(better.differences) == set(METRICS)
    for name, one in better.differences.items():
        assert one.difference < 0
        assert one.ci95[1] < 0
        assert one.p_value < 0.01
        a, b = (score.per_sequence.figures[name] for score in (better.a, better.b))
        assert one.difference == pytest.approx(np.nanmean(a - b)) == pytest.approx(-other[name].difference)
        assert one.ci95 == pytest.approx(tuple(-end for end in reversed(other[name].ci95)))
        assert one.p_value == other[name].p_value


def test_equally_good_submissions_are_not_told_apart(room: Path) -> None:
    result = compare(room / "poor", room / "hostile", room / "data")
    assert np.mean([result.differences[name].p_value for name in METRICS]) > 0.05


def test_protocols_are_not_mixed(room: Path) -> None:
    with pytest.raises(VbbenchError, match="one protocol"):
        compare(room / "poor", room / "roll", room / "data")


def test_json_and_text(better: Comparison) -> None:
    values = json.loads(better.to_json())
    assert values["a"] == {"solver": "fine", "coverage": 1.0}
    assert set(values["metrics"]) == {"dx", "dx_rel", "dr", "dt"}
    keys = {"a", "b", "difference", "ci95", "p_value", "failure_rate", "mean", "sequences"}
    assert set(values["metrics"]["dx"]) == keys
    assert values["metrics"]["dx"]["failure_rate"] == {"a": 0.0, "b": 0.0}
    assert values["ranked_by"] == "capped"
    assert "A = fine (coverage 100.00%), B = poor" in better.table()
    assert "Caution: made up" in better.table()
    assert "ranked on boards, by capped means" in better.table()
    assert f"{better.blocks:.1f} blocks of" in better.table()


def test_a_runaway_does_not_hide_who_is_better(room: Path, tmp_path: Path) -> None:
    """Fine in all sequences but one, where it goes 8 km astray: plain and capped means say different things."""
    poses, positions = true_answers(room / "data", 0.02, seed=1)
    positions.loc[positions.sequence == 3, "x"] += 8000.0
    runaway = submit(tmp_path / "astray", room / "data", (poses, positions), solver="astray")
    values = compare(runaway, room / "poor", room / "data").values()["metrics"]["dx"]
    assert values["mean"]["difference"] > 100
    assert abs(values["difference"]) < 0.2
    assert values["failure_rate"]["a"] > 0 == values["failure_rate"]["b"]


def test_too_few_sequences_have_no_p_value(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(scenes=1, people=3, frames=12, stay=(10, 11)))
    for name, noise in (("a", 0.02), ("b", 0.1)):
        submit(tmp_path / name, tmp_path / "data", true_answers(tmp_path / "data", noise))
    result = compare(tmp_path / "a", tmp_path / "b", tmp_path / "data")
    dx = json.loads(result.to_json())["metrics"]["dx"]
    assert dx["difference"] < 0
    assert (dx["p_value"], dx["ci95"]) == (None, [None, None])
    assert "too few for honest ones" in result.table()
    assert "too few for honest ones" in result.a.table()
    assert json.loads(result.a.to_json())["metrics"]["dx"]["capped_ci95"] == [None, None]


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
def test_mistakes_are_said_in_one_line(arguments: tuple[str, ...], complaint: str, mistake: Callable[..., str]) -> None:
    assert complaint in mistake(*arguments)
