"""A split of footage: a reader of recordings, how they are cut into sequences, and what solvers are given of these."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.files.dataset_checks import PUBLIC, TRUTH_TABLES, Known
from vbbench.files.dataset_info import DatasetInfo, Pictures
from vbbench.files.tables import ODOMETRY_TABLE, TRACK_TABLE
from vbbench.generation.footage import FOOTAGE, Footage, FootageOptions, Recordings
from vbbench.generation.generator import Card, Options
from vbbench.geometry import BoolArray, FloatArray, IntArray, runs_of_true
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import NO_OBSERVER, NOBODY, Given, Odometry, Sequence, SequenceData, Truth

REVISION = 3
"""Raised whenever the same recordings give other sequences, so that dataset ids differ too."""

READ_BY_ALL = frozenset({"source", "seed", "limit", "sequences", "every", "longest"})
"""Options, and options of footage, that every split of footage reads."""

_ELSEWHERE = frozenset({"footage", "stride"})
"""Options that are no split's: one holds others, and `vbbench.generation.planning` refuses the other for footage."""

_IN_PARTS = {"simulation": "`scenario` or `people`"}
"""Options that messages name by what they hold."""


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


@dataclass(frozen=True, kw_only=True)
class FootageSplit(ABC):
    """Base of the splits of footage: a subclass reads the recordings.

    ``reads`` names the options, and options of footage, that a split reads; any other is an error.

    Parameters
    ----------
    card : source, licence and citation.
    every : one of so many frames is kept by default.
    rules : the rules by which frames become sequences.
    height_mean, height_std : prior N(μ_h, σ_h²) in m of people's heights that solvers are given.
    pixel_std : noise in px of a box's column, top and bottom that solvers are given.
    tilt_std, mount_height_std : standard deviations in rad and m of momentary pitch, roll and mount height about the
        calibration, which solvers are given; measured on planes through people's feet in KITTI.
    """

    reads: ClassVar[frozenset[str]] = READ_BY_ALL

    card: Card
    every: int = 1
    rules: RunRules = field(default_factory=RunRules)
    height_mean: float = 1.72
    height_std: float = 0.09
    pixel_std: float = 2.0
    tilt_std: float = 0.03
    mount_height_std: float = 0.16

    @abstractmethod
    def recordings(self, options: Options) -> Recordings:
        """Read the chosen recordings.

        Raises VbbenchError if a file is missing or invalid, or a name is unknown.
        """

    def plan(self, options: Options) -> FootageSequences:
        """Read the recordings and lay out the sequences.

        Raises VbbenchError if an option is set that the split does not read, or there is nothing to read.
        """
        self._refuse_others(options)
        return self.lay_out(self.recordings(options), options)

    def lay_out(self, found: Recordings, options: Options) -> FootageSequences:
        """Lay out the sequences of recordings that this split, or another caller, has read."""
        asked = options.footage or FootageOptions()
        every = asked.every or self.every
        rules = self.rules if asked.longest is None else replace(self.rules, longest=asked.longest)
        footage = tuple(one.thinned(every) for one in found.footage)
        other = next((one for one in footage if round(one.dt, 6) != round(footage[0].dt, 6)), None)
        if other is not None:
            times = " but ".join(f"{one.name} takes {one.dt:.6g} s a frame" for one in (footage[0], other))
            raise VbbenchError(f"{self.card.name}: {times}; make a dataset of each, named by --sequences")
        runs = [run for n, one in enumerate(footage) for run in find_runs(n, self.counted(one), rules)]
        runs = runs[: options.limit]
        if not runs:
            wanted = f"{rules.shortest} frames in a row, {every} apart, with {rules.fewest} people{self.counted_where}"
            raise VbbenchError(f"{self.card.name}: nowhere are there {wanted}; try another `every`")
        return FootageSequences(self._info(options, found, footage, runs, every, rules), footage, tuple(runs))

    @property
    def counted_where(self) -> str:
        """The end of an error message that states which boxes count for the rules; empty where all count."""
        return ""

    def counted(self, one: Footage) -> BoolArray:
        """[T, K] mask of the boxes that count for the rules: all, unless a subclass limits them."""
        return one.observed

    def _refuse_others(self, options: Options) -> None:
        """Raise VbbenchError if an option is set that the split does not read."""
        known = [
            (option.name, getattr(values, option.name) == option.default)
            for values in (options, options.footage or FootageOptions())
            for option in fields(values)
            if option.name not in _ELSEWHERE
        ]
        other = next((name for name, unasked in known if not unasked and name not in self.reads), None)
        if other is not None:
            *most, last = (f"`{name}`" for name, _ in known if name in self.reads)
            named = _IN_PARTS.get(other, f"`{other}`")
            raise VbbenchError(
                f"{self.card.name} is footage and does not read {named}; it reads {', '.join(most)} and {last}"
            )

    def _info(
        self,
        options: Options,
        found: Recordings,
        footage: tuple[Footage, ...],
        runs: list[Run],
        every: int,
        rules: RunRules,
    ) -> DatasetInfo:
        pictures = tuple(_pictures(footage[run.recording], run) for run in runs)
        longest = (options.footage or FootageOptions()).longest
        return DatasetInfo(
            split=self.card.name,
            title=self.card.title,
            camera=footage[0].camera,
            cameras=tuple(one.camera for one in footage),
            tier=FOOTAGE,
            seed=options.seed,
            dt=footage[0].dt,
            height_mean=found.height_mean or self.height_mean,
            height_std=self.height_std if found.height_std is None else found.height_std,
            pixel_std=self.pixel_std if found.pixel_std is None else found.pixel_std,
            tilt_std=self.tilt_std,
            mount_height_std=self.mount_height_std,
            carried_by=found.carried_by,
            box_edge=found.box_edge,
            scenes=tuple(one.name for one in footage),
            definition={
                "generator": f"footage/{REVISION}",
                "every": every,
                "limit": options.limit,
                **({} if longest is None else {"longest": longest}),
                "count_observer": False,
                "rules": asdict(rules),
                **found.definition,
            },
            caution=found.caution or self.card.caution,
            calibration=found.calibration,
            truth=least_known(footage),
            pictures=pictures if any(pictures) else (),
        )


def _pictures(one: Footage, run: Run) -> Pictures | None:
    if one.pictures is None:
        return None
    first = one.pictures.first + run.first * one.pictures.step
    return Pictures(pattern=one.pictures.pattern, first=first, step=one.pictures.step)


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
