"""MOTChallenge text: export of a dataset's boxes, and import of a tracker's files as a dataset of tier `tracked`.

One box is a line, ``frame,id,left,top,width,height,conf,class,visibility``. Frames and boxes are 1-based in it: frame 1
is a sequence's frame 0, and left = 1 is the left edge of the picture (MOT16, arXiv 1603.00831, section 3.2). Here both
count from 0.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vbbench.boxes import observations_of, rectangles
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.box_rows import BoxRows, read_boxes, rows_in_frames, rows_of
from vbbench.exchange.box_tables import NOUNS, UNLINKED
from vbbench.exchange.matching import (
    LEAST_FRAMES,
    LEAST_OVERLAP,
    FrameOffset,
    frame_offset,
    lasting_tracks,
    match_tracks,
    true_rectangles,
)
from vbbench.exchange.sequence_files import (
    SEQUENCE_INFO,
    files_by_sequence,
    picture_facts,
    sequence_info,
    sequence_name,
)
from vbbench.exchange.text_tables import decode, split_header
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.tables import file_sha256
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_bytes_atomically, write_text_atomically
from vbbench.generation import write_dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of, silent
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import NOBODY, Sequence, SequenceData, held_persons

PEDESTRIAN = 1
"""The class of walking people."""
REVISION = 2
"""Incremented whenever the same files give another dataset, so that ids differ too."""
LEAST_MATCHED, GOOD_MATCH = 0.5, 0.9
"""Shares of the boxes that must match a person, unless less is asked for, and below which a warning says so."""
LOOKED_AT = 20
"""Files, the first ones, of which other frames are tried."""
PIXEL_STD = {"perspective": 10.0, "panorama": 3.7}
"""Noise in px of a tracker's columns, tops and bottoms that the dataset declares, as in docs/tiers.md."""


def write_mot(path: Path, rows: BoxRows) -> None:
    """Write MOTChallenge text: tracks with class and visibility (9 columns), detections without (10, three are -1)."""
    numbers = np.column_stack([rows.boxes[:, :2] + 1.0, rows.boxes[:, 2:]]).tolist()
    visible = np.nan_to_num(rows.visible, nan=1.0)
    lines = [
        f"{frame + 1},{track},{','.join(map(repr, box))},{score:g},"
        + ("-1,-1,-1\n" if track == UNLINKED else f"{PEDESTRIAN},{share:.6g}\n")
        for frame, track, box, score, share in zip(rows.frame, rows.track, numbers, rows.scores, visible, strict=True)
    ]
    write_text_atomically(path, "".join(lines))


def export_mot(
    dataset: Dataset,
    out: Path | str,
    *,
    sequence: int | None = None,
    backend: Backend | None = None,
    announce: Callable[[str], object] = silent,
) -> Path:
    """Write the boxes of sequences as MOTChallenge text into the folder ``out``, and return it.

    Each sequence is a folder ``sequence-000012`` with ``gt/gt.txt`` (boxes with their tracks), ``det/det.txt`` (the
    same boxes as detections, without) and ``seqinfo.ini``. A box is `BOX_ASPECT` times as wide as it is high, since an
    observation has no width.

    Parameters
    ----------
    sequence : number of the only sequence to write; ``None`` for all.
    backend : renders pictures into ``img1``, which needs truth; ``None`` for no pictures.
    announce : called with a line that names the renderer.
    """
    out = Path(out)
    chosen = dataset.sequences() if sequence is None else [dataset.sequence(sequence)]
    with loose_files(out):
        for one in chosen:
            name = sequence_name(one.index)
            folder, (frame, column) = out / name, np.nonzero(one.observed)
            boxes = rectangles(one.observations[frame, column])
            tracks = rows_of(Path(), frame, one.tracks[column], boxes, np.ones(len(frame)))
            tracks = replace(tracks, visible=one.visible[frame, column])
            write_mot(folder / "gt" / "gt.txt", tracks)
            write_mot(folder / "det" / "det.txt", replace(tracks, track=np.full(len(tracks.frame), UNLINKED)))
            info = sequence_info(name, dataset.info.dt, one.frames, dataset.camera(one).picture_size, ".png")
            write_text_atomically(folder / SEQUENCE_INFO, info)
            if backend is None:
                continue
            from vbbench.pictures.video import png_bytes

            opened = open_renderer(backend, scene_of(dataset, one.scene), announce=announce)
            with opened as renderer, progress_bar(one.frames, name, unit="frame") as bar:
                for number, picture in enumerate(pictures(dataset, one, renderer), 1):
                    write_bytes_atomically(folder / "img1" / f"{number:06d}.png", png_bytes(picture.rgb))
                    bar.update()
    return out


