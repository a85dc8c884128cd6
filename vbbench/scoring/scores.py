"""Scores a submission: errors of every scored row, each sequence's figures, and the split's."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.geometry import BoolArray, FloatArray
from vbbench.scoring import metrics
from vbbench.scoring.matched_rows import Answers
from vbbench.scoring.scorecard import PerSequence, Score, join_figures
from vbbench.scoring.scored_rows import ScoredRows
from vbbench.scoring.statistics import mean_of_groups, summarise
from vbbench.scoring.truth_rows import TruthRows
from vbbench.scoring.validation import CheckedSubmission


def score(submission: Path | str, dataset: Path | str, truth: Path | str | None = None) -> Score:
    """Score a submission folder against its dataset.

    Parameters
    ----------
    submission, dataset : the folders.
    truth : folder with the truth tables, where it is kept elsewhere.

    Raises
    ------
    SubmissionError
        With every fault of the submission.
    VbbenchError
        If the truth is not at hand, or there is nothing to score.
    """
    opened = Dataset(dataset, truth)
    true_rows = TruthRows(opened)
    checked = CheckedSubmission(Path(submission), opened, true_rows)
    parts = [_figures(rows, answers, true_rows, opened.info.dt) for rows, answers in checked.chunks()]
    per_sequence = PerSequence.join([part.sequences for part in parts])
    if not len(per_sequence.sequence):
        raise VbbenchError(f"{dataset}: no sequence has a frame to score; generate longer sequences")
    return Score(
        info=checked.info,
        dataset=opened.info,
        protocol=checked.protocol,
        total_sequences=len(opened),
        fallback_frames=_total([part.fallbacks for part in parts]),
        per_sequence=per_sequence,
        summaries=summarise(per_sequence.figures, join_figures([part.frames for part in parts])),
    )


@dataclass(frozen=True)
class _Part:
    """Figures of some sequences, and by metric of their scored frames [P]; how many of these fell back."""

    sequences: PerSequence
    frames: dict[str, FloatArray]
    fallbacks: int | None


def _figures(rows: ScoredRows, answers: Answers, truth: TruthRows, dt: float) -> _Part:
    true_poses = truth.poses(rows)
    errors = _person_errors(rows, answers, truth, true_poses)
    owner, count = rows.pose_of_position, len(rows.pose_sequence)
    pose_figures = {
        "dr": metrics.rotation_error(answers.poses, true_poses),
        "dt": metrics.translation_error(answers.poses, true_poses),
    }
    paired, drifts = _drifts(rows, answers.poses, true_poses, dt)
    frames = {
        **pose_figures,
        **{name: mean_of_groups(owner, error, count) for name, error in errors.items()},
        **{name: _spread(paired, values) for name, values in drifts.items()},
    }
    fallbacks = None if answers.fallback is None else int(answers.fallback.sum())
    local, size = rows.pose_sequence - rows.grid.first, len(rows.grid.frames)
    figures = {
        **{name: mean_of_groups(local, values, size) for name, values in pose_figures.items()},
        **{name: mean_of_groups(rows.sequence - rows.grid.first, error, size) for name, error in errors.items()},
        **{name: mean_of_groups(local[paired], values, size) for name, values in drifts.items()},
    }
    return _Part(_per_sequence(rows, answers, figures), frames, fallbacks)


def _total(counts: list[int | None]) -> int | None:
    known = [count for count in counts if count is not None]
    return sum(known) if known else None


def _person_errors(
    rows: ScoredRows, answers: Answers, truth: TruthRows, true_poses: FloatArray
) -> dict[str, FloatArray]:
    """[Q] position errors of each scored position."""
    owner = rows.pose_of_position
    true_positions = truth.positions(rows, truth.persons(rows))
    return {
        "dx": metrics.position_error(answers.positions, true_positions),
        "dx_rel": metrics.relative_position_error(
            answers.positions, answers.poses[owner], true_positions, true_poses[owner]
        ),
    }


def _per_sequence(rows: ScoredRows, answers: Answers, figures: dict[str, FloatArray]) -> PerSequence:
    size = len(rows.grid.frames)
    pose_owner, owner = rows.pose_sequence - rows.grid.first, rows.sequence - rows.grid.first
    return PerSequence(
        sequence=np.arange(size) + rows.grid.first,
        frames=np.bincount(pose_owner, minlength=size),
        positions=np.bincount(owner, minlength=size),
        posed=np.bincount(pose_owner[answers.posed], minlength=size),
        placed=np.bincount(owner[answers.placed], minlength=size),
        figures=figures,
    ).scored()


def _drifts(
    rows: ScoredRows, poses: FloatArray, true_poses: FloatArray, dt: float
) -> tuple[BoolArray, dict[str, FloatArray]]:
    """[P] which scored frames are followed by a scored one a second later, and of these the drift to it."""
    step = max(1, round(1.0 / dt))
    slot = rows.pose_slot
    end = np.searchsorted(slot, slot + step).clip(max=max(len(slot) - 1, 0))
    paired = (slot[end] == slot + step) & (rows.pose_sequence[end] == rows.pose_sequence)
    begin, end = np.flatnonzero(paired), end[paired]
    values = metrics.drift(poses[begin], poses[end], true_poses[begin], true_poses[end], step * dt)
    return paired, dict(zip(("drift_m", "drift_rad"), values, strict=True))


def _spread(where: BoolArray, values: FloatArray) -> FloatArray:
    spread = np.full(len(where), np.nan)
    spread[where] = values
    return spread
