"""Results made of figures alone, for the tests of ranks, charts and pages."""

from typing import Any

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.scoring.metrics import METRICS, section
from vbbench.scoring.scorecard import PerSequence
from vbbench.scoring.statistics import summarise
from vbbench_leaderboards.results.result import Board, Result

BOARD = Board(split="hotel", tier="noisy", protocol="one-step")


def result(solver: str, dx: FloatArray, *, board: Board = BOARD, **facts: Any) -> Result:
    """A solver whose every metric has the figures ``dx`` [N] of the sequences 0 … N − 1."""
    count = len(dx)
    figures = {name: np.asarray(dx, float) for name in METRICS}
    sequence, ones = np.arange(count), np.ones(count, np.int64)
    own = PerSequence(
        sequence=sequence,
        scene=sequence,
        first_frame=0 * ones,
        last_frame=19 * ones,
        frames=ones,
        positions=ones,
        posed=ones,
        placed=ones,
        figures=figures,
    )
    values = {
        "version": "1.0",
        "reference": "",
        "link": "",
        "dataset": "0123456789abcdef",
        "camera": "panorama",
        "seed": 0,
        "package_version": "0.1.0",
        "hardware": "a machine",
        "submission": {},
    }
    return Result(
        board=board,
        solver=solver,
        score=score(solver, board, own, facts.pop("score", {})),
        per_sequence=own,
        **{**values, **facts},
    )


def score(solver: str, board: Board, own: PerSequence, more: dict[str, Any]) -> dict[str, Any]:
    """As ``vbbench score --json`` prints it."""
    figures, protocol = own.figures, get_protocol(board.protocol)
    found = summarise(own.timeline, protocol, figures, figures)
    summaries = {name: summary.to_dict() for name, summary in found.items()}
    return {
        "solver": solver,
        "protocol": board.protocol,
        "protocol_version": protocol.version,
        "sequences": len(figures["dx"]),
        "sequences_in_dataset": len(figures["dx"]),
        "frames": len(figures["dx"]),
        "positions": len(figures["dx"]),
        "coverage": 1.0,
        "seconds_per_frame": 1e-4,
        "metrics": {name: summaries[name] for name in section("metrics")},
        "drift": {name: summaries[name] for name in section("drift")},
        **more,
    }
