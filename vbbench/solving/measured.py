"""Measurements of a robot as checked arrays: boxes of tracks, odometry, and time stamps."""

import sys
import warnings
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vbbench.boxes import find_misfit
from vbbench.camera import Camera
from vbbench.errors import VbbenchError, VbbenchWarning, quoted
from vbbench.geometry import BoolArray, FloatArray, IntArray, motion_levers, wrap_angle
from vbbench.sequence import Odometry

MOST = 4
"""Columns are added up to so many times the people seen at once; then whoever was out of sight longest has to go."""

NOBODY = -1


class Columns:
    """The assignment of remembered tracks to columns.

    Parameters
    ----------
    count : initial number of columns.
    patience : frames out of sight after which a track is forgotten.
    """

    def __init__(self, count: int, patience: int) -> None:
        self.count, self._patience = count, patience
        self._of: dict[Hashable, int] = {}
        self._tracks: list[Hashable] = [None] * count
        self._seen = np.full(count, NOBODY)
        self._free = list(range(count - 1, -1, -1))
        self._left: list[int] = []

    def expire(self, frame: int) -> None:
        """Forget tracks last seen ``patience`` or more frames before this one; if they return, they are new."""
        for column in np.flatnonzero((self._seen != NOBODY) & (frame - self._seen >= self._patience)).tolist():
            self._forget(column)

    def clear_for(self, tracks: Sequence[Hashable]) -> IntArray:
        """Free columns of expired tracks for the new ones among these tracks, if they are needed.

        Returns
        -------
        [M] columns whose people the solver must forget; none while enough columns were never used.
        """
        if self._lacking(tracks) <= 0:
            return np.empty(0, np.int64)
        if self.count >= MOST * len(tracks):
            seen = {self._of[track] for track in tracks if track in self._of}
            away = [column for column in self._of.values() if column not in seen]
            away.sort(key=lambda column: int(self._seen[column]))
            for column in away[: max(self._lacking(tracks) - len(self._left), 0)]:
                self._forget(column)
        cleared, self._left = self._left, []
        self._free += cleared
        return np.array(cleared, np.int64)

    def know(self, tracks: Sequence[Hashable]) -> bool:
        """Whether one of the tracks was seen before and has not been cleared."""
        return any(track in self._of for track in tracks)

    def lack(self, tracks: Sequence[Hashable]) -> bool:
        """Whether the tracks need more columns than exist."""
        return self._lacking(tracks) > 0

    def widen(self, tracks: Sequence[Hashable]) -> None:
        """Double the columns, or more where these tracks need it."""
        count = max(2 * self.count, self.count + self._lacking(tracks))
        self._free = [*range(count - 1, self.count - 1, -1), *self._free]
        self._tracks += [None] * (count - self.count)
        self._seen = np.concatenate([self._seen, np.full(count - self.count, NOBODY)])
        self.count = count

    def place(self, tracks: Sequence[Hashable], frame: int) -> IntArray:
        """The columns [N] of tracks seen in this frame; assigns free columns to new tracks."""
        of, columns = self._of, np.empty(len(tracks), np.int64)
        for row, track in enumerate(tracks):
            column = of.get(track)
            if column is None:
                column = of[track] = self._free.pop()
                self._tracks[column] = track
            columns[row] = column
        self._seen[columns] = frame
        return columns

    def _lacking(self, tracks: Sequence[Hashable]) -> int:
        of = self._of
        return sum(track not in of for track in tracks) - len(self._free)

    def _forget(self, column: int) -> None:
        del self._of[self._tracks[column]]
        self._tracks[column] = None
        self._seen[column] = NOBODY
        self._left.append(column)


OfTracks = Mapping[Any, ArrayLike] | Iterable[tuple[Any, ArrayLike]]
"""Numbers of each track, by its id: a mapping, or pairs such as a list of detections makes them."""

LATE = 0.75
"""A frame that is late by up to so many dt is late; beyond it, one was missed."""

EARLIEST = 0.5
"""Frames that come earlier than after so many dt are too many."""

TALLEST = 4.0
"""In heights of the picture: no box is taken to reach farther beyond it."""

SAMPLED, FIRST_LOOK = 512, 10
"""Boxes of a session of which a sample is kept, and after how many it is looked at first."""

FASTEST, LEAP, QUICKEST, SWING = 60.0, 5.0, 10.0, 0.5
"""In m/s, m, rad/s and rad: no camera is faster, but for noise."""

LONGEST_BREAK = 3600.0
"""Seconds after which a session cannot go on."""


