"""``people.csv``: where people truly were, as far as somebody measured it."""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.box_rows import AS_THEY_ARE, Ids
from vbbench.exchange.own.box_files import named_frames
from vbbench.exchange.own.timing import Timeline
from vbbench.exchange.text_tables import read_table, refuse_missing
from vbbench.files.tables import LARGEST_ID
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.rows import first_repetition
from vbbench.scene import Scene

COLUMNS = ("frame", "time", "id", "x", "y", "height")
FASTEST, LEAP = 12.0, 2.0
"""In m/s and m: nobody runs faster, but for the noise of a place."""


def read_people(
    path: Path, name: str, timeline: Timeline, *, posed: bool, ids: Ids = AS_THEY_ARE
) -> tuple[Scene, tuple[str, ...]]:
    """The people of ``people.csv`` (frame or time, id, x, y, height), and notes.

    Positions are in the world of the poses, in m; without poses (right, forward) of the camera. A height that is not
    stated anywhere is NaN. How fast people are is looked at where the camera is ``posed``: else it moves them. ``ids``
    are those of the boxes.

    Raises
    ------
    FileError
        If it cannot be read; with the line, if an id is not whole, or somebody is at two places in a frame; if no row
        is of a frame of the boxes, or it has time stamps where they have frames, or the other way round.
    """
    if not path.is_file():
        raise FileError(path, "the file is missing")
    table = read_table(path, path.read_bytes(), COLUMNS, required=("id", "x", "y"))
    refuse_missing(table, [("frame", "time"), ("id",), ("x",), ("y",)])
    if not len(table):
        raise FileError(path, "holds no row")
    found = table["id"]
    if ids.originals is None or ids.originals.dtype.kind != "U":
        numbers = table.numbers("id")
        wrong = (numbers != np.round(numbers)) | (numbers < 0) | ((numbers > LARGEST_ID) & (ids.originals is None))
        if wrong.any():
            row = int(wrong.argmax())
            raise table.fault(row, f"id {found[row]:.19g} is not a whole number from 0 to {LARGEST_ID}")
    frame = named_frames(table, timeline)
    there = np.flatnonzero(frame >= 0)
    if not len(there):
        times = timeline.times
        raise FileError(path, f"no row is of a frame of the boxes, which are of {times[0]:.10g} to {times[-1]:.10g} s")
    people, column = np.unique(ids.tracks(found)[there], return_inverse=True)
    _refuse_repetition(path, frame[there], column, table.lines[there])
    places = np.stack([table.scaled("x"), table.scaled("y")], axis=-1)[there]
    notes = []
    count, row, far = _leaps(people[column], timeline.times[frame[there]], places) if posed else (0, 0, 0.0)
    if count:
        notes.append(
            f"{path.name}, line {table.lines[there][row]}: id {found[there][row]} is {far:.4g} m from its place "
            f"before, as are {count} places: are they in m, and are ids not used again?"
        )
    positions, heights = np.full((timeline.frames, len(people), 2), np.nan), np.full(len(people), np.nan)
    positions[frame[there], column] = places
    stated = table.numbers("height")[there]
    heights[column[~np.isnan(stated)]] = stated[~np.isnan(stated)]
    left = len(frame) - len(there)
    if left:
        notes.append(f"{left} of {len(frame)} rows of {path.name} are of no frame of the boxes")
    return Scene(name=name, dt=timeline.dt, people=people, positions=positions, heights=heights), tuple(notes)


def _refuse_repetition(path: Path, frame: IntArray, column: IntArray, lines: IntArray) -> None:
    found = first_repetition(frame, column)
    if found is not None:
        before, again = lines[list(found)]
        raise FileError(path, f"this id already has a place in this frame, in line {before}", int(again))


def _leaps(track: IntArray, times: FloatArray, places: FloatArray) -> tuple[int, int, float]:
    """How many rows [M] are where nobody gets to from the row before of the same track, the first, and how far it is.

    Nobody is faster than `FASTEST`; ``times`` [M] are in s, ``places`` [M, 2] in m.
    """
    order = np.lexsort((times, track))
    moved = np.hypot(*np.diff(places[order], axis=0).T)
    leaps = (np.diff(track[order]) == 0) & (moved > LEAP + FASTEST * np.diff(times[order]))
    first = int(leaps.argmax()) if len(leaps) else 0
    return int(leaps.sum()), int(order[first + 1]) if leaps.any() else 0, float(moved[first]) if leaps.any() else 0.0
