"""Any tracker's MOTChallenge files as a dataset of tier `tracked`: its boxes, matched to people by their overlap."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.boxes import observations_of
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.matching import LEAST_FRAMES, LEAST_OVERLAP, NOBODY, lasting_tracks, match_tracks, true_rectangles
from vbbench.exchange.mot.text import UNLINKED, MotRows, read_mot
from vbbench.exchange.sequence_files import files_by_sequence
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.tables import file_sha256
from vbbench.generation import write_dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.rendering import scene_of, silent
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import Sequence, SequenceData, Truth

REVISION = 1
"""Incremented whenever the same files give another dataset, so that ids differ too."""
PIXEL_STD = {"perspective": 9.0, "panorama": 2.4}
"""Noise in px of a tracker's columns, tops and bottoms that the dataset declares, as in docs/tiers.md."""


def import_mot(
    folder: Path | str,
    dataset: Dataset,
    out: Path | str,
    *,
    pixel_std: float | None = None,
    overwrite: bool = False,
    announce: Callable[[str], object] = silent,
) -> Dataset:
    """Make a dataset of tier `tracked` from a tracker's boxes on the pictures of ``dataset``.

    Tracks are matched to people frame by frame (`match_boxes`); those matched in fewer than three frames are left out.
    Given is where the person behind a track is in its first two matched frames. Sequences without a file are left out,
    and the others renumbered in order.

    Parameters
    ----------
    folder : with ``sequence-000012.txt``, or else ``sequence-000012/gt/gt.txt``, for sequence 12.
    dataset : the dataset of the pictures, with its truth.
    out : folder of the new dataset.
    pixel_std : standard deviation in px of a box's column, top and bottom that the dataset declares; ``None`` for that
        of the bundled tracker.
    overwrite : replace an existing dataset.
    announce : called with a line that says how many boxes were kept.

    Raises
    ------
    VbbenchError
        If a file cannot be used (`read_mot`), no track matches a person, the truth is withheld, or ``out`` exists.
    """
    out = Path(out)
    if pixel_std is None:
        pixel_std = PIXEL_STD["perspective" if dataset.info.camera.period is None else "panorama"]
    if not (np.isfinite(pixel_std) and pixel_std >= 0.0):
        raise VbbenchError(f"pixel_std must be at least 0 px, not {pixel_std:g}")
    plan = TrackedPlan(dataset, _files(Path(folder), len(dataset)), pixel_std)
    if not any(plan.build(index).sequence.tracks.size for index in range(len(plan))):
        problem = "no track matches a person in three frames; are its boxes in pixels of the rendered pictures?"
        raise FileError(folder, problem)
    made = write_dataset(plan, out, overwrite=overwrite)
    kept, boxes = made.info.counts["observations"], sum(len(rows.frame) for rows in plan.contents)
    announce(f"{kept} of {boxes} boxes kept: of tracks that match a person in {LEAST_FRAMES} frames or more")
    return made


