"""Errors of several submissions, over time and as cumulative distributions: the data of plots, also as JSON."""

import json
from collections.abc import Mapping
from collections.abc import Sequence as Several
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.submission import SubmissionInfo
from vbbench.files.submission_tables import info_of_answer, unique_names
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.json_text import finite_or_none
from vbbench.protocol import START_FRAMES, Protocol
from vbbench.scoring.answers import CheckedSubmission
from vbbench.scoring.metrics import METRICS, section
from vbbench.scoring.scorecard import PerSequence, Summary, interval_note, interval_text, join_figures, known, summarise
from vbbench.scoring.scored_rows import TruthRows
from vbbench.scoring.scores import scored_parts


@dataclass(frozen=True, kw_only=True)
class ErrorsInTime:
    """The errors of a submission, as `vbbench.scoring.score` counts them.

    Parameters
    ----------
    info, dataset, protocol : facts of the submission, its dataset and its protocol.
    only : the only sequence that is read; ``None`` = all.
    sequence, frame : [F] sequence and frame of each scored frame.
    answered : [F] whether every scored row of the frame was submitted; others are filled by the failure policy.
    frames : metric → [F] errors in the metric's unit, means over people where they are of people; NaN = none.
    per_sequence : figures and coverage of every scored sequence.
    """

    info: SubmissionInfo
    dataset: DatasetInfo
    protocol: Protocol
    only: int | None
    sequence: IntArray
    frame: IntArray
    answered: BoolArray
    frames: dict[str, FloatArray]
    per_sequence: PerSequence

    @property
    def seconds(self) -> FloatArray:
        """[F] time since the last frame that every protocol gives."""
        return np.round((self.frame - (START_FRAMES - 1)) * self.dataset.dt, 9)

    @property
    def coverage(self) -> float:
        """Share of all scored rows that were submitted: of poses or of positions, whichever is smaller."""
        return self.per_sequence.total_coverage

    def summaries(self) -> dict[str, Summary]:
        """Summaries of the split by metric, as in a score."""
        own = self.per_sequence
        return summarise(own.timeline, self.protocol, own.figures, self.frames)

    def samples(self, metric: str) -> FloatArray:
        """[N] figures of a metric for the cumulative distribution: of sequences, or of the frames of a single one."""
        return known(self.per_sequence.figures[metric] if self.only is None else self.frames[metric])


def errors_in_time(submission: Path | str, dataset: Dataset, only: int | None = None) -> ErrorsInTime:
    """The errors of a submission folder.

    Raises SubmissionError with every fault of the submission; VbbenchError if there is no such sequence, no truth, or
    nothing to score.

    Parameters
    ----------
    submission : the folder.
    dataset : its dataset, with truth.
    only : number of a single sequence, whose rows alone are then read and checked.
    """
    if only is not None:
        dataset.sequence(only)
    truth = TruthRows(dataset)
    checked = CheckedSubmission(Path(submission), dataset, truth)
    parts = list(scored_parts(checked, truth, only))
    per_sequence = PerSequence.join([part.sequences for part in parts])
    if not len(per_sequence.sequence):
        which = "no sequence has" if only is None else f"sequence {only} does not have"
        raise VbbenchError(f"{dataset.folder}: {which} a frame to score; its first {START_FRAMES} are given")
    return ErrorsInTime(
        info=checked.info,
        dataset=dataset.info,
        protocol=checked.protocol,
        only=only,
        sequence=np.concatenate([part.sequence for part in parts]),
        frame=np.concatenate([part.frame for part in parts]),
        answered=np.concatenate([part.answered for part in parts]),
        frames=join_figures([part.frames for part in parts]),
        per_sequence=per_sequence,
    )


@dataclass(frozen=True, kw_only=True)
class OverTime:
    """Errors by the time in s [S] since the last given frame: median and quartiles over ``sequences`` [S], a number.

    For a single sequence, median and quartiles are the errors themselves.
    """

    seconds: FloatArray
    median: FloatArray
    low: FloatArray
    high: FloatArray
    sequences: IntArray


def over_time(errors: ErrorsInTime, metric: str) -> OverTime:
    """The errors of a metric over the time since the last given frame."""
    there = np.isfinite(errors.frames[metric])
    order = np.argsort(errors.frame[there], kind="stable")
    values, seconds = errors.frames[metric][there][order], errors.seconds[there][order]
    moments, starts, counts = np.unique(seconds, return_index=True, return_counts=True)
    groups = np.split(values, starts[1:]) if len(moments) else []
    quartiles = np.array([np.quantile(group, (0.25, 0.5, 0.75)) for group in groups]).reshape(-1, 3)
    low, median, high = quartiles.T
    return OverTime(seconds=moments, median=median, low=low, high=high, sequences=counts)


