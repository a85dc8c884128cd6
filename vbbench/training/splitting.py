"""Which sequences of a dataset train, which validate and which test: official lists that are the same for everybody."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.footage import FOOTAGE
from vbbench.geometry import BoolArray, IntArray, freeze
from vbbench.parsing.toml_text import read_bundled

SHARES = (0.7, 0.15, 0.15)
"""The people of a recording who are wanted for training, validation and test."""
GAP = 4.0
"""Least time in s between two parts: who leaves still decides how those walk who come."""
LEAST_KEPT = 0.5
"""The people of a recording who must lie in a part, or it is not cut: in a dense one a person always stays."""
FINEST = 1000
"""Most places in a recording where a cut is tried."""


class Cuts(NamedTuple):
    """Frames of a recording: training before ``train_end``, validation in between, test from ``test_begin`` on."""

    train_end: int
    validation_begin: int
    validation_end: int
    test_begin: int

    def part_of(self, first: IntArray, last: IntArray) -> IntArray:
        """[N] 0, 1 or 2 for runs of frames first ≤ t < last [N] that lie whole in a part, −1 for the others."""
        within = (last <= self.train_end, (first >= self.validation_begin) & (last <= self.validation_end))
        return np.select([*within, first >= self.test_begin], [0, 1, 2], -1)


def find_cuts(present: BoolArray, dt: float) -> Cuts | None:
    """The cuts that leave each part as many people as can be, at `SHARES`.

    A person counts for a part who is there from the first to the last frame of the person's presence. Between two parts
    lies a gap: nobody who is there before it is there after it, and it lasts `GAP` or longer. Of all such cuts, those
    are taken whose smallest part, by its share, is largest; of equal ones those that keep most people, the earliest.

    Parameters
    ----------
    present : [T, P] who is there.
    dt : seconds per frame.

    Returns
    -------
    The cuts; ``None`` if a part would have nobody, or all together less than `LEAST_KEPT` of the people.
    """
    frames, present = len(present), present[:, present.any(axis=0)]
    enter, leave = present.argmax(axis=0), frames - present[::-1].argmax(axis=0)
    places = np.unique([*range(0, frames, max(1, -(-frames // FINEST))), frames])
    resume = _resume(enter, leave, places, frames, max(1, round(GAP / dt)))
    inside = _people_inside(enter, leave, places)
    train, following = inside[0], np.minimum(np.searchsorted(places, resume), len(places) - 1)
    validation = inside[following]  # [train's end, validation's end]
    test = inside[following, -1]
    smallest = np.minimum(np.minimum(train[:, None] / SHARES[0], validation / SHARES[1]), test[None] / SHARES[2])
    best = np.argwhere(smallest == smallest.max())
    kept = [train[i] + validation[i, j] + test[j] for i, j in best]
    i, j = best[int(np.argmax(kept))]
    if smallest[i, j] <= 0.0 or max(kept) < LEAST_KEPT * present.shape[1]:
        return None
    return Cuts(*(int(places[n]) for n in (i, following[i], j, following[j])))


def _resume(enter: IntArray, leave: IntArray, places: IntArray, frames: int, gap: int) -> IntArray:
    """[C] the first frame after a gap that begins at each of the ``places`` [C]: everybody from before it has left."""
    stays = np.zeros(frames + 1, np.int64)
    np.maximum.at(stays, enter + 1, leave)
    return np.maximum(np.maximum.accumulate(stays)[places], places + gap)


def _people_inside(enter: IntArray, leave: IntArray, places: IntArray) -> IntArray:
    """[C, C] people who are only there from one of the ``places`` [C] until another one."""
    counts = np.zeros((len(places), len(places)), np.int64)
    begins = np.searchsorted(places, enter, side="right") - 1
    ends = np.searchsorted(places, leave)
    np.add.at(counts, (begins, ends), 1)
    inside: IntArray = counts[::-1].cumsum(axis=0)[::-1].cumsum(axis=1)
    return inside


By = Literal["time", "recording", "seed"]
"""How sequences are shared out."""
NAMES = ("train", "validation", "test")
VERSIONS: Mapping[str, int] = {"time": 1, "recording": 1, "seed": 1}
"""Raised whenever a rule gives other lists."""
OFFICIAL_SEEDS = {"test": 0, "validation": 1}
"""Seeds of simulated splits that are not for training: boards are made with 0."""


@dataclass(frozen=True, kw_only=True)
class Parts:
    """The sequences of a dataset that train, validate and test. No two parts share a moment, a person or a scene.

    Parameters
    ----------
    split, dataset : name of the split and id of the dataset.
    rule : name and version of the rule, such as ``time/1``; with the recording that tests, if it was named.
    train, validation, test : [N] numbers of sequences, ascending; each may be empty.
    left_out : [N] sequences of no part: those that lie in a gap or reach from one part into another.
    """

    split: str
    dataset: str
    rule: str
    train: IntArray
    validation: IntArray
    test: IntArray
    left_out: IntArray

    def __post_init__(self) -> None:
        freeze(self, np.int64, **dict.fromkeys((*NAMES, "left_out"), (None,)))

    @property
    def sha256(self) -> str:
        """SHA-256 of rule and lists: the same for every tier and camera of a recording."""
        return hashlib.sha256(json.dumps({"rule": self.rule, **self._lists()}, sort_keys=True).encode()).hexdigest()

    def to_json(self) -> str:
        """Everything as JSON."""
        facts: dict[str, Any] = {"split": self.split, "dataset": self.dataset, "rule": self.rule, "sha256": self.sha256}
        return json.dumps(facts | self._lists()) + "\n"

    @property
    def is_official(self) -> bool:
        """Whether these are the lists that are published for the complete split."""
        own = (self.split, self.rule, self.sha256)
        return any(own == (one.split, one.rule, one.sha256) for one in official_lists())

    def _lists(self) -> dict[str, list[int]]:
        return {name: getattr(self, name).tolist() for name in (*NAMES, "left_out")}


def parts(dataset: Dataset | Path | str, by: By | None = None, *, test: str | None = None) -> Parts:
    """The official training, validation and test sequences of a dataset.

    Raises VbbenchError if the rule cannot be applied to this dataset, or there is no recording of that name.

    Parameters
    ----------
    dataset : the dataset, or its folder.
    by : ``time`` cuts every recording in three, with gaps that nobody stays through; ``recording`` leaves one recording
        out for the test; of the others what is not for training by time validates, and among the recordings of one
        dataset the next one; ``seed`` looks at the seed of a simulated split, as a whole:
        0 tests, 1 validates, every other one trains. ``None``: ``seed`` for simulated splits, ``time`` for others.
    test : for ``recording``: the name of the recording that tests.
    """
    dataset = dataset if isinstance(dataset, Dataset) else Dataset(dataset)
    chosen = by or ("seed" if is_simulated(dataset.info) else "time")
    if chosen not in VERSIONS:
        raise UnknownNameError("rule", chosen, VERSIONS)
    if test is not None and chosen != "recording":
        raise VbbenchError(f"a recording that tests is for parts by recording, not by {chosen}; remove {test}")
    part = {"time": _by_time, "recording": _by_recording, "seed": _by_seed}[chosen](dataset, test)
    rule = f"{chosen}/{VERSIONS[chosen]}"
    return Parts(
        split=dataset.info.split,
        dataset=dataset.info.id,
        rule=rule if test is None else f"{rule} {test}",
        left_out=np.flatnonzero(part < 0),
        **{name: np.flatnonzero(part == number) for number, name in enumerate(NAMES)},
    )


def describe(of: Parts, dataset: Dataset) -> str:
    """The parts in numbers, as text."""
    frames = dataset.rows["frames"]
    lines = [f"{of.split} ({of.dataset}), rule {of.rule}", "  part        sequences   frames"]
    for name in (*NAMES, "left_out"):
        numbers = getattr(of, name)
        lines.append(f"  {name.replace('_', ' '):<10} {len(numbers):10d} {int(frames[numbers].sum()):8d}")
    return "\n".join([*lines, f"  SHA-256 {of.sha256}: {_standing(of)}"])


def _standing(of: Parts) -> str:
    if of.is_official:
        return "the official lists"
    if of.rule.startswith("seed"):
        return "official, as every simulated split goes by its seed"
    if any((one.split, one.rule) == (of.split, of.rule) for one in official_lists()):
        return "not the official lists, which are of the complete split with its own observers"
    return "no lists of this are published; the rule makes the same ones everywhere"


def is_simulated(info: DatasetInfo) -> bool:
    """Whether everybody in a dataset walked in a computer alone."""
    return not info.sources and info.tier != FOOTAGE


def recording_names(dataset: Dataset) -> list[str]:
    """The recordings that can be withheld for a test of what others teach, in the order of the folds."""
    places = _places(dataset.info)
    return [place.name for place in _published().recording] if places else list(dataset.info.scenes)


def _by_seed(dataset: Dataset, _: str | None) -> IntArray:
    info = dataset.info
    if not is_simulated(info):
        raise VbbenchError(f"{dataset.folder} is a recording, in which another seed gives the same people; use by time")
    if info.seed is None:
        raise VbbenchError(f"the seed of {dataset.folder} is withheld: it is for a test alone, which its owner scores")
    name = next((name for name, seed in OFFICIAL_SEEDS.items() if seed == info.seed), "train")
    return np.full(len(dataset), NAMES.index(name))


def _by_time(dataset: Dataset, _: str | None) -> IntArray:
    _require_scenes(dataset, "time")
    if not (dataset.has_truth and dataset.info.truth in ("whole", "relative")):
        raise VbbenchError(f"{dataset.folder} lacks the times of people, which parts by time need; use by recording")
    rows, part = dataset.rows, np.zeros(len(dataset), np.int64)
    for scene in np.unique(rows["scene"]).tolist():
        cuts = find_cuts(~np.isnan(dataset.scene(scene)[1][..., 0]), dataset.info.dt)
        if cuts is not None:  # what is not cut is for training
            here = rows["scene"] == scene
            first = rows["first_frame"][here].astype(np.int64)
            part[here] = cuts.part_of(first, first + rows["frames"][here])
    return part


def _by_recording(dataset: Dataset, test: str | None) -> IntArray:
    _require_scenes(dataset, "recording")
    names, places = recording_names(dataset), _places(dataset.info)
    if test is None:
        raise VbbenchError(f"which recording is to test? name one of {', '.join(names)}")
    if test not in names:
        raise UnknownNameError("recording", test, names)
    if places:
        return np.full(len(dataset), 2) if test in places else np.minimum(_by_time(dataset, None), 1)
    if len(names) < len(NAMES):
        raise VbbenchError(f"{dataset.folder} has {len(names)} recordings, too few for three parts; use by time")
    ahead = (dataset.rows["scene"].astype(np.int64) - names.index(test)) % len(names)
    return np.select([ahead == 0, ahead == 1], [2, 1], 0)


def _require_scenes(dataset: Dataset, by: str) -> None:
    if is_simulated(dataset.info):
        raise VbbenchError(f"{dataset.folder} is simulated and has no recordings to divide by {by}; use by seed")


@dataclass(frozen=True, kw_only=True)
class Place:
    """A place that was recorded, and the SHA-256 of the files of it."""

    name: str
    sources: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Official:
    """Lists that were published: whoever computes them finds this SHA-256."""

    split: str
    rule: str
    train: int
    validation: int
    test: int
    left_out: int
    sha256: str


@dataclass(frozen=True, kw_only=True)
class _Published:
    recording: tuple[Place, ...]
    lists: tuple[Official, ...]


@cache
def _published() -> _Published:
    return read_bundled("vbbench", "training/official.toml", _Published, "official lists")


def official_lists() -> tuple[Official, ...]:
    """The published lists of all splits of recordings."""
    return _published().lists


def _places(info: DatasetInfo) -> set[str]:
    """Where a dataset was recorded, if it was made from a file that is known."""
    return {place.name for place in _published().recording if info.sources & set(place.sources)}
