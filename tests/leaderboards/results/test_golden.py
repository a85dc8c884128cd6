"""The committed results: sound, complete, and a part of them recomputed exactly."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_leaderboards.checks import tolerance_of
from vbbench_leaderboards.results.boards import REFERENCES, published_sources, source
from vbbench_leaderboards.results.dataset_record import read_dataset
from vbbench_leaderboards.results.folder import published_results
from vbbench_leaderboards.results.result import Board, read_result

SEQUENCES = 40
"""Sequences of Hotel that are solved again; what comes after them does not change them."""


@pytest.fixture(scope="module")
def committed() -> Path:
    """The folder of the committed results."""
    return published_results()


@pytest.fixture(scope="module")
def hotel(committed: Path, tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """The first sequences of Hotel's dataset, of the seed that its record names."""
    rules = source("hotel", "noisy")
    options = rules.options(read_dataset(committed / "hotel/noisy.json").seed or 0)
    part = replace(options, limit=SEQUENCES * (rules.stride or 1))
    return generate("hotel", tmp_path_factory.mktemp("golden") / "hotel", part)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("protocol", "solver"), [*product(["sequential"], sorted(REFERENCES)), ("one-step", "vb-cv"), ("one-step", "vb-sf")]
)
def test_hotel_scores_as_committed(
    data_folder: Path, committed: Path, request: pytest.FixtureRequest, tmp_path: Path, protocol: str, solver: str
) -> None:
    dataset = request.getfixturevalue("hotel")
    own = score(solve(dataset, solver, protocol, tmp_path / "answers"), dataset.folder).per_sequence
    board = Board(split="hotel", tier="noisy", protocol=protocol)
    kept = read_result(committed / board.key / f"{solver}.json").per_sequence
    rows = np.isin(kept.sequence, own.sequence)
    assert len(own.sequence) == rows.sum() > SEQUENCES // 2
    for name, values in own.figures.items():
        exact = tolerance_of(solver)
        np.testing.assert_allclose(kept.figures[name][rows], values, rtol=exact, atol=exact)


def test_every_bundled_solver_stands_on_every_board(committed: Path) -> None:
    boards = [board for one in published_sources() for board in one.boards]
    wanted = [Path(board.key, f"{solver}.json") for board in boards for solver in sorted(REFERENCES)]
    missing = [str(path) for path in wanted if not (committed / path).is_file()]
    assert not missing, "write them with make leaderboard"
    assert all((committed / path).stat().st_size < 40_000 for path in wanted)
