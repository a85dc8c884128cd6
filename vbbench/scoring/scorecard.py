"""The result of scoring: figures of each sequence and of the split, as JSON, as text and as CSV."""

import csv
import io
import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vbbench.errors import needs_extra
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.submission import SubmissionInfo
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import Protocol
from vbbench.scoring.metrics import METRICS, Metric, section
from vbbench.scoring.statistics import Summary

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, kw_only=True)
class PerSequence:
    """Figures of every scored sequence.

    Parameters
    ----------
    sequence : [N] its number in the dataset.
    frames, positions : [N] scored poses and positions.
    posed, placed : [N] how many of them were submitted.
    figures : metric → [N] mean over the sequence's frames (or person-frames), NaN where it has none.
    """

    sequence: IntArray
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
    total_sequences : in the dataset; those without a scored frame have no figures.
    fallback_frames : scored frames in which the observer's own prior decided; ``None`` = not reported.
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
        """The score as the command line prints it with ``--json``."""
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
            "metrics": {name: self.summaries[name].to_dict() for name in section("metrics")},
            "drift": {name: self.summaries[name].to_dict() for name in section("drift")},
        }
        notes = {"caution": self.dataset.caution, "truth": self.dataset.truth}
        return values | {name: note for name, note in notes.items() if note not in (None, "whole")}

    def to_json(self) -> str:
        """`values` as text."""
        return json.dumps(self.values(), indent=2, ensure_ascii=False)

    def table(self) -> str:
        """The score as a table for people, with the dataset's caution if it has one."""
        own = self.per_sequence
        rows = [
            _line(metric, self.summaries[name], own.position_coverage if metric.over == "people" else own.pose_coverage)
            for name, metric in METRICS.items()
        ]
        notes = [f"Caution: {self.dataset.caution}"] if self.dataset.caution else []
        if self.dataset.truth != "whole":
            notes.append(f"Figures without a number are not known: {_UNKNOWN[self.dataset.truth]}")
        return "\n".join([*self._heading(), _HEADER, *rows, *notes])

    def to_csv(self) -> str:
        """Figures of each sequence as CSV, NaN as an empty cell."""
        own = self.per_sequence
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["sequence", "frames", "positions", "coverage", *METRICS])
        heads = own.sequence, own.frames, own.positions, own.coverage.tolist()
        figures = (own.figures[name].tolist() for name in METRICS)
        for *head, values in zip(*heads, zip(*figures, strict=True), strict=True):
            writer.writerow([*head, *("" if np.isnan(value) else repr(value) for value in values)])
        return text.getvalue()

    def to_pandas(self) -> "pandas.DataFrame":
        """Figures of each sequence, as `to_csv` has them, the sequence's number as index; needs the extra ``pandas``.

        Raises
        ------
        MissingExtraError
            If pandas is not installed.
        """
        with needs_extra("pandas", "Score.to_pandas"):
            import pandas
        return pandas.read_csv(io.StringIO(self.to_csv()), index_col="sequence")

    def write_per_sequence(self, path: Path | str) -> None:
        """Write `to_csv` to a file, whole or not at all."""
        write_text_atomically(Path(path), self.to_csv())

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


_UNKNOWN = {
    "poses": "where people really were was not measured.",
    "relative": "where the camera really was was not measured; Δx̃ is in the camera's own axes.",
}
"""What is missing where not everything is known of a dataset's truth."""

_HEADER = (
    f"{'':<12}{'mean':>9}{'± std':>9}{'95 % interval':>18}{'median':>9}{'p95':>9}{'over frames':>18}{'coverage':>10}"
)


def _line(metric: Metric, summary: Summary, coverage: float) -> str:
    interval = f"{summary.ci95[0]:.4f}–{summary.ci95[1]:.4f}"
    frames = f"{summary.frame_mean:.4f} ±{summary.frame_std:.4f}"
    return (
        f"{row_title(metric)}{summary.mean:>9.4f}{summary.std:>9.4f}{interval:>18}{summary.median:>9.4f}"
        f"{summary.p95:>9.4f}{frames:>18}{coverage:>10.2%}"
    )


def row_title(metric: Metric) -> str:
    """Symbol and unit of a metric, 12 columns wide on a terminal, where a combining tilde takes no column."""
    tildes = metric.symbol.count("\u0303")
    return f"{f'{metric.symbol:<{3 + tildes}} {metric.unit}':<{12 + tildes}}"


def join_figures(parts: list[dict[str, FloatArray]]) -> dict[str, FloatArray]:
    """Figures by metric of several parts, concatenated."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _share(part: Any, whole: Any) -> FloatArray:
    return np.where(np.asarray(whole) > 0, np.divide(part, np.maximum(whole, 1)), 1.0)
