"""Tables of positions, a row for each person in each frame; a header or comment may name the columns.

Otherwise, four columns are Trajnet's ``frame id x y``, and eight are ETH's ``obsmat.txt``: ``frame id x z y vx vz vy``
in metres, where z is up.
"""

import re
from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.text_tables import NamedColumns, names_several, read_table, refuse_missing, split_header
from vbbench.geometry import FloatArray
from vbbench.parsing.column_names import SHARES, header_of
from vbbench.parsing.numbers import parse_number
from vbbench.scene import Scene
from vbbench_generators.recordings.loading import Reader, SceneFile
from vbbench_generators.recordings.readers.tracks import (
    NOUNS,
    count_columns,
    read_rows,
    read_text,
    scene_of_rows,
    steps_of_people,
)

TRAJNET = ("frame", "id", "x", "y")
OBSMAT = ("frame", "id", "x", "z", "y", "vx", "vz", "vy")
"""Names of the columns."""
JITTER = 0.1
"""Share by which times may differ from ``dt``."""
SWAPPED = 2.0
"""Frames and ids are swapped if people's steps are so many times shorter then."""
FEWEST_STEPS = 12
"""Steps from which this is judged."""


def _check_rate(path: Path, content: bytes, dt: float, steps: FloatArray) -> None:
    """Raise FileError if a comment states a frame rate that contradicts ``dt``; frames are ``steps`` [N] apart."""
    comment = rb"^#\s*(?:framerate|frame rate|fps)\s*[:=]\s*([\d.]+)"
    found = re.search(comment, content, re.I | re.M) if b"#" in content else None
    rate = 0.0 if found is None else parse_number(found[1].decode()) or 0.0
    step = float(np.median(steps)) if len(steps) else 1.0
    if rate and min(abs(rate * dt - 1.0), abs(rate * dt / step - 1.0)) > JITTER:
        problem = f"has {rate:g} frames a second by its comment, and --dt is {dt:g}"
        raise FileError(path, f"{problem}; write --dt {step / rate:.4g}")


def _points(table: NamedColumns, homography: FloatArray | None) -> FloatArray:
    """[N, 2] places in the unit of the columns' names: m, or px with a homography."""
    unit = table.unit("x")
    if unit != table.unit("y") or unit in SHARES:
        raise table.fault(0, "x and y must both be in metres, or in pixels with --homography")
    if unit in ("px", "pixel", "pixels") and homography is None:
        raise table.fault(0, "x and y are in pixels: a homography is needed, name its file with --homography")
    if unit in ("m", "cm", "mm", "km") and homography is not None:
        raise table.fault(0, f"x and y are in {unit} already: remove `homography`")
    return np.column_stack([table.scaled("x"), table.scaled("y")])


def _frames(table: NamedColumns, dt: float) -> FloatArray:
    """[N] frames from 0 of times in the unit of the column's name, else in whichever of s, ms, us, ns fits ``dt``."""
    time = table.scaled("time")
    steps = steps_of_people(time, table.numbers("id"), time[:, None])
    step = float(np.median(steps)) if len(steps) else dt
    fitting = [factor for factor in table.time_units if abs(step * factor / dt - 1.0) <= JITTER]
    if not fitting:
        raise table.fault(0, f"times of a person are {step:g} s apart, but --dt is {dt:g}; write --dt {step:.4g}")
    instants, place = np.unique(time, return_inverse=True)
    passed = np.diff(instants) * fitting[0] / dt
    frames = np.append(0.0, np.cumsum(np.round(passed)))[place]
    off = np.append(False, np.abs(passed - np.round(passed)) > 2.0 * JITTER)[place]
    table.refuse(off, f"time {{0:.15g}} is not a whole number of steps of {dt:g} s", time)
    return frames


def _refuse_swapped(path: Path, frame: FloatArray, person: FloatArray, points: FloatArray) -> None:
    """Raise FileError if steps are much shorter with the columns of frame and person swapped."""
    given, swapped = steps_of_people(frame, person, points), steps_of_people(person, frame, points)
    if min(len(given), len(swapped)) >= FEWEST_STEPS and np.median(given) > SWAPPED * np.median(swapped) > 0.0:
        problem = f"frame and id seem to be swapped: people move by {np.median(given):.3g} from row to row, and by "
        problem += f"{np.median(swapped):.3g} if the columns are id frame x y"
        raise FileError(path, f"{problem}; write what they are in a first line, such as '# id frame x y'")


def names_columns(line: str) -> bool:
    """Whether a line is a header of such a table."""
    header = header_of(line, NOUNS)
    return header is not None and names_several(header, comment=False)


class Trajnet(Reader):
    """Rows ``frame id x y``, or columns with names, in metres, or in pixels with a homography."""

    signature = f"{len(TRAJNET)} columns ({' '.join(TRAJNET)}), or more under a header that names these"

    def recognises(self, line: str) -> bool:
        """See `Reader.recognises`: by the names of columns, or their number."""
        return count_columns(line) == len(TRAJNET) or names_columns(line)

    def read(self, file: SceneFile) -> Scene:
        """See `Reader.read`; rows may be in any order. A header or comment that names columns decides what they are."""
        path, dt = file.path, file.dt
        content = read_text(path)
        named = split_header(content, NOUNS)[1] is not None
        table = read_table(path, content, NOUNS, required=NOUNS) if named else read_rows(path, TRAJNET)
        table.refuse_films()
        if not len(table):
            raise FileError(path, "is empty: it names columns and holds no row of numbers")
        refuse_missing(table, [("frame", "time"), ("id",), ("x",), ("y",)])
        person, points = table.numbers("id"), _points(table, file.homography)
        frame = table.numbers("frame") if "frame" in table else _frames(table, dt)
        if not named:
            _refuse_swapped(path, frame, person, points)
        _check_rate(path, content, dt, steps_of_people(frame, person, frame[:, None]))
        step, matrix = file.frame_step, file.homography
        return scene_of_rows(path, frame, person, points, table.lines, dt=dt, frame_step=step, homography=matrix)


class Obsmat(Reader):
    """ETH's ``obsmat.txt``, in metres."""

    signature = f"{len(OBSMAT)} columns ({' '.join(OBSMAT)})"

    def recognises(self, line: str) -> bool:
        """See `Reader.recognises`: by the number of columns, where they have no names."""
        return count_columns(line) == len(OBSMAT) and not names_columns(line)

    def read(self, file: SceneFile) -> Scene:
        """See `Reader.read`: ground-plane positions (x, y) in m; heights z and velocities are ignored."""
        if file.homography is not None:
            raise FileError(file.path, "is an obsmat table, which is in metres already: remove `homography`")
        table = read_rows(file.path, OBSMAT)
        frame, person, points = table.numbers("frame"), table.numbers("id"), table.stacked("x", "y")
        step = file.frame_step
        return scene_of_rows(file.path, frame, person, points, table.lines, dt=file.dt, frame_step=step)


trajnet = Trajnet()
obsmat = Obsmat()
