"""UCY's ``.vsp`` spline annotation: for each person, a few hand-made key points in the image.

    415 - the number of splines
    9 - Num of control points
    174.000000 -131.000000 0 91.974945 - (2D point, m_id)

A key point is ``x y frame gaze``: pixels from the frame's centre, y up, and a video frame. The UCY text files
interpolate linearly between key points; a smooth curve is closer to walking. Records after the last spline (obstacles)
are ignored.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, quoted
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.numbers import finite_number
from vbbench.scene import Scene
from vbbench_generators.recordings.loading import Reader, SceneFile
from vbbench_generators.recordings.readers.tracks import (
    check_homography,
    check_integers,
    check_on_ground,
    read_text,
    scene_of_rows,
    to_ground,
)

FRAME_RATE = 25.0
"""Video frames a second of the UCY recordings."""

COLUMNS = ("x", "y", "frame", "gaze")

FEW_SAMPLES, SAMPLES_PER_KEY = 10**5, 2000
"""A file is sampled at so many places or fewer, or so many for each key point: 80 s of every frame between two."""

Lines = list[tuple[int, str]]
"""Numbers of lines from 1, with what stands there."""


@dataclass(frozen=True, kw_only=True)
class KeyPoints:
    """One person's annotation.

    Parameters
    ----------
    frame : [N] video frames, ascending.
    points : [N, 2] in px from the frame's centre, y up.
    lines : [N] 1-based line numbers.
    """

    frame: IntArray
    points: FloatArray
    lines: IntArray

    def samples(self, step: int) -> tuple[int, int]:
        """The first and the last multiple of ``step`` frames between the key points, in steps."""
        return -(-int(self.frame[0]) // step), int(self.frame[-1]) // step


def polyline(times: FloatArray, key_times: FloatArray, keys: FloatArray) -> FloatArray:
    """The straight line between key points, as in the UCY text files."""
    return np.stack([np.interp(times, key_times, keys[:, axis]) for axis in (0, 1)], axis=-1)


def read_key_points(path: Path) -> list[KeyPoints]:
    """The key points of every person, in file order.

    Raises FileError with file and line, if the annotation is bad or cut short.
    """
    stripped = ((number, line.strip()) for number, line in enumerate(read_text(path).decode().split("\n"), 1))
    lines = [(number, line) for number, line in stripped if line and not line.startswith("#")]
    if not lines:
        raise FileError(path, "is empty: it holds no spline")
    people = _header(path, lines, 0, "the number of splines")
    found, row = [], 1
    for _ in range(people):
        count = _header(path, lines, row, "Num of control points")
        found.append(_key_points(path, lines[row + 1 : row + 1 + count], count, lines[row][0]))
        row += 1 + count
    if not found:
        raise FileError(path, "is empty: it holds no spline", lines[0][0])
    return found


def _header(path: Path, lines: Lines, row: int, what: str) -> int:
    """The count on a line such as ``9 - Num of control points``."""
    if row >= len(lines):
        raise FileError(path, f"ends where '<count> - {what}' should stand", lines[-1][0])
    number, line = lines[row]
    match = re.fullmatch(rf"([0-9]{{1,9}})\s*-\s*{what}", line)
    if match is None:
        raise FileError(path, f"'<count> - {what}' should stand here, not {quoted(line)}", number)
    return int(match[1])


def _check_samples(path: Path, people: list[KeyPoints], step: int) -> None:
    """Refuse key points so far apart in time that what lies between them would fill the memory."""
    counts = [last - first + 1 for first, last in (keys.samples(step) for keys in people)]
    if sum(counts) > max(FEW_SAMPLES, SAMPLES_PER_KEY * sum(len(keys.frame) for keys in people)):
        longest = people[counts.index(max(counts))]
        problem = (
            f"a spline goes from frame {longest.frame[0]} to {longest.frame[-1]} with {len(longest.frame)} key points"
        )
        raise FileError(path, f"{problem}; correct its frame numbers", int(longest.lines[0]))


def _key_points(path: Path, lines: Lines, count: int, header: int) -> KeyPoints:
    if len(lines) < count or count == 0:
        raise FileError(path, f"a spline of {count} control points has {len(lines)}", header)
    numbers = np.array([number for number, _ in lines])
    values = np.array([_numbers(path, number, line.partition(" - ")[0]) for number, line in lines])
    frame = check_integers(path, "frame", values[:, 2], numbers)
    back = np.flatnonzero(np.diff(frame) <= 0)
    if len(back):
        row = back[0] + 1
        raise FileError(path, f"key frame {frame[row]} does not come after {frame[row - 1]}", int(numbers[row]))
    return KeyPoints(frame=frame, points=values[:, :2], lines=numbers)


def _numbers(path: Path, number: int, line: str) -> list[float]:
    words = line.replace(",", " ").split()
    if len(words) != len(COLUMNS):
        raise FileError(path, f"has {len(words)} columns, not {len(COLUMNS)} ({' '.join(COLUMNS)})", number)
    return [finite_number(path, number, name, word) for name, word in zip(COLUMNS, words, strict=True)]


def smooth_curve(times: FloatArray, key_times: FloatArray, keys: FloatArray) -> FloatArray:
    """Positions [M, 2] at ``times`` [M] on the monotone cubic (PCHIP) through ``keys`` [N, 2] at ``key_times`` [N].

    The velocity is continuous, and between two key points no coordinate leaves the range of the two. A cubic spline
    with continuous acceleration would overshoot by up to 4.8 m in UCY Students, where people who stand have key points
    up to 54 s apart.
    """
    from scipy.interpolate import PchipInterpolator

    if len(key_times) == 1:
        return keys.repeat(len(times), axis=0)
    curve: FloatArray = PchipInterpolator(key_times, keys)(times)
    return curve


class Splines(Reader):
    """A spline annotation in pixels, with the homography to metres."""

    signature = "a UCY .vsp spline file"

    def recognises(self, line: str) -> bool:
        """See `Reader.recognises`: by the header."""
        return "number of splines" in line

    def read(self, file: SceneFile) -> Scene:
        """See `Reader.read`; the file counts frames at `FRAME_RATE`, and ``dt`` gives their number per sample.

        A person is present from the first to the last key point, in the video frames that the number divides. Ids
        count from 1 in file order.
        """
        path, homography = file.path, file.homography
        if homography is None:
            raise FileError(path, "is a spline annotation in pixels: name the file of its homography with `homography`")
        step, curve = file.frame_step or _frames_in(path, file.dt), smooth_curve if file.smooth else polyline
        people = read_key_points(path)
        _check_samples(path, people, step)
        time = np.concatenate([keys.frame for keys in people]) / FRAME_RATE
        whose = np.repeat(np.arange(len(people)), [len(keys.frame) for keys in people]).astype(np.float64)
        check_homography(path, time, whose, np.concatenate([keys.points for keys in people]), homography)
        parts = []
        for person, keys in enumerate(people, 1):
            ground = to_ground(keys.points, homography)
            check_on_ground(path, ground, keys.lines)
            first, last = keys.samples(step)
            frame = np.arange(first, last + 1, dtype=np.float64) * step
            if len(frame):
                place = np.broadcast_to([person, keys.lines[0]], (len(frame), 2))
                parts.append(np.column_stack([place, frame, curve(frame, keys.frame.astype(float), ground)]))
        if not parts:
            raise FileError(path, f"no person is annotated at a multiple of {step} frames")
        ids, line, frames, *xy = np.concatenate(parts).T
        metres, lines = np.stack(xy, -1), line.astype(np.int64)  # mapped above
        return scene_of_rows(path, frames, ids, metres, lines, dt=file.dt, frame_step=step, homography=np.eye(3))


def _frames_in(path: Path, dt: float) -> int:
    """Video frames in ``dt``."""
    frames = dt * FRAME_RATE
    if frames < 0.5 or abs(frames - round(frames)) > 1e-6:
        raise FileError(path, f"counts frames at {FRAME_RATE:g} Hz: `dt` must be a multiple of {1.0 / FRAME_RATE:g} s")
    return round(frames)


vsp = Splines()
