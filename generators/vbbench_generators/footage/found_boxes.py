"""Boxes of anybody's detector or tracker on the pictures of a recording, and how MOTChallenge text holds them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.mot.text import read_mot
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


def boxes_of_mot(path: Path, frames: int) -> FoundBoxes:
    """Sure enough boxes of MOTChallenge text on a recording of ``frames`` frames.

    Raises
    ------
    FileError
        At the first row that is not valid.
    """
    rows = read_mot(path, frames)
    scores, sure = chances(rows.confidence)
    refuse_mixture(path, rows.track[sure], rows.line[sure])
    return FoundBoxes(
        path=path,
        frame=rows.frame[sure],
        track=rows.track[sure],
        boxes=rows.boxes[sure],
        scores=scores[sure],
        lines=rows.line[sure],
    )


def chances(scores: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Scores [N] from 0 to 1, and which are sure enough [N].

    Scores that leave this range are log-odds, and count above `LEAST_SCORE`; others are left to the tracker. Where all
    are −1, as MOTChallenge writes what is not known, all count.
    """
    if (scores == UNKNOWN).all():
        return np.ones(len(scores)), np.ones(len(scores), np.bool_)
    if scores.size and scores.min() >= 0.0 and scores.max() <= 1.0:
        return scores, scores > 0.0
    return 1.0 / (1.0 + np.exp(-np.clip(scores, -50.0, 50.0))), scores > LEAST_SCORE


def refuse_mixture(path: Path, track: IntArray, lines: IntArray) -> None:
    """Raise FileError if some rows have ids and others none."""
    loose = track < 0
    if loose.any() and not loose.all():
        problem = "id is -1, but other rows have ids; write ids in all rows, or in none, to have them linked"
        raise FileError(path, problem, int(lines[loose.argmax()]))


def file_for(given: Path, name: str, several: bool) -> Path:
    """The file of a sequence in a folder that the user names, or the file itself if there is one sequence alone.

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
    if not path.is_file():
        raise FileError(path, "is missing; files for a sequence are called like it, in a folder or named alone")
    return path
