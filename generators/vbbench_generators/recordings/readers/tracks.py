"""The rows that readers make of a file, the gates that they pass, and the dense scene made of them."""

import warnings
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchWarning
from vbbench.files.dataset_checks import CELLS_PER_ROW, FEW_CELLS
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.scene import Scene

SPEED_RANGE = (0.3, 3.0)
"""Median walking speeds in m/s that people can have."""

FARTHEST = 1e6
"""How far from the origin, in m along either axis, somebody may walk."""
MOST_CELLS = 10**8
"""Frames times people that a scene may have: 1.6 GB."""

_LARGEST = {"frame": 2**53, "id": 2**31 - 1}


def check_integers(path: Path, name: str, values: FloatArray, lines: IntArray) -> IntArray:
    """Frame numbers or ids [N] as integers; ``1.0`` is one, ``1.5`` is an error, and so is a negative id."""
    bad = (values != np.round(values)) | (np.abs(values) > _LARGEST[name])
    if name == "id":
        bad |= values < 0
    if bad.any():
        row = int(bad.argmax())
        kind = "an integer of 0 or more" if name == "id" else "an integer"
        raise FileError(path, f"{name} is {values[row]:.15g}, not {kind}", int(lines[row]))
    return values.astype(np.int64)


def check_on_ground(path: Path, positions: FloatArray, lines: IntArray) -> None:
    """Positions [N, 2] in m must be somewhere on the ground; a point on the horizon of a homography is not."""
    bad = ~(np.abs(positions) <= FARTHEST).all(axis=1)
    if bad.any():
        row = int(bad.argmax())
        if np.isfinite(positions[row]).all():
            x, y = positions[row]
            problem = f"({x:.6g}, {y:.6g}) m is more than {FARTHEST / 1000:,.0f} km from the origin; are these metres?"
        else:
            problem = "the homography maps this point beyond its horizon"
        raise FileError(path, problem, int(lines[row]))


def check_size(path: Path, frames: int, people: int, rows: int) -> None:
    """Refuse a scene of ``frames`` frames and ``people`` people, from ``rows`` rows, that would be nearly all empty."""
    if frames * people > min(MOST_CELLS, max(FEW_CELLS, rows * CELLS_PER_ROW)):
        problem = (
            f"{frames:,} frames of {people:,} people from {rows:,} rows are too many, and nearly all of them empty"
        )
        raise FileError(path, f"{problem}; split the recording, or correct its frame numbers")


def check_tracks(path: Path, frame: IntArray, person: IntArray, lines: IntArray, step: int) -> None:
    """Rows [N] sorted by person, then frame: each person once a frame, and every ``step`` frames without a gap."""
    same, delta = np.diff(person) == 0, np.diff(frame)
    twice = same & (delta == 0)
    if twice.any():
        row = _earliest(twice, lines)
        earlier, later = sorted((int(lines[row - 1]), int(lines[row])))
        problem = f"person {person[row]} is in frame {frame[row]} twice (also on line {earlier})"
        raise FileError(path, problem, later)
    off = same & (delta != step)
    if off.any():
        row = _earliest(off, lines)
        problem = f"person {person[row]}: frame {frame[row]} follows frame {frame[row - 1]}, but the step is {step}"
        raise FileError(path, f"{problem}; complete the track, or give its parts ids of their own", int(lines[row]))


def check_phase(path: Path, frame: IntArray, lines: IntArray, step: int) -> None:
    """All people must be recorded at the same instants: no two frames of ``frame`` [N] less than a step apart."""
    order = np.argsort(frame, kind="stable")
    frame, lines = frame[order], lines[order]
    delta = np.diff(frame)
    close = np.flatnonzero((delta > 0) & (delta < step))
    if len(close):
        # Of two rows too close in time, the one that stands later in the file is the stranger.
        row = close[np.maximum(lines[close], lines[close + 1]).argmin()]
        other, stranger = sorted((row, row + 1), key=lambda n: int(lines[n]))
        problem = f"frame {frame[stranger]} is {delta[row]} from frame {frame[other]}, but the step is {step}"
        raise FileError(path, problem, int(lines[stranger]))


