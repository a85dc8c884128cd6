"""The result of scoring: figures of each sequence and of the split, as JSON, as text and as CSV."""

import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vbbench.errors import needs_extra
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.submission import SubmissionInfo
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.json_text import finite_or_none
from vbbench.protocol import Protocol
from vbbench.scoring.block_bootstrap import Timeline, block_means, is_enough
from vbbench.scoring.metrics import METRICS, Metric, section
from vbbench.table import best, csv_text, decimals

NAN = float("nan")


@dataclass(frozen=True, kw_only=True)
class Summary:
    """One metric over a split.

    Parameters
    ----------
    capped : mean over sequences of min(figure, cap of the protocol), by which boards rank.
    failure_rate : share of the sequences with a figure above the protocol's limit; NaN where it sets none.
    median, p95, mean, std : statistics over the sequences' uncapped figures.
    capped_ci95, ci95 : 95 % intervals of ``capped`` and ``mean`` by a block bootstrap over time; NaN where the
        sequences are too few or too long for one.
    frame_mean, frame_std : statistics over all frames of all sequences.
    blocks : number of blocks of the bootstrap.
    """

    capped: float = NAN
    capped_ci95: tuple[float, float] = (NAN, NAN)
    failure_rate: float = NAN
    median: float = NAN
    mean: float = NAN
    ci95: tuple[float, float] = (NAN, NAN)
    std: float = NAN
    p95: float = NAN
    frame_mean: float = NAN
    frame_std: float = NAN
    blocks: float = NAN

    def to_dict(self) -> dict[str, object]:
        """The summary, with ``None`` for NaN, as JSON needs it."""
        return {
            name: [finite_or_none(end) for end in value] if isinstance(value, tuple) else finite_or_none(value)
            for name, value in vars(self).items()
        }


def summarise(
    timeline: Timeline, protocol: Protocol, sequences: Mapping[str, FloatArray], frames: Mapping[str, FloatArray]
) -> dict[str, Summary]:
    """Summary of each metric.

    Parameters
    ----------
    timeline : times of the sequences.
    protocol : the protocol, with caps and limits.
    sequences : metric → [N] one figure per sequence, NaN where it has none.
    frames : metric → [F] one figure per frame, NaN likewise.
    """
    plain, capped = np.stack(list(sequences.values()), axis=1), capped_figures(protocol.caps, sequences)
    block = timeline.block_length(capped)
    means = block_means(timeline, np.concatenate([capped, plain], axis=1), block)
    bounds = [protocol.caps.get(name, np.inf) for name in sequences]
    largest = np.concatenate([bounds, np.max(np.nan_to_num(plain), axis=0)])
    intervals = [(low, high) for low, high in means.positive_interval(largest).tolist()]
    return {
        name: Summary(
            capped=float(means.mean[m]),
            capped_ci95=intervals[m],
            ci95=intervals[m + len(sequences)],
            failure_rate=_failure_rate(figures, protocol.failures.get(name)),
            blocks=means.blocks,
            **_plain(figures, known(frames[name])),
        )
        for m, (name, figures) in enumerate((name, known(values)) for name, values in sequences.items())
    }


def capped_figures(caps: Mapping[str, float], sequences: Mapping[str, FloatArray]) -> FloatArray:
    """[N, M] figures [N] of M metrics, limited to each metric's cap."""
    return np.stack([np.minimum(values, caps.get(name, np.inf)) for name, values in sequences.items()], axis=1)


def mean_of_groups(group: IntArray, values: FloatArray, groups: int) -> FloatArray:
    """Mean of values [R] over rows of the same group number [R] → [groups]; NaN for an empty group."""
    count = np.bincount(group, minlength=groups)
    mean = np.full(groups, np.nan)
    np.divide(np.bincount(group, values, groups), count, out=mean, where=count > 0)
    return mean


def known(values: FloatArray) -> FloatArray:
    """The values that are not NaN."""
    return values[~np.isnan(values)]


def _failure_rate(figures: FloatArray, limit: float | None) -> float:
    """Share of the figures, in float32 as result files have them, that are above the limit."""
    return NAN if limit is None or not len(figures) else float(np.mean(figures.astype(np.float32) > limit))


def _plain(figures: FloatArray, frames: FloatArray) -> dict[str, float]:
    if not len(figures):
        return {}
    return {
        "median": float(np.median(figures)),
        "mean": float(np.mean(figures)),
        "std": float(np.std(figures)),
        "p95": float(np.quantile(figures, 0.95)),
        "frame_mean": float(np.mean(frames)),
        "frame_std": float(np.std(frames)),
    }


