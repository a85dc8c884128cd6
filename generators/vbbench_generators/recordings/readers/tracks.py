"""Rows of positions from text files, checks of them, and the dense scene that they form."""

import re
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchWarning
from vbbench.exchange.text_tables import NamedColumns, Rows, decode, read_table
from vbbench.files.dataset_checks import CELLS_PER_ROW, FEW_CELLS
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.column_names import split_cells
from vbbench.scene import Scene

NOUNS = ("frame", "time", "id", "film", "x", "y")
"""What a header may name."""


def read_text(path: Path) -> bytes:
    """The text of a file in UTF-8, whatever its encoding and line ends.

    Raises FileError if it cannot be read or is no text.
    """
    try:
        content = decode(path, path.read_bytes())
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise FileError(path, "is not a text file") from error
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    return content


def read_rows(path: Path, names: Sequence[str], content: bytes | None = None) -> NamedColumns:
    """Columns of numbers without a header, separated by white space or commas; every row has exactly ``names``.

    Raises FileError if there is no row, or at the first line with other columns or without finite numbers.
    """
    table = read_table(path, read_text(path) if content is None else content, layout=" ".join(names))
    if not len(table):
        raise FileError(path, "is empty: it holds no row of numbers")
    return table


def count_columns(line: str) -> int:
    """Number of columns of a line."""
    return len(split_cells(line))


def read_homography(path: Path) -> FloatArray:
    """Read a [3, 3] homography: three rows of three numbers, or all in one row, with brackets or without.

    Raises FileError if the shape differs, a number is bad, or the matrix is singular.
    """
    names, text = ("h1", "h2", "h3"), re.sub(rb"[\[\](),; \t]+", b" ", read_text(path)).strip()
    if len(words := text.split()) == len(names) ** 2 != len(text.partition(b"\n")[0].split()) * len(names):
        text = b"\n".join(b" ".join(words[row : row + 3]) for row in (0, 3, 6))
    rows = read_rows(path, names, text)
    matrix = rows.stacked(*names)
    if len(matrix) != 3:
        raise FileError(path, f"a homography has 3 rows of 3 numbers, not {len(matrix)}", int(rows.lines[-1]))
    largest = np.abs(matrix).max()
    if not largest or np.linalg.matrix_rank(matrix / largest) < 3:
        raise FileError(path, "the homography is singular: it maps the image onto a line or a point")
    return matrix


