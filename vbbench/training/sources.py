"""Where samples come from: the folder of a dataset, or a generator that makes them when they are wanted.

Both give any sample by its number, in any process; nothing depends on which samples were asked for before.
"""

import os
from collections.abc import Iterator
from collections.abc import Sequence as Several
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset, problem_of
from vbbench.files.sequence_tables import part_ranges
from vbbench.generation.footage import FOOTAGE
from vbbench.generation.generator import Options, Plan
from vbbench.generation.planning import build_sequence, is_endless, planned
from vbbench.geometry import IntArray, world_to_relative
from vbbench.protocol import get_protocol
from vbbench.sequence import NOBODY, Sequence, Truth
from vbbench.streams import Stream, random_stream
from vbbench.training.samples import Known, Sample, sample_of

CELLS_KEPT = 1 << 19
"""People times frames of the sequences that a folder's samples keep in memory, about 50 MB."""


class Source(Protocol):
    """Samples by number."""

    @property
    def size(self) -> int | None:
        """How many there are; ``None`` for a source without an end."""

    def read(self, numbers: Several[int]) -> list[Sample[NDArray[Any]]]:
        """Some samples, in the order asked for."""


class FolderSamples:
    """The sequences of a dataset folder, or windows of them, by number.

    What is asked for together is read together, and the sequences read last are kept, some tens of megabytes of them.
    Every process opens the folder itself.

    Raises VbbenchError if the folder is no dataset, there is no such sequence, or ``frames`` or ``step`` is less than
    1.

    Parameters
    ----------
    folder : the dataset folder.
    sequences : [N] the sequences to take, such as `Parts.train`; ``None`` for all.
    truth : folder with the truth tables, if they are in another one.
    frames : length of a window; ``None`` for whole sequences. A shorter sequence is one window.
    step : frames from a window to the next one; ``None`` for as many as a window has.
    protocol : what is given.
    local : whether every sample's world begins at its first pose (`vbbench.training.samples.sample_of`).
    """

    def __init__(
        self,
        folder: Path | str,
        *,
        sequences: ArrayLike | None = None,
        truth: Path | str | None = None,
        frames: int | None = None,
        step: int | None = None,
        protocol: str = "sequential",
        local: bool = False,
    ) -> None:
        self.folder, self._truth = Path(folder).resolve(), truth and Path(truth).resolve()
        self._protocol, self._local, self._frames = get_protocol(protocol), local, frames
        self._opened: tuple[int, Dataset] | None = None
        self._kept: dict[int, Known] = {}
        rows = self._dataset.rows
        self.sequences: IntArray = np.asarray(np.arange(len(self._dataset)) if sequences is None else sequences)
        if not np.isin(self.sequences, np.arange(len(self._dataset))).all():
            raise VbbenchError(f"{folder} has sequences 0 to {len(self._dataset) - 1}; others were asked for")
        self._windows = _windows(self.sequences, rows["frames"][self.sequences], frames, step)
        self._cells = self._dataset.cells

    def __len__(self) -> int:
        return len(self._windows)

    def __getitem__(self, number: int) -> Sample[NDArray[Any]]:
        if not -len(self) <= number < len(self):
            raise IndexError(f"there are samples 0 to {len(self) - 1}, not {number}")
        return self.read([number])[0]

    @property
    def size(self) -> int:
        """How many there are."""
        return len(self)

    def read(self, numbers: Several[int]) -> list[Sample[NDArray[Any]]]:
        """Some samples, in the order asked for."""
        wanted = self._windows[list(numbers)]
        made: dict[int, Sample[NDArray[Any]]] = {}
        for known in self._known(np.unique(wanted[:, 0])):
            for place in np.flatnonzero(wanted[:, 0] == known.sequence.index).tolist():
                made[place] = self._sample(known, int(wanted[place, 1]))
        return [made[place] for place in range(len(wanted))]

    def _known(self, sequences: IntArray) -> Iterator[Known]:
        """These sequences [N], those that are kept first."""
        kept = [self._kept[index] for index in sequences.tolist() if index in self._kept]
        yield from kept
        sequences = np.setdiff1d(sequences, [known.sequence.index for known in kept])
        for first, last in part_ranges(len(sequences), self._cells[sequences]):
            self._dataset.read_ahead(sequences[first:last])
            for index in sequences[first:last].tolist():
                self._kept[index] = known_of(self._dataset, self._dataset.sequence(index))
                yield self._kept[index]
        while sum(self._cells[list(self._kept)]) > CELLS_KEPT:
            del self._kept[next(iter(self._kept))]

    def _sample(self, known: Known, start: int) -> Sample[NDArray[Any]]:
        stop = min(start + (self._frames or known.sequence.frames), known.sequence.frames)
        window = None if self._frames is None else slice(start, stop)
        return sample_of(known, self._protocol, window, local=self._local)

    @property
    def _dataset(self) -> Dataset:
        """The dataset as this process opened it: an open file is no good in another one."""
        if self._opened is None or self._opened[0] != os.getpid():
            self._opened = os.getpid(), Dataset(self.folder, self._truth)
        return self._opened[1]

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_opened": None, "_kept": {}}


