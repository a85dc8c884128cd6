"""What solvers get in Table 4: centre lines with jitter, boxes of a tracker, and these linked by truth."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Options, Simulation
from vbbench.generation.planning import DerivedPlan
from vbbench.protocol import arrivals_given
from vbbench.sequence import NOBODY, SequenceData, Truth, held_persons

Kind = Literal["cline", "tracked", "linked"]


@dataclass(frozen=True, kw_only=True)
class Input:
    """One of the inputs.

    Parameters
    ----------
    kind : centre lines of people who show enough; boxes of a tracker; or these under the ids of the people.
    jitter : standard deviation in px of column, top and bottom of centre lines.
    least_track : fewest frames of a track that counts; ``None`` for the tracker's own.
    """

    kind: Kind
    jitter: float = 0.0
    least_track: int | None = None

    @property
    def name(self) -> str:
        """Of its folder."""
        if self.kind == "cline":
            return f"cline-{self.jitter:g}px"
        return self.kind if self.least_track is None else f"{self.kind}-{self.least_track}"

    @property
    def label(self) -> str:
        """As tables have it."""
        if self.kind == "cline":
            return f"cline, {self.jitter:g} px" if self.jitter else "cline, exact"
        rule = "" if self.least_track is None else f", {self.least_track} frames or more"
        return f"tracked{rule}" if self.kind == "tracked" else "tracked, true ids"

    def options(self, seed: int, sequences: int | None) -> Options:
        """What is asked of split `street`; ids are made true later (`linked_by_truth`)."""
        simulation = None if sequences is None else Simulation(sequences=sequences)
        if self.kind != "cline":
            return Options(tier="tracked", least_track=self.least_track, seed=seed, simulation=simulation)
        if self.jitter:
            return Options(tier="noisy", noise=self.jitter, seed=seed, simulation=simulation)
        return Options(seed=seed, simulation=simulation)


@dataclass(frozen=True)
class LinkedByTruth(DerivedPlan):
    """A plan's sequences as a tracker that never confuses anybody would give them.

    The boxes stay; each goes to the track of the person behind it, and those of nobody are gone.
    """

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts."""
        info = self.whole.info
        return replace(info, definition={**info.definition, "linked": "by truth"})

    def build(self, index: int) -> SequenceData:
        """One sequence."""
        return linked_by_truth(self.whole.build(index))


def linked_by_truth(data: SequenceData) -> SequenceData:
    """A tracked sequence with a track for each person; see `LinkedByTruth`.

    Raises
    ------
    VbbenchError
        If its tracks are no tracker's, or its scene is not its own.
    """
    if data.persons is None or data.scene is None:
        raise VbbenchError("only tracks of a simulated crowd can be linked by truth; take tier tracked of street")
    found, scene = data.sequence, data.scene
    frame, track = np.nonzero(found.observed & (data.persons != NOBODY))
    people, column = np.unique(data.persons[frame, track], return_inverse=True)
    shape = (found.frames, len(people))
    boxes, visible = np.full((*shape, 3), np.nan), np.full(shape, np.nan)
    boxes[frame, column], visible[frame, column] = found.observations[frame, track], found.visible[frame, track]
    observed = ~np.isnan(visible)
    persons = held_persons(np.broadcast_to(people, shape), observed)
    places = scene.positions[found.first_frame :][: found.frames, np.searchsorted(scene.people, people)]
    truth = Truth(
        poses=data.truth.poses,
        positions=np.where((persons == NOBODY)[..., None], np.nan, places),
        heights=scene.heights[np.searchsorted(scene.people, people)],
    )
    sequence = replace(
        found,
        tracks=np.arange(len(people)),
        observations=boxes,
        visible=visible,
        given=arrivals_given(truth, observed),
    )
    return replace(data, sequence=sequence, truth=truth, persons=persons)


@dataclass(frozen=True, kw_only=True)
class Counts:
    """What an input has: boxes, tracks and people, tracks that go over to somebody else, and boxes of nobody."""

    boxes: int = 0
    tracks: int = 0
    people: int = 0
    switches: int = 0
    nobody: int = 0

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(**{name: value + vars(other)[name] for name, value in vars(self).items()})


def count(dataset: Dataset) -> Counts:
    """Of all sequences."""
    return sum((_count(dataset, index) for index in range(len(dataset))), Counts())


def _count(dataset: Dataset, index: int) -> Counts:
    sequence = dataset.sequence(index)
    observed, persons = sequence.observed, dataset.track_persons(sequence)
    behind = [column[seen & (column != NOBODY)] for column, seen in zip(persons.T, observed.T, strict=True)]
    return Counts(
        boxes=int(observed.sum()),
        tracks=len(sequence.tracks),
        people=len(np.unique(np.concatenate(behind))),
        switches=sum(int(np.count_nonzero(np.diff(column))) for column in behind),
        nobody=int((observed & (persons == NOBODY)).sum()),
    )
