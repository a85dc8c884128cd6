"""MOTChallenge text: one box a line, ``frame,id,left,top,width,height,conf,class,visibility``.

Frames and boxes are 1-based in it: frame 1 is a sequence's frame 0, and left = 1 is the left edge of the picture
(MOT16, arXiv 1603.00831, section 3.2). Here both count from 0.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.mot.table import UNLINKED, parse_mot
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import BoolArray, FloatArray, IntArray, frozen_array

PEDESTRIAN = 1
"""The class of walking people."""


@dataclass(frozen=True, kw_only=True)
class MotRows:
    """Boxes of one sequence, one a row.

    Parameters
    ----------
    frame : [N] from 0.
    track : [N] ids, `UNLINKED` for detections.
    boxes : [N, 4] (left, top, width, height) in px from 0.
    confidence : [N] the detector's or tracker's.
    visible : [N] visible fraction in (0, 1].
    line : [N] line of the file, from 1.
    """

    frame: IntArray
    track: IntArray
    boxes: FloatArray
    confidence: FloatArray
    visible: FloatArray
    line: IntArray

    def __post_init__(self) -> None:
        count = len(self.frame)
        for name in ("frame", "track", "line"):
            object.__setattr__(self, name, frozen_array(name, getattr(self, name), (count,), np.int64))
        for name in ("confidence", "visible"):
            object.__setattr__(self, name, frozen_array(name, getattr(self, name), (count,)))
        object.__setattr__(self, "boxes", frozen_array("boxes", self.boxes, (count, 4)))


def write_mot(path: Path, rows: MotRows) -> None:
    """Write MOTChallenge text: tracks with class and visibility (9 columns), detections without (10, three are -1)."""
    numbers = np.column_stack([rows.boxes[:, :2] + 1.0, rows.boxes[:, 2:]]).tolist()
    lines = [
        f"{frame + 1},{track},{','.join(map(repr, box))},{confidence:g},"
        + ("-1,-1,-1\n" if track == UNLINKED else f"{PEDESTRIAN},{visible:.6g}\n")
        for frame, track, box, confidence, visible in zip(
            rows.frame.tolist(),
            rows.track.tolist(),
            numbers,
            rows.confidence.tolist(),
            rows.visible.tolist(),
            strict=True,
        )
    ]
    write_text_atomically(path, "".join(lines))


def read_mot(path: Path, frames: int) -> MotRows:
    """Read MOTChallenge text of a sequence of ``frames`` frames.

    Lines have 6 to 10 columns. In those with 9, as ground truth has them, rows of conf 0, of another class than 1 (or
    -1), and of visibility 0 are left out, as the evaluation of MOTChallenge does; in others class and visibility are
    unknown and count as 1.

    Raises
    ------
    FileError
        With the line: wrong number of columns, text or NaN in a number, a box without size, a frame that the sequence
        has not, an id that is none, or a track that has two boxes in a frame.
    """
    if not path.is_file():
        raise FileError(path, "the file is missing")
    table = parse_mot(path, path.read_bytes())
    table.check(frames)
    table = table.select(_counts(table.values))
    table.refuse_repetition()
    visible = table.values[:, 8]
    return MotRows(
        frame=table.frame,
        track=table.track,
        boxes=table.boxes,
        confidence=table.values[:, 6],
        visible=np.where(visible == UNLINKED, 1.0, visible),
        line=table.lines,
    )


def _counts(values: FloatArray) -> BoolArray:
    """Which rows [N, 9] the evaluation of MOTChallenge counts."""
    confidence, kind, visible = values[:, 6:].T
    counts: BoolArray = (kind == UNLINKED) | ((kind == PEDESTRIAN) & (confidence != 0.0) & (visible != 0.0))
    return counts
