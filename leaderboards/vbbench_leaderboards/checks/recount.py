"""Checks what a result file says against its per-sequence figures and its board's dataset record.

Figures are kept to float32, half a unit in the eighth digit; a recount must agree to a relative `TOLERANCE`.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import known, summarise
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.result import Result

TOLERANCE = 1e-6
_LISTED = 5


def count_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    """Faults of all but the summaries: differences from the record, missing sequences, counts and coverage."""
    yield from _declared_faults(result, record)
    rows = list(_row_faults(result, record))
    yield from rows
    if not rows:
        yield from _total_faults(result)
        yield from _figure_faults(result, record)


def summary_faults(results: Iterable[Result]) -> Iterator[tuple[Result, str]]:
    """Results with the summaries that do not follow from their per-sequence figures."""
    for result in results:
        own, protocol = result.per_sequence, get_protocol(result.board.protocol)
        fresh = summarise(own.timeline, protocol, own.figures, own.figures)
        for name, metric in METRICS.items():
            said = result.score[metric.section][name]
            for fault in _metric_summary_faults(said, fresh[name].to_dict(), result, name):
                yield result, f"$.score.{metric.section}.{name}.{fault}"


def _declared_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    score = result.score
    pairs = {
        "dataset.camera": (result.camera, record.camera["kind"]),
        "dataset.seed": (result.seed, record.seed),
        "score.dataset": (score["dataset"], result.dataset),
        "score.split": (score["split"], result.board.split),
        "score.protocol": (score["protocol"], result.board.protocol),
        "score.protocol_version": (score["protocol_version"], get_protocol(result.board.protocol).version),
        "score.solver": (score["solver"], result.solver),
        "score.solver_version": (score["solver_version"], result.version),
        "score.caution": (score.get("caution"), record.caution),
        "score.sequences_in_dataset": (score["sequences_in_dataset"], record.counts["sequences"]),
    }
    yield from _unequal(pairs)


def _row_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    if result.board.protocol not in record.scored:
        yield f"$.protocol: {record.path} is older than {result.board.protocol}; remove it and add its results again"
        return
    own, wanted = result.per_sequence, record.scored[result.board.protocol]
    for words, numbers in (
        ("lacks", np.setdiff1d(wanted.sequence, own.sequence)),
        ("has, and the board does not,", np.setdiff1d(own.sequence, wanted.sequence)),
    ):
        if len(numbers):
            yield f"$.per_sequence: {words} {_some(numbers)}; solve and score the whole dataset"
    if len(own.sequence) == len(wanted.sequence) and not np.array_equal(own.sequence, wanted.sequence):
        yield "$.per_sequence: sequences are not in order, each once"
    if not np.array_equal(own.sequence, wanted.sequence):
        return
    for name, theirs in vars(wanted).items():
        mine = getattr(own, name)
        if not np.array_equal(mine, theirs):
            yield f"$.per_sequence: {name} differs from the board's in {_some(own.sequence[mine != theirs])}"
    for name, part, whole in (("posed", own.posed, own.frames), ("placed", own.placed, own.positions)):
        short = part != whole if result.score["failure_policy"] == "refuse" else part > whole
        if short.any():
            yield f"$.per_sequence: {name} does not go with the failure policy in {_some(own.sequence[short])}"


def _total_faults(result: Result) -> Iterator[str]:
    own, score = result.per_sequence, result.score
    frames, positions = int(own.frames.sum()), int(own.positions.sum())
    posed, placed = int(own.posed.sum()) / frames, int(own.placed.sum()) / positions if positions else 1.0
    yield from _unequal(
        {
            "score.sequences": (score["sequences"], len(own.sequence)),
            "score.frames": (score["frames"], frames),
            "score.positions": (score["positions"], positions),
            "score.pose_coverage": (score["pose_coverage"], posed),
            "score.position_coverage": (score["position_coverage"], placed),
            "score.coverage": (score["coverage"], min(posed, placed)),
        }
    )
    if (score["fallback_frames"] or 0) > frames:
        yield f"$.score.fallback_frames: is {score['fallback_frames']}, more than the {frames} scored frames"


def _figure_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    own = result.per_sequence
    second = max(1, round(1.0 / record.dt)) * record.dt
    for name, figures in own.figures.items():
        metric = METRICS[name]
        there = own.positions > 0 if metric.over == "people" else own.frames > 0
        wrong = ~there & np.isfinite(figures) if metric.over == "people" else np.zeros(len(figures), bool)
        if metric.over != "seconds":
            wrong |= there & np.isnan(figures)
        largest = {"rad": np.pi, "rad/s": np.pi / second}.get(metric.unit, np.inf)
        wrong |= figures > largest * (1 + TOLERANCE)
        if wrong.any():
            yield f"$.per_sequence: {name} has impossible values in {_some(own.sequence[wrong])}"


def _metric_summary_faults(said: dict[str, Any], fresh: dict[str, Any], result: Result, name: str) -> Iterator[str]:
    scale = abs(fresh["mean"] or 0.0)
    for key in ("capped", "failure_rate", "mean", "std", "median", "p95", "blocks"):
        if not _close(said[key], fresh[key], scale if key == "std" else 0.0):
            yield _differs(key, said[key], fresh[key])
    for key, end in (("capped_ci95", 0), ("capped_ci95", 1), ("ci95", 0), ("ci95", 1)):
        if not _close(said[key][end], fresh[key][end]):
            yield _differs(f"{key}[{end}]", said[key][end], fresh[key][end])
    yield from _frame_summary_faults(said, result, name)


def _frame_summary_faults(said: dict[str, Any], result: Result, name: str) -> Iterator[str]:
    """The mean over frames follows where every frame has a figure: of poses; their spread is that of sequences or more.

    Of people and drift it is known whether there is any.
    """
    figures, frames = result.per_sequence.figures[name], result.per_sequence.frames
    if METRICS[name].over != "frames":
        for key in ("frame_mean", "frame_std"):
            if (said[key] is None) != (not len(known(figures))):
                yield f"{key}: is {said[key]}, the per-sequence figures say otherwise"
        return
    mean = float(np.average(figures, weights=frames))
    least = float(np.sqrt(np.average((figures - mean) ** 2, weights=frames)))
    if not _close(said["frame_mean"], mean):
        yield _differs("frame_mean", said["frame_mean"], mean)
    if said["frame_std"] is None or said["frame_std"] < least - TOLERANCE * (least + mean):
        yield f"frame_std: is {said['frame_std']}, the per-sequence figures alone spread by {least!r}"


def _close(said: float | None, fresh: float | None, scale: float = 0.0) -> bool:
    if said is None or fresh is None:
        return said is fresh
    return abs(said - fresh) <= TOLERANCE * max(abs(fresh), scale) + 1e-12


def _unequal(pairs: dict[str, tuple[Any, Any]]) -> Iterator[str]:
    for name, (said, wanted) in pairs.items():
        if said != wanted:
            yield f"$.{_differs(name, said, wanted)}"


def _differs(name: str, said: Any, wanted: Any) -> str:
    return f"{name}: is {said!r}, must be {wanted!r}"


def _some(numbers: FloatArray | Any) -> str:
    listed = ", ".join(str(number) for number in numbers[:_LISTED])
    more = f" and {len(numbers) - _LISTED} more" if len(numbers) > _LISTED else ""
    return f"sequence{'s' if len(numbers) > 1 else ''} {listed}{more}"
