"""A sequence with all that is to be recorded of it: what is seen, what is so, and what submissions say."""

from collections.abc import Sequence as Several
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.files.submission_rows import SubmittedEstimates
from vbbench.geometry import BoolArray, FloatArray
from vbbench.pictures.bystanders import unseen
from vbbench.protocol import get_protocol, scored_frames, scored_positions
from vbbench.scoring.metrics import frame_errors
from vbbench.sequence import Given, Sequence, Truth
from vbbench.solver import Estimate


@dataclass(frozen=True, kw_only=True)
class Answer:
    """A submission's answer to the sequence.

    Parameters
    ----------
    name : what it is called in the recording; no two are called the same.
    info : the submission's facts.
    estimate : its poses and positions, what was given filled in, NaN = no answer.
    given : what its protocol hands over.
    errors : [T] each of scored frames, by their key, NaN elsewhere; empty without truth.
    """

    name: str
    info: SubmissionInfo
    estimate: Estimate
    given: Given
    errors: dict[str, FloatArray]


@dataclass(frozen=True, kw_only=True)
class Take:
    """What is recorded; ``truth`` is ``None`` where it is withheld."""

    dataset: Dataset
    sequence: Sequence
    truth: Truth | None
    estimates: tuple[Answer, ...] = ()

    @cached_property
    def unseen(self) -> tuple[FloatArray, FloatArray]:
        """Positions [T, N, 2] in m of people without a box, NaN elsewhere, and heights [N] in m."""
        people, positions, heights = self.dataset.scene(self.sequence.scene)
        persons = self.dataset.track_persons(self.sequence)
        places = unseen(self.sequence, persons, people, positions)
        ever = np.isfinite(places[..., 0]).any(axis=0)
        known = np.where(np.isfinite(heights), heights, self.dataset.info.height_mean)
        return places[:, ever], known[ever]

    @cached_property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner [2] in m of what there is on the ground; wild estimates do not count."""
        sources = [self.sequence.given] if self.truth is None else [self.truth]
        guesses = [answer.estimate for answer in self.estimates] if self.truth is None else []
        there = self.sequence.observed
        places = np.concatenate([one.positions[there] for one in [*sources, *guesses]])
        poses = np.concatenate([one.poses[:, :2] for one in [*sources, *guesses]])
        points = np.concatenate([places, poses])
        low, high = np.nanpercentile(points, (1.0, 99.0) if guesses else (0.0, 100.0), axis=0)
        return low, high

    @cached_property
    def false_alarms(self) -> BoolArray:
        """[T, K] which boxes are known to show nobody."""
        if self.truth is None:
            return np.zeros(self.sequence.observed.shape, np.bool_)
        return np.asarray(self.sequence.observed & np.isnan(self.truth.positions[..., 0]))


def load_take(dataset: Dataset, index: int, submissions: Several[Path | str] = ()) -> Take:
    """Read a sequence, and the answers of submissions to it.

    Raises
    ------
    VbbenchError
        If there is no such sequence, or a submission cannot be read or answers another dataset.
    """
    sequence = dataset.sequence(index)
    truth = dataset.truth(sequence) if dataset.has_truth else None
    opened = [SubmittedEstimates(dataset, folder) for folder in submissions]
    names = _names([one.info for one in opened], [Path(folder).resolve().name for folder in submissions])
    answers = [_answer(name, one, sequence, truth) for name, one in zip(names, opened, strict=True)]
    return Take(dataset=dataset, sequence=sequence, truth=truth, estimates=tuple(answers))


def _answer(name: str, submitted: SubmittedEstimates, sequence: Sequence, truth: Truth | None) -> Answer:
    estimate = submitted.of(sequence)
    given = get_protocol(submitted.info.protocol).select_given(sequence.given)
    errors: dict[str, FloatArray] = {}
    if truth is not None:
        counted = scored_positions(sequence.observed, given)
        every = frame_errors(estimate.poses, estimate.positions, truth.poses, truth.positions, counted)
        errors = {key: np.where(scored_frames(sequence.observed), values, np.nan) for key, values in every.items()}
    return Answer(name=name, info=submitted.info, estimate=estimate, given=given, errors=errors)


def _names(infos: list[SubmissionInfo], folders: list[str]) -> list[str]:
    """The solver; where that is not enough with its protocol, else with the folder, and if need be with a number."""
    protocols = [f"{info.solver} {info.protocol}" for info in infos]
    solvers = [info.solver for info in infos]
    with_folder = [f"{name} ({folder})" for name, folder in zip(solvers, folders, strict=True)]
    for names in (solvers, protocols, with_folder):
        if len(set(names)) == len(names):
            return names
    return [f"{name} {number}" for number, name in enumerate(with_folder, 1)]
