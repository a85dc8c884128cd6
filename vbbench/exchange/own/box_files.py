"""Boxes of people in one film, as `BoxRows` on a timeline: from text, JSON, archives and folders of labels.

gt.txt, det.txt    frame,id,left,top,width,height[,conf,class,visibility]   frames and px from 1; id −1 = not linked
boxes.csv          columns by their names, in any order (`vbbench.parsing.column_names`)   frames and px from 0
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, quoted
from vbbench.exchange.box_containers import read_box_file
from vbbench.exchange.box_tables import UNLINKED, BoxTable, frame_numbers, people_in
from vbbench.exchange.own.timing import Timeline, number_frames, time_frames
from vbbench.exchange.text_tables import NamedColumns
from vbbench.files.tables import LARGEST_ID
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.rows import first_repetition

FARTHEST = 1e6
"""Largest side or size of a box in px."""
FEWEST_ALONE = 10
"""So many boxes of which no two have one id are numbered, not linked."""
OFF_FRAME = 0.25
"""How far a time stamp may be from a frame of another recording, in frames."""
MOST_BACK = 3
"""Times that a clock goes back; a file whose times do so more often is in no order."""


@dataclass(frozen=True)
class Ids:
    """Ids of a file as the numbers of tracks: its own, or from 1 on where these are texts or have 64 bits.

    Parameters
    ----------
    originals : [K] ids of the tracks 1 to K, ascending; ``None`` where tracks have the ids of the file.
    """

    originals: NDArray[Any] | None = None

    def tracks(self, ids: NDArray[Any]) -> IntArray:
        """[N] the track of each id; ids that no box has follow those that have."""
        if self.originals is None:
            return ids.astype(np.int64)
        more = np.setdiff1d(ids.astype(self.originals.dtype), self.originals)
        every = np.concatenate([self.originals, more])
        order = np.argsort(every)
        return 1 + order[np.searchsorted(every[order], ids.astype(every.dtype))]

    def of(self, tracks: IntArray) -> NDArray[Any]:
        """[N] the ids of the file of some tracks."""
        return tracks if self.originals is None else self.originals[tracks - 1]


AS_THEY_ARE = Ids()
"""Ids of a file that are the numbers of tracks."""


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
    ids : what the file calls the tracks.
    plain : whether the file is text that is read alike under another name.
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
    ids: Ids = AS_THEY_ARE
    plain: bool = False

    def fault(self, row: int, problem: str) -> FileError:
        """The error to raise about a row."""
        line = int(self.lines[row])
        return FileError(self.path, problem if line else f"box {row + 1}: {problem}", line or None)

    def select(self, kept: BoolArray) -> "BoxRows":
        """The rows marked in ``kept`` [N]."""
        if kept.all():
            return self
        names = ("frame", "track", "boxes", "scores", "visible", "lines")
        return replace(self, **{name: getattr(self, name)[kept] for name in names})

    @property
    def linked(self) -> bool:
        """Whether boxes have ids."""
        return bool((self.track != UNLINKED).any())


def read_boxes(
    path: Path,
    dt: float | None,
    *,
    picture: tuple[float, float] | None = None,
    person_class: int | str | None = None,
) -> BoxRows:
    """Read boxes of people.

    Parameters
    ----------
    path : a file, or a folder of YOLO's labels (`vbbench.exchange.box_containers`).
    dt : seconds per frame, ``None`` if only the file's time stamps say it.
    picture : width and height in px, for boxes that are shares of it.
    person_class : class of people, by number or name, where the file does not show it.

    Raises
    ------
    FileError
        If it cannot be read or has no boxes; with the line, if a cell is not a number, a box has no size, a track has
        two boxes in a frame, an id is not whole, a share is not between 0 and 1, or the clock jumps. If its classes do
        not show which is of people.
    """
    table = read_box_file(path, picture)
    if not len(table.frame):
        raise FileError(path, "holds no box")
    if table.timed:
        frame, timeline = time_frames(path, table.frame, table.lines, dt)
    else:
        frame, timeline = number_frames(path, table.frame, table.lines, dt, base=table.base)
    kept, notes = people_in(table, person_class)
    table, frame = table.select(kept), frame[kept]
    track, ids, renumbered = _tracks(table)
    rows = BoxRows(
        path=path,
        frame=frame,
        track=track,
        boxes=table.boxes,
        scores=table.scores,
        visible=table.visible,
        lines=table.lines,
        timeline=timeline,
        notes=(*table.notes, *notes, *renumbered),
        ids=ids,
        plain=table.path == path and bool(table.lines.any()) and person_class is None and not table.class_names,
    )
    _check(rows)
    return replace(rows, notes=(*rows.notes, *_goes_back(rows)))


def frames_of(rows: BoxRows, frames: int, dt: float) -> IntArray:
    """The frame [N] of each box in a recording of ``frames`` frames, ``dt`` s apart, whose first one is at 0 s.

    Raises
    ------
    FileError
        At the first box that is of no frame of the recording, or between two.
    """
    exact = rows.timeline.times[rows.frame] / dt
    frame = np.round(exact).astype(np.int64)
    beyond, between = (frame < 0) | (frame >= frames), np.abs(exact - frame) > OFF_FRAME
    if beyond.any():
        row = int(beyond.argmax())
        raise rows.fault(row, f"frame {frame[row]}, counted from 0, is beyond the recording of {frames} frames")
    if between.any():
        row = int(between.argmax())
        time = f"time {rows.timeline.times[rows.frame[row]]:.10g} s lies between two frames"
        raise rows.fault(row, f"{time}; frame n is at n x {dt:g} s, from 0")
    return frame


def write_boxes(path: Path, rows: BoxRows) -> None:
    """Write CSV that `read_boxes` reads as the same boxes, of people alone, at the same times."""
    columns = {"time": rows.timeline.times[rows.frame]}
    if rows.linked:
        columns["id"] = rows.ids.of(rows.track)
    columns |= dict(zip(("left", "top", "width", "height"), rows.boxes.T, strict=True))
    columns |= {"score": rows.scores, "visible": rows.visible}
    cells = [["" if cell == "nan" else cell for cell in map(str, column.tolist())] for column in columns.values()]
    lines = [",".join(columns), *map(",".join, zip(*cells, strict=True))]
    write_text_atomically(path, "\n".join(lines) + "\n")


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


def _tracks(table: BoxTable) -> tuple[IntArray, Ids, tuple[str, ...]]:
    """The tracks of rows, `UNLINKED` if none has an id (empty or −1); what the file calls them, and a note."""
    ids = table.id
    texts = ids.dtype.kind not in "if"
    loose = (ids == "") | (ids == str(UNLINKED)) if texts else np.isnan(ids.astype(np.float64)) | (ids == UNLINKED)
    if loose.all():
        return np.full(len(ids), UNLINKED), AS_THEY_ARE, ()
    wrong = loose if texts else loose | (ids != np.round(ids)) | (ids < 0)
    if wrong.any():
        row = int(wrong.argmax())
        shown = "missing here" if loose[row] else f"{ids[row]:.19g}, which is not a whole number from 0 on"
        raise table.table.fault(row, f"the id is {shown}; give every box an id, or none")
    if len(ids) >= FEWEST_ALONE and len(np.unique(ids)) == len(ids) and len(np.unique(table.frame)) > 1:
        problem = f"no id occurs in two of {len(ids)} boxes: these are numbers of boxes, not of people"
        raise FileError(table.path, f"{problem}; leave the column out to have boxes linked")
    if ids.dtype.kind == "f" and ids.max() > 2.0**53:
        row = int(ids.argmax())
        raise table.table.fault(row, f"the id is {ids[row]:g}: digits are lost; write ids without point and exponent")
    if not texts and ids.max() <= LARGEST_ID:
        return ids.astype(np.int64), AS_THEY_ARE, ()
    originals = np.unique(ids if texts else ids.astype(np.int64))
    named = Ids(originals)
    first = quoted(str(originals[0]))
    kind = "texts" if texts else f"larger than {LARGEST_ID}"
    note = f"ids are {kind}: in dataset and submission, tracks are numbered 1 to {len(originals)}, {first} is 1"
    return named.tracks(ids), named, (note,)


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
            raise rows.fault(row, text)
    if rows.linked:
        _refuse_repetition(rows)


def _refuse_repetition(rows: BoxRows) -> None:
    found = first_repetition(rows.frame, rows.track)
    if found is None:
        return
    before, again = found
    called = rows.ids.of(rows.track[again : again + 1])[0]
    at = f"line {rows.lines[before]}" if rows.lines[before] else f"box {before + 1}"
    back = _backwards(rows)
    between = back[(back > before) & (back <= again)]
    row = int(between[-1]) if len(between) and len(back) <= MOST_BACK else 0
    if row and rows.track[row] in rows.track[:row] and _goes_on(rows, row):
        second = f"and id {called} has a second box of that time (the first is in {at})"
        raise rows.fault(row, f"{_leap_of(rows, row)}, {second}; split the recording here")
    raise rows.fault(again, f"id {called} already has a box in this frame, in {at}; leave one of them out")


def named_frames(table: NamedColumns, timeline: Timeline) -> IntArray:
    """The frame of each row of a table beside the boxes, −1 where there is none.

    Raises
    ------
    FileError
        If a frame or time is not a number.
    """
    if "frame" in table:
        exact = timeline.frame_of_number(frame_numbers(table))
    else:
        exact = timeline.frame_of_time(table.scaled("time"))
    there = (exact == np.round(exact)) & (exact >= 0) & (exact < timeline.frames)
    return np.where(there, exact, -1.0).astype(np.int64)