def import_mot(
    folder: Path | str,
    dataset: Dataset,
    out: Path | str,
    *,
    least_matched: float = LEAST_MATCHED,
    least_track: int = LEAST_FRAMES,
    person_class: str | None = None,
    overwrite: bool = False,
    announce: Callable[[str], object] = silent,
) -> Dataset:
    """Make a dataset of tier `tracked` from a tracker's boxes on the pictures of ``dataset``.

    Tracks are matched to people frame by frame (`match_boxes`); those matched in too few are dropped.
    Given is where the person behind a track is in its first two matched frames. Sequences without a file are dropped,
    and the others renumbered in order. A file may have a first line of names, time stamps in place of frames, and gaps.

    Parameters
    ----------
    folder : with ``sequence-000012.txt``, .csv or .json, or else ``sequence-000012/gt/gt.txt``, for sequence 12.
    dataset : the dataset of the pictures, with its truth.
    least_matched : share of the boxes that must match a person; fewer are refused.
    least_track : fewest frames in which a track that counts is matched.
    person_class : class of people in the files, by number or name, where they do not show it.
    announce : called with a line that says how many boxes were kept.
    """
    out = Path(out)
    if dataset.info.truth != "whole":
        raise FileError(dataset.folder, "not everybody's place was measured; make it again with --boxes FOLDER")
    if not 0.0 <= least_matched <= 1.0:
        raise VbbenchError(f"least_matched is a share from 0 to 1, not {least_matched:g}")
    if least_track < 1:
        raise VbbenchError(f"least_track must be 1 or more, not {least_track}")
    pixel_std = PIXEL_STD["perspective" if dataset.info.camera.period is None else "panorama"]
    plan = TrackedPlan(dataset, _files(Path(folder), len(dataset)), pixel_std, least_track, person_class)
    kept = _check_matches(plan, Path(folder), least_matched)
    made = write_dataset(plan, out, overwrite=overwrite)
    announce(f"{kept}: of tracks that match a person in {least_track} frames or more")
    return made


def _check_matches(plan: "TrackedPlan", folder: Path, least: float) -> str:
    """Refuse boxes that hardly match people, warn of those that match badly, and say how many are kept."""
    matched, kept, shifted = np.zeros(len(plan), np.int64), 0, ""
    for index, (number, path) in enumerate(plan.files.items()):
        size = plan.dataset.camera(plan.dataset.sequence(number)).picture_size
        facts = picture_facts(path.parent / path.stem, path.parent.parent)
        facts.refuse_other("the dataset's", size, plan.dataset.info.dt)
        tracks = plan.match(index, shifts=index < LOOKED_AT and not shifted)
        matched[index] = (tracks.persons != NOBODY).sum()
        kept += int((tracks.visible[:, lasting_tracks(tracks.persons, plan.least_track)] > 0.0).sum())
        shifted = f"{path.name}: {tracks.offset}" if tracks.offset else shifted
    boxes = np.array([len(rows.frame) for rows in plan.contents])
    said = f"{matched.sum()} of {boxes.sum()} boxes match a person"
    width, height = plan.dataset.info.camera.picture_size
    of_what = shifted or f"are they in px of these pictures, {width} x {height}, and numbered by their frames from 1?"
    if not kept:
        raise FileError(folder, f"no track matches a person in {plan.least_track} frames; {of_what}")
    if matched.sum() < least * boxes.sum():
        problem = f"only {said}; {of_what} If so, allow for it: least_matched below {matched.sum() / boxes.sum():.2g}"
        raise FileError(folder, problem)
    poor = [path.name for path, few in zip(plan.files.values(), matched < least * boxes, strict=True) if few]
    badly = bool(poor) or matched.sum() < GOOD_MATCH * boxes.sum()
    fewest = f"; fewer than {least:.0%} of {', '.join(poor[:5])}" if poor else ""
    if badly or shifted:
        problem = f"only {said}{fewest}; {of_what}" if badly else shifted
        warnings.warn(VbbenchWarning(f"{folder}: {problem}"), stacklevel=3)
    return f"{kept} of {boxes.sum()} boxes kept"