Values = Mapping[str, Any]

NONE = "–"
_SUMMARIES = ("median", "mean", "p95", "std", "frame_mean", "failure_rate")

SHOWN_HEAD = (*(metric.label for metric in section("metrics").values()), "failed", "coverage", "µs/frame")
"""Heads of the columns for people."""

VALUES_HEAD = (
    *("sequences", "coverage", "seconds_per_frame"),
    *(f"{name}{part}" for name in METRICS for part in ("", "_low", "_high", *(f"_{one}" for one in _SUMMARIES))),
)
"""Names of the columns for programs: a metric's capped mean goes by the metric's name."""


def shown_cells(scores: Sequence[Values], groups: Sequence[object] = ()) -> list[list[str]]:
    """Cells [score][column] of `SHOWN_HEAD`: capped means with their intervals; each group's best in bold."""
    columns = [_errors([score["metrics"][name] for score in scores], groups) for name in section("metrics")]
    failed = [score["metrics"]["dx"]["failure_rate"] for score in scores]
    columns.append(best([NONE if rate is None else f"{rate:.1%}" for rate in failed], failed, groups))
    columns.append([f"{score['coverage']:.2%}".replace("100.00%", "100%") for score in scores])
    seconds = [score["seconds_per_frame"] for score in scores]
    columns.append([NONE if one is None else f"{1e6 * one:.0f}" for one in seconds])
    return [list(row) for row in zip(*columns, strict=True)]


def value_cells(score: Values) -> list[object]:
    """Cells of `VALUES_HEAD`: numbers in the unit of the metric, ``None`` where there is none."""
    cells: list[object] = [score["sequences"], score["coverage"], score["seconds_per_frame"]]
    for name, metric in METRICS.items():
        figures = score[metric.section][name]
        cells += [figures["capped"], *figures["capped_ci95"], *(figures[one] for one in _SUMMARIES)]
    return cells


def ranking_fact(protocol: Protocol) -> str:
    """A line that explains the columns of a table."""
    cap, turn, lost = protocol.caps["dx"], protocol.caps["dr"], protocol.failures["dx"]
    return (
        f"Capped means, by which boards rank: over sequences, of min(error, {cap:g} m or {turn:g} rad), with 95 % "
        f"intervals. Failed: sequences with a mean Δx above {lost:g} m. The best of a column is marked; 'vbbench "
        "compare' decides whether a difference is significant."
    )


def _errors(figures: Sequence[Values], groups: Sequence[object]) -> list[str]:
    """The cells of a metric's column."""
    values = [one["capped"] for one in figures]
    digits = decimals([value for value in values if value is not None])
    return best([_with_interval(one, digits) for one in figures], values, groups)


def _with_interval(figures: Values, digits: int) -> str:
    low, high = figures["capped_ci95"]
    if figures["capped"] is None:
        return NONE
    value = f"{figures['capped']:.{digits}f}"
    return value if low is None else f"{value} ({low:.{digits}f}–{high:.{digits}f})"


if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, kw_only=True)
class PerSequence:
    """Figures of every scored sequence.

    Parameters
    ----------
    sequence : [N] its number in the dataset.
    scene, first_frame, last_frame : [N] its scene, and its first and last frame there, scored or not.
    frames, positions : [N] scored poses and positions.
    posed, placed : [N] submitted poses and positions among these.
    figures : metric → [N] mean over the sequence's frames (or person-frames), NaN where it has none.
    """

    sequence: IntArray
    scene: IntArray
    first_frame: IntArray
    last_frame: IntArray
    frames: IntArray
    positions: IntArray
    posed: IntArray
    placed: IntArray
    figures: dict[str, FloatArray]

    def select(self, keep: BoolArray) -> "PerSequence":
        """Only the sequences marked in ``keep`` [N]."""
        counts = {name: values[keep] for name, values in vars(self).items() if name != "figures"}
        return PerSequence(**counts, figures={name: values[keep] for name, values in self.figures.items()})

    @staticmethod
    def join(parts: "list[PerSequence]") -> "PerSequence":
        """One table of several."""
        names = [field.name for field in fields(PerSequence) if field.name != "figures"]
        counts = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        return PerSequence(**counts, figures=join_figures([part.figures for part in parts]))

    @property
    def timeline(self) -> Timeline:
        """The times of the sequences."""
        return Timeline.of(self.scene, self.first_frame, self.last_frame)

    @property
    def coverage(self) -> FloatArray:
        """[N] share of scored rows that were submitted: of poses or of positions, whichever is smaller."""
        return np.minimum(_share(self.posed, self.frames), _share(self.placed, self.positions))

    @property
    def pose_coverage(self) -> float:
        """Share of all scored poses that were submitted."""
        return float(_share(self.posed.sum(), self.frames.sum()))

    @property
    def position_coverage(self) -> float:
        """Share of all scored positions that were submitted."""
        return float(_share(self.placed.sum(), self.positions.sum()))

    @property
    def total_coverage(self) -> float:
        """Share of all scored rows that were submitted: of poses or of positions, whichever is smaller."""
        return min(self.pose_coverage, self.position_coverage)