def _windows(sequences: IntArray, lengths: IntArray, frames: int | None, step: int | None) -> IntArray:
    """[N, 2] sequence and first frame of every window."""
    if frames is None:
        return np.stack([sequences, np.zeros_like(sequences)], axis=-1)
    if frames < 1 or (step is not None and step < 1):
        raise VbbenchError(f"windows of {frames} frames, {step} apart: both are 1 or more")
    counts = np.maximum(lengths.astype(np.int64) - frames, 0) // (step or frames) + 1
    number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([np.repeat(sequences, counts), number * (step or frames)], axis=-1)


def known_of(dataset: Dataset, sequence: Sequence) -> Known:
    """A sequence of a dataset, with NaN for what was never measured or is withheld."""
    kind, (frames, people) = dataset.info.truth if dataset.has_truth else "none", sequence.observed.shape
    if kind in ("whole", "poses"):
        truth = dataset.truth(sequence)
    else:
        poses, positions, heights = (np.full(shape, np.nan) for shape in ((frames, 3), (frames, people, 2), people))
        truth = Truth(poses=poses, positions=positions, heights=heights)
    measured, tracked = kind == "relative", kind in ("whole", "relative")
    return Known(
        sequence=sequence,
        problem=dataset.problem(sequence),
        truth=truth,
        relative=dataset.relative_truth(sequence) if measured else world_to_relative(truth.positions, truth.poses),
        persons=dataset.track_persons(sequence) if tracked else np.full((frames, people), NOBODY),
    )


class GeneratedSamples:
    """The sequences that a split's generator makes, or a window drawn from each, by number; nothing is written.

    They are those of ``vbbench generate`` with the same options. A simulated split never ends.

    Raises VbbenchError if split or options are wrong, it is footage, or ``stop`` or ``frames`` is less than 1.

    Parameters
    ----------
    split, options : what to make: any split but footage.
    stop : how many sequences there are; ``None`` for all of a recording, and no end of a simulated split.
    frames : length of the window that is drawn from each longer sequence; ``None`` for whole sequences.
    protocol, local : as of `FolderSamples`.
    """

    def __init__(
        self,
        split: str = "sim",
        options: Options | None = None,
        *,
        stop: int | None = None,
        frames: int | None = None,
        protocol: str = "sequential",
        local: bool = False,
    ) -> None:
        self.split, self.options = split, options or Options()
        self._protocol, self._local, self._frames = get_protocol(protocol), local, frames
        if min(stop or 1, 1 if frames is None else frames) < 1 or stop == 0:
            raise VbbenchError(f"{stop} sequences, windows of {frames} frames: both are 1 or more")
        if self._plan.info.tier == FOOTAGE:
            raise VbbenchError(f"{split} is footage: generate its folder, and read samples from that (FolderSamples)")
        ends = (None if is_endless(self._plan) else len(self._plan), stop)
        self.size: int | None = min((end for end in ends if end is not None), default=None)

    def __len__(self) -> int:
        if self.size is None:
            raise TypeError("these samples have no end; give a 'stop'")
        return self.size

    def __getitem__(self, number: int) -> Sample[NDArray[Any]]:
        if number < 0 or (self.size is not None and number >= self.size):
            raise IndexError(f"there are samples 0 to {'…' if self.size is None else self.size - 1}, not {number}")
        data = build_sequence(self._plan, number)
        sequence, info = data.sequence, self._plan.info
        persons = np.broadcast_to(sequence.tracks, sequence.observed.shape) if data.persons is None else data.persons
        known = Known(
            sequence=sequence,
            problem=problem_of(info, sequence),
            truth=data.truth,
            relative=world_to_relative(data.truth.positions, data.truth.poses),
            persons=persons,
        )
        return sample_of(known, self._protocol, self._window(sequence), local=self._local)

    def read(self, numbers: Several[int]) -> list[Sample[NDArray[Any]]]:
        """Some samples, in the order asked for."""
        return [self[number] for number in numbers]

    def _window(self, sequence: Sequence) -> slice | None:
        if self._frames is None:
            return None
        rng = random_stream(self._plan.info.known_seed, sequence.index, Stream.WINDOW)
        start = int(rng.integers(max(sequence.frames - self._frames, 0) + 1))
        return slice(start, min(start + self._frames, sequence.frames))

    @cached_property
    def _plan(self) -> Plan:
        return planned(self.split, self.options)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_plan"}