@dataclass(frozen=True)
class TrackedPlan:
    """The plan of a dataset made from tracks (`vbbench.generation.generator.Plan`).

    Parameters
    ----------
    files : a file for each sequence, by its number in ``dataset``.
    pixel_std : the noise in px that the new dataset declares.
    least_track : fewest frames in which a track that counts is matched.
    person_class : class of people in the files, where they do not show it.
    """

    dataset: Dataset
    files: dict[int, Path]
    pixel_std: float
    least_track: int = LEAST_FRAMES
    person_class: str | None = None

    def __len__(self) -> int:
        return len(self.files)

    @cached_property
    def contents(self) -> list[BoxRows]:
        """The rows of each file."""
        return [_tracks(path, self.dataset, number, self.person_class) for number, path in self.files.items()]

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
            "least_frames": self.least_track,
            "of": source.definition,
        } | ({} if self.person_class is None else {"person_class": self.person_class})
        facts: dict[str, Any] = {"definition": definition, "counts": {}, "tables": {}, "withheld_id": None}
        return replace(source, tier="tracked", scenes=names, pixel_std=self.pixel_std, **facts)

    def match(self, index: int, *, shifts: bool = False) -> "Matched":
        """The tracks of one sequence, with the person behind each box; their offset is found only with ``shifts``."""
        source, rows = self.dataset.sequence(list(self.files)[index]), self.contents[index]
        camera, (people, positions, heights) = self.dataset.camera(source), self.dataset.surroundings(source)
        others = people != source.observer
        true = true_rectangles(positions[:, others], heights[others], self.dataset.truth(source).poses, camera)
        tracks, dense = rows.dense(source.frames, rows.boxes, np.nan_to_num(rows.visible, nan=1.0))
        boxes = dense[..., :4]
        persons = match_tracks(boxes, true, people[others], camera)
        offset = frame_offset(boxes, lambda frames, later: true[frames + later], camera.period) if shifts else None
        return Matched(source, tracks, observations_of(boxes, camera), dense[..., 4], persons, offset)

    def build(self, index: int) -> SequenceData:
        """Match the tracks of one sequence, and drop those that match no person; its world is that of the source."""
        found = self.match(index)
        source, kept = found.source, lasting_tracks(found.persons, self.least_track)
        matched, observations = found.persons[:, kept], found.observations[:, kept]
        persons = held_persons(matched, ~np.isnan(observations[..., 2]))
        truth = self.dataset.truth(source, persons)
        sequence = replace(
            source,
            index=index,
            scene=self._scene_numbers.index(source.scene) if self._shared else index,
            tracks=found.tracks[kept],
            observations=observations,
            visible=found.visible[:, kept],
            given=arrivals_given(truth, matched != NOBODY),
        )
        scene, world = None if self._shared else scene_of(self.dataset, source.scene), self.dataset.world(source)
        return SequenceData(sequence=sequence, truth=truth, persons=persons, scene=scene, world=world)

    @cached_property
    def _scene_numbers(self) -> list[int]:
        return sorted({int(self.dataset.rows["scene"][number]) for number in self.files})

    @property
    def _shared(self) -> bool:
        return len(set(self.dataset.rows["scene"].tolist())) < len(self.dataset)


class Matched(NamedTuple):
    """A sequence's tracks [K]: their boxes [T, K, 3], visible fractions and the person behind each [T, K].

    ``offset`` is a shift in frames under which they fit people better; ``None`` without one.
    """

    source: Sequence
    tracks: IntArray
    observations: FloatArray
    visible: FloatArray
    persons: IntArray
    offset: FrameOffset | None


def _files(folder: Path, sequences: int) -> dict[int, Path]:
    """Each sequence's file, by number."""
    texts = sorted(folder.glob("*.txt")) or sorted([*folder.glob("*.csv"), *folder.glob("*.json")])
    named = {path: path.stem for path in texts}
    named = named or {path: path.parent.parent.name for path in sorted(folder.glob("sequence-*/gt/gt.txt"))}
    if not named:
        wanted = "sequence-000000.txt, or sequence-000000/gt/gt.txt, for sequence 0, and so on"
        raise FileError(folder, f"holds no tracks; files are called {wanted}")
    return files_by_sequence(named, sequences)


def _tracks(path: Path, dataset: Dataset, number: int, person_class: str | None) -> BoxRows:
    """The boxes of a file, which may be empty."""
    body, *_ = split_header(decode(path, path.read_bytes()), NOUNS)
    if body.strip() in (b"", b"[]"):
        nothing = np.empty(0)
        return rows_of(path, nothing.astype(np.int64), nothing.astype(np.int64), nothing.reshape(0, 4), nothing)
    picture, dt = dataset.camera(dataset.sequence(number)).picture_size, dataset.info.dt
    rows = read_boxes(path, dt, picture=picture, person_class=person_class)
    for note in rows.notes:
        warnings.warn(VbbenchWarning(f"{path}: {note}"), stacklevel=2)
    if not rows.linked:
        raise rows.fault(0, "id is -1: these are detections; let a tracker link them first")
    return rows_in_frames(rows, int(dataset.rows["frames"][number]), dt)