@dataclass(frozen=True, kw_only=True)
class Score:
    """A submission's score on a dataset.

    Parameters
    ----------
    info : what the submission declares.
    dataset : facts of the dataset.
    protocol : the protocol it was scored under.
    total_sequences : number of sequences in the dataset; those without a scored frame have no figures.
    fallback_frames : scored frames whose pose is the solver's prior of the observer; ``None`` = not reported.
    per_sequence : figures of each scored sequence.
    summaries : metric → figures of the split.
    """

    info: SubmissionInfo
    dataset: DatasetInfo
    protocol: Protocol
    total_sequences: int
    fallback_frames: int | None
    per_sequence: PerSequence
    summaries: dict[str, Summary]

    @property
    def sequences(self) -> int:
        """Number of scored sequences."""
        return len(self.per_sequence.sequence)

    @property
    def frames(self) -> int:
        """Number of scored frames."""
        return int(self.per_sequence.frames.sum())

    @property
    def coverage(self) -> float:
        """Share of all scored rows that were submitted: of poses or of positions, whichever is smaller."""
        return self.per_sequence.total_coverage

    def values(self) -> dict[str, Any]:
        """The score in the form of boards' results."""
        values: dict[str, Any] = {
            "dataset": self.info.dataset,
            "protocol": self.protocol.name,
            "protocol_version": self.protocol.version,
            "solver": self.info.solver,
            "solver_version": self.info.version,
            "split": self.dataset.split,
            "sequences": self.sequences,
            "sequences_in_dataset": self.total_sequences,
            "frames": self.frames,
            "positions": int(self.per_sequence.positions.sum()),
            "fallback_frames": self.fallback_frames,
            "coverage": self.coverage,
            "pose_coverage": self.per_sequence.pose_coverage,
            "position_coverage": self.per_sequence.position_coverage,
            "failure_policy": self.info.failure_policy,
            "seconds_per_frame": self.info.seconds_per_frame,
            "ranked_by": RANKED_BY,
            "metrics": {name: self.summaries[name].to_dict() for name in section("metrics")},
            "drift": {name: self.summaries[name].to_dict() for name in section("drift")},
        }
        notes = {"caution": self.dataset.caution, "truth": self.dataset.truth}
        return values | {name: note for name, note in notes.items() if note not in (None, "whole")}

    def published(self) -> dict[str, Any]:
        """`values` with more keys for other programs: ``capped_mean`` of each metric, and Δx's ``failure_rate``."""
        values = self.values()
        for part in ("metrics", "drift"):
            values[part] = {name: one | {"capped_mean": one["capped"]} for name, one in values[part].items()}
        return values | {"failure_rate": values["metrics"]["dx"]["failure_rate"]}

    def to_json(self) -> str:
        """`published` as text."""
        return json.dumps(self.published(), indent=2, ensure_ascii=False)

    def table(self) -> str:
        """The score as a text table, with the dataset's caution if it has one."""
        own = self.per_sequence
        rows = [
            self._line(name, own.position_coverage if metric.over == "people" else own.pose_coverage)
            for name, metric in METRICS.items()
        ]
        return "\n".join([*self._heading(), _HEADER, *rows, _RANKS, *self.notes()])

    def notes(self) -> Iterator[str]:
        """Notes on the figures: source of the intervals, the dataset's caution, unknown truth."""
        yield interval_note(self.per_sequence.timeline, self.summaries["dx"].blocks)
        if self.dataset.caution:
            yield f"Caution: {self.dataset.caution}"
        if self.dataset.truth != "whole":
            yield f"Figures without a number are not known: {_UNKNOWN[self.dataset.truth]}"

    def to_csv(self) -> str:
        """Figures of each sequence as CSV, NaN as an empty cell."""
        own = self.per_sequence
        names = ("sequence", "scene", "first_frame", "last_frame", "frames", "positions")
        heads = *(getattr(own, name).tolist() for name in names), own.coverage.tolist()
        figures = (own.figures[name].tolist() for name in METRICS)
        return csv_text((*names, "coverage", *METRICS), zip(*heads, *figures, strict=True))

    def to_pandas(self) -> "pandas.DataFrame":
        """Figures of each sequence, as in `to_csv`, indexed by the sequence's number; needs the extra ``pandas``.

        Raises MissingExtraError if pandas is not installed.
        """
        with needs_extra("pandas", "Score.to_pandas"):
            import pandas
        return pandas.read_csv(io.StringIO(self.to_csv()), index_col="sequence")

    def write_per_sequence(self, path: Path | str) -> None:
        """Write `to_csv` to a file, atomically."""
        write_text_atomically(Path(path), self.to_csv())

    def _line(self, name: str, coverage: float) -> str:
        metric, own = METRICS[name], self.summaries[name]
        failed = "" if np.isnan(own.failure_rate) else f"{own.failure_rate:.1%}"
        if np.isnan(own.capped):
            return f"{row_title(metric)}{NONE:>9}{NONE:>16}"
        over_frames = f"{_fitting(own.frame_mean, 9)} ±{_fitting(own.frame_std, 9)}"
        return (
            f"{row_title(metric)}{own.capped:>9.4f}{_interval_text(own.capped_ci95):>16}{failed:>8}"
            f"{_fitting(own.median, 8):>9}{_fitting(own.mean, 9):>10}{_fitting(own.std, 9):>10}{over_frames:>20}"
            f"{coverage:>10.2%}"
        )

    def _heading(self) -> list[str]:
        info, data = self.info, self.dataset
        sequences = f"{self.sequences} of {self.total_sequences} sequences scored"
        fallback = "" if self.fallback_frames is None else f" ({self.fallback_frames} by fallback)"
        speed = "" if info.seconds_per_frame is None else f", {1e3 * info.seconds_per_frame:.3g} ms per frame"
        return [
            f"{f'{info.solver} {info.version}'.strip()} on {data.split} ({data.camera.kind}, {data.tier}, seed "
            f"{data.spoken_seed}, {info.dataset}), {self.protocol.id}",
            f"{sequences}, {self.frames} frames{fallback}, {self.per_sequence.positions.sum()} positions{speed}; "
            f"missing rows: {info.failure_policy}",
        ]


