"""MOTChallenge text: one box a line, ``frame,id,left,top,width,height,conf,class,visibility``.

Frames and boxes are 1-based in it: frame 1 is a sequence's frame 0, and left = 1 is the left edge of the picture
(MOT16, arXiv 1603.00831, section 3.2). Here both count from 0.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.arrays import FloatArray, IntArray, frozen_array
from vbbench.errors import FileError
from vbbench.tables import write_text_atomically

UNLINKED = -1
"""Track of a detection that nobody linked."""
PEDESTRIAN = 1
"""The class of walking people."""
_COLUMNS = ("frame", "id", "left", "top", "width", "height", "conf", "class", "visibility")
_NEEDED, _MOST, _TRUTH_COLUMNS = 6, 10, 9
_LARGEST_ID = 2**31 - 1


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
    kept = []
    for line, text in enumerate(path.read_text("utf-8-sig", errors="replace").splitlines(), 1):
        if text.strip() and not text.lstrip().startswith("#"):
            row = _row(path, line, text, frames)
            if _counts(row):
                kept.append([*row, line])
    table = np.array(kept, dtype=np.float64).reshape(-1, _TRUTH_COLUMNS + 1)
    visible = np.where(table[:, 8] == UNLINKED, 1.0, table[:, 8])
    rows = MotRows(
        frame=table[:, 0].astype(np.int64) - 1,
        track=table[:, 1].astype(np.int64),
        boxes=table[:, 2:6] - np.array([1.0, 1.0, 0.0, 0.0]),
        confidence=table[:, 6],
        visible=visible,
        line=table[:, 9].astype(np.int64),
    )
    _refuse_repetition(path, rows)
    return rows


def _row(path: Path, line: int, text: str, frames: int) -> list[float]:
    """The nine numbers of a line; class and visibility are -1 where they are not told."""
    cells = text.split(",")
    if not _NEEDED <= len(cells) <= _MOST:
        wanted = ",".join(_COLUMNS)
        raise FileError(path, f"{len(cells)} columns with commas between, wanted {_NEEDED} to {_MOST}: {wanted}", line)
    told = len(_COLUMNS) if len(cells) == _TRUTH_COLUMNS else 7
    row = [_number(path, line, name, cell) for name, cell in zip(_COLUMNS[:told], cells, strict=False)]
    row += [1.0, -1.0, -1.0][len(row) - _NEEDED :]
    problem = _problem(row, frames)
    if problem:
        raise FileError(path, problem, line)
    return row


def _number(path: Path, line: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        raise FileError(path, f"{name} is '{cell.strip()}'; write a number", line) from None
    if not np.isfinite(value):
        raise FileError(path, f"{name} is {cell.strip()}; write a finite number", line)
    return value


def _problem(row: list[float], frames: int) -> str | None:
    """What is wrong with the numbers of a line."""
    frame, track, _, _, width, height, _, _, visible = row
    if not frame.is_integer() or not 1 <= frame <= frames:
        return f"frame {frame:.10g} is none of the sequence; its frames are 1 to {frames}"
    if not track.is_integer() or not UNLINKED <= track <= _LARGEST_ID:
        return f"id {track:.10g} is no whole number from 0 on (or -1 for a detection)"
    if width <= 0 or height <= 0:
        return f"the box is {width:g} x {height:g} px; leave out frames without a box"
    if visible != UNLINKED and not 0.0 <= visible <= 1.0:
        return f"visibility is {visible:g}; it is a fraction between 0 and 1 (or -1: unknown)"
    return None


def _counts(row: list[float]) -> bool:
    _, _, _, _, _, _, confidence, kind, visible = row
    return kind == UNLINKED or (kind == PEDESTRIAN and confidence != 0.0 and visible != 0.0)


def _refuse_repetition(path: Path, rows: MotRows) -> None:
    linked = np.flatnonzero(rows.track != UNLINKED)
    pairs = np.stack([rows.frame[linked], rows.track[linked]], axis=-1)
    _, first, place = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    again = np.flatnonzero(first[place.reshape(-1)] != np.arange(len(linked)))
    if len(again):
        now = linked[again[0]]
        before = rows.line[linked[first[place.reshape(-1)[again[0]]]]]
        problem = f"id {rows.track[now]} already has a box in frame {rows.frame[now] + 1}, in line {before}"
        raise FileError(path, f"{problem}; leave one of them out", int(rows.line[now]))
