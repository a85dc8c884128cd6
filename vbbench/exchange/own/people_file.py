"""``people.csv``: where people truly were, as far as somebody measured it."""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.own.box_files import named_frames
from vbbench.exchange.own.named_columns import NamedColumns, read_named
from vbbench.exchange.own.timing import Timeline
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.rows import first_repetition
from vbbench.scene import Scene

FASTEST, LEAP = 12.0, 2.0
"""In m/s and m: nobody runs faster, but for the noise of a place."""


def read_people(path: Path, name: str, timeline: Timeline, *, posed: bool) -> tuple[Scene, tuple[str, ...]]:
    """The people of ``people.csv`` (frame or time, id, x, y, height), and notes.

    Positions are in the world of the poses, in m; without poses (right, forward) of the camera. A height that is not
    said anywhere is NaN. How fast people are is looked at where the camera is ``posed``: else it moves them.

    Raises
    ------
    FileError
        If it cannot be read; with the line, if an id is not whole, or somebody is at two places in a frame; if no row
        is of a frame of the boxes, or it has time stamps where they have frames, or the other way round.
    """
    table = read_named(path, [("frame", "time"), ("id",), ("x",), ("y",)], ("height",))
    ids = table["id"]
    wrong = (ids != np.round(ids)) | (ids < 0) | (ids > 2**31 - 1)
    if wrong.any():
        row = int(wrong.argmax())
        raise FileError(path, f"id {ids[row]:.10g} is not a whole number from 0 on", int(table.lines[row]))
    frame = named_frames(table, timeline)
    there = np.flatnonzero(frame >= 0)
    if not len(there):
        times = timeline.times
        raise FileError(path, f"no row is of a frame of the boxes, which are of {times[0]:.10g} to {times[-1]:.10g} s")
    people, column = np.unique(ids[there].astype(np.int64), return_inverse=True)
    _refuse_repetition(path, frame[there], column, table.lines[there])
    notes = _leaps(path, ids[there], timeline.times[frame[there].astype(np.int64)], table, there) if posed else []
    positions, heights = np.full((timeline.frames, len(people), 2), np.nan), np.full(len(people), np.nan)
    positions[frame[there], column] = np.stack([table["x"][there], table["y"][there]], axis=-1)
    if "height" in table:
        said = ~np.isnan(table["height"][there])
        heights[column[said]] = table["height"][there][said]
    left = len(frame) - len(there)
    if left:
        notes.append(f"{left} of {len(frame)} rows of {path.name} are of no frame of the boxes")
    return Scene(name=name, dt=timeline.dt, people=people, positions=positions, heights=heights), tuple(notes)


def _refuse_repetition(path: Path, frame: IntArray, column: IntArray, lines: IntArray) -> None:
    found = first_repetition(frame, column)
    if found is not None:
        before, again = lines[list(found)]
        raise FileError(path, f"this id already has a place in this frame, in line {before}", int(again))


def _leaps(path: Path, ids: FloatArray, times: FloatArray, table: NamedColumns, rows: IntArray) -> list[str]:
    """A note on people who get about as nobody does, by the ``ids`` and ``times`` [M] of some ``rows`` of a table."""
    order = np.lexsort((times, ids))
    moved = np.hypot(np.diff(table["x"][rows][order]), np.diff(table["y"][rows][order]))
    leaps = (np.diff(ids[order]) == 0) & (moved > LEAP + FASTEST * np.diff(times[order]))
    if not leaps.any():
        return []
    first = int(leaps.argmax())
    line = int(table.lines[rows][order[first + 1]])
    return [
        f"{path.name}, line {line}: id {ids[order[first]]:.10g} is {moved[first]:.4g} m from its place before, as are "
        f"{int(leaps.sum())} places: are they in m, and are ids not used again?"
    ]
