"""The README's table says what the committed results say."""

import re
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from vbbench.cli import main
from vbbench_leaderboards.results.boards import LEADING_SPLITS, REAL_SPLITS
from vbbench_leaderboards.results.folder import published_results, read_results
from vbbench_leaderboards.results.result import Board, Result

README = Path(__file__).parents[1] / "README.md"
CAUSAL = ("cv", "sf", "vb-cv", "vb-sf", "map-causal", "vb-former")
SOLVERS = (*CAUSAL, "map-batch")
ROWS = re.findall(
    r"^\| ([\w-]+) \| (field|noisy|footage) \| " + r" \| ".join([r"([^|]+)"] * len(SOLVERS)) + r" \|$",
    README.read_text("utf-8"),
    re.M,
)


def test_every_headline_split_has_its_rows() -> None:
    assert len(ROWS) == 2 * len(LEADING_SPLITS) + len(REAL_SPLITS)


@pytest.fixture(scope="module")
def committed() -> Mapping[Board, tuple[Result, ...]]:
    return read_results(published_results())


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]}-{row[1]}")
def test_row_is_as_committed(row: tuple[str, ...], committed: Mapping[Board, tuple[Result, ...]]) -> None:
    split, tier, *cells = row
    board = committed[Board(split=split, tier=tier, protocol="sequential")]
    capped = {result.solver: result.score["metrics"]["dx"]["capped"] for result in board}
    printed = {solver: f"{capped[solver]:.3f}" for solver in SOLVERS}
    least = min(CAUSAL, key=lambda solver: capped[solver])
    marked = {result.solver: "†" if result.seen else "" for result in board}
    bold = {solver: "**" if solver == least else "" for solver in SOLVERS}
    assert cells == [f"{bold[solver]}{printed[solver]}{bold[solver]}{marked[solver]}" for solver in SOLVERS]


@pytest.mark.slow
def test_the_solver_of_the_readme_goes_onto_a_board(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From an empty folder, as README says; without the page, which has tests of its own."""
    page = README.read_text("utf-8")
    block = next(block for block in re.findall(r"```python\n(.*?)```", page, re.S) if "class StandStill" in block)
    found = re.search(r"(?m)^    \$ vbbench (leaderboard try mysolver:StandStill .*) --out site\n    (.*)$", page)
    assert found is not None
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    Path("mysolver.py").write_text(block, encoding="utf-8")
    sys.modules.pop("mysolver", None)  # another test's
    try:
        assert main(shlex.split(found[1])) == 0
    finally:
        sys.modules.pop("mysolver", None)
    assert capsys.readouterr().out.strip() == found[2]
