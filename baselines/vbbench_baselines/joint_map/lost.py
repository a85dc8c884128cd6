"""For how long too few people have been seen to tell where the observer is.

One person who is seen alone leaves open where the observer stands around them, and nobody leaves everything open. What
the joint problem believes then, that all go on as they did, is sure of itself for much longer than it is right: people
stop and turn.
"""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray

ENOUGH, FOUND = 2, 3
"""So many people who are seen at once keep an observer in place, and so many whose places are given find one who is
lost: two of them may stand in one direction."""

PATIENCE = 2.0
"""In s: for so long an observer without enough people is not lost."""

RECENT = 8
"""Frames for which a given place keeps somebody known."""


def seconds_after(seconds: float, seen: BoolArray, given: BoolArray, posed: bool, dt: float) -> float:
    """The ``seconds`` without enough people, a frame later.

    Parameters
    ----------
    seen : [K] who is seen now.
    given : [n, K] whose place is given, now (last) and in frames before.
    posed : whether the observer's pose is given.
    dt : seconds that have passed without odometry.
    """
    known = np.count_nonzero(seen & given[-RECENT:].any(axis=0))
    kept = np.count_nonzero(seen) >= ENOUGH and seconds <= PATIENCE
    return 0.0 if posed or kept or known >= FOUND else seconds + dt


def seconds_lost(seen: BoolArray, given: BoolArray, posed: BoolArray, dt: FloatArray) -> FloatArray:
    """The same of all frames [T] at once, where the frames after them count as well.

    All frames without enough people, if enough come in the end, are half as long lost as the last of them is: where the
    way that was believed before meets what is known afterwards is anywhere between them. ``seen`` and ``given`` are
    [T, K].
    """
    seconds, now, first = np.zeros(len(seen)), 0.0, 0
    for t in range(len(seen)):
        before, now = now, seconds_after(now, seen[t], given[: t + 1], bool(posed[t]), float(dt[t]))
        seconds[t] = now
        if now == 0.0:
            seconds[first:t] = 0.5 * before
            first = t + 1
    return seconds


def beyond_patience(seconds: FloatArray) -> FloatArray:
    """The ``seconds`` [...] of those who are lost, 0 of others."""
    return np.where(seconds > PATIENCE, seconds, 0.0)
