"""Frames from frame numbers and from time stamps."""

from dataclasses import dataclass, replace

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.text_tables import Rows
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.column_names import UNITS

SAME_FRAME = 0.1
"""Time stamps that differ by less, in frames, are of one frame."""
UNEVEN = 0.25
"""How far the time between two frames may be from a whole number of frames before it is worth a note."""
SLOWEST, MOST_FRAMES = 5.0, 300.0
"""Stamps that are usually so many s apart, or frames whose duration is given, are no seconds."""

LONGEST_GAP, LONGEST_ABSENCE = 60.0, 3600.0
"""A clock that goes on by more seconds from one box to the next has jumped; so has a frame number."""
SEVERAL_TICKS, DOUBTED = 200, 0.12
"""Ticks that show how long one of an even clock lasts, and by what share that may differ from what is stated."""
FIRST_TICKS, FOLLOWS = 10, 0.1
"""Stamps that show when it ticks, and the share of what a stamp is off by that it follows."""
DRIFT = 0.02
"""How far the mean time of a frame may be from the stated one before it is worth a note, as a share."""


@dataclass(frozen=True)
class Timeline:
    """The times of a recording's frames.

    Parameters
    ----------
    frames : number of frames T.
    times : [T] in s by the clock of the boxes' file, to which poses and odometry refer.
    first_number, step : number of frame 0 in the file, and difference to the next; 0 and 1 with time stamps.
    numbered : whether frames have numbers in the file, and no time stamps.
    near : greatest distance in s of a time from its frame; ``None`` for half of ``dt``.
    """

    frames: int
    dt: float
    times: FloatArray
    first_number: int = 0
    step: int = 1
    notes: tuple[str, ...] = ()
    near: float | None = None
    numbered: bool = False

    @property
    def frame_time(self) -> float:
        """Seconds from a frame of the film to the next, of which every ``step``-th is used."""
        return self.dt / self.step

    def frame_of_time(self, time: FloatArray) -> FloatArray:
        """The nearest frames of time stamps; −1 if none is near."""
        frame = nearest(self.times, time)
        near = np.abs(self.times[frame] - time) <= (0.5 * self.dt if self.near is None else self.near) + 1e-9
        return np.where(near, frame, -1.0)


def number_frames(rows: Rows, numbers: FloatArray, dt: float | None, base: int) -> tuple[IntArray, Timeline]:
    """The frame of each row by its frame number [N]; ``base`` is the number of the first frame of the film.

    Numbers with a constant step, as of a film of which every fourth frame was used, become consecutive frames.
    """
    wrong = (numbers != np.round(numbers)) | (numbers < 0)
    rows.refuse(wrong, "frame {0:.10g} is not a whole number from 0 on", numbers)
    if dt is None:
        problem = "its frames are numbered, and no file says how long one lasts"
        raise FileError(rows.path, f"{problem}: give --dt, or write dt or fps in camera.toml")
    different = np.unique(numbers)
    apart = np.diff(different) * dt
    if (apart > LONGEST_ABSENCE).any():
        gap = int(np.argmax(apart > LONGEST_ABSENCE))
        before, after = different[gap : gap + 2]
        problem = f"frame {after:.10g} is {apart[gap]:.6g} s after the one before, {before:.10g}"
        stamped = len(apart) >= FIRST_TICKS and np.median(apart) > LONGEST_ABSENCE
        name = "are these time stamps? Then name the column time_ms or time_ns"
        advice = name if stamped else "split the recording there"
        raise rows.fault(int(np.argmax(numbers == after)), f"{problem}; {advice}")
    different = different.astype(np.int64)
    step = max(1, int(np.gcd.reduce(np.diff(different)))) if len(different) > 1 else 1
    first = int(different[0])
    frame = (numbers.astype(np.int64) - first) // step
    count = int(frame.max()) + 1
    note = f"frames are numbered in steps of {step}: one every {step} x {dt:g} = {step * dt:g} s is used"
    times = np.asarray((first - min(base, first) + step * np.arange(count)) * dt, np.float64)
    return frame, Timeline(count, step * dt, times, first, step, (note,) if step > 1 else (), numbered=True)


