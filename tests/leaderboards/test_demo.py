"""``vbbench demo``: a table of four solvers and a page whose pictures and player are there."""

import re
from pathlib import Path

import numpy as np
import pytest

from vbbench.errors import VbbenchError
from vbbench_leaderboards import demo
from vbbench_leaderboards.results.boards import REFERENCES
from vbbench_leaderboards.results.folder import read_results


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    out = tmp_path_factory.mktemp("demo") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(demo, "SEQUENCES", 6)
        return out, demo.make_demo(out)


def test_the_table_has_a_row_for_each_solver(made: tuple[Path, str]) -> None:
    for solver in demo.SOLVERS:
        figures = re.search(rf"(?m)^{solver} .*?((?: +\d+\.\d+){{3}}) *$", made[1])
        assert figures is not None
        assert all(float(value) > 0.0 for value in figures[1].split())


def test_the_page_refers_to_files_and_shows_a_usual_sequence(made: tuple[Path, str]) -> None:
    out, page = made[0], (made[0] / "index.html").read_text("utf-8")
    referred = {address.partition("?")[0].partition("#")[0] for address in re.findall(r'(?:src|href)="([^"]+)"', page)}
    for address in referred - {"data:,", ""}:  # "" leads to a part of the page itself
        assert (out / address).is_file()
    (shown,) = {int(number) for number in re.findall(r"play\?sequence=(\d+)", page)}
    assert (out / "site" / "data" / "player" / "demo" / demo.TIER / f"{shown}.js").is_file()
    (board,) = [rows for key, rows in read_results(out / "results").items() if key.protocol == "sequential"]
    (scored,) = [row.per_sequence for row in board if row.solver == demo.SHOWN]
    far = np.abs(scored.figures["dx"] - np.nanmedian(scored.figures["dx"]))
    assert (far < far[scored.sequence == shown]).sum() < max(1, len(far) // 3)


def test_it_can_be_made_again_in_its_own_folder_and_in_no_other(made: tuple[Path, str], tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(VbbenchError, match="demo"):
        demo.make_demo(tmp_path)
    assert (tmp_path / "mine.txt").read_text() == "mine"


@pytest.mark.slow
def test_all_of_it_has_a_row_for_each_bundled_solver_and_a_column_for_each_protocol(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demo, "SEQUENCES", 2)
    table = demo.make_demo(tmp_path / "out", full=True)
    for solver in sorted(REFERENCES):
        figures = re.search(rf"(?m)^{solver} .*?((?: +\d+\.\d+){{5}}) *$", table)
        assert figures is not None