def read_boxes(boxes: OfTracks, names: tuple[str, ...]) -> tuple[list[Hashable], FloatArray]:
    """Tracks and their numbers [N, len(names)].

    Raises VbbenchError if a track comes twice, or its numbers are not finite, or a size is not above 0.

    Parameters
    ----------
    boxes : numbers of each track.
    names : names of the numbers; those after the second are sizes.
    """
    try:
        pairs = list(boxes.items() if isinstance(boxes, Mapping) else boxes)
        tracks, values = [track for track, _ in pairs], [value for _, value in pairs]
    except (TypeError, ValueError) as error:
        wanted = f"boxes must be a mapping of ids to ({', '.join(names)}), or pairs (id, ({', '.join(names)}))"
        raise VbbenchError(f"{wanted}, not {quoted(boxes)}") from error
    numbers, sound = _rows(values, len(names))
    sound &= np.isfinite(numbers).all(axis=1) & (numbers[:, 2:] > 0.0).all(axis=1)
    if not sound.all():
        row = int(np.argmin(sound))
        raise VbbenchError(
            f"box of track {quoted(tracks[row])}: ({', '.join(names)}) must be {len(names)} finite numbers, "
            f"{' and '.join(names[2:])} above 0, not {quoted(values[row])}"
        )
    _check_tracks(tracks)
    return tracks, numbers


def _rows(values: list[ArrayLike], length: int) -> tuple[FloatArray, BoolArray]:
    """The values as an array [N, length], and a mask of those that have so many numbers."""
    try:
        numbers = np.array(values, dtype=np.float64).reshape(len(values), -1 if values else length)
        if numbers.shape[1] == length:
            return numbers, np.ones(len(values), np.bool_)
    except (TypeError, ValueError):
        pass
    return np.ones((len(values), length)), np.array([_is_row(value, length) for value in values], np.bool_)


def _is_row(value: ArrayLike, length: int) -> bool:
    try:
        return np.asarray(value, dtype=np.float64).shape == (length,)
    except (TypeError, ValueError):
        return False


def _check_tracks(tracks: list[Hashable]) -> None:
    for track in tracks:
        if track != track:  # NaN, as a table has it that knows no ids
            raise VbbenchError(f"the id {quoted(track)} of a track is not equal to itself; give each track its own")
    try:
        distinct = len(set(tracks)) == len(tracks)
    except TypeError as error:
        raise VbbenchError(f"ids of tracks must be hashable, such as numbers or text: {error}") from error
    if not distinct:
        twice = next(track for row, track in enumerate(tracks) if track in tracks[:row])
        raise VbbenchError(f"track {quoted(twice)} has two boxes in one frame; keep one")


class BoxWatch:
    """Warns once of boxes that cannot be people in the camera's picture (`vbbench.boxes`).

    A bounded sample of all boxes is kept, and checked after 10, 20, 40, … boxes.

    Parameters
    ----------
    camera : camera of the pictures.
    height_mean : mean height of people in m.
    """

    def __init__(self, camera: Camera, height_mean: float) -> None:
        self._camera, self._height_mean = camera, height_mean
        self._sample, self._kept = np.empty((SAMPLED, 4)), 0
        self._frames, self._every = 0, 1
        self._boxes, self._due = 0, FIRST_LOOK

    def see(self, boxes: FloatArray) -> None:
        """Add the boxes [N, 4] (left, top, width, height) in px of a frame, and check when due."""
        self._frames += 1
        self._boxes += len(boxes)
        if self._frames % self._every == 0:
            kept = boxes[: SAMPLED - self._kept]
            self._sample[self._kept : self._kept + len(kept)] = kept
            self._kept += len(kept)
        if self._boxes >= self._due:
            self._due = 2 * self._boxes
            self._look()
        if self._kept == SAMPLED:
            self._kept, self._every = SAMPLED // 2, 2 * self._every
            self._sample[: self._kept] = self._sample[::2].copy()

    def _look(self) -> None:
        size = self._camera.picture_size
        misfit = find_misfit(self._sample[: self._kept], self._camera, size, self._height_mean)
        if misfit is not None:
            self._due = sys.maxsize
            warnings.warn(VbbenchWarning(f"after {self._boxes} boxes: {misfit.text}"), stacklevel=4)


def far_outside(observations: FloatArray, camera: Camera) -> BoolArray:
    """Mask [N] of boxes [N, 3] with a centre outside the picture by more than their height.

    Columns of a panorama may exceed its sides by one turn.
    """
    size = np.array(camera.picture_size)
    off = np.abs(observations[:, :2] - 0.5 * size) - 0.5 * size
    if camera.period is not None:
        off[:, 0] -= camera.period
    return np.asarray((off > np.minimum(observations[:, 2:], TALLEST * size[1])).any(axis=1))


def check_in_picture(tracks: list[Hashable], observations: FloatArray, camera: Camera) -> None:
    """Raise VbbenchError if a box of ``observations`` [N, 3] lies outside the picture, as of another camera."""
    outside = far_outside(observations, camera)
    if outside.any():
        row = int(np.argmax(outside))
        column, line, height = observations[row]
        width, rows = camera.picture_size
        raise VbbenchError(
            f"box of track {quoted(tracks[row])}: its centre ({column:g}, {line:g}) is too far, at a height of "
            f"{height:g} px, outside the camera's picture of {width} x {rows} px; is it the camera that took it?"
        )


