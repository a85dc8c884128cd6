"""The plan of a dataset of footage: its runs of frames, and what solvers are given."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vbbench.errors import UnknownNameError
from vbbench.files.dataset_checks import PUBLIC, TRUTH_TABLES, Known
from vbbench.files.dataset_info import DatasetInfo, Pictures
from vbbench.files.tables import ODOMETRY_TABLE, TRACK_TABLE
from vbbench.generation.footage import Footage
from vbbench.geometry import BoolArray, FloatArray, IntArray, runs_of_true
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import NO_OBSERVER, NOBODY, Given, Odometry, Sequence, SequenceData, Truth


@dataclass(frozen=True, kw_only=True)
class RunRules:
    """The rules by which frames become sequences.

    Parameters
    ----------
    fewest : least number of people seen in every frame.
    shortest : least length of a run, in frames.
    longest : length in frames at which a run is cut; ``None`` = never.
    """

    fewest: int = 3
    shortest: int = 5
    longest: int | None = 40


class Run(NamedTuple):
    """Frames first ≤ frame < last of a recording."""

    recording: int
    first: int
    last: int


def find_runs(recording: int, observed: BoolArray, rules: RunRules) -> list[Run]:
    """The runs of a recording whose people are ``observed`` [T, K]."""
    runs = []
    for begin, end in runs_of_true(observed.sum(axis=1) >= rules.fewest).tolist():
        longest = rules.longest or end - begin
        runs += [Run(recording, first, min(first + longest, end)) for first in range(begin, end, longest)]
    return [run for run in runs if run.last - run.first >= rules.shortest]


def named(kind: str, names: Iterable[str] | None, known: Iterable[str]) -> list[str]:
    """Those of the ``known`` recordings that are named, each once, or all; an error calls them ``kind``."""
    there = list(known)
    for name in names or ():
        if name not in there:
            raise UnknownNameError(kind, name, there)
    return list(dict.fromkeys(names or there))


def pictures_in(folder: Path, name: str, first: int) -> Pictures | None:
    """The consecutive pictures in a folder, whatever its name, from number ``first`` on; ``None`` if it is not there.

    Parameters
    ----------
    name : of a picture in the form of `str.format`, such as ``{:06d}.png``.
    """
    if not folder.is_dir():
        return None
    whole = str(folder.absolute()).replace("{", "{{").replace("}", "}}")
    return Pictures(pattern=f"{whole}/{name}", first=first, step=1)


def laid_out(shape: tuple[int, int], at: tuple[IntArray, IntArray], values: FloatArray) -> FloatArray:
    """[T, K, …] ``values`` [N, …] of rows ``at`` frames [N] and columns [N], NaN elsewhere."""
    table = np.full((*shape, *values.shape[1:]), np.nan)
    table[at] = values
    return table


def medians(values: FloatArray, group: IntArray, count: int) -> FloatArray:
    """[count] median of the known ``values`` [N] of each group, NaN where there is none."""
    known = np.flatnonzero(~np.isnan(values))
    order = known[np.lexsort((values[known], group[known]))]
    groups, first, size = np.unique(group[order], return_index=True, return_counts=True)
    ordered, found = values[order], np.full(count, np.nan)
    found[groups] = 0.5 * (ordered[first + (size - 1) // 2] + ordered[first + size // 2])
    return found


@dataclass(frozen=True)
class FootageSequences:
    """See `vbbench.generation.generator.FootagePlan`; `info.cameras` has one camera for each recording.

    Parameters
    ----------
    runs : frames of each sequence.
    """

    info: DatasetInfo
    footage: tuple[Footage, ...]
    runs: tuple[Run, ...]

    def __len__(self) -> int:
        return len(self.runs)

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """The scene of each recording whose people have places."""
        return tuple(one.scene for one in self.footage if one.scene is not None) if self._people_known else ()

    @property
    def tables(self) -> tuple[str, ...]:
        """See `FootagePlan.tables`."""
        measured = any(one.odometry is not None for one in self.footage)
        return (
            *PUBLIC,
            *TRUTH_TABLES[self.info.truth],
            *([TRACK_TABLE] if self._people_known else []),
            *([ODOMETRY_TABLE] if measured else []),
        )

    @property
    def expected_rows(self) -> IntArray:
        """[N] number of boxes of each sequence."""
        return np.array([self.footage[run.recording].observed[run.first : run.last].sum() for run in self.runs])

    def build(self, index: int) -> SequenceData:
        """One sequence."""
        run = self.runs[index]
        one, frames = self.footage[run.recording], slice(run.first, run.last)
        positions, persons = self._people[run.recording]
        seen = one.observed[frames].any(axis=0)
        boxes, persons = one.boxes[frames, seen], persons[frames, seen]
        truth = Truth(
            poses=np.full((len(boxes), 3), np.nan) if one.poses is None else one.poses[frames],
            positions=positions[frames, seen],
            heights=_heights(one.scene, persons),
        )
        given = self._given(truth, ~np.isnan(boxes[..., 2]))
        if one.odometry is not None:
            odometry = Odometry.unmeasured(1).followed_by(one.odometry.frames(frames).frames(slice(1, None)))
            given = Given(poses=given.poses, positions=given.positions, odometry=odometry)
        sequence = Sequence(
            index=index,
            scene=run.recording,
            observer=NO_OBSERVER,
            first_frame=run.first,
            tracks=one.tracks[seen],
            observations=boxes,
            visible=one.visible[frames, seen],
            given=given,
            camera=run.recording,
        )
        return SequenceData(sequence=sequence, truth=truth, persons=persons if self._people_known else None)

    def _given(self, truth: Truth, observed: BoolArray) -> Given:
        """What `sequential` gives, if poses and places are known; else the first pose, as `cold-start` gives it."""
        if self.info.truth == "whole":
            return arrivals_given(truth, observed & ~np.isnan(truth.positions[..., 0]))
        poses = np.full(truth.poses.shape, np.nan)
        poses[0] = truth.poses[0] if self.info.truth == "poses" else 0.0
        return Given(poses=poses, positions=np.full(truth.positions.shape, np.nan))

    @property
    def _people_known(self) -> bool:
        return "truth/scenes" in TRUTH_TABLES[self.info.truth]

    @cached_property
    def _people(self) -> list[tuple[FloatArray, IntArray]]:
        return [one.positions() for one in self.footage]


def least_known(footage: tuple[Footage, ...]) -> Known:
    """What is known of every one of the recordings."""
    known = {one.known for one in footage}
    if len(known) == 1:
        return known.pop()
    if known <= {"whole", "poses"}:
        return "poses"
    return "none"


def _heights(scene: Scene | None, persons: IntArray) -> FloatArray:
    """[K] height in m of the first person behind each track [T, K], NaN if there is none or it is unknown."""
    heights = np.full(persons.shape[1], np.nan)
    frame, track = np.nonzero(persons != NOBODY)
    if scene is not None:
        column = np.searchsorted(scene.people, persons[frame, track])
        heights[track[::-1]] = scene.heights[column[::-1]]
    return heights
