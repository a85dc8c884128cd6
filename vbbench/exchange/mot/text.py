"""MOTChallenge text: one box a line, ``frame,id,left,top,width,height,conf,class,visibility``.

Frames and boxes are 1-based in it: frame 1 is a sequence's frame 0, and left = 1 is the left edge of the picture
(MOT16, arXiv 1603.00831, section 3.2). Here both count from 0. A first line of names says in which order the columns
are, and decimal numbers in place of frames are time stamps in s, 0 that of the first frame.
"""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchWarning
from vbbench.exchange.box_tables import UNLINKED as UNLINKED
from vbbench.exchange.box_tables import BoxTable, people_in, read_box_text
from vbbench.files.tables import LARGEST_ID
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze
from vbbench.parsing.rows import first_repetition

PEDESTRIAN = 1
"""The class of walking people."""
COLUMNS = ("frame", "id", "left", "top", "width", "height", "conf", "class", "visibility")
FARTHEST = 1e6
"""Largest side or size of a box in px."""
_OFF_FRAME = 0.25
"""How far a time stamp may be from its frame, in frames."""


@dataclass(frozen=True)
class MotTable:
    """Rows as they are in a file.

    Parameters
    ----------
    table : what was read.
    values : [N, 9] numbers, by `COLUMNS`, frames and boxes from 1; class and visibility −1 where they are not known.
    """

    table: BoxTable
    values: FloatArray

    @property
    def path(self) -> Path:
        """The file, for messages."""
        return self.table.path

    @property
    def lines(self) -> IntArray:
        """[N] line numbers, from 1."""
        return self.table.lines

    def select(self, kept: BoolArray) -> "MotTable":
        """The rows marked in ``kept`` [N]."""
        return MotTable(self.table.select(kept), self.values[kept])

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
        return self.table.boxes

    def in_frames(self, dt: float) -> "MotTable":
        """The same with the frame nearest to each time stamp, if it has those; ``dt`` seconds per frame.

        Raises
        ------
        FileError
            At the first stamp that lies between two frames.
        """
        if not self.table.timed:
            return self
        exact = self.values[:, 0] / dt
        wrong = np.abs(exact - np.round(exact)) > _OFF_FRAME
        if wrong.any():
            row = int(wrong.argmax())
            problem = f"time {self.values[row, 0]:.10g} s lies between two frames; frame n is at n x {dt:g} s, from 0"
            raise FileError(self.path, problem, int(self.lines[row]))
        values = self.values.copy()
        values[:, 0] = np.round(exact) + 1.0
        return MotTable(self.table, values)

    def of_pedestrians(self) -> "MotTable":
        """The rows that count: of people, not ignored, not wholly hidden; a warning says what is left out.

        Raises
        ------
        FileError
            If classes do not show which is of people (`vbbench.exchange.person_classes`).
        """
        if self.table.ignored.all():
            return self.select(~self.table.ignored)
        kept, notes = people_in(self.table)
        for note in notes:
            warnings.warn(VbbenchWarning(f"{self.path}: {note}"), stacklevel=3)
        return self.select(kept)

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
    """Parse MOTChallenge text, or a text whose columns have names; blank lines and comments (``#``) are skipped.

    Ids of 64 bits are numbered from 1 on.

    Parameters
    ----------
    path : the file, for messages.
    content : the text.
    least, most : how many columns a line without names may have.

    Raises
    ------
    FileError
        At the first line with another number of columns, or with something other than finite numbers.
    """
    table = read_box_text(path, content, columns=(least, most))
    values = np.empty((len(table.frame), len(COLUMNS)))
    values[:, 0] = table.frame if table.timed else table.frame + (1 - table.base)
    values[:, 1] = table.table.numbers("id") if "id" in table.table else UNLINKED
    if table.id.dtype.kind != "f" and len(values) and values[:, 1].max() > LARGEST_ID:
        linked = values[:, 1] >= 0
        values[linked, 1] = 1 + np.unique(table.id[linked], return_inverse=True)[1]
    values[:, 2:6] = table.boxes + np.array([1.0, 1.0, 0.0, 0.0])
    values[:, 6] = table.table.numbers("score", 1.0)
    values[:, 7] = table.classes if table.classes.dtype.kind in "if" else UNLINKED
    values[:, 8] = np.where(np.isnan(table.visible), UNLINKED, table.visible)
    return MotTable(table, values)


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

    Lines have 6 to 10 columns. Rows of another class than people, and those that ground truth marks as ignored (conf 0
    or visibility 0), are left out, as in the evaluation of MOTChallenge; a visibility that is not known counts as 1.

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
