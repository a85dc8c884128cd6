"""Whether the tables of a dataset fit one another, so that rows can be put into dense arrays."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError
from vbbench.geometry import IntArray

FEW_CELLS, CELLS_PER_ROW = 10**6, 5000
"""A sequence or scene has so many frames times people or fewer, or so many for each row that fills them."""

Rows = dict[str, NDArray[Any]]
PathOf = Callable[[str], Path]


def check_sequence(path_of: PathOf, index: int, frames: int, boxes: Rows, given: Rows, tracks: IntArray) -> None:
    """Check the rows of sequence ``index``.

    Parameters
    ----------
    path_of : where a table lies, by name.
    frames : frames of the sequence.
    boxes, given : its rows of the tables of these names.
    tracks : [K] who is observed.

    Raises
    ------
    FileError
        If a row has a frame or somebody that the sequence has not, or nearly all of it would be empty.
    """
    for name, rows in (("observations", boxes), ("given", given)):
        if not _all_below(rows["frame"], frames):
            raise _contradiction(path_of(name), f"sequence {index} has {frames:,} frames, and a row another one")
    people = given["track"][given["track"] >= 0]
    if not np.isin(people, tracks).all():
        raise _contradiction(path_of("given"), f"in sequence {index} it gives somebody who is never observed")
    if frames * max(1, len(tracks)) > _most_cells(len(boxes["frame"]) + len(given["frame"])):
        problem = f"sequence {index} has {frames:,} frames with {len(boxes['frame']):,} boxes"
        raise _contradiction(path_of("sequences"), problem)


def check_scene(path_of: PathOf, scene: int, people: IntArray, rows: Rows) -> int:
    """Check the true rows of a scene with ``people`` [K]; return how many frames it has.

    Raises
    ------
    FileError
        If people are not in order, a row is of somebody else, or nearly all of the scene would be empty.
    """
    if not (np.diff(people) > 0).all() or not np.isin(rows["person"], people).all():
        raise _contradiction(path_of("truth/people"), f"scene {scene} has people twice, unsorted or unknown")
    if not _all_below(rows["frame"], _most_cells(len(rows["frame"])) // max(1, len(people))):
        raise _contradiction(path_of("truth/scenes"), f"scene {scene} has a frame far from all others, or below 0")
    return int(rows["frame"].max(initial=-1)) + 1


def check_truth_rows(
    path_of: PathOf, index: int, frames: range, poses: Rows, scene_frames: int, people: IntArray
) -> None:
    """Check that sequence ``index``, ``frames`` of a scene, has a true pose in each, and lies in the scene.

    Raises
    ------
    FileError
        If it does not.
    """
    if not np.array_equal(poses["frame"], np.arange(len(frames))):
        raise _contradiction(path_of("truth/poses"), f"sequence {index} has {len(frames):,} frames")
    if not len(people) or frames.stop > scene_frames:
        raise _contradiction(path_of("truth/scenes"), f"sequence {index} goes on after its scene, or nobody is in it")


def check_tracks(path_of: PathOf, index: int, frames: int, tracks: IntArray, rows: Rows) -> None:
    """Check that the true persons of sequence ``index`` are those of ``tracks`` [K] in its ``frames`` frames.

    Raises
    ------
    FileError
        If they are not.
    """
    if not _all_below(rows["frame"], frames) or not np.isin(rows["track"], tracks).all():
        raise _contradiction(path_of("truth/tracks"), f"it tells of a box that sequence {index} has not")


def _all_below(values: NDArray[Any], end: int) -> bool:
    """Whether all are indices of ``end`` things."""
    return bool(((values >= 0) & (values < end)).all())


def _most_cells(rows: int) -> int:
    return max(FEW_CELLS, CELLS_PER_ROW * rows)


def _contradiction(path: Path, problem: str) -> FileError:
    return FileError(path, f"does not fit the other tables: {problem}; generate the dataset again")
