"""A dataset folder: its sequences, and their truth where it is available."""

import threading
from collections.abc import Callable, Iterator
from dataclasses import fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import Camera
from vbbench.errors import FileError, UnknownNameError, VbbenchError, needs_extra
from vbbench.files.dataset_checks import TRUTH_TABLES, check_in_scene, check_poses, check_scene
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.sequence_tables import SequenceTable, part_ranges, persons_of, sequence_of, world_of
from vbbench.files.tables import CAMERA, FRAME_TABLE, LARGEST_ID, ODOMETRY_TABLE, SCENE_TABLES, TRACK_TABLE
from vbbench.files.withholding import check_truth
from vbbench.folders.work_folder import finish_swaps
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.scene import World
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Problem

if TYPE_CHECKING:
    import pandas

SCENES_KEPT = 64
"""Most true scenes kept in memory: there may be as many as sequences."""


class Dataset:
    """A dataset folder, opened for reading; sequences are read on demand.

    Raises FileError if a table is missing or has another size than ``dataset.json`` states, or ``truth`` has other
    hashes.

    Parameters
    ----------
    folder : the dataset folder.
    truth : folder with the truth tables, if they are in another one.
    """

    def __init__(self, folder: Path | str, truth: Path | str | None = None) -> None:
        self.folder = Path(folder)
        self.info = DatasetInfo.read(self.folder)
        self.truth_folder = self.folder / "truth"
        if truth:
            nested = Path(truth) / "truth"
            self.truth_folder = nested if nested.is_dir() else Path(truth)
            finish_swaps(truth)
            check_truth(self.info, self.truth_folder)
        for name, facts in self.info.tables.items():
            path = self.table_path(name)
            if path.is_file() and path.stat().st_size != facts["bytes"]:
                raise FileError(path, f"{path.stat().st_size} bytes, {facts['bytes']} were written; generate it again")
        self._tables: dict[str, SequenceTable] = {}
        self._moved = ODOMETRY_TABLE in self.info.tables
        for name in ("observations", "given", *([ODOMETRY_TABLE] if self._moved else [])):
            self._opened(name)
        self._scenes: dict[int, tuple[IntArray, FloatArray, FloatArray]] = {}

    def table_path(self, name: str) -> Path:
        """The path of a table; truth may be in another folder."""
        if name.startswith("truth/"):
            return self.truth_folder / f"{name.removeprefix('truth/')}.parquet"
        return self.folder / f"{name}.parquet"

    def __len__(self) -> int:
        return len(self.rows["sequence"])

    def __reduce__(self) -> tuple[Callable[..., "Dataset"], tuple[Path, Path, str]]:
        """Worker processes open the folder themselves."""
        return _opened_once, (self.folder.resolve(), self.truth_folder.resolve(), self.info.id)

    @property
    def has_truth(self) -> bool:
        """Whether the truth tables are available; they may hold less than everything (`DatasetInfo.truth`)."""
        tables = TRUTH_TABLES[self.info.truth]
        return bool(tables) and self.table_path(tables[-1]).is_file()

    @property
    def has_whole_truth(self) -> bool:
        """Whether the truth tables are available, and the observer's poses and people's positions are in them."""
        return self.has_truth and self.info.truth == "whole"

    def camera(self, sequence: Sequence) -> Camera:
        """The camera of a sequence."""
        return problem_of(self.info, sequence).camera

    def to_pandas(self, table: str) -> "pandas.DataFrame":
        """A table as a data frame; needs the extra ``pandas``.

        Raises VbbenchError if there is no such table, the truth is withheld, or pandas is not installed.

        Parameters
        ----------
        table : one of ``info.tables``, for example ``observations`` or ``truth/poses``.
        """
        with needs_extra("pandas", "Dataset.to_pandas"):
            import pandas
        if table not in self.info.tables:
            raise UnknownNameError("table", table, self.info.tables)
        if table.startswith("truth/"):
            self._require_truth()
        return pandas.read_parquet(self.table_path(table))

    @cached_property
    def rows(self) -> dict[str, NDArray[Any]]:
        """The columns of ``sequences.parquet``."""
        table = SequenceTable(self.table_path("sequences"), "sequences", optional=[CAMERA])
        rows = table.read(0, LARGEST_ID)
        numbered = np.array_equal(rows["sequence"], np.arange(table.rows))
        if not numbered or any((rows[name] < 0).any() for name in ("scene", "first_frame", "frames", "people")):
            raise FileError(table.path, "its sequences are not numbered from 0, or a count is below 0; generate again")
        camera = rows.setdefault(CAMERA, np.zeros(table.rows, np.int32))
        if not ((camera >= 0) & (camera < max(1, len(self.info.cameras)))).all():
            raise FileError(table.path, f"a sequence's camera is none of the {len(self.info.cameras)}; generate again")
        return rows

    @cached_property
    def _scene_ends(self) -> tuple[IntArray, IntArray]:
        """Numbers of the scenes, ascending, and the frame after the last one of each that belongs to a sequence."""
        numbers, scene = np.unique(self.rows["scene"], return_inverse=True)
        ends = np.zeros(len(numbers), np.int64)
        np.maximum.at(ends, scene, self.rows["first_frame"].astype(np.int64) + self.rows["frames"])
        return numbers, ends

    @property
    def cells(self) -> IntArray:
        """[N] frames times tracks of each sequence, an upper bound of its number of boxes."""
        cells: IntArray = self.rows["frames"].astype(np.int64) * self.rows["people"]
        return cells

    def problem(self, sequence: Sequence, *, covariances: bool = False) -> Problem:
        """The published facts about a sequence, as a solver gets them."""
        return problem_of(self.info, sequence, covariances=covariances)

    def sequence(self, index: int) -> Sequence:
        """One sequence."""
        return next(self.sequences(index, index + 1))

    def read_ahead(self, indices: IntArray) -> None:
        """Read all rows of these sequences [N] at once: later reads of them, or of their truth, are from memory."""
        scenes = np.setdiff1d(self.rows["scene"][indices], list(self._scenes))
        for name in set(self.info.tables) - {"sequences"}:
            if self.table_path(name).is_file():
                self._opened(name).read_ahead(scenes if name in SCENE_TABLES else indices)

    def sequences(self, first: int = 0, last: int | None = None) -> Iterator[Sequence]:
        """Sequences first ≤ index < last; some megabytes of them are in memory at a time."""
        last = self._checked_range(first, last)
        for begin, end in part_ranges(last - first, self.cells[first:last]):
            boxes, given = (self._opened(name).read(first + begin, first + end) for name in ("observations", "given"))
            moved = self._opened(ODOMETRY_TABLE).read(first + begin, first + end) if self._moved else None
            for index in range(first + begin, first + end):
                facts = {name: values[index] for name, values in self.rows.items()}
                own = None if moved is None else _of(moved, index)
                yield sequence_of(self.table_path, facts, _of(boxes, index), _of(given, index), own)

    def truth(self, sequence: Sequence, persons: IntArray | None = None) -> Truth:
        """Truth in the sequence's world; NaN for tracks of false alarms, and for all people if only poses are known.

        ``persons`` [T, K] are behind the tracks of another tracker; by default behind those of the dataset.

        Raises VbbenchError if the truth is withheld, or has only positions relative to the camera.
        """
        self._require_truth()
        if self.info.truth == "relative":
            raise VbbenchError(
                f"{self.folder}: poses of the camera are unknown; only positions relative to it were measured"
            )
        poses = self._opened("truth/poses").read(sequence.index, sequence.index + 1)
        check_poses(self.table_path, sequence.index, sequence.frames, poses)
        positions, heights = self._people_of(sequence, persons)
        return Truth(
            poses=np.stack([poses["x"], poses["y"], poses["yaw"]], axis=-1), positions=positions, heights=heights
        )

    def relative_truth(self, sequence: Sequence) -> FloatArray:
        """[T, K, 2] true position of each track's person relative to the camera, (right, forward) in m, or NaN."""
        if self.info.truth != "relative":
            truth = self.truth(sequence)
            return world_to_relative(truth.positions, truth.poses)
        self._require_truth()
        return self._people_of(sequence)[0]

    def _people_of(self, sequence: Sequence, of: IntArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Positions [T, K, 2] in the sequence's world and heights [K] of the person behind each track."""
        if self.info.truth == "poses":
            return np.full((*sequence.observed.shape, 2), np.nan), np.full(len(sequence.tracks), np.nan)
        people, positions, heights = self.surroundings(sequence)
        persons = self.track_persons(sequence) if of is None else of
        column = np.searchsorted(people, persons).clip(max=len(people) - 1)
        path = np.take_along_axis(positions, column[..., None], axis=1)
        known = (people[column] == persons) & (persons >= 0)
        nowhere = known & (sequence.observed if of is None else False) & np.isnan(path[..., 0])
        check_in_scene(self.table_path, sequence.index, people, nowhere)
        return np.where(known[..., None], path, np.nan), _first_known(heights[column], known)

    def scene(self, scene: int) -> tuple[IntArray, FloatArray, FloatArray]:
        """True scene, in its own world: people [K], positions [T, K, 2] in m, heights [K] in m."""
        if scene not in self._scenes:
            if len(self._scenes) >= SCENES_KEPT:
                self._scenes.clear()
            self._scenes[scene] = self._read_scene(scene)
        return self._scenes[scene]

    def surroundings(self, sequence: Sequence) -> tuple[IntArray, FloatArray, FloatArray]:
        """All people of the scene during a sequence, as from `scene`, in the sequence's frames and world."""
        people, positions, heights = self.scene(sequence.scene)
        check_in_scene(self.table_path, sequence.index, people)
        frames = slice(sequence.first_frame, sequence.first_frame + sequence.frames)
        return people, self.world(sequence).positions(positions[frames]), heights

    def world(self, sequence: Sequence) -> World:
        """The transform from a sequence's scene to its world; the identity if truth is relative to the camera."""
        if self.info.truth == "relative":
            return World()
        return world_of(
            self.table_path, sequence.index, self._opened(FRAME_TABLE).read(sequence.index, sequence.index + 1)
        )

    def track_persons(self, sequence: Sequence) -> IntArray:
        """[T, K] the person behind each track in each frame, −1 for a false alarm and before the first box."""
        rows = self._opened(TRACK_TABLE).read(sequence.index, sequence.index + 1)
        return persons_of(self.table_path, sequence.index, sequence.frames, sequence.tracks, rows)

    def _opened(self, name: str) -> SequenceTable:
        """A table, opened at its first use."""
        if name not in self._tables:
            key = "scene" if name in SCENE_TABLES else "sequence"
            self._tables[name] = SequenceTable(self.table_path(name), name, key)
        return self._tables[name]

    def _checked_range(self, first: int, last: int | None) -> int:
        last = len(self) if last is None else last
        if not 0 <= first <= last <= len(self):
            asked = f"{first}" if last == first + 1 else f"{first} to {last - 1}"
            raise VbbenchError(f"{self.folder} has sequences 0 to {len(self) - 1}, not {asked}")
        return last

    def _require_truth(self) -> None:
        if self.info.truth == "none":
            raise VbbenchError(f"{self.folder} is footage of which no truth was ever measured")
        if not self.has_truth:
            where = f"put it at {self.folder / 'truth'}, or name its folder with `truth` where a command takes that"
            raise VbbenchError(f"{self.folder} has no truth; {where}")

    def _read_scene(self, scene: int) -> tuple[IntArray, FloatArray, FloatArray]:
        self._require_truth()
        persons = self._opened("truth/people").read(scene, scene + 1)
        rows = self._opened("truth/scenes").read(scene, scene + 1)
        people = persons["person"].astype(np.int64)
        numbers, ends = self._scene_ends
        least = int(ends[slice(*np.searchsorted(numbers, [scene, scene + 1]))].max(initial=0))
        positions = np.full((check_scene(self.table_path, scene, people, rows, least), len(people), 2), np.nan)
        positions[rows["frame"], np.searchsorted(people, rows["person"])] = np.stack([rows["x"], rows["y"]], axis=-1)
        return people, positions, persons["height"]


def problem_of(info: DatasetInfo, sequence: Sequence, *, covariances: bool = False) -> Problem:
    """The published facts about a sequence, as a solver gets them; ``info`` is of its dataset."""
    published = {field.name for field in fields(Problem)} - {"camera", "tracks", "covariances"}
    facts = {name: getattr(info, name) for name in published}
    camera = info.cameras[sequence.camera] if info.cameras else info.camera
    return Problem(camera=camera, tracks=sequence.tracks, covariances=covariances, **facts)


_last = threading.local()


def _opened_once(folder: Path, truth: Path, wanted: str) -> Dataset:
    """The dataset, opened once per thread of a worker, as threads cannot share open tables."""
    if getattr(_last, "place", None) != (folder, truth, wanted):
        try:
            dataset = Dataset(folder)
            dataset.truth_folder = truth
        except FileError as error:
            raise VbbenchError(
                f"a worker cannot open the dataset; keep it on a disk that all share ({error})"
            ) from error
        if dataset.info.id != wanted:
            raise FileError(folder, f"a worker sees dataset {dataset.info.id} here, not {wanted}; share one disk")
        _last.dataset, _last.place = dataset, (folder, truth, wanted)
    opened: Dataset = _last.dataset
    return opened


def _first_known(values: FloatArray, known: BoolArray) -> FloatArray:
    """[K] the first of values [T, K] that is ``known``, NaN where none is."""
    first = known.argmax(axis=0)
    return np.where(known.any(axis=0), np.take_along_axis(values, first[None], axis=0)[0], np.nan)


def _of(rows: dict[str, NDArray[Any]], index: int) -> dict[str, NDArray[Any]]:
    start, stop = np.searchsorted(rows["sequence"], [index, index + 1])
    return {name: values[start:stop] for name, values in rows.items()}
