"""Boxes of anybody's detector or tracker on the pictures of a recording."""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.box_tables import UNLINKED, scores_as_shares
from vbbench.exchange.own.box_files import frames_of, read_boxes
from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze

LEAST_SCORE = 0.0
"""Log-odds that a detection must have more of to count; even odds."""
UNKNOWN = -1.0
"""A score that says nothing."""


@dataclass(frozen=True, kw_only=True)
class FoundBoxes:
    """Boxes of a detector or tracker, one a row.

    Parameters
    ----------
    path : the file, for messages.
    frame : [N] from 0.
    track : [N] ids, `UNLINKED` for detections.
    boxes : [N, 4] (left, top, width, height) in px.
    scores : [N] from 0 to 1.
    lines : [N] line numbers.
    """

    path: Path
    frame: IntArray
    track: IntArray
    boxes: FloatArray
    scores: FloatArray
    lines: IntArray

    def __post_init__(self) -> None:
        count = len(self.frame)
        freeze(self, np.int64, frame=(count,), track=(count,), lines=(count,))
        freeze(self, boxes=(count, 4), scores=(count,))

    def __len__(self) -> int:
        return len(self.frame)

    def at(self, frames: IntArray, kept: BoolArray) -> "FoundBoxes":
        """Those marked in ``kept`` [N], in other ``frames`` [N]."""
        own = {name: getattr(self, name)[kept] for name in ("track", "boxes", "scores", "lines")}
        return FoundBoxes(path=self.path, frame=frames[kept], **own)

    def within(self, frames: int) -> "FoundBoxes":
        """The same; raises FileError at the first box that is not of a recording of ``frames`` frames."""
        beyond = (self.frame < 0) | (self.frame >= frames)
        if beyond.any():
            row = int(beyond.argmax())
            problem = f"frame {self.frame[row]}, counted from 0, is beyond the recording of {frames} frames"
            raise FileError(self.path, problem, int(self.lines[row]) or None)
        return self


def read_found(
    path: Path, frames: int, dt: float, picture: tuple[float, float], person_class: str | None = None
) -> FoundBoxes:
    """Sure enough boxes of people on a recording of ``frames`` frames, in any form that `birdify` reads.

    Parameters
    ----------
    dt : seconds per frame, by which time stamps are frames; 0 is the first one.
    picture : width and height in px, for boxes that are shares of it.
    person_class : class of people, by number or name, where the file does not show it.

    Raises
    ------
    FileError
        At the first row that is not valid, or of no frame of the recording.
    """
    rows = read_boxes(path, dt, picture=picture, person_class=person_class)
    for note in rows.notes:
        warnings.warn(VbbenchWarning(f"{path}: {note}"), stacklevel=2)
    frame = frames_of(rows, frames, dt)
    return found_boxes(path, frame, rows.track, rows.boxes, rows.scores, rows.lines)


def found_boxes(
    path: Path, frame: IntArray, track: IntArray, boxes: FloatArray, scores: FloatArray, lines: IntArray
) -> FoundBoxes:
    """Those of the boxes that are sure enough: their scores [N] are above `LEAST_SCORE`, log-odds or shares.

    Where all are −1, as MOTChallenge writes what is not known, all count.

    Raises
    ------
    FileError
        If some rows have ids and others none.
    """
    known = np.where((scores == UNKNOWN).all(), np.nan, scores)
    sure = ~(known <= LEAST_SCORE)
    loose = sure & (track < 0)
    if loose.any() and not loose[sure].all():
        problem = "id is -1, but other rows have ids; write ids in all rows, or in none, to have them linked"
        raise FileError(path, problem, int(lines[loose.argmax()]) or None)
    return FoundBoxes(
        path=path,
        frame=frame[sure],
        track=np.where(track[sure] < 0, UNLINKED, track[sure]),
        boxes=boxes[sure],
        scores=scores_as_shares(known)[sure],
        lines=lines[sure],
    )


def file_for(given: Path, name: str, several: bool) -> Path:
    """The file of a sequence in a folder that the user names, or the file itself if there is one sequence alone.

    Text is looked for first, then whatever else is called like the sequence.

    Raises
    ------
    VbbenchError
        If one file is named for several sequences, or the file is not there.
    """
    if given.is_file():
        if several:
            raise VbbenchError(
                f"{given} is one file; name a folder with a file for each sequence, {name}.txt and so on"
            )
        return given
    path = given / f"{name}.txt"
    if path.is_file():
        return path
    other = next((one for one in sorted(given.iterdir()) if one.stem == name), None) if given.is_dir() else None
    if other is None:
        raise FileError(path, "is missing; files for a sequence are called like it, in a folder or named alone")
    return other
