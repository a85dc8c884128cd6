"""MOTChallenge text: one box a line, ``frame,id,left,top,width,height,conf,class,visibility``.

Frames and boxes are 1-based in it: frame 1 is a sequence's frame 0, and left = 1 is the left edge of the picture
(MOT16, arXiv 1603.00831, section 3.2). Here both count from 0. A first line of names is skipped, and decimal numbers in
place of frames are time stamps in s, 0 that of the first frame.
"""

import re
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv

from vbbench.errors import FileError
from vbbench.files.tables import LARGEST_ID, column_values
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze
from vbbench.parsing.numbers import finite_number
from vbbench.parsing.rows import first_repetition

UNLINKED = -1
"""Track of an unlinked detection; class and visibility if they are unknown."""
PEDESTRIAN = 1
"""The class of walking people."""
COLUMNS = ("frame", "id", "left", "top", "width", "height", "conf", "class", "visibility")
_DEFAULTS = (1.0, -1.0, -1.0)
"""Confidence, class and visibility of lines without them."""
FARTHEST = 1e6
"""Largest side or size of a box in px."""
_FRAME_NAMES, _ID_NAMES = ("frame", "frame_id", "time", "timestamp"), ("id", "track", "track_id", "object_id")
_OFF_FRAME = 0.25
"""How far a time stamp may be from its frame, in frames."""


@dataclass(frozen=True)
class MotTable:
    """Rows as they are in a file.

    Parameters
    ----------
    path : the file, for messages.
    values : [N, 9] numbers, by `COLUMNS`, frames and boxes from 1.
    lines : [N] their line numbers, from 1.
    """

    path: Path
    values: FloatArray
    lines: IntArray

    def select(self, kept: BoolArray) -> "MotTable":
        """The rows marked in ``kept`` [N]."""
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

    def in_frames(self, dt: float) -> "MotTable":
        """The same with the frame nearest to each time stamp, if not all are whole; ``dt`` seconds per frame.

        Raises
        ------
        FileError
            At the first stamp that lies between two frames.
        """
        if (self.values[:, 0] == np.round(self.values[:, 0])).all():
            return self
        exact = self.values[:, 0] / dt
        wrong = np.abs(exact - np.round(exact)) > _OFF_FRAME
        if wrong.any():
            row = int(wrong.argmax())
            problem = f"time {self.values[row, 0]:.10g} s lies between two frames; frame n is at n x {dt:g} s, from 0"
            raise FileError(self.path, problem, int(self.lines[row]))
        values = self.values.copy()
        values[:, 0] = np.round(exact) + 1.0
        return MotTable(self.path, values, self.lines)

    def of_pedestrians(self) -> "MotTable":
        """The rows that the evaluation of MOTChallenge counts: class 1 or unknown, not ignored, not wholly hidden."""
        confidence, kind, visible = self.values[:, 6:].T
        return self.select((kind == UNLINKED) | ((kind == PEDESTRIAN) & (confidence != 0.0) & (visible != 0.0)))

    def check(self, frames: int) -> None:
        """Check that every row can be of a sequence of ``frames`` frames.

        Raises
        ------
        FileError
            At the first line with a frame beyond the sequence, an invalid id, a box without size, or a visibility that
            is not a fraction.
        """
        frame, track, _, _, width, height, _, _, visible = self.values.T
        reach = np.abs(self.values[:, 2:6]).max(axis=1, initial=0.0)
        checks = (
            (
                (frame != np.round(frame)) | (frame < 1) | (frame > frames),
                "frame {0:.10g} is not in the sequence; its frames are 1 to {frames}",
            ),
            (
                (track != np.round(track)) | (track < UNLINKED) | (track > LARGEST_ID),
                "id {1:.10g} is not a whole number from 0 on (or -1 for a detection)",
            ),
            ((width <= 0) | (height <= 0), "the box is {4:g} x {5:g} px; leave out frames without a box"),
            (reach > FARTHEST, "the box reaches {reach:g} px; boxes are in px of the picture"),
            (
                (visible != UNLINKED) & ((visible < 0.0) | (visible > 1.0)),
                "visibility is {8:g}; it is a fraction between 0 and 1 (or -1: unknown)",
            ),
        )
        bad = np.any([wrong for wrong, _ in checks], axis=0)
        if bad.any():
            row = int(bad.argmax())
            problem = next(text for wrong, text in checks if wrong[row])
            text = problem.format(*self.values[row], frames=frames, reach=reach[row])
            raise FileError(self.path, text, int(self.lines[row]))

    def refuse_repetition(self) -> None:
        """Refuse a track that has two boxes in a frame; rows without a track may repeat.

        Raises
        ------
        FileError
            At the first line that repeats an earlier one.
        """
        linked = np.flatnonzero(self.track != UNLINKED)
        found = first_repetition(self.frame[linked], self.track[linked])
        if found is not None:
            before, again = linked[list(found)]
            box = f"id {self.track[again]} already has a box in frame {self.frame[again] + 1}"
            raise FileError(
                self.path, f"{box}, in line {self.lines[before]}; leave one of them out", int(self.lines[again])
            )


