"""Boxes of people in one film, as `BoxRows` on a timeline: from text, JSON, archives and folders of labels.

gt.txt, det.txt    frame,id,left,top,width,height[,conf,class,visibility]   frames and px from 1; id −1 = not linked
boxes.csv          columns by their names, in any order (`vbbench.parsing.column_names`)   frames and px from 0
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.box_containers import read_box_file
from vbbench.exchange.box_rows import MOST_BACK, BoxRows, linked_rows
from vbbench.exchange.box_tables import BoxTable, frame_numbers, people_in
from vbbench.exchange.own.timing import Timeline, number_frames, time_frames
from vbbench.exchange.text_tables import NamedColumns
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import IntArray

OTHER_RATE = 0.1
"""Share by which times may differ from the frames that they stand next to."""
OFF_FRAME = 0.25
"""How far a time stamp may be from a frame of another recording, in frames."""


@dataclass(frozen=True, kw_only=True)
class OwnBoxes(BoxRows):
    """The boxes of one recording with the times of its frames.

    ``plain`` is whether the file is text whose reading does not depend on its name.
    """

    timeline: Timeline
    notes: tuple[str, ...] = ()
    plain: bool = False


def read_boxes(
    path: Path,
    dt: float | None,
    *,
    picture: tuple[float, float] | None = None,
    person_class: int | str | None = None,
) -> OwnBoxes:
    """Read boxes of people.

    Parameters
    ----------
    path : a file, or a folder of YOLO's labels (`vbbench.exchange.box_containers`).
    dt : seconds per frame, ``None`` if only the file's time stamps say it.
    picture : width and height in px, for boxes that are shares of it.
    person_class : class of people, by number or name, where the file does not show it.
    """
    table = read_box_file(path, picture)
    if not len(table.frame):
        raise FileError(path, "holds no box")
    lasts = None if table.timed else _frame_time(table, dt)
    dt, rate = dt or lasts, ""
    if lasts and dt and abs(lasts / dt - 1.0) > OTHER_RATE:
        rate = f"times go on by {lasts:.4g} s a frame, and a frame is said to last {dt:g} s, which counts: is it right?"
    if table.timed:
        frame, timeline = time_frames(table, table.frame, dt)
    else:
        frame, timeline = number_frames(table, table.frame, dt, base=table.base)
    kept, notes = people_in(table, person_class)
    table = table.select(kept)
    boxes, renumbered = linked_rows(table, frame[kept])
    plain = table.path == path and bool(table.lines.any()) and person_class is None and not table.class_names
    rows = OwnBoxes(**vars(boxes), timeline=timeline, plain=plain)
    return replace(rows, notes=(*table.notes, *notes, *renumbered, *filter(None, (rate, _goes_back(rows)))))


def _frame_time(table: BoxTable, dt: float | None) -> float | None:
    """Seconds per frame from times next to frame numbers, in the unit that fits; ``None`` without times."""
    times, ends = table.scaled("time"), [int(table.frame.argmin()), int(table.frame.argmax())]
    (passed,), (frames,) = np.diff(times[ends]), np.diff(table.frame[ends])
    if not passed > 0.0:
        return None
    units = [1.0] if table.unit("time") else [1.0, 1e-3, 1e-6, 1e-9]
    return min((float(passed * unit / frames) for unit in units), key=lambda one: abs(np.log(one / (dt or 0.1))))


def rows_in_frames(rows: OwnBoxes, frames: int, dt: float) -> BoxRows:
    """The boxes in a recording of ``frames`` frames, ``dt`` s apart, whose first one is at 0 s."""
    exact = rows.timeline.times[rows.frame] / dt
    found = replace(rows, frame=np.round(exact).astype(np.int64)).within(frames)
    between = np.abs(exact - found.frame) > OFF_FRAME
    problem = f"time {{0:.10g}} s lies between two frames; frame n is at n x {dt:g} s, from 0"
    rows.refuse(between, problem, exact * dt)
    return found


def write_boxes(path: Path, rows: OwnBoxes) -> None:
    """Write CSV that `read_boxes` reads as the same boxes, of people alone, at the same times."""
    columns = {"time": rows.timeline.times[rows.frame]}
    if rows.linked:
        columns["id"] = rows.ids.of(rows.track)
    columns |= dict(zip(("left", "top", "width", "height"), rows.boxes.T, strict=True))
    columns |= {"score": rows.scores, "visible": rows.visible}
    cells = [["" if cell == "nan" else cell for cell in map(str, column.tolist())] for column in columns.values()]
    lines = [",".join(columns), *map(",".join, zip(*cells, strict=True))]
    write_text_atomically(path, "\n".join(lines) + "\n")


def _goes_back(rows: OwnBoxes) -> str:
    """A note if the clock goes back a few times; that of unordered rows does so often, in order of ids at each id."""
    apart = np.diff(rows.timeline.times[rows.frame])
    back = np.flatnonzero(apart < 0.0)
    if not rows.lines.any() or not 0 < len(back) <= MOST_BACK:
        return ""
    parts = rows.track[: back[0] + 1], rows.track[back[0] + 1 :]
    if rows.linked and (min(len(np.unique(part)) for part in parts) < 2 or np.isin(*parts).any()):
        return ""
    split = "ids before and after differ: are these two recordings?"
    what = split if rows.linked else "boxes of one time are taken for one frame"
    return f"{rows.path.name}, line {rows.lines[back[0] + 1]}: the clock goes back by {-apart[back[0]]:.4g} s; {what}"


def named_frames(table: NamedColumns, timeline: Timeline) -> IntArray:
    """The frame of each row of a table of the same recording, −1 where there is none.

    Times are in the unit of their name, or in whichever of s, ms, us and ns most frames have.
    """
    if "frame" in table:
        exact = [(frame_numbers(table) - timeline.first_number) / timeline.step]
    else:
        units = [1.0] if table.unit("time") else [1.0, 1e-3, 1e-6, 1e-9]
        exact = [timeline.frame_of_time(table.scaled("time") * unit) for unit in units]
    there = [(one == np.round(one)) & (one >= 0) & (one < timeline.frames) for one in exact]
    frames = [np.where(known, one, -1.0).astype(np.int64) for known, one in zip(there, exact, strict=True)]
    return max(frames, key=lambda one: len(np.unique(one)))