def to_ground(points: FloatArray, homography: FloatArray) -> FloatArray:
    """Image points [N, 2] in px to the ground plane [N, 2] in m; not finite for points on the horizon."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mapped = points @ homography[:, :2].T + homography[:, 2]
        ground: FloatArray = mapped[:, :2] / mapped[:, 2:]
    return ground


SPEED_RANGE = (0.3, 3.0)
"""Median walking speeds in m/s that people can have."""
LARGEST_SCENE = 2000.0
"""m between the 5th and the 95th percentile of places along an axis."""
SMALL_PICTURE = 100.0
"""px: places that reach no farther are not from a picture; most of those that are lie within it, above 0."""
EVENLY = 1.05
"""Factor up to which speeds may vary more with another reading than as given: a wrong ``dt`` leaves this as it is."""
FEWEST_STEPS = 3
"""Steps from which another reading of a homography is judged."""
EVENLY_SWAPPED, MANY_POINTS = 0.85, 100
"""Factor below which speeds vary less with swapped columns, and places from which this is judged."""

FARTHEST = 1e6
"""How far from the origin, in m along either axis, a person may walk."""
MOST_CELLS = 10**8
"""Frames times people that a scene may have: 1.6 GB."""

UNITS = {"feet": 0.3048, "centimetres": 0.01, "millimetres": 0.001}
"""In m, for the causes of a speed that people do not have."""

_LARGEST = {"frame": 2**53, "id": 2**31 - 1}


def check_integers(path: Path, name: str, values: FloatArray, lines: IntArray) -> IntArray:
    """Frame numbers or ids [N] as integers; ``1.0`` is valid; ``1.5`` and negative ids are errors."""
    bad = (values != np.round(values)) | (np.abs(values) > _LARGEST[name])
    if name == "id":
        bad |= values < 0
    kind = "an integer of 0 or more" if name == "id" else "an integer; name a column of times 'time' in a first line"
    Rows(path=path, lines=lines).refuse(bad, f"{name} is {{0:.15g}}, not {kind}", values)
    return values.astype(np.int64)


def check_on_ground(path: Path, positions: FloatArray, lines: IntArray) -> None:
    """Refuse positions [N, 2] in m that are not finite or too far, such as points on the horizon of a homography."""
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
    """Refuse rows [N], sorted by person, then frame, unless each person has one every ``step`` frames."""
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
        raise FileError(path, f"{problem}; complete the track, or give its parts separate ids", int(lines[row]))


def check_phase(path: Path, frame: IntArray, lines: IntArray, step: int) -> None:
    """Refuse people recorded at different instants: two of the frames ``frame`` [N] less than a step apart."""
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


def check_speed(path: Path, scene: Scene, frame_step: int = 1, homography: FloatArray | None = None) -> None:
    """Warn if the median walking speed is implausible, and name causes that would explain it."""
    steps = np.linalg.norm(np.diff(scene.positions, axis=0), axis=-1)
    steps = steps[~np.isnan(steps)]
    if not len(steps):
        return
    speed = float(np.median(steps)) / scene.dt
    low, high = SPEED_RANGE
    if low <= speed <= high:
        return
    whose = "positions are" if homography is None else "the homography maps to"
    row = f"dt is that of a frame number, and rows of a person are {frame_step} apart (dt = {frame_step * scene.dt:g})"
    factors = {row: 1.0 / frame_step} | {f"{whose} {unit}": part for unit, part in UNITS.items()}
    likely = [f"{cause}: {speed * part:.3g} m/s" for cause, part in factors.items() if low <= speed * part <= high]
    first, last = np.nanpercentile(scene.positions, (20, 95))
    if homography is None and first >= 0.0 and last >= SMALL_PICTURE:
        likely.insert(0, "positions are pixels (a homography is needed)")
    if speed < low:
        likely = ["most people stand, or dt is too long, or the unit is larger than a metre"]
    cause = "; or ".join(likely) or "dt or the unit is another"
    message = f"{path}: the median walking speed is {speed:.3g} m/s, outside {low:g}–{high:g} m/s: {cause}"
    warnings.warn(message, VbbenchWarning, stacklevel=4)


def check_homography(path: Path, time: FloatArray, person: FloatArray, points: FloatArray, matrix: FloatArray) -> None:
    """Raise FileError if walking is plausible only without the homography, or with its inverse or transpose.

    Warn if it is more even with the two columns of places swapped.

    Parameters
    ----------
    path : the file of the points.
    time, person : [N] in s, and ids.
    points : [N, 2] as in the file.
    matrix : [3, 3] from them to metres, as given.
    """
    inverse = np.linalg.inv(matrix).astype(np.float64)
    names, readings = ("", "inverse", "transpose", "inverse of the transpose"), (matrix, inverse, matrix.T, inverse.T)
    walks = {
        name: _walk(time, person, to_ground(points, reading)) for name, reading in zip(names, readings, strict=True)
    }
    walks["none"] = _walk(time, person, points)
    best = min(walks, key=lambda name: (not walks[name][0], walks[name][2]))
    (given, fast, uneven), (fits, speed, varies) = walks[""], walks[best]
    swapped, _, evenly = _walk(time, person, to_ground(points[:, ::-1], matrix))
    if given and swapped and len(points) >= MANY_POINTS and evenly < EVENLY_SWAPPED * uneven:
        problem = f"speeds of a person vary by {uneven:.1%}, and by {evenly:.1%} with the columns of places swapped"
        warnings.warn(VbbenchWarning(f"{path}: {problem}: does the homography want (row, column)?"), stacklevel=4)
    if given or not fits or varies > EVENLY * uneven:
        return
    if best == "none":
        problem = f"without the homography people walk at {speed:.3g} m/s, with it at {fast:,.4g} m/s"
        raise FileError(path, f"{problem}: the places are metres already, remove `homography`")
    problem = f"with this homography people walk at {fast:,.4g} m/s, with its {best} at {speed:.3g} m/s"
    raise FileError(path, f"{problem}: give the {best}, the matrix that maps the picture to metres")


def _walk(time: FloatArray, person: FloatArray, places: FloatArray) -> tuple[bool, float, float]:
    """Whether walking is plausible, its median speed in m/s, and by what share a person's speed varies (median)."""
    order = np.lexsort((time, person))
    speeds = steps_of_people(time, person, places, per_time=True)
    if len(speeds) < FEWEST_STEPS or not np.isfinite(places).all():
        return False, np.inf, np.inf
    walker = person[order][1:][(np.diff(person[order]) == 0) & (np.diff(time[order]) > 0)]
    parts = np.split(speeds, np.flatnonzero(np.diff(walker)) + 1)
    varies = [float(np.median(np.abs(one / np.median(one) - 1.0))) for one in parts if np.median(one) > 0.0]
    speed, spread = float(np.median(speeds)), np.ptp(np.percentile(places, (5, 95), axis=0), axis=0).max()
    fits = SPEED_RANGE[0] <= speed <= SPEED_RANGE[1] and spread <= LARGEST_SCENE
    return bool(fits), speed, float(np.median(varies or [0.0]))


