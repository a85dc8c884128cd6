"""README is short, its leaderboard is the committed one, and its commands for a solver do what it shows."""

import re
import runpy
import shlex
import sys
from pathlib import Path

import pytest

from vbbench.cli import main
from vbbench_leaderboards.results.folder import published_results, read_results

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text("utf-8")


@pytest.mark.slow
def test_the_leaderboard_is_the_committed_one() -> None:
    board = runpy.run_path(str(ROOT / "docs" / "write_board.py"))
    assert board["table"](read_results(published_results())) in README


@pytest.mark.slow
def test_its_commands_take_a_solver_onto_a_board(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From an empty folder; without the page, which has tests of its own."""
    begin = re.search(r"(?m)^    \$ vbbench (leaderboard template mine) && cd mine$", README)
    trial = re.search(r"(?m)^    \$ vbbench (leaderboard try mysolver:MySolver .*) --out site\n    (.*)$", README)
    assert begin is not None
    assert trial is not None
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(begin[1])) == 0
    monkeypatch.chdir(tmp_path / "mine")
    monkeypatch.syspath_prepend(str(tmp_path / "mine"))
    sys.modules.pop("mysolver", None)  # another test's
    capsys.readouterr()
    try:
        assert main(shlex.split(trial[1])) == 0
    finally:
        sys.modules.pop("mysolver", None)
    assert capsys.readouterr().out.strip() == trial[2]
