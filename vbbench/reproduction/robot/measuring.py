"""Measures the experiment of a robot: every recording that is here, every solver and protocol, and references."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vbbench.errors import SourceMissingError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.submission_tables import SubmittedEstimates
from vbbench.files.tables import ODOMETRY_TABLE
from vbbench.folders.locks import loose_files
from vbbench.generation.generator import Plan, tables_of
from vbbench.geometry import FloatArray, moved_as_one
from vbbench.registry import load
from vbbench.reproduction.making import Making, submission_folder
from vbbench.reproduction.robot.drift import LENGTHS, Drift, dead_reckoning, distances, drift
from vbbench.reproduction.robot.silent import CameraAlone
from vbbench.reproduction.robot.study import Entrant, Recording, RobotStudy
from vbbench.scoring.scorecard import Summary
from vbbench.sequence import Sequence, Truth

JRDB_MISSING = (
    "jrdb is missing: everybody downloads it for themselves, from jrdb.erc.monash.edu. `vbbench reproduce figure-robot "
    "--jrdb FOLDER --bags FOLDER` measures it; rosbags tell how the robot moved"
)


@dataclass(frozen=True, kw_only=True)
class Row:
    """What a solver, or a reference, did in one recording under one protocol.

    Parameters
    ----------
    title : who.
    protocol : its name; "" for a reference, which no protocol changes.
    drifts : at each of `LENGTHS`.
    summaries : figures by metric; none for a reference, which places nobody.
    """

    title: str
    protocol: str
    drifts: tuple[Drift, ...]
    summaries: dict[str, Summary] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Example:
    """The sequence that is shown: the one in which the camera went farthest.

    Parameters
    ----------
    dataset, sequence, truth : it.
    ways : title → poses [T, 3] by it; NaN where nothing was estimated.
    people : title → positions [T, K, 2] in m, NaN likewise.
    """

    dataset: Dataset
    sequence: Sequence
    truth: Truth
    ways: dict[str, FloatArray]
    people: dict[str, FloatArray]


@dataclass(frozen=True, kw_only=True)
class Course:
    """One recording measured.

    Parameters
    ----------
    recording : which.
    metres : [N] gone in each sequence.
    rows : references first, then solvers under every protocol.
    example : what is shown of it.
    """

    recording: Recording
    metres: FloatArray
    rows: tuple[Row, ...]
    example: Example


@dataclass(frozen=True, kw_only=True)
class Robot:
    """What the study found: recordings, and why others are missing."""

    study: RobotStudy
    courses: tuple[Course, ...]
    missing: tuple[str, ...]


def measure_robot(study: RobotStudy, out: Path | str, making: Making = Making()) -> Robot:  # noqa: B008
    """Generate, solve and score every recording that is here.

    Datasets and submissions are kept in ``out``; complete ones are reused.

    Raises
    ------
    VbbenchError
        If the study is invalid, or another dataset or submission is in the way.
    """
    study.check()
    out, courses, missing = Path(out), list[Course](), list[str]()
    with loose_files(out):
        for recording in study.recordings():
            try:
                planned = load("generator", recording.split).plan(recording.options)
            except SourceMissingError as error:
                missing.append(f"{recording.name} is missing: {error}")
                continue
            courses.append(_Measuring(study, recording, out / recording.name, making).course(planned))
    if study.jrdb is None:
        missing.append(JRDB_MISSING)
    return Robot(study=study, courses=tuple(courses), missing=tuple(missing))


@dataclass(frozen=True)
class _Measuring:
    """The work on one recording, in the folder ``out``."""

    study: RobotStudy
    recording: Recording
    out: Path
    making: Making

    def course(self, planned: Plan) -> Course:
        """Everything about the recording that ``planned`` makes."""
        whole = self.making.dataset(self.recording.split, self.out / "whole" / "dataset", self.recording.options)
        if whole.info.truth != "whole":
            raise VbbenchError(f"{self.recording.name}: its poses are not known, and no drift can be measured")
        alone = whole
        if ODOMETRY_TABLE in tables_of(planned):
            alone = self.making.planned(CameraAlone(planned), self.out / "camera-alone" / "dataset")
        truths = [whole.truth(sequence) for sequence in whole.sequences()]
        metres = np.array([distances(truth.poses)[-1] for truth in truths])
        shown = int(metres.argmax())
        ways, people = dict[str, FloatArray](), dict[str, FloatArray]()
        rows = list[Row]()
        reference = self._reference(whole)
        if reference:
            rows.append(Row(title=self.recording.reference, protocol="", drifts=_drifts(reference, truths)))
            ways[self.recording.reference] = reference[shown]
        for entrant, protocol, dataset in self._runs(whole, alone):
            row, way, places = self._solved(entrant, protocol, dataset, truths, shown)
            rows.append(row)
            if protocol == self.study.protocols[0]:
                ways[entrant.title], people[entrant.title] = way, places
        sequence = whole.sequence(shown)
        example = Example(dataset=whole, sequence=sequence, truth=truths[shown], ways=ways, people=people)
        return Course(recording=self.recording, metres=metres, rows=tuple(rows), example=example)

    def _runs(self, whole: Dataset, alone: Dataset) -> Iterator[tuple[Entrant, str, Dataset]]:
        """Solvers with protocol and dataset; those with odometry only where there is any."""
        for protocol in self.study.protocols:
            for entrant in self.study.entrants:
                if not entrant.odometry or whole is not alone:
                    yield entrant, protocol, whole if entrant.odometry else alone

    def _solved(
        self, entrant: Entrant, protocol: str, dataset: Dataset, truths: list[Truth], shown: int
    ) -> tuple[Row, FloatArray, FloatArray]:
        """A solver's row, and its poses [T, 3] and positions [T, K, 2] in the sequence that is ``shown``."""
        ((_, found),) = self.making.scores(dataset, [entrant.solver], protocol)
        submitted = SubmittedEstimates(dataset, submission_folder(dataset, entrant.solver, protocol))
        answers = [submitted.of(sequence) for sequence in dataset.sequences()]
        drifts = _drifts([answer.poses for answer in answers], truths)
        row = Row(title=entrant.title, protocol=protocol, drifts=drifts, summaries=found.summaries)
        return row, answers[shown].poses, answers[shown].positions

    def _reference(self, whole: Dataset) -> list[FloatArray]:
        """Of each sequence, the poses [T, 3] that somebody measured without looking at people; none where nobody did.

        NaN where that is the truth itself.
        """
        sequences = list(whole.sequences())
        truths = [whole.truth(sequence).poses for sequence in sequences]
        if self.recording.other is None:
            measured = [(one.given.odometry, truth[0]) for one, truth in zip(sequences, truths, strict=True)]
            return [dead_reckoning(moved, start) for moved, start in measured if moved is not None]
        other = self.making.dataset(self.recording.split, self.out / "other" / "dataset", self.recording.other)
        ways = [other.truth(sequence).poses for sequence in sequences]
        pairs = list(zip(ways, truths, strict=True))
        return [
            np.full(way.shape, np.nan) if np.array_equal(way, own) else moved_as_one(way, way[0], own[0])
            for way, own in pairs
        ]


def _drifts(ways: list[FloatArray], truths: list[Truth]) -> tuple[Drift, ...]:
    pairs = [(way, truth.poses) for way, truth in zip(ways, truths, strict=True)]
    return tuple(drift(pairs, length) for length in LENGTHS)
