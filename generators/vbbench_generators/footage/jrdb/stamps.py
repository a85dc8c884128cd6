"""Times of JRDB's pictures and point clouds: ``timestamps/NAME/frames_img.json`` and ``frames_pc.json``."""

from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from vbbench.errors import FileError, quoted
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.json_text import read_object

RATE = 15.0
"""Pictures a second, nominally."""

PICTURES, CLOUDS = "frames_img.json", "frames_pc.json"
_LISTS = {PICTURES: ("cameras", "stitched"), CLOUDS: ("pointclouds", "upper")}
_LONGEST_GAP = 1.0
_DRIFT = 0.1


@dataclass(frozen=True, kw_only=True)
class Stamps:
    """Times of numbered frames.

    Parameters
    ----------
    frames : [N] numbers, ascending.
    times : [N] in s, ascending.
    """

    path: Path
    frames: IntArray
    times: FloatArray

    def between(self, first: int, last: int) -> "Stamps":
        """The times of frames ``first`` to ``last``, both included."""
        kept = slice(*np.searchsorted(self.frames, [first, last + 1]))
        return Stamps(path=self.path, frames=self.frames[kept], times=self.times[kept])


@dataclass(frozen=True, kw_only=True)
class Grid:
    """A regular grid of slots, 1/15 s apart, with the frames of a recording; some slots may be empty.

    Parameters
    ----------
    frames : [N] numbers of the recording's frames, ascending.
    slots : [N] slot of each frame.
    times : [T] times of all slots in s.
    """

    frames: IntArray
    slots: IntArray
    times: FloatArray

    @property
    def seconds(self) -> float:
        """Measured duration of a slot, in s."""
        return float((self.times[-1] - self.times[0]) / max(len(self.times) - 1, 1))

    def slot_of(self, frames: IntArray) -> IntArray:
        """[M] slots of numbered frames, −1 where there is none."""
        if not len(self.frames):
            return np.full(len(frames), -1)
        nearest = np.searchsorted(self.frames, frames).clip(max=len(self.frames) - 1)
        return np.where(self.frames[nearest] == frames, self.slots[nearest], -1)


def nominal_stamps(path: Path, frames: IntArray) -> Stamps:
    """Times of frames exactly at `RATE`, for a recording without times."""
    return Stamps(path=path, frames=frames, times=frames / RATE)


def lay_out(stamps: Stamps) -> Grid:
    """Put frames on slots by their times."""
    if len(stamps.frames) < 2:
        raise FileError(stamps.path, f"stamps {len(stamps.frames)} of the labelled frames; two at least are wanted")
    passed = np.diff(stamps.times)
    common = float(np.median(passed))
    step = max(1, round(common * RATE))
    if abs(common * RATE / step - 1.0) > _DRIFT:
        raise FileError(stamps.path, f"frames are {common:.4f} s apart, which is no multiple of 1/{RATE:.0f} s")
    slots = np.concatenate([[0], np.cumsum(np.maximum(1, np.rint(passed / (common / step)).astype(np.int64)))])
    times = np.interp(np.arange(slots[-1] + 1), slots, stamps.times)
    return Grid(frames=stamps.frames, slots=slots, times=times)


def read_stamps(folder: Path, name: str) -> Stamps:
    """The times in one of the two files in ``timestamps/NAME``."""
    path = folder / name
    rows = read_object(path, "download JRDB's timestamps next to the labels").get("data")
    if not isinstance(rows, list) or not rows:
        raise FileError(path, "has no list 'data' with an object for each frame")
    found = dict(_stamp(path, number, row, name) for number, row in enumerate(rows, 1))
    if len(found) < len(rows):
        raise FileError(path, f"has {len(rows)} entries of {len(found)} frames: a frame stands there twice")
    frames = np.array(sorted(found), np.int64)
    times = np.array([found[frame] for frame in frames.tolist()])
    passed = np.diff(times)
    bad = (passed <= 0.0) | (passed > _LONGEST_GAP)
    if bad.any():
        row = int(bad.argmax())
        problem = f"the clock jumps by {passed[row]:+.3f} s from frame {frames[row]:06d} to the next"
        raise FileError(path, f"{problem}; exclude this recording with `sequences`")
    return Stamps(path=path, frames=frames, times=times)


def _stamp(path: Path, number: int, row: Any, name: str) -> tuple[int, float]:
    """Number and time of one frame: of the stitched picture, or of the upper lidar's cloud, if they are there."""
    key, wanted = _LISTS[name]
    sensors = row.get(key) if isinstance(row, dict) else None
    usable = isinstance(sensors, list) and all(isinstance(sensor, dict) for sensor in sensors)
    if not sensors or not usable:
        raise FileError(path, f"entry {number} of 'data': key '{key}' is {quoted(sensors)}, not a list of sensors")
    sensor = next((one for one in sensors if wanted in str(one.get("name"))), sensors[0])
    stem = PurePosixPath(str(sensor.get("url"))).stem
    if not (stem.isascii() and stem.isdigit() and len(stem) <= 9):
        raise FileError(path, f"entry {number} of 'data': url is {quoted(sensor.get('url'))}, not …/000000.jpg or .pcd")
    try:
        time = float(sensor.get("timestamp", row.get("timestamp")))
    except (TypeError, ValueError):
        time = np.nan
    if not np.isfinite(time):
        raise FileError(path, f"entry {number} of 'data': key 'timestamp' is missing or no number of seconds")
    return int(stem), time
