"""Boards as files for papers and programs: the figures of the results and the ranks of the page."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest

from tests.lib.board_results import BOARD, record_of, result
from tests.lib.made_results import SOLVERS, made_results
from vbbench.cli import main
from vbbench_leaderboards.results.folder import read_datasets, read_results
from vbbench_leaderboards.results.ranking import rank_apart
from vbbench_leaderboards.site.building import build
from vbbench_leaderboards.site.export import DOWNLOADS, ExportedBoard, exported_text, table_address

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
    rows = list(csv.DictReader(io.StringIO(printed(capsys, results, "csv", "kitti/sequential-footage", KEY))))
    splits = list(dict.fromkeys(row["split"] for row in rows))
    assert splits == ["kitti", "hotel"]
    assert {row["solver"] for row in rows if row["split"] == "kitti"} == set(SOLVERS)
    assert main(["leaderboard", "export", "--results", str(results), "--board", "hotel/sequential-fild"]) == 2
    assert f"no board is called 'hotel/sequential-fild'; did you mean '{KEY}'?" in capsys.readouterr().err


def test_the_best_is_marked_among_its_like() -> None:
    late = result("late", ERRORS / 4, delay="offline")
    rows = [result("good", ERRORS), result("poor", ERRORS * 3), late, result("later", ERRORS / 3, delay="offline")]
    table = ExportedBoard.of(BOARD, record_of(*rows), rows).table()
    assert [row[1] for row in table.rows] == ["good", "poor", "late", "later"]
    assert ["**" in row[4] for row in table.rows] == [True, False, True, False]
    assert [row[2] for row in table.rows] == ["causal", "causal", "offline", "offline"]


@pytest.mark.slow
def test_the_page_offers_every_board_in_every_format(results: Path, tmp_path: Path) -> None:
    site = build(tmp_path / "site", results)
    records = read_datasets(results)
    for board in site.boards:
        piece = (tmp_path / "site" / "data" / f"{board.key}.js").read_text("utf-8")
        for form in DOWNLOADS:
            address = table_address(board, form)
            path = tmp_path / "site" / address
            exported = ExportedBoard.of(board, records[board.split, board.tier], site.results[board])
            assert path.read_text("utf-8") == exported_text([exported], form)
            assert address in piece