def parse_mot(path: Path, content: bytes, *, least: int = 6, most: int = 10) -> MotTable:
    """Parse MOTChallenge text; blank lines, comments (``#``) and a first line of names are skipped.

    Parameters
    ----------
    path : the file, for messages.
    content : the text, UTF-8.
    least, most : how many columns a line may have. Lines without all 9 have neither class nor visibility.

    Raises
    ------
    FileError
        At the first line with another number of columns, or with something other than finite numbers; or if names in
        the first line are in another order.
    """
    content, begin = _after_names(path, content)
    values = _read_even(content, least, most)
    if values is not None:
        return MotTable(path, values, np.arange(begin, begin + len(values)))
    rows, lines = [], []
    for line, text in enumerate(re.split("\r\n|\r|\n", content.decode("utf-8-sig", errors="replace")), begin):
        if text.strip() and not text.lstrip().startswith("#"):
            rows.append(_row(path, line, text, least, most))
            lines.append(line)
    return MotTable(path, np.array(rows, np.float64).reshape(-1, len(COLUMNS)), np.array(lines, np.int64))


def _after_names(path: Path, content: bytes) -> tuple[bytes, int]:
    """The text after a first line of names, and the number of its first line."""
    first, _, rest = content.partition(b"\n")
    names = [cell.strip(" \t\r\"'\ufeff").lower() for cell in first[:1000].decode("utf-8", "replace").split(",")]
    if names[0] not in _FRAME_NAMES:
        return content, 1
    if len(names) < 2 or names[1] not in _ID_NAMES:
        raise FileError(path, f"the first line names columns in another order; write {','.join(COLUMNS)}", 1)
    return rest, 2


def _read_even(content: bytes, least: int, most: int) -> FloatArray | None:
    """The rows [N, 9] of a text whose lines are all alike, in finite numbers; else ``None``."""
    count = content.partition(b"\n")[0].count(b",") + 1
    if not least <= count <= most:
        return None
    names = [str(column) for column in range(count)]
    read = names[: _columns_read(count)]
    convert = csv.ConvertOptions(column_types=dict.fromkeys(read, pa.float64()), include_columns=read, null_values=[])
    parse = csv.ParseOptions(quote_char=False, ignore_empty_lines=False)
    try:
        table = csv.read_csv(BytesIO(content), csv.ReadOptions(column_names=names), parse, convert)
    except pa.ArrowException:
        return None
    values = np.empty((len(table), len(COLUMNS)))
    values[:, 6:] = _DEFAULTS
    for column, cells in enumerate(table.columns):
        values[:, column] = column_values(cells)
    return values if np.isfinite(values).all() else None


def _columns_read(columns: int) -> int:
    """How many of `COLUMNS` are read from a line of ``columns``."""
    return len(COLUMNS) if columns == len(COLUMNS) else min(columns, 7)


def _row(path: Path, line: int, text: str, least: int, most: int) -> list[float]:
    """The nine numbers of a line."""
    cells = text.split(",")
    if not least <= len(cells) <= most:
        wanted = f"{least}" if least == most else f"{least} to {most}"
        problem = f"{len(cells)} columns with commas between, wanted {wanted}: {','.join(COLUMNS)}"
        raise FileError(path, problem, line)
    names = COLUMNS[: _columns_read(len(cells))]
    row = [finite_number(path, line, name, cell) for name, cell in zip(names, cells, strict=False)]
    return row + list(_DEFAULTS[len(row) - 6 :])


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
        freeze(self, np.int64, frame=(count,), track=(count,), line=(count,))
        freeze(self, confidence=(count,), visible=(count,), boxes=(count, 4))


def write_mot(path: Path, rows: MotRows) -> None:
    """Write MOTChallenge text: tracks with class and visibility (9 columns), detections without (10, three are -1)."""
    numbers = np.column_stack([rows.boxes[:, :2] + 1.0, rows.boxes[:, 2:]]).tolist()
    lines = [
        f"{frame + 1},{track},{','.join(map(repr, box))},{confidence:g},"
        + ("-1,-1,-1\n" if track == UNLINKED else f"{PEDESTRIAN},{visible:.6g}\n")
        for frame, track, box, confidence, visible in zip(
            rows.frame, rows.track, numbers, rows.confidence, rows.visible, strict=True
        )
    ]
    write_text_atomically(path, "".join(lines))


def read_mot(path: Path, frames: int, dt: float | None = None) -> MotRows:
    """Read MOTChallenge text of a sequence of ``frames`` frames; with ``dt`` s per frame, time stamps are read, too.

    Lines have 6 to 10 columns. In those with 9, as in ground truth, rows of conf 0, of another class than 1 (or -1),
    and of visibility 0 are left out, as in the evaluation of MOTChallenge; in others class and visibility are unknown
    and count as 1.

    Raises
    ------
    FileError
        With the line: wrong number of columns, text or NaN in a number, or as in `MotTable.in_frames`,
        `MotTable.check` and `MotTable.refuse_repetition`.
    """
    if not path.is_file():
        raise FileError(path, "the file is missing")
    table = parse_mot(path, path.read_bytes())
    table = table if dt is None else table.in_frames(dt)
    table.check(frames)
    table = table.of_pedestrians()
    table.refuse_repetition()
    confidence, _, visible = table.values[:, 6:].T
    return MotRows(
        frame=table.frame,
        track=table.track,
        boxes=table.boxes,
        confidence=confidence,
        visible=np.where(visible == UNLINKED, 1.0, visible),
        line=table.lines,
    )
