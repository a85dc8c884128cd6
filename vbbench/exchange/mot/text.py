"""MOTChallenge text: one box a line, ``frame,id,left,top,width,height,conf,class,visibility``.

Frames and boxes are 1-based in it: frame 1 is a sequence's frame 0, and left = 1 is the left edge of the picture
(MOT16, arXiv 1603.00831, section 3.2). Here both count from 0.
"""

import re
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv

from vbbench.errors import FileError
from vbbench.files.schemas import column_values
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import BoolArray, FloatArray, IntArray, frozen_array
from vbbench.parsing.numbers import finite_number

UNLINKED = -1
"""Track of a detection that nobody linked; class and visibility where they are not told."""
COLUMNS = ("frame", "id", "left", "top", "width", "height", "conf", "class", "visibility")
_UNTOLD = (1.0, -1.0, -1.0)
"""Confidence, class and visibility of lines without them."""
_LARGEST_ID = 2**31 - 1
FARTHEST = 1e6
"""Px that no side or size of a box is beyond."""


@dataclass(frozen=True)
class MotTable:
    """Rows as they stand in a file.

    Parameters
    ----------
    path : the file, for messages.
    values : [N, 9] numbers, by `COLUMNS`, frames and boxes from 1.
    lines : [N] where they stand, from 1.
    """

    path: Path
    values: FloatArray
    lines: IntArray

    def select(self, kept: BoolArray) -> "MotTable":
        """The rows that are ``kept`` [N]."""
        return MotTable(self.path, self.values[kept], self.lines[kept])

    @property
    def frame(self) -> IntArray:
        """[N] frames from 0."""
        return self.values[:, 0].astype(np.int64) - 1

    @property
    def track(self) -> IntArray:
        """[N] ids."""
        return self.values[:, 1].astype(np.int64)

    @property
    def boxes(self) -> FloatArray:
        """[N, 4] (left, top, width, height) in px from 0."""
        boxes: FloatArray = self.values[:, 2:6] - np.array([1.0, 1.0, 0.0, 0.0])
        return boxes

    def check(self, frames: int) -> None:
        """Check that every row can be of a sequence of ``frames`` frames.

        Raises
        ------
        FileError
            At the first line with a frame that the sequence has not, an id that is none, a box without size, or a
            visibility that is no fraction.
        """
        frame, track, _, _, width, height, _, _, visible = self.values.T
        bad = (frame != np.round(frame)) | (frame < 1) | (frame > frames)
        bad |= (track != np.round(track)) | (track < UNLINKED) | (track > _LARGEST_ID)
        bad |= (width <= 0) | (height <= 0) | (np.abs(self.values[:, 2:6]) > FARTHEST).any(axis=1)
        bad |= (visible != UNLINKED) & ((visible < 0.0) | (visible > 1.0))
        if bad.any():
            row = int(bad.argmax())
            raise FileError(self.path, _problem(self.values[row].tolist(), frames), int(self.lines[row]))

    def refuse_repetition(self) -> None:
        """Refuse a track that has two boxes in a frame; rows without a track may repeat.

        Raises
        ------
        FileError
            At the first line that comes too late.
        """
        linked = np.flatnonzero(self.track != UNLINKED)
        frame, track = self.frame[linked], self.track[linked]
        order = np.lexsort((frame, track))  # stable: of two boxes, the earlier line comes first
        same = (np.diff(track[order]) == 0) & (np.diff(frame[order]) == 0)
        if same.any():
            place = np.flatnonzero(same)
            place = place[order[place + 1].argmin()]
            before, again = linked[order[place]], linked[order[place + 1]]
            box = f"id {self.track[again]} already has a box in frame {self.frame[again] + 1}"
            raise FileError(
                self.path, f"{box}, in line {self.lines[before]}; leave one of them out", int(self.lines[again])
            )


def parse_mot(path: Path, content: bytes, *, least: int = 6, most: int = 10) -> MotTable:
    """Make numbers of MOTChallenge text; blank lines and comments (``#``) are passed over.

    Parameters
    ----------
    path : what messages call it.
    content : the text, UTF-8.
    least, most : how many columns a line may have. Those with 9 have all; others tell no class and no visibility.

    Raises
    ------
    FileError
        At the first line with another number of columns, or with what is no finite number.
    """
    values = _read_even(content, least, most)
    if values is not None:
        return MotTable(path, values, np.arange(1, len(values) + 1))
    rows, lines = [], []
    for line, text in enumerate(re.split("\r\n|\r|\n", content.decode("utf-8-sig", errors="replace")), 1):
        if text.strip() and not text.lstrip().startswith("#"):
            rows.append(_row(path, line, text, least, most))
            lines.append(line)
    return MotTable(path, np.array(rows, np.float64).reshape(-1, len(COLUMNS)), np.array(lines, np.int64))


def _read_even(content: bytes, least: int, most: int) -> FloatArray | None:
    """The rows [N, 9] of a text whose lines are all alike; ``None`` where a line differs, or holds no finite number."""
    count = content.partition(b"\n")[0].count(b",") + 1
    if not least <= count <= most:
        return None
    names = [str(column) for column in range(count)]
    told = names[: _told(count)]
    convert = csv.ConvertOptions(column_types=dict.fromkeys(told, pa.float64()), include_columns=told, null_values=[])
    parse = csv.ParseOptions(quote_char=False, ignore_empty_lines=False)
    try:
        table = csv.read_csv(BytesIO(content), csv.ReadOptions(column_names=names), parse, convert)
    except pa.ArrowException:
        return None
    values = np.empty((len(table), len(COLUMNS)))
    values[:, 6:] = _UNTOLD
    for column, cells in enumerate(table.columns):
        values[:, column] = column_values(cells)
    return values if np.isfinite(values).all() else None


def _told(columns: int) -> int:
    """How many of `COLUMNS` a line of so many tells."""
    return len(COLUMNS) if columns == len(COLUMNS) else min(columns, 7)


def _row(path: Path, line: int, text: str, least: int, most: int) -> list[float]:
    """The nine numbers of a line."""
    cells = text.split(",")
    if not least <= len(cells) <= most:
        wanted = f"{least}" if least == most else f"{least} to {most}"
        problem = f"{len(cells)} columns with commas between, wanted {wanted}: {','.join(COLUMNS)}"
        raise FileError(path, problem, line)
    row = [
        finite_number(path, line, name, cell) for name, cell in zip(COLUMNS[: _told(len(cells))], cells, strict=False)
    ]
    return row + list(_UNTOLD[len(row) - 6 :])


def _problem(row: list[float], frames: int) -> str:
    """What is wrong with the numbers of a line."""
    frame, track, _, _, width, height, _, _, visible = row
    if not frame.is_integer() or not 1 <= frame <= frames:
        return f"frame {frame:.10g} is none of the sequence; its frames are 1 to {frames}"
    if not track.is_integer() or not UNLINKED <= track <= _LARGEST_ID:
        return f"id {track:.10g} is no whole number from 0 on (or -1 for a detection)"
    if width <= 0 or height <= 0:
        return f"the box is {width:g} x {height:g} px; leave out frames without a box"
    if max(map(abs, row[2:6])) > FARTHEST:
        return f"the box reaches {max(map(abs, row[2:6])):g} px; boxes are in px of the picture"
    return f"visibility is {visible:g}; it is a fraction between 0 and 1 (or -1: unknown)"


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
