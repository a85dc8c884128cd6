"""A small folder of results for tests of pages and checks: drawn figures, not measured ones, on boards of all kinds."""

from pathlib import Path

import numpy as np

from tests.lib.board_results import record_of, result
from vbbench.camera import PanoramaCamera, camera_to_dict
from vbbench_leaderboards.results.dataset_record import BoardDataset, write_dataset
from vbbench_leaderboards.results.result import Board, Result, write_result

SOLVERS = {"cv": 0.9, "sf": 1.1, "vb-cv": 0.4, "vb-sf": 0.35, "map-causal": 0.2, "map-batch": 0.12}
"""Solvers and their usual error in m."""

BOARDS = (
    ("sim", "field", ("sequential",)),
    ("hotel", "field", ("sequential", "rollout", "one-step", "cold-start")),
    ("hotel", "noisy", ("sequential", "one-step", "rollout")),
    ("hotel", "ideal", ("one-step", "rollout")),
    ("kitti", "footage", ("sequential", "one-step")),
    ("eth", "noisy", ("sequential", "rollout")),
    ("eth", "ideal", ("sequential", "rollout")),
    ("students", "ideal", ("one-step",)),
)
"""Splits and tiers with the protocols that have boards."""

_HARD = {"field": 1.5, "noisy": 1.0, "ideal": 0.7, "footage": 2.0}
_COUNT = {"kitti": 9}
KITTI_CAUTION = "poses have errors of their own"


def made_results(folder: Path) -> Path:
    """Write all of them below ``folder``, and return it."""
    for number, (split, tier, protocols) in enumerate(BOARDS):
        rng, caution = np.random.default_rng(number), KITTI_CAUTION if split == "kitti" else None
        rows = [
            _row(Board(split=split, tier=tier, protocol=protocol), solver, rng, caution)
            for protocol in protocols
            for solver in SOLVERS
        ]
        write_dataset(_record(rows), folder)
        for row in rows:
            write_result(row, folder)
    return folder


def _row(board: Board, solver: str, rng: np.random.Generator, caution: str | None) -> Result:
    offline = solver == "map-batch" and board.protocol != "one-step"
    usual = SOLVERS[solver] * _HARD[board.tier] * (0.2 if board.protocol == "one-step" else 1.0)
    figures = rng.gamma(3.0, usual / 3.0, _COUNT.get(board.split, 40))
    said = {} if caution is None else {"caution": caution}
    return result(
        solver,
        figures.astype("f4").astype(float) % 3.0,  # a heading is turned by no more than π
        board=board,
        dataset=f"{abs(hash_of(board)):016x}",
        reference=f"The solver {solver}",
        delay="offline" if offline else 0,
        score=said,
    )


def hash_of(board: Board) -> int:
    """A number for each split and tier."""
    return sum(ord(letter) * 31**n for n, letter in enumerate(board.split + board.tier)) % (1 << 60)


def _record(rows: list[Result]) -> BoardDataset:
    return record_of(*rows, camera=camera_to_dict(PanoramaCamera()))