def read_odometry(measured: tuple[ArrayLike, ArrayLike], seconds: float) -> Odometry:
    """One measured motion (forward, left, turn) in m and rad during ``seconds``, and its covariance [3, 3].

    Raises VbbenchError if a number is not finite, no camera is so fast, or the covariance is not symmetric and
    positive.
    """
    wanted = "odometry must be a pair, a motion (forward, left, turn) and its covariance [3, 3]"
    try:
        moved, sigma = (np.array(part, dtype=np.float64) for part in measured)
    except (TypeError, ValueError) as error:
        raise VbbenchError(f"{wanted}, not {quoted(measured)}") from error
    if moved.shape != (3,) or sigma.shape != (3, 3):
        raise VbbenchError(f"{wanted}, not {list(moved.shape)} and {list(sigma.shape)}")
    if not (np.isfinite(moved).all() and np.isfinite(sigma).all()):
        raise VbbenchError("odometry must be finite; give None where nothing was measured")
    way, turn = float(np.hypot(*moved[:2])), abs(float(wrap_angle(moved[2])))
    if way > LEAP + FASTEST * seconds or turn > SWING + QUICKEST * seconds:
        fast = f"odometry moves the camera by {way:.4g} m and {turn:.3g} rad in {seconds:g} s"
        raise VbbenchError(f"{fast}; give the motion since the last frame, in m and rad")
    variances = sigma.diagonal()
    if not (variances > 0.0).all():
        raise VbbenchError(
            f"the odometry's variances must be above 0, not {quoted(variances.tolist())}: zeros often stand for "
            "unknown; give what is known of the wheels, or give None"
        )
    scale = np.sqrt(variances)
    correlations = sigma / np.outer(scale, scale)
    if np.abs(correlations - correlations.T).max() > 1e-6 or np.linalg.eigvalsh(correlations)[0] < -1e-6:
        raise VbbenchError(
            f"the odometry's covariance {quoted(sigma.tolist())} is not symmetric positive semi-definite"
        )
    return Odometry(motions=moved[None], covariances=0.5 * (sigma + sigma.T)[None])


def shared_out(odometry: Odometry, frames: int) -> Odometry:
    """One motion divided into ``frames`` equal ones along the same arc, with the same total covariance.

    An error e of the motion into frame i moves and turns all that follows, by J_i e in the axes before the first; with
    J_i⁻¹ C/n J_i⁻ᵀ as the covariance of each, that of all n together is C.
    """
    if frames == 1:
        return odometry
    forward, left, turn = odometry.motions[0]
    turn = float(wrap_angle(turn)) / frames
    axes = np.exp(1j * turn * np.arange(frames))  # of each frame, in those of the first
    first = complex(forward, left) / axes.sum()
    motions = np.tile([first.real, first.imag, turn], (frames, 1))
    places = np.cumsum(first * axes)
    behind = places[-1] - places  # from where each motion ends to where the last one does
    back = np.linalg.inv(motion_levers(axes, behind))
    return Odometry(motions=motions, covariances=back @ (odometry.covariances / frames) @ back.transpose(0, 2, 1))


@dataclass(frozen=True, kw_only=True)
class FrameClock:
    """Counts frames by time stamps with jitter.

    Parameters
    ----------
    dt : seconds per frame.
    last : the last stamp in s; ``None`` before the first.
    behind : delay in s of the last frame; it is halved with each frame.
    """

    dt: float
    last: float | None = None
    behind: float = 0.0

    def advanced(self, time: float | None) -> tuple[int, "FrameClock"]:
        """The number of frames, at least 1, from the last stamp to ``time`` in s, and the clock then; ``None`` means 1.

        Raises VbbenchError if the stamp is not finite, not later than the last one, far too early, or an hour later.
        """
        if time is None:
            return 1, replace(self, last=None if self.last is None else self.last + self.dt)
        number = isinstance(time, (int, float, np.integer, np.floating)) and not isinstance(time, bool)
        if not number or not np.isfinite(float(time)):
            raise VbbenchError(f"the time of a frame must be a finite number of seconds, not {quoted(time)}")
        time = float(time)
        if self.last is None:
            return 1, replace(self, last=time)
        elapsed = time - self.last
        if elapsed <= 0.0:
            raise VbbenchError(f"the frame at {time:.3f} s is not later than the one before at {self.last:.3f} s")
        if elapsed > LONGEST_BREAK:
            raise VbbenchError(
                f"the frame at {time:.3f} s is {elapsed:.0f} s later than the one before; times are in seconds, "
                "and after so long a break a new session has to begin"
            )
        due = elapsed + self.behind
        if due < EARLIEST * self.dt:
            raise VbbenchError(
                f"the frame at {time:.3f} s is {elapsed:.3f} s later than the one before, and frames are {self.dt:g} s "
                "apart; give fewer frames, or give the session the camera's dt"
            )
        frames = max(1, int(np.ceil(due / self.dt - LATE)))
        return frames, replace(self, last=time, behind=0.5 * (due - frames * self.dt))