@dataclass(frozen=True)
class TrackedPlan:
    """The plan of a dataset made from tracks (`vbbench.generation.generator.Plan`).

    Parameters
    ----------
    dataset : the dataset of the pictures.
    files : a file for each sequence, by its number in ``dataset``.
    pixel_std : the noise in px that the new dataset declares.
    """

    dataset: Dataset
    files: dict[int, Path]
    pixel_std: float

    def __len__(self) -> int:
        return len(self.files)

    @cached_property
    def contents(self) -> list[MotRows]:
        """The rows of the files."""
        return [_tracks(path, int(self.dataset.rows["frames"][number])) for number, path in self.files.items()]

    @cached_property
    def scenes(self) -> tuple[Scene, ...]:
        """The scenes that sequences share; none if each has its own."""
        return tuple(scene_of(self.dataset, number) for number in self._scene_numbers) if self._shared else ()

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts; the id follows from the files and the id of the dataset that they belong to."""
        source = self.dataset.info
        names = tuple(source.scenes[n] for n in self._scene_numbers) if self._shared else source.scenes
        definition: dict[str, Any] = {
            "import": f"mot/{REVISION}",
            "dataset": source.id,
            "files": {str(number): file_sha256(path) for number, path in self.files.items()},
            "least_overlap": LEAST_OVERLAP,
            "least_frames": LEAST_FRAMES,
            "of": source.definition,
        }
        facts: dict[str, Any] = {"definition": definition, "counts": {}, "tables": {}, "withheld_id": None}
        return replace(source, tier="tracked", scenes=names, pixel_std=self.pixel_std, **facts)

    def build(self, index: int) -> SequenceData:
        """Match the tracks of one sequence, and leave out those that match nobody."""
        source = self.dataset.sequence(list(self.files)[index])
        camera, scene = self.dataset.camera(source), scene_of(self.dataset, source.scene)
        tracks, boxes, visible = _dense(self.contents[index], source.frames)
        poses = self.dataset.truth(source).poses
        others = scene.people != source.observer
        frames = slice(source.first_frame, source.first_frame + source.frames)
        true = true_rectangles(scene.positions[frames, others], scene.heights[others], poses, camera)
        persons = match_tracks(boxes, true, scene.people[others], camera)
        kept = lasting_tracks(persons)
        persons, truth = persons[:, kept], _truth(scene, frames, poses, persons[:, kept])
        sequence = Sequence(
            index=index,
            scene=self._scene_numbers.index(source.scene) if self._shared else index,
            observer=source.observer,
            first_frame=source.first_frame,
            tracks=tracks[kept],
            observations=observations_of(boxes[:, kept], camera),
            visible=visible[:, kept],
            given=arrivals_given(truth, persons != NOBODY),
        )
        return SequenceData(sequence=sequence, truth=truth, persons=persons, scene=None if self._shared else scene)

    @cached_property
    def _scene_numbers(self) -> list[int]:
        return sorted({int(self.dataset.rows["scene"][number]) for number in self.files})

    @property
    def _shared(self) -> bool:
        return len(set(self.dataset.rows["scene"].tolist())) < len(self.dataset)


def _files(folder: Path, sequences: int) -> dict[int, Path]:
    """Each sequence's file, by number."""
    named = {path: path.stem for path in sorted(folder.glob("*.txt"))} or {
        path: path.parent.parent.name for path in sorted(folder.glob("sequence-*/gt/gt.txt"))
    }
    if not named:
        wanted = "sequence-000000.txt, or sequence-000000/gt/gt.txt, for sequence 0, and so on"
        raise FileError(folder, f"holds no tracks; files are called {wanted}")
    return files_by_sequence(named, sequences)


def _tracks(path: Path, frames: int) -> MotRows:
    rows = read_mot(path, frames)
    loose = np.flatnonzero(rows.track == UNLINKED)
    if len(loose):
        line = int(rows.line[loose[0]])
        raise FileError(path, "id is -1: these are detections; let a tracker link them first", line)
    return rows


def _dense(rows: MotRows, frames: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Track ids [K], boxes [T, K, 4] and visible fractions [T, K], NaN where a track has no box."""
    tracks, column = np.unique(rows.track, return_inverse=True)
    boxes, visible = np.full((frames, len(tracks), 4), np.nan), np.full((frames, len(tracks)), np.nan)
    boxes[rows.frame, column] = rows.boxes
    visible[rows.frame, column] = rows.visible
    return tracks, boxes, visible


def _truth(scene: Scene, frames: slice, poses: FloatArray, persons: IntArray) -> Truth:
    """Where the person behind each track [T, K] is."""
    columns = np.searchsorted(scene.people, persons).clip(max=len(scene.people) - 1)
    known = persons != NOBODY
    path = np.take_along_axis(scene.positions[frames], columns[..., None], axis=1)
    first = known.argmax(axis=0)
    heights = scene.heights[columns[first, np.arange(persons.shape[1])]]
    return Truth(poses=poses, positions=np.where(known[..., None], path, np.nan), heights=heights)