def cumulative(samples: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The cumulative distribution of samples [N]: ascending errors [N], and the share [N] of samples up to each."""
    return np.sort(samples), np.arange(1, len(samples) + 1) / max(len(samples), 1)


FEW, FEWEST = 0.1, 0.05
"""Shares of the sequences: medians over time are drawn thin over fewer than the one, and end at the other."""


@dataclass(frozen=True, kw_only=True)
class ErrorTables:
    """Errors of submissions to one dataset.

    Parameters
    ----------
    names : names of the submissions, no two equal.
    errors : errors of each submission.
    metrics : the metrics that are shown.
    """

    names: tuple[str, ...]
    errors: tuple[ErrorsInTime, ...]
    metrics: tuple[str, ...]

    @property
    def only(self) -> int | None:
        """The single sequence that is shown; ``None`` = all."""
        return self.errors[0].only

    @property
    def dataset(self) -> DatasetInfo:
        """Facts of the dataset."""
        return self.errors[0].dataset

    @property
    def unit(self) -> str:
        """Name of a sample: a sequence, or a frame."""
        return "sequences" if self.only is None else "frames"

    @property
    def drawn_seconds(self) -> float:
        """Time in s up to which curves are drawn: until too few sequences are left."""
        ends = []
        for own in self.errors:
            moments, counts = np.unique(own.seconds, return_counts=True)
            ends.append(float(moments[counts >= FEWEST * counts.max()].max()))
        return 1.02 * max(ends)

    @cached_property
    def summaries(self) -> tuple[Mapping[str, Summary], ...]:
        """Summaries by metric of each submission; empty for a single sequence."""
        return tuple(own.summaries() if self.only is None else {} for own in self.errors)

    def capped(self, number: int, metric: str) -> tuple[float, tuple[float, float]]:
        """The capped mean of a submission, with its interval; of a single sequence the mean over frames, without."""
        if self.only is not None:
            return float(self.errors[number].per_sequence.figures[metric][0]), (np.nan, np.nan)
        own = self.summaries[number][metric]
        return own.capped, own.capped_ci95

    @property
    def title(self) -> str:
        """The title of the figures."""
        data = self.dataset
        tier = data.tier if data.pixel_std == 0 else f"{data.tier} (σ = {data.pixel_std:g} px)"
        which = [] if self.only is None else [f"sequence {self.only}"]
        return "  ·  ".join([f"errors on {data.split}", *which, data.camera.kind, tier])

    @property
    def facts(self) -> str:
        """A line with the number of sequences or frames, and the meaning of curves."""
        own = self.errors[0].per_sequence
        count = f"{len(own.sequence)} sequences, {own.frames.sum()} frames"
        if self.only is not None:
            marks = [f"{own.frames[0]} scored frames, dt = {self.dataset.dt:g} s"]
            marks += ["× filled, not answered"] if any(not each.answered.all() for each in self.errors) else []
            return ";  ".join(marks)
        time = f"lines: medians and middle half over sequences, thin where under {FEW:.0%} last, to {FEWEST:.0%}"
        return f"{count};  {time}"

    def notes(self) -> list[str]:
        """Cautions for readers of the figures."""
        notes = []
        if len({own.protocol.name for own in self.errors}) > 1:
            notes.append("Caution: made under different protocols, and so given different truth.")
        for name, own in zip(self.names, self.errors, strict=True):
            if own.coverage < 1.0:
                missing = f"{1.0 - own.coverage:.1%} of the rows of {name} are missing"
                notes.append(f"Caution: {missing}; they count as the last place known of the same person.")
        if self.only is None and np.isnan(self.capped(0, self.metrics[0])[1][0]):
            blocks = self.summaries[0][self.metrics[0]].blocks
            notes.append(interval_note(self.errors[0].per_sequence.timeline, blocks))
        shown = section("metrics").values()
        if unknown := [metric.symbol for metric in shown if self.dataset.truth not in metric.known]:
            notes.append(f"Not known of this dataset: {', '.join(unknown)}.")
        return [*notes, *([f"Caution: {self.dataset.caution}"] if self.dataset.caution else [])]

    def summary(self) -> tuple[list[str], list[list[str]]]:
        """Header and rows of a table: a row per submission with its means, failure rates and coverage."""
        first = "dx" if "dx" in self.metrics else self.metrics[0]
        kind = "mean" if self.only is not None else "capped"
        head = ["", "protocol", *(f"{kind} {METRICS[metric].label}" for metric in self.metrics), "answered"]
        failing = self.only is None and self.errors[0].protocol.failures.get(first) is not None
        if failing:
            head[-1:] = [f"failed in {METRICS[first].symbol}", "answered"]
        rows = []
        for n, (name, own) in enumerate(zip(self.names, self.errors, strict=True)):
            figures = [self._figure(n, metric) for metric in self.metrics]
            failed = [f"{self.summaries[n][first].failure_rate:.1%}"] if failing else []
            rows.append([name, own.protocol.name, *figures, *failed, f"{own.coverage:.1%}"])
        return head, rows

    def _figure(self, number: int, metric: str) -> str:
        mean, ends = self.capped(number, metric)
        text = "–" if np.isnan(mean) else f"{mean:.3f}"
        return text if np.isnan(ends[0]) else f"{text} ({interval_text(ends, '.3f')})"

    def values(self) -> dict[str, Any]:
        """Every number of the figure."""
        data = self.dataset
        which = {} if self.only is None else {"sequence": self.only}
        return {
            "dataset": data.id,
            "split": data.split,
            **which,
            "unit": self.unit,
            "notes": self.notes(),
            "submissions": [
                {
                    "name": name,
                    "solver": own.info.solver,
                    "protocol": own.protocol.name,
                    "coverage": own.coverage,
                    "metrics": {metric: self._curves(n, metric) for metric in self.metrics},
                }
                for n, (name, own) in enumerate(zip(self.names, self.errors, strict=True))
            ],
        }

    def _curves(self, number: int, metric: str) -> dict[str, Any]:
        own = self.errors[number]
        samples, line = own.samples(metric), over_time(own, metric)
        error, share = cumulative(samples)
        mean, ends = self.capped(number, metric)
        curves: dict[str, dict[str, Any]] = {
            "over_time": {
                "seconds": line.seconds.tolist(),
                "median": line.median.tolist(),
                "q25": line.low.tolist(),
                "q75": line.high.tolist(),
                "sequences": line.sequences.tolist(),
            },
            "cumulative": {"error": error.tolist(), "share": share.tolist()},
        }
        figures: dict[str, Any] = {"unit": METRICS[metric].unit}
        if self.only is None:
            summary = self.summaries[number][metric]
            figures |= {"cap": own.protocol.caps.get(metric), "failure_limit": own.protocol.failures.get(metric)}
            figures |= {"capped_mean": finite_or_none(mean), "ci95": [finite_or_none(end) for end in ends]}
            figures |= {"failure_rate": finite_or_none(summary.failure_rate)}
        else:
            figures["mean"] = finite_or_none(mean)
        return figures | curves

    def to_json(self) -> str:
        """`values` as text."""
        return json.dumps(self.values(), indent=1, ensure_ascii=False, allow_nan=False)


def error_tables(
    dataset: Dataset,
    submissions: Several[Path | str],
    *,
    only: int | None = None,
    metrics: Several[str] = (),
) -> ErrorTables:
    """The errors of submissions, scored as `vbbench.scoring.score` does.

    Raises SubmissionError with every fault of the first submission that has one; VbbenchError if a submission answers
    another dataset, there is no such sequence or metric, no truth, or nothing to score.

    Parameters
    ----------
    dataset : the dataset, with truth.
    submissions : folders that answer it, at least one.
    only : number of a single sequence.
    metrics : keys of `METRICS`; by default Δx̃, Δx, Δr and Δt, as far as they are known.
    """
    if not submissions:
        raise VbbenchError("name at least one submission")
    infos = [info_of_answer(dataset, folder) for folder in submissions]
    if unknown := [key for key in metrics if key not in METRICS]:
        raise UnknownNameError("metric", unknown[0], METRICS)
    known = [key for key, metric in METRICS.items() if dataset.info.truth in metric.known]
    wanted = list(dict.fromkeys(metrics)) or list(section("metrics"))
    shown = tuple(key for key in wanted if key in known)
    if not shown:
        raise VbbenchError(f"{dataset.folder}: its truth is too incomplete for {', '.join(wanted)}")
    errors = tuple(errors_in_time(folder, dataset, only) for folder in submissions)
    names = unique_names(infos, submissions)
    return ErrorTables(names=tuple(names), errors=errors, metrics=shown)
