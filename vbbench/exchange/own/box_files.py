"""Boxes of people in one film: MOTChallenge text, or CSV whose first line names its columns.

gt.txt, det.txt    frame,id,left,top,width,height[,conf,class,visibility]   frames and px from 1; id −1 = not linked
boxes.csv          frame or time, id, left, top, width, height, or u, v, l; score, visible      frames and px from 0
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vbbench.boxes import rectangles
from vbbench.errors import FileError
from vbbench.exchange.mot.text import FARTHEST, UNLINKED, MotTable, parse_mot
from vbbench.exchange.own.named_columns import NamedColumns, read_named
from vbbench.exchange.own.timing import Timeline, number_frames, time_frames
from vbbench.files.tables import LARGEST_ID
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.rows import first_repetition

OPTIONAL = ("id", "score", "visible")

MOST_BACK = 3
"""Times that a clock goes back; a file whose times do so more often is in no order."""


@dataclass(frozen=True, kw_only=True)
class BoxRows:
    """The boxes of one recording, one a row.

    Parameters
    ----------
    path : the file, for messages.
    frame : [N] from 0.
    track : [N] ids; all `UNLINKED` for detections that no tracker has linked.
    boxes : [N, 4] (left, top, width, height) in px from 0.
    scores : [N] of the detector, from 0 to 1; NaN where it says nothing.
    visible : [N] visible fraction in (0, 1]; NaN where it is not known.
    lines : [N] lines of the file, from 1.
    timeline : of the frames.
    notes : what the user should know.
    """

    path: Path
    frame: IntArray
    track: IntArray
    boxes: FloatArray
    scores: FloatArray
    visible: FloatArray
    lines: IntArray
    timeline: Timeline
    notes: tuple[str, ...] = ()

    def select(self, kept: BoolArray) -> "BoxRows":
        """The rows marked in ``kept`` [N]."""
        names = ("frame", "track", "boxes", "scores", "visible", "lines")
        return replace(self, **{name: getattr(self, name)[kept] for name in names})

    @property
    def linked(self) -> bool:
        """Whether boxes have ids."""
        return bool((self.track != UNLINKED).any())


def read_boxes(path: Path, dt: float | None) -> BoxRows:
    """Read a file of boxes; ``dt`` s per frame, ``None`` if only the file's time stamps say it.

    Raises
    ------
    FileError
        If it cannot be read or has no boxes; with the line, if a cell is not a number, a box has no size, a track has
        two boxes in a frame, an id is not whole, a share is not between 0 and 1, or the clock jumps.
    """
    if not path.exists() or path.is_dir():
        raise FileError(path, "is a folder; name the file of boxes" if path.is_dir() else "the file is missing")
    named = path.suffix.lower() == ".csv" and _has_header(path)
    rows = _named_rows(path, dt) if named else _mot_rows(path, dt)
    _check(rows)
    return replace(rows, notes=(*rows.notes, *_goes_back(rows)))


def _has_header(path: Path) -> bool:
    with path.open("rb") as file:
        return any(byte in b"abcdefghijklmnopqrstuvwxyz" for byte in file.readline(4096).lower())


def _mot_rows(path: Path, dt: float | None) -> BoxRows:
    table = parse_mot(path, path.read_bytes())
    if not len(table.values):
        raise FileError(path, "holds no box")
    frame, timeline = _mot_frames(table, dt)
    kept = table.of_pedestrians()
    if not len(kept.values):
        raise FileError(path, "every box of it is ignored: conf 0, visibility 0 or another class than 1 (people)")
    counted = np.isin(table.lines, kept.lines)
    track, confidence, visible = kept.values[:, 1], kept.values[:, 6], kept.values[:, 8]
    dropped = len(table.values) - len(kept.values)
    note = f"{dropped} of {len(table.values)} boxes are left out: conf 0, visibility 0 or another class than 1 (people)"
    return BoxRows(
        path=path,
        frame=frame[counted],
        track=_ids(path, track, kept.lines),
        boxes=kept.boxes,
        scores=np.where(confidence == UNLINKED, np.nan, confidence),
        visible=np.where(visible == UNLINKED, np.nan, visible),
        lines=kept.lines,
        timeline=timeline,
        notes=(note,) if dropped else (),
    )


def _mot_frames(table: MotTable, dt: float | None) -> tuple[IntArray, Timeline]:
    first = table.values[:, 0]
    if (first != np.round(first)).any():
        return time_frames(table.path, first, table.lines, dt)
    return number_frames(table.path, first, table.lines, dt, base=1)


def _named_rows(path: Path, dt: float | None) -> BoxRows:
    centred = _has_columns(path, ("u", "v", "l"))
    shape = ("u", "v", "l") if centred else ("left", "top", "width", "height")
    table = read_named(path, [("frame", "time"), *((name,) for name in shape)], OPTIONAL)
    sizes = np.stack([table[name] for name in shape], axis=-1)
    nothing = np.full(len(table), np.nan)
    if "time" in table:
        frame, timeline = time_frames(path, table["time"], table.lines, dt)
    else:
        frame, timeline = number_frames(path, table["frame"], table.lines, dt, base=0)
    rest = [name for name in table.ignored if name]
    return BoxRows(
        path=path,
        frame=frame,
        track=_ids(path, table.columns.get("id", nothing), table.lines),
        boxes=rectangles(sizes) if centred else sizes,
        scores=table.columns.get("score", nothing),
        visible=table.columns.get("visible", nothing),
        lines=table.lines,
        timeline=timeline,
        notes=(f"columns {', '.join(rest)} of {path.name} are not read",) if rest else (),
    )


def _goes_back(rows: BoxRows) -> list[str]:
    """A note if the clock of detections goes back a few times; rows in no order go back everywhere."""
    back = _backwards(rows)
    if rows.linked or not 0 < len(back) <= MOST_BACK:
        return []
    where = f"{rows.path.name}, line {rows.lines[back[0]]}"
    return [f"{where}: {_leap_of(rows, back[0])}; boxes of one time are taken for one frame"]


def _backwards(rows: BoxRows) -> IntArray:
    """Rows whose time is before that of the row above."""
    return 1 + np.flatnonzero(np.diff(rows.timeline.times[rows.frame]) < 0.0)


def _goes_on(rows: BoxRows, row: int) -> bool:
    """Whether what follows the ``row`` comes after it again, frame by frame: then it is no row out of its place."""
    return len(np.unique(rows.frame[row:][rows.frame[row:] <= rows.frame[:row].max()])) > 1


def _leap_of(rows: BoxRows, row: int) -> str:
    above, here = rows.timeline.times[rows.frame[row - 1 : row + 1]]
    return f"the clock goes back by {above - here:.4g} s"


def _has_columns(path: Path, names: tuple[str, ...]) -> bool:
    with path.open("rb") as file:
        header = file.readline(4096).decode("utf-8", "replace").split(",")
    return set(names) <= {cell.strip(" \t\r\n\"'\ufeff") for cell in header}


def _ids(path: Path, values: FloatArray, lines: IntArray) -> IntArray:
    """The ids of rows; `UNLINKED` if none has one (empty or −1)."""
    loose = np.isnan(values) | (values == UNLINKED)
    if loose.all():
        return np.full(len(values), UNLINKED)
    wrong = loose | (values != np.round(values)) | (values < 0) | (values > LARGEST_ID)
    if wrong.any():
        row = int(wrong.argmax())
        shown = "missing here" if loose[row] else f"{values[row]:.10g}, which is not a whole number from 0 on"
        raise FileError(path, f"the id is {shown}; give every box an id, or none", int(lines[row]))
    return values.astype(np.int64)


def _check(rows: BoxRows) -> None:
    """Refuse what cannot be a box, and a track that has two of them in a frame."""
    width, height = rows.boxes[:, 2], rows.boxes[:, 3]
    reach = np.abs(rows.boxes).max(axis=1)
    checks = (
        ((width <= 0.0) | (height <= 0.0), "the box is {2:g} x {3:g} px; leave it out"),
        (reach > FARTHEST, "the box reaches {reach:g} px; boxes are in px of the picture"),
        ((rows.visible < 0.0) | (rows.visible > 1.0), "visible is {visible:g}; it is a share, from 0 to 1"),
    )
    for wrong, problem in checks:
        if wrong.any():
            row = int(wrong.argmax())
            text = problem.format(*rows.boxes[row], reach=reach[row], visible=rows.visible[row])
            raise FileError(rows.path, text, int(rows.lines[row]))
    if rows.linked:
        _refuse_repetition(rows)


def _refuse_repetition(rows: BoxRows) -> None:
    found = first_repetition(rows.frame, rows.track)
    if found is None:
        return
    before, again = found
    problem = f"id {rows.track[again]} already has a box in this frame, in line {rows.lines[before]}"
    back = _backwards(rows)
    between = back[(back > before) & (back <= again)]
    row = int(between[-1]) if len(between) and len(back) <= MOST_BACK else 0
    if row and rows.track[row] in rows.track[:row] and _goes_on(rows, row):
        second = f"and id {rows.track[again]} has a second box of that time (the first is in line {rows.lines[before]})"
        raise FileError(rows.path, f"{_leap_of(rows, row)}, {second}; split the recording here", int(rows.lines[row]))
    raise FileError(rows.path, f"{problem}; leave one of them out", int(rows.lines[again]))


def named_frames(table: NamedColumns, timeline: Timeline) -> IntArray:
    """The frame of each row of a table beside the boxes, −1 where there is none.

    Raises
    ------
    FileError
        If it has frame numbers and the boxes time stamps only.
    """
    exact = timeline.frame_of_time(table["time"]) if "time" in table else timeline.frame_of_number(table["frame"])
    there = (exact == np.round(exact)) & (exact >= 0) & (exact < timeline.frames)
    return np.where(there, exact, -1.0).astype(np.int64)