def check_speed(path: Path, scene: Scene) -> None:
    """Warn where the median walking speed is none that people have, and name the likely cause."""
    steps = np.linalg.norm(np.diff(scene.positions, axis=0), axis=-1)
    steps = steps[~np.isnan(steps)]
    if not len(steps):
        return
    speed = float(np.median(steps)) / scene.dt
    if not SPEED_RANGE[0] <= speed <= SPEED_RANGE[1]:
        low, high = SPEED_RANGE
        message = f"{path}: the median walking speed is {speed:.3g} m/s, outside {low:g}–{high:g} m/s: {_cause(speed)}"
        warnings.warn(message, VbbenchWarning, stacklevel=4)


def _earliest(bad: BoolArray, lines: IntArray) -> int:
    """Of the pairs of rows that are bad [N − 1], the one whose second row stands first in the file; that row."""
    rows = np.flatnonzero(bad) + 1
    return int(rows[lines[rows].argmin()])


def _cause(speed: float) -> str:
    if speed < SPEED_RANGE[0]:
        return "most people stand, or dt is too long, or the unit is larger than a metre"
    if speed > 10.0:
        return "positions are probably pixels (a homography is needed) or centimetres"
    return "dt is probably too short for the frame step, or positions are feet"


def scene_of_rows(
    path: Path,
    frame: FloatArray,
    person: FloatArray,
    positions: FloatArray,
    lines: IntArray,
    *,
    dt: float,
    frame_step: int | None = None,
) -> Scene:
    """The scene of one row for each person in each frame.

    Row 0 of the scene is the first frame with anybody in it. Where nobody is, rows are empty.

    Parameters
    ----------
    path : the file.
    frame, person : [N] numbers as they stand in the file.
    positions : [N, 2] in m.
    lines : [N] where each row stands in the file, from 1.
    dt, frame_step : seconds and frame numbers between rows of a person; ``None``: the commonest step.

    Raises
    ------
    FileError
        If a gate of this module is shut; an implausible walking speed is a warning only.
    """
    frames, ids = check_integers(path, "frame", frame, lines), check_integers(path, "id", person, lines)
    check_on_ground(path, positions, lines)
    order = np.lexsort((lines, frames, ids))
    frames, ids, lines = frames[order], ids[order], lines[order]
    step = frame_step or commonest_step(frames, ids)
    check_tracks(path, frames, ids, lines, step)
    check_phase(path, frames, lines, step)
    people, column = np.unique(ids, return_inverse=True)
    row = _row_of_frame(frames, step)
    count = int(row.max()) + 1
    check_size(path, count, len(people), len(frames))
    dense = np.full((count, len(people), 2), np.nan)
    dense[row, column] = positions[order]
    unknown = np.full(len(people), np.nan)
    scene = Scene(name=path.stem, dt=dt, people=people, positions=dense, heights=unknown)
    check_speed(path, scene)
    return scene


def commonest_step(frame: IntArray, person: IntArray) -> int:
    """The commonest step within tracks, of rows [N] sorted by person, then frame; 1 where there is none."""
    delta = np.diff(frame)[np.diff(person) == 0]
    steps, counts = np.unique(delta[delta > 0], return_counts=True)
    return int(steps[counts.argmax()]) if len(steps) else 1


def _row_of_frame(frame: IntArray, step: int) -> IntArray:
    """Row [N] of each frame. Recordings may go on at another phase after nobody was there, so gaps round up."""
    unique, inverse = np.unique(frame, return_inverse=True)
    rows = np.concatenate([[0], np.cumsum(-(-np.diff(unique) // step))])
    return rows[inverse].astype(np.int64)
