"""The README's table says what the committed results say."""

import re
from collections.abc import Mapping
from pathlib import Path

import pytest

from vbbench_leaderboards.results.folder import published_results, read_results
from vbbench_leaderboards.results.result import Board, Result

README = Path(__file__).parents[1] / "README.md"
SOLVERS = ("cv", "sf", "vb-cv", "vb-sf", "map-causal", "map-batch")
ROWS = re.findall(
    r"^\| ([\w-]+) \| (one-step|sequential|rollout) \| " + r" \| ".join([r"([^|]+)"] * len(SOLVERS)) + r" \|$",
    README.read_text("utf-8"),
    re.M,
)


def test_every_headline_split_has_its_rows() -> None:
    assert len(ROWS) == 15


@pytest.fixture(scope="module")
def committed() -> Mapping[Board, tuple[Result, ...]]:
    return read_results(published_results())


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row[0]}-{row[1]}")
def test_row_is_as_committed(row: tuple[str, ...], committed: Mapping[Board, tuple[Result, ...]]) -> None:
    split, protocol, *cells = row
    board = committed.get(Board(split=split, tier="noisy", protocol=protocol))
    if board is None:
        pytest.skip("this board is not committed")
    means = {result.solver: result.score["metrics"]["dx"]["mean"] for result in board}
    printed = {solver: f"{means[solver]:.3f}" for solver in SOLVERS}
    least = min(SOLVERS, key=lambda solver: means[solver])
    assert cells == [f"**{printed[solver]}**" if solver == least else printed[solver] for solver in SOLVERS]