def _fitting(value: float, width: int) -> str:
    """A figure in at most ``width`` characters, with fewer digits if it is large."""
    text = f"{value:.4f}"
    return text if len(text) <= width else f"{value:.2e}"


_UNKNOWN = {
    "poses": "where people really were was not measured.",
    "relative": "where the camera really was was not measured; Δx̃ is in the camera's own axes.",
}
"""What is missing where not everything is known of a dataset's truth."""

RANKED_BY = "capped"
"""The figure of a summary by which boards rank."""

_HEADER = (
    f"{'':<12}{'capped':>9}{'95 % interval':>16}{'failed':>8}{'median':>9}{'mean':>10}{'± std':>10}{'over frames':>20}"
    f"{'coverage':>10}"
)

_RANKS = (
    "Boards rank by 'capped': the mean over sequences of min(error, cap of the protocol). 'failed': share of sequences "
    "above the\nprotocol's limit. The other figures are not capped, and one runaway can decide them."
)


def interval_note(timeline: Timeline, blocks: float) -> str:
    """A note on the source of the intervals, or why there are none."""
    frames = f"{timeline.total:.0f} frames, the longest sequence {timeline.longest:.0f}"
    count = f"{blocks:.1f} blocks of {timeline.total / blocks:.0f} frames"
    if not is_enough(blocks, np.array(len(timeline.middle))):
        return (
            f"No intervals: {len(timeline.middle)} scored sequences ({count}) are too few for honest ones ({frames})."
        )
    return f"Intervals: block bootstrap over time, {count} ({frames})."


def _interval_text(ends: tuple[float, float]) -> str:
    low, high = ends
    return NONE if np.isnan(low) else f"{low:.4f}–{high:.4f}"


def row_title(metric: Metric) -> str:
    """Symbol and unit of a metric, padded to 12 columns of a terminal; a combining tilde takes none."""
    tildes = metric.symbol.count("\u0303")
    return f"{f'{metric.symbol:<{3 + tildes}} {metric.unit}':<{12 + tildes}}"


def join_figures(parts: list[dict[str, FloatArray]]) -> dict[str, FloatArray]:
    """Figures by metric of several parts, concatenated."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _share(part: Any, whole: Any) -> FloatArray:
    return np.where(np.asarray(whole) > 0, np.divide(part, np.maximum(whole, 1)), 1.0)
