"""The errors behind a score: of every scored frame and every sequence, for pictures that show when and how often."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.submission import SubmissionInfo
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import START_FRAMES, Protocol
from vbbench.scoring.answers import CheckedSubmission
from vbbench.scoring.scorecard import PerSequence, join_figures
from vbbench.scoring.scores import scored_parts
from vbbench.scoring.statistics import Summary, known, summarise
from vbbench.scoring.truth import TruthRows


@dataclass(frozen=True, kw_only=True)
class ErrorsInTime:
    """The errors of a submission, as `vbbench.scoring.score` counts them.

    Parameters
    ----------
    info, dataset, protocol : what they are of.
    only : the one sequence they are of; ``None`` = all.
    sequence, frame : [F] which frames were scored.
    answered : [F] whether every scored row of the frame was submitted; others are filled by the failure policy.
    frames : metric → [F] errors in the metric's unit, means over people where they are of people; NaN = none.
    per_sequence : figures of every scored sequence, and how much of it was submitted.
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
        """Metric → figures of the split, as a score has them."""
        own = self.per_sequence
        return summarise(own.timeline, self.protocol, own.figures, self.frames)

    def samples(self, metric: str) -> FloatArray:
        """[N] the figures that are compared: of sequences, or of the frames of the only one."""
        return known(self.per_sequence.figures[metric] if self.only is None else self.frames[metric])


def errors_in_time(submission: Path | str, dataset: Dataset, only: int | None = None) -> ErrorsInTime:
    """The errors of a submission folder.

    Parameters
    ----------
    submission : the folder.
    dataset : what it answers, with its truth.
    only : number of the one sequence that is wanted; its rows alone are then read and checked.

    Raises
    ------
    SubmissionError
        With every fault of the submission.
    VbbenchError
        If there is no such sequence, no truth, or nothing to score.
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
    """Errors of the frames so many ``seconds`` [S] after the given ones: median and middle half over sequences.

    ``sequences`` [S] says over how many; of one sequence, its errors are their own medians and quartiles.
    """

    seconds: FloatArray
    median: FloatArray
    low: FloatArray
    high: FloatArray
    sequences: IntArray


def over_time(errors: ErrorsInTime, metric: str) -> OverTime:
    """A metric's errors over the time since the given frames."""
    there = np.isfinite(errors.frames[metric])
    order = np.argsort(errors.frame[there], kind="stable")
    values, seconds = errors.frames[metric][there][order], errors.seconds[there][order]
    moments, starts, counts = np.unique(seconds, return_index=True, return_counts=True)
    groups = np.split(values, starts[1:]) if len(moments) else []
    quartiles = np.array([np.quantile(group, (0.25, 0.5, 0.75)) for group in groups]).reshape(-1, 3)
    low, median, high = quartiles.T
    return OverTime(seconds=moments, median=median, low=low, high=high, sequences=counts)


def cumulative(samples: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Errors [N], ascending, and the share [N] of the samples [N] that are not above each."""
    return np.sort(samples), np.arange(1, len(samples) + 1) / max(len(samples), 1)


QUANTILES = {"p5": 0.05, "q25": 0.25, "median": 0.5, "q75": 0.75, "p95": 0.95}
"""What a box and its whiskers show."""


def spread(samples: FloatArray) -> dict[str, float]:
    """The `QUANTILES` of samples [N]; NaN without any."""
    if not len(samples):
        return dict.fromkeys(QUANTILES, float("nan"))
    return dict(zip(QUANTILES, np.quantile(samples, list(QUANTILES.values())).tolist(), strict=True))


def outside_whiskers(samples: FloatArray) -> FloatArray:
    """The samples [M] of [N] that lie beyond the whiskers of `spread`, ascending."""
    box = spread(samples)
    return np.sort(samples[(samples < box["p5"]) | (samples > box["p95"])])