def time_frames(rows: Rows, times: FloatArray, dt: float | None) -> tuple[IntArray, Timeline]:
    """The frame of each row by its time stamp in s [N], in whatever order the rows are.

    The time from a frame to the next is rounded to whole frames, which tolerates a small error of the clock's rate.
    With large jitter, ticks of a regular clock are counted instead.
    """
    order = np.argsort(times, kind="stable")
    begins = np.concatenate([[True], np.diff(times[order]) > SAME_FRAME * (dt or 0.001)])
    stamps, group = times[order][begins], np.cumsum(begins) - 1
    if len(stamps) < 2:
        raise FileError(rows.path, "all boxes are of one time; a map needs a film")
    apart = np.diff(stamps)
    usual, row_of = float(np.quantile(apart, 0.5, method="lower")), order[np.flatnonzero(begins)]
    if usual > (MOST_FRAMES * dt if dt else SLOWEST):
        unit = next((one for one in ("ms", "us", "ns") if dt and 0.9 < usual * UNITS[one] / dt <= MOST_FRAMES), None)
        if unit is None:
            advice = "times are in seconds: are these milliseconds, or nanoseconds? Then name them time_ms or time_ns"
            raise rows.fault(int(row_of[1]), f"frames are {usual:.6g} s apart; {advice}; else write dt")
        frame, timeline = time_frames(rows, times * UNITS[unit], dt)
        return frame, replace(timeline, notes=(f"times are read as {unit}", *timeline.notes))
    said = dt or usual
    steps = apart / said
    whole = np.round(steps).astype(np.int64)
    if (whole < 1).any():
        whole = _by_the_clock(stamps, said)
    wrong = (whole < 1) | (apart > LONGEST_GAP)
    if wrong.any():
        after = int(wrong.argmax())
        if apart[after] > LONGEST_GAP:
            problem = f"the clock jumps by {apart[after]:.6g} s, from {stamps[after]:.10g} s; split the recording there"
        else:
            late = f"{apart[after]:.3g} s after the frame before"
            problem = f"time {stamps[after + 1]:.10g} s is {late}, a frame lasts {said:g} s; write the dt of the stamps"
        raise rows.fault(int(row_of[after + 1]), problem)
    number = np.concatenate([[0], np.cumsum(whole)])
    every = int(np.gcd.reduce(np.diff(number)))
    number, steps, notes = number // every, steps / every, list[str]()
    if every > 1:
        notes += [f"time stamps come every {every} frames: one every {every} x {said:g} = {every * said:g} s is used"]
    near = 0.5 * said
    said *= every
    frame = np.empty(len(times), np.int64)
    frame[order] = number[group]
    count = int(number[-1]) + 1
    middle = number - number.mean()
    mean = float(middle @ (stamps - stamps.mean()) / (middle @ middle))  # the slope of all, whatever the ends' jitter
    lasts = said if abs(mean / said - 1.0) <= DRIFT else round(mean, 6)
    if lasts != said:
        stated = f"every {mean:.4g} s, and dt is {said:g} s"
        notes += [f"time stamps come {stated}: motions are taken to last {mean:.4g} s"]
    uneven = int((np.abs(steps - np.round(steps)) > UNEVEN).sum())
    if uneven:
        grid = f"more than {UNEVEN:g} frames from an even grid of {said:g} s"
        notes += [f"{uneven} of {len(steps)} time stamps are {grid}"]
    times = np.interp(np.arange(count), number, stamps)
    return frame, Timeline(count, lasts, times, notes=tuple(notes), near=near if every > 1 else None)


def _by_the_clock(stamps: FloatArray, dt: float) -> IntArray:
    """[N − 1] frames from each stamp to the next, by the nearest tick of a regular clock, for stamps with jitter.

    The clock follows the stamps slowly, as its rate may have a small error. A step below 1 means that two stamps belong
    to one tick.
    """
    since = stamps - stamps[0]
    shown = since[since <= SEVERAL_TICKS * dt]
    finest = 0.1 * dt / max(float(shown[-1]) / dt, 1.0)
    ticks = dt + finest * np.arange(-round(DOUBTED * dt / finest), round(DOUBTED * dt / finest) + 1)
    dt = float(ticks[np.abs(np.exp(2j * np.pi * shown / ticks[:, None]).sum(axis=1)).argmax()])  # the best period
    first = since[:FIRST_TICKS] / dt
    clock = stamps[0] + dt * float(np.angle(np.exp(2j * np.pi * first).mean())) / (2.0 * np.pi)
    steps = np.empty(len(stamps), np.int64)
    for n, stamp in enumerate(stamps.tolist()):
        steps[n] = round((stamp - clock) / dt)
        clock += steps[n] * dt
        clock += FOLLOWS * (stamp - clock)
    return steps[1:]


def nearest(times: FloatArray, wanted: FloatArray) -> IntArray:
    """[M] the row of ``times`` [N], ascending, nearest to each that is ``wanted`` [M]."""
    after = np.searchsorted(times, wanted).clip(min(1, len(times) - 1), len(times) - 1)
    before = np.maximum(after - 1, 0)
    return np.where(np.abs(times[before] - wanted) <= np.abs(times[after] - wanted), before, after)
