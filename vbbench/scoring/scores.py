"""Scores a submission: errors of every scored row, each sequence's figures, and the split's."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import START_FRAMES
from vbbench.scoring.answers import Answers, CheckedSubmission, check_submission
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import PerSequence, Score, join_figures, mean_of_groups, summarise
from vbbench.scoring.scored_rows import ScoredRows, TruthRows


def score(
    submission: Path | str,
    dataset: Path | str,
    truth: Path | str | None = None,
    *,
    sequences: IntArray | None = None,
) -> Score:
    """Score a submission folder against its dataset.

    Raises SubmissionError with every fault of the submission; without truth, with those that can be seen without it;
    VbbenchError if the truth is not available, or there is nothing to score.

    Parameters
    ----------
    submission, dataset : the folders.
    truth : folder of the truth tables, if they are not in the dataset's folder.
    sequences : [N] numbers of the sequences to score; ``None`` for all. Others are only checked.
    """
    opened = Dataset(dataset, truth)
    if not opened.has_truth:
        check_submission(submission, opened)
    true_rows = TruthRows(opened)
    checked = CheckedSubmission(Path(submission), opened, true_rows)
    parts = list(scored_parts(checked, true_rows, counted=sequences))
    per_sequence = PerSequence.join([part.sequences for part in parts])
    if not len(per_sequence.sequence):
        raise VbbenchError(f"{dataset}: no sequence has a frame to score; generate longer sequences")
    reported = [part.fallbacks for part in parts if part.fallbacks is not None]
    return Score(
        info=checked.info,
        dataset=opened.info,
        protocol=checked.protocol,
        total_sequences=len(opened),
        fallback_frames=sum(reported) if reported else None,
        per_sequence=per_sequence,
        summaries=summarise(
            per_sequence.timeline,
            checked.protocol,
            per_sequence.figures,
            join_figures([part.frames for part in parts]),
        ),
    )


def score_sequence(submission: Path | str, dataset: Dataset, index: int) -> PerSequence:
    """The figures of one sequence, as `score` counts them; only its rows are read and checked.

    Raises SubmissionError with every fault of these rows; VbbenchError if there is no such sequence, no truth, or
    nothing to score.
    """
    dataset.sequence(index)
    truth = TruthRows(dataset)
    parts = scored_parts(CheckedSubmission(Path(submission), dataset, truth), truth, index)
    found = PerSequence.join([part.sequences for part in parts])
    if not len(found.sequence):
        raise VbbenchError(
            f"{dataset.folder}: sequence {index} does not have a frame to score; its first {START_FRAMES} are given"
        )
    return found


@dataclass(frozen=True, kw_only=True)
class ScoredPart:
    """The scores of some sequences.

    Parameters
    ----------
    sequences : their figures.
    frames : metric → [P] errors of the scored frames; means over people for metrics of people.
    fallbacks : number of frames whose pose is the solver's prior of the observer; ``None`` = not reported.
    """

    sequences: PerSequence
    frames: dict[str, FloatArray]
    fallbacks: int | None


def scored_parts(
    checked: CheckedSubmission, truth: TruthRows, only: int | None = None, *, counted: IntArray | None = None
) -> Iterator[ScoredPart]:
    """The scored sequences of a submission, some at a time; raises what `CheckedSubmission.chunks` raises.

    Parameters
    ----------
    checked, truth : the submission, and the truth.
    only : the only sequence to read; ``None`` for all.
    counted : [N] numbers of the sequences to score; ``None`` for all that are read.
    """
    for rows, answers in checked.chunks(only):
        yield _figures(*_counted(rows, answers, counted), truth, checked.dataset)


def _counted(rows: ScoredRows, answers: Answers, sequences: IntArray | None) -> tuple[ScoredRows, Answers]:
    """The scored rows and their answers of the given ``sequences`` [N]."""
    if sequences is None:
        return rows, answers
    poses, positions = np.isin(rows.pose_sequence, sequences), np.isin(rows.sequence, sequences)
    return rows.where(positions, poses), answers.where(positions, poses)


def _figures(rows: ScoredRows, answers: Answers, truth: TruthRows, dataset: Dataset) -> ScoredPart:
    true_poses = truth.poses(rows, answers.poses)
    true_positions = truth.positions(rows, true_poses)
    owner, count, size = rows.pose_of_position, len(rows.pose_sequence), len(rows.grid.frames)
    begin, end, seconds = _a_second_apart(rows, dataset.info.dt)
    poses, sequence = answers.poses, rows.pose_sequence - rows.grid.first
    # What a metric's function is called with, and to which scored pose each of its errors belongs.
    called: dict[str, tuple[tuple[FloatArray | float, ...], IntArray]] = {
        "frames": ((poses, true_poses), np.arange(count)),
        "people": ((answers.positions, poses[owner], true_positions, true_poses[owner]), owner),
        "seconds": ((poses[begin], poses[end], true_poses[begin], true_poses[end], seconds), begin),
    }
    frames, figures = {}, {}
    for name, metric in METRICS.items():
        arguments, pose = called[metric.over]
        errors = metric.function(*arguments) if truth.known in metric.known else np.full(len(pose), np.nan)
        frames[name] = mean_of_groups(pose, errors, count)
        figures[name] = mean_of_groups(sequence[pose], errors, size)
    fallbacks = None if answers.fallback is None else int(answers.fallback.sum())
    return ScoredPart(
        sequences=_per_sequence(rows, answers, figures, dataset),
        frames=frames,
        fallbacks=fallbacks,
    )


def _per_sequence(rows: ScoredRows, answers: Answers, figures: dict[str, FloatArray], dataset: Dataset) -> PerSequence:
    size = len(rows.grid.frames)
    scene, first_frame = (dataset.rows[name][rows.grid.first :][:size] for name in ("scene", "first_frame"))
    pose_owner, owner = rows.pose_sequence - rows.grid.first, rows.sequence - rows.grid.first
    every = PerSequence(
        sequence=np.arange(size) + rows.grid.first,
        scene=scene,
        first_frame=first_frame,
        last_frame=first_frame + rows.grid.frames - 1,
        frames=np.bincount(pose_owner, minlength=size),
        positions=np.bincount(owner, minlength=size),
        posed=np.bincount(pose_owner[answers.posed], minlength=size),
        placed=np.bincount(owner[answers.placed], minlength=size),
        figures=figures,
    )
    return every.select(every.frames > 0)


def _a_second_apart(rows: ScoredRows, dt: float) -> tuple[IntArray, IntArray, float]:
    """Pairs of scored poses [M] about a second apart: indices of the first and the second, and the exact time in s."""
    step = max(1, round(1.0 / dt))
    slot = rows.pose_slot
    end = np.searchsorted(slot, slot + step).clip(max=max(len(slot) - 1, 0))
    paired = (slot[end] == slot + step) & (rows.pose_sequence[end] == rows.pose_sequence)
    return np.flatnonzero(paired), end[paired], step * dt
