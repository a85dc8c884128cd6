"""MOTChallenge text: one box a line, ``frame,id,left,top,width,height,conf,class,visibility``.

Frames and boxes are 1-based in it: frame 1 is a sequence's frame 0, and left = 1 is the left edge of the picture
(MOT16, arXiv 1603.00831, section 3.2). Here both count from 0. A first line of names says in which order the columns
are, and decimal numbers in place of frames are time stamps in s, 0 that of the first frame.
"""

import warnings
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchWarning
from vbbench.exchange.box_rows import BoxRows, tracks_of
from vbbench.exchange.box_tables import UNLINKED as UNLINKED
from vbbench.exchange.box_tables import BoxTable, people_in, read_box_text
from vbbench.folders.replacing import write_text_atomically

PEDESTRIAN = 1
"""The class of walking people."""


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


def read_mot(path: Path, frames: int) -> BoxRows:
    """Read MOTChallenge text of a sequence of ``frames`` frames.

    Lines have 6 to 10 columns. Rows of another class than people, and those that ground truth marks as ignored (conf 0
    or visibility 0), are left out, as in the evaluation of MOTChallenge, with a warning that counts them.

    Raises
    ------
    FileError
        If classes do not show which is of people; with the line, as `read_box_text` and `numbered_rows`.
    """
    if not path.is_file():
        raise FileError(path, "the file is missing")
    table = read_box_text(path, path.read_bytes())
    kept, notes = people_in(table) if not table.ignored.all() else (~table.ignored, ())
    for note in notes:
        warnings.warn(VbbenchWarning(f"{path}: {note}"), stacklevel=2)
    return numbered_rows(table.select(kept), frames)


def numbered_rows(table: BoxTable, frames: int) -> BoxRows:
    """The boxes of a table of one sequence of ``frames`` frames.

    Raises
    ------
    FileError
        At the first line whose frame is not one of the ``frames``; or as `tracks_of` and `BoxRows.check`.
    """
    frame = table.frame - table.base
    wrong = (frame != np.round(frame)) | (frame < 0) | (frame >= frames)
    if wrong.any():
        row, first = int(wrong.argmax()), table.base
        known = f"its frames are {first} to {first + frames - 1}"
        raise table.table.fault(row, f"frame {frame[row] + first:.10g} is not in the sequence; {known}")
    track, ids, _ = tracks_of(table)
    rows = BoxRows(
        path=table.path,
        frame=frame.astype(np.int64),
        track=track,
        boxes=table.boxes,
        scores=table.scores,
        visible=table.visible,
        lines=table.lines,
        ids=ids,
    )
    rows.check()
    return rows
