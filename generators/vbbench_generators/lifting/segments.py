"""Stretches of walking: where a person's head is at the beginning and at the end of a window of about two seconds."""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray

_LEAST_SHARE = 0.8


@dataclass(frozen=True, kw_only=True)
class Segments:
    """Windows of tracks, by track.

    Parameters
    ----------
    person : [S] number of the track, ascending.
    begin, end : [S, 2] mean (x, ν) in px over a window's first and last third, in px from the picture's centre.
    duration : [S] seconds between the two.
    """

    person: IntArray
    begin: FloatArray
    end: FloatArray
    duration: FloatArray

    def __len__(self) -> int:
        return len(self.person)


def cut_segments(
    x: FloatArray, nu: FloatArray, frame: IntArray, track: IntArray, *, dt: float, window: float
) -> Segments:
    """Cut tracks into windows of ``window`` s that follow one another; those with too few boxes are left out.

    Parameters
    ----------
    x, nu, frame, track : [N] boxes by track, then by frame.
    dt : seconds a frame.
    """
    third = max(1, round(window / dt / 3.0))
    opening = np.r_[True, track[1:] != track[:-1]]
    number = np.cumsum(opening) - 1
    part = (frame - frame[opening][number]) // third
    key = number * (int(part.max()) + 3) + part
    starts = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    count = np.diff(np.r_[starts, len(key)])
    mean = np.stack([np.add.reduceat(values, starts) / count for values in (x, nu, frame * dt)], axis=1)
    opens = np.flatnonzero(part[starts] % 3 == 0)
    opens = opens[opens + 2 < len(starts)]
    full = np.minimum(count[opens], count[opens + 2]) >= _LEAST_SHARE * third
    opens = opens[full & (key[starts[opens + 2]] == key[starts[opens]] + 2)]
    return Segments(
        person=number[starts[opens]],
        begin=mean[opens, :2],
        end=mean[opens + 2, :2],
        duration=mean[opens + 2, 2] - mean[opens, 2],
    )
