"""Results made of figures alone, for the tests of ranks, charts and pages."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.scoring.metrics import METRICS, section
from vbbench.scoring.scorecard import PerSequence, summarise
from vbbench_leaderboards.results.dataset_record import BoardDataset, ScoredSequences
from vbbench_leaderboards.results.result import About, Board, Result

ABOUT = About(authors="somebody", date="2026-11-22", delay=0, trained_on="nothing", tuned_on="nothing")
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
        "dataset": "0123456789abcdef",
        "camera": "panorama",
        "seed": 0,
        "package_version": "0.1.0",
        "hardware": "a machine",
        "submission": {"poses.parquet": "0" * 64, "positions.parquet": "1" * 64},
    }
    words = {field.name: facts.pop(field.name) for field in fields(About) if field.name in facts}
    more = {"solver_version": "1.0", "dataset": facts.get("dataset", values["dataset"]), **facts.pop("score", {})}
    return Result(
        board=board,
        solver=solver,
        about=replace(ABOUT, **words),
        score=score(solver, board, own, more),
        per_sequence=own,
        **{**values, **facts},
    )


def score(solver: str, board: Board, own: PerSequence, more: dict[str, Any]) -> dict[str, Any]:
    """As ``vbbench score --json`` prints it."""
    protocol, count = get_protocol(board.protocol), len(own.sequence)
    found = summarise(own.timeline, protocol, own.figures, own.figures)
    summaries = {name: summary.to_dict() for name, summary in found.items()}
    return {
        "solver": solver,
        "protocol": board.protocol,
        "protocol_version": protocol.version,
        "split": board.split,
        "sequences": count,
        "sequences_in_dataset": count,
        "frames": count,
        "positions": count,
        "fallback_frames": None,
        "coverage": 1.0,
        "pose_coverage": 1.0,
        "position_coverage": 1.0,
        "failure_policy": "refuse",
        "seconds_per_frame": 1e-4,
        "ranked_by": "capped",
        "metrics": {name: summaries[name] for name in section("metrics")},
        "drift": {name: summaries[name] for name in section("drift")},
        **more,
    }


def record_of(*rows: Result, camera: dict[str, Any] | None = None) -> BoardDataset:
    """The record of the dataset of results on its boards."""
    first, board = rows[0], rows[0].board
    own = first.per_sequence
    scored = ScoredSequences(**{field.name: getattr(own, field.name) for field in fields(ScoredSequences)})
    return BoardDataset(
        id=first.dataset,
        split=board.split,
        tier=board.tier,
        title=f"{board.split}, made for a test",
        camera=camera or {"kind": first.camera},
        seed=first.seed,
        dt=0.4,
        command=f"vbbench generate {board.split} --tier {board.tier}",
        counts={
            "split": board.split,
            "camera": first.camera,
            "tier": board.tier,
            "sequences": len(own.sequence),
            "mean_frames": 20.0,
            "people_min": 3,
            "people_mean": 5.5,
            "people_max": 9,
            "observations": 1000,
            "id": first.dataset,
        },
        caution=first.score.get("caution"),
        licence="",
        citation="",
        tables=dict.fromkeys(("sequences", "observations", "given"), "2" * 64),
        scored={row.board.protocol: scored for row in rows},
    )