def steps_of_people(time: FloatArray, person: FloatArray, places: FloatArray, *, per_time: bool = False) -> FloatArray:
    """[M] lengths of the steps between consecutive places [N, 2] of a person, or with ``per_time`` their speeds."""
    order = np.lexsort((time, person))
    same = (np.diff(person[order]) == 0) & (np.diff(time[order]) > 0)
    with np.errstate(over="ignore", invalid="ignore"):
        lengths: FloatArray = np.linalg.norm(np.diff(places[order], axis=0), axis=1)[same]
    return np.divide(lengths, np.diff(time[order])[same]) if per_time else lengths


def _earliest(bad: BoolArray, lines: IntArray) -> int:
    """Of the ``bad`` pairs [N − 1] of consecutive rows, the second row that stands first in the file."""
    rows = np.flatnonzero(bad) + 1
    return int(rows[lines[rows].argmin()])


def scene_of_rows(
    path: Path,
    frame: FloatArray,
    person: FloatArray,
    positions: FloatArray,
    lines: IntArray,
    *,
    dt: float,
    frame_step: int | None = None,
    homography: FloatArray | None = None,
) -> Scene:
    """The scene from a table with one row for each person in each frame.

    Row 0 of the scene is the first frame with a person. Frames without people have empty rows.

    Raises FileError if a check of this module fails; an implausible walking speed is a warning only.

    Parameters
    ----------
    path : the file.
    frame, person : [N] numbers as they stand in the file.
    positions : [N, 2] in m, or in the unit that the homography maps from.
    lines : [N] where each row stands in the file, from 1.
    dt, frame_step : seconds and frame numbers between rows of a person; ``None``: the commonest step.
    homography : [3, 3] from the positions to metres; ``None`` if they are metres.
    """
    frames, ids = check_integers(path, "frame", frame, lines), check_integers(path, "id", person, lines)
    step = frame_step or commonest_step(frames, ids)
    if homography is not None:
        check_homography(path, frames * np.float64(dt / step), person, positions, homography)
        positions = to_ground(positions, homography)
    check_on_ground(path, positions, lines)
    order = np.lexsort((lines, frames, ids))
    frames, ids, lines = frames[order], ids[order], lines[order]
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
    check_speed(path, scene, step, homography)
    return scene


def commonest_step(frame: IntArray, person: IntArray) -> int:
    """The commonest step within tracks of rows [N]; 1 where there is none."""
    order = np.lexsort((frame, person))
    delta = np.diff(frame[order])[np.diff(person[order]) == 0]
    steps, counts = np.unique(delta[delta > 0], return_counts=True)
    return int(steps[counts.argmax()]) if len(steps) else 1


def _row_of_frame(frame: IntArray, step: int) -> IntArray:
    """Row [N] of each frame; a recording may change its phase while it has no people, so gaps are rounded up."""
    unique, inverse = np.unique(frame, return_inverse=True)
    rows = np.concatenate([[0], np.cumsum(-(-np.diff(unique) // step))])
    return rows[inverse].astype(np.int64)
