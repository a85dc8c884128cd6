"""Boards as files for papers and programs: the figures of the results, the ranks of the page, and what to cite."""

import csv
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.lib.board_results import BOARD, record_of, result
from tests.lib.made_results import SOLVERS, made_results
from tests.test_table import check_latex
from vbbench import __version__
from vbbench.cli import main
from vbbench.registry import load, registered
from vbbench_leaderboards.results.folder import read_results
from vbbench_leaderboards.results.ranking import rank_apart
from vbbench_leaderboards.site.export import (
    ExportedBoard,
    bibliography,
    cited,
    exported_text,
    known_references,
)

ERRORS = np.random.default_rng(3).gamma(4.0, 0.02, 40)
KEY = "hotel/sequential-field"


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_results(tmp_path_factory.mktemp("results"))


def printed(capsys: pytest.CaptureFixture[str], results: Path, form: str, *boards: str) -> str:
    chosen = ["--board", *boards] if boards else []
    assert main(["leaderboard", "export", "--results", str(results), "--format", form, *chosen]) == 0
    return capsys.readouterr().out


@pytest.mark.slow
def test_csv_has_a_row_per_result_with_every_digit(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = list(csv.DictReader(io.StringIO(printed(capsys, results, "csv"))))
    found = read_results(results)
    assert len(rows) == sum(map(len, found.values()))
    for board, own in found.items():
        places = rank_apart(own)["dx"].places
        ours = {row["solver"]: row for row in rows if (row["split"], row["tier"]) == (board.split, board.tier)
                and row["protocol"].startswith(f"{board.protocol}/")}  # fmt: skip
        for one in own:
            row, figures = ours[one.solver], one.score["metrics"]["dx"]
            assert float(row["dx"]) == figures["capped"]
            assert row["dx_high"] == ("" if figures["capped_ci95"][1] is None else str(figures["capped_ci95"][1]))
            assert int(row["rank"]) == places[one.solver].rank
            assert (row["dataset"], row["authors"]) == (one.dataset, one.about.authors)


def test_chosen_boards_alone_and_in_that_order(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    boards = json.loads(printed(capsys, results, "json", "kitti/sequential-footage", KEY))
    assert [(board["split"], board["tier"]) for board in boards] == [("kitti", "footage"), ("hotel", "field")]
    assert {row["score"]["solver"] for row in boards[0]["rows"]} == set(SOLVERS)
    assert main(["leaderboard", "export", "--results", str(results), "--board", "hotel/sequential-fild"]) == 2
    assert f"no board is called 'hotel/sequential-fild'; did you mean '{KEY}'?" in capsys.readouterr().err


def test_the_best_is_marked_among_its_like() -> None:
    late = result("late", ERRORS / 4, delay="offline")
    rows = [result("good", ERRORS), result("poor", ERRORS * 3), late, result("later", ERRORS / 3, delay="offline")]
    table = ExportedBoard.of(BOARD, record_of(*rows), rows).table()
    assert [row[1] for row in table.rows] == ["good", "poor", "late", "later"]
    assert ["**" in row[4] for row in table.rows] == [True, False, True, False]
    assert [row[2] for row in table.rows] == ["causal", "causal", "offline", "offline"]


def test_hostile_words_stay_words() -> None:
    hostile = result("x", ERRORS, reference="} @misc{evil, \\input{/etc/passwd} 5% $_^", authors='{{{ \\" a_b')
    exported = ExportedBoard.of(BOARD, record_of(hostile), [hostile])
    bib = exported_text([exported], "bibtex")
    assert re.findall(r"@misc\{([\w-]+)", bib) == ["vbbench", "nishimura2021view", "solver-x"]
    for value in re.findall(r"(?m)^  (?:note|author|title) = \{\{(.*)\}\},$", bib.partition("@misc{solver-x")[2]):
        check_latex(value)
    assert bib.count("{") == bib.count("}")


def test_bibtex_cites_each_work_once_and_an_address_becomes_a_link() -> None:
    facts = {"reference": "Somebody, 2026", "code": "https://example.org/a_b%20{c}", "authors": "A & B"}
    rows = [result("net", ERRORS, **facts), result("net", ERRORS * 2, **facts), result("silent", ERRORS)]
    citations = [load("generator", split).card.citation for split in ("hotel", "sim", "eth")]
    records = [replace(record_of(*rows), citation=one) for one in (*citations, "A book of mine, 1999")]
    text = bibliography(rows, records)
    known, *data, own, net = re.findall(r"(?m)^@\w+\{([^,]+),$", text)[1:]
    assert (known, *data) == ("nishimura2021view", "pellegrini2009never", "moussaid2009experimental")
    assert (own[:5], net) == ("data-", "solver-net")
    assert f"note = {{Version {__version__}}}" in text
    assert "note = {{Somebody, 2026}}" in text
    assert r"author = {{A \& B}}" in text
    assert r"url = {https://example.org/a_b\%20\%7Bc\%7D}" in text
    assert "note = {{A book of mine, 1999}}" in text


@pytest.mark.parametrize("split", sorted(registered("generator")))
def test_every_public_source_has_its_entry(split: str) -> None:
    own = {"your own", "the user's", "none; made by vbbench"}
    citation = load("generator", split).card.citation
    if citation not in own:
        assert set(cited(citation)) <= set(known_references())
