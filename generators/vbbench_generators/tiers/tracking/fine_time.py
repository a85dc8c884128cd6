"""Time between frames: what is seen at the rate of a video of people whose places are known less often.

Recordings have a frame every 0.4 s, and detectors and trackers run on video. Between two frames everybody follows the
cubic curve through both places whose velocities there are means of the steps before and after (Catmull and Rom 1974);
the camera's yaw does the same, the shorter way round. A frame stands for the time around it: whoever is there is there
for half a frame before and after, walking straight on, so that people do not come out of nowhere in the very picture
in which they count.
"""

from dataclasses import replace
from math import ceil

import numpy as np

from vbbench.generation.tier import Sight
from vbbench.geometry import FloatArray, wrap_angle
from vbbench.sequence import Truth

VIDEO_RATE = 25.0
"""Frames per second of a usual camera's video, at which detectors and trackers run."""


def finer(sight: Sight, rate: float = VIDEO_RATE) -> tuple[Sight, int]:
    """The sight at a finer rate.

    Parameters
    ----------
    sight : what is around an observer in T frames.
    rate : least number of frames per second that is wanted.

    Returns
    -------
    The sight in (T − 1)·n + 1 frames, of which every n-th is one of the T, unchanged; and n ≥ 1.
    """
    steps = max(ceil(sight.dt * rate - 1e-9), 1)
    if steps == 1:
        return sight, 1
    truth = sight.truth
    turns = np.diff(truth.poses[:, 2:], axis=0)
    ahead = np.concatenate([np.diff(truth.poses[:, :2], axis=0), wrap_angle(turns)], axis=1)
    nearest = (np.arange((len(truth.poses) - 1) * steps + 1) + steps // 2) // steps
    fine = Truth(
        poses=_curve(truth.poses, ahead, steps),
        positions=_curve(truth.positions, np.diff(truth.positions, axis=0), steps),
        heights=truth.heights,
    )
    return replace(
        sight, truth=fine, seen=sight.seen[nearest], watched=sight.watched[nearest], dt=sight.dt / steps
    ), steps


def _curve(values: FloatArray, ahead: FloatArray, steps: int) -> FloatArray:
    """The curve through ``values`` [T, ...], whose next ones are ``ahead`` [T − 1, ...], at ``steps`` places a frame.

    Where one end is NaN, straight on from the other end for half of the way.
    """
    unknown = np.full((1, *values.shape[1:]), np.nan)
    before, after = np.concatenate([unknown, ahead]), np.concatenate([ahead, unknown])
    before, after = np.where(np.isnan(before), after, before), np.where(np.isnan(after), before, after)
    speed = np.nan_to_num(0.5 * (before + after))
    s = (np.arange(steps) / steps).reshape(1, -1, *[1] * (values.ndim - 1))
    start, way, leaving, arriving = values[:-1, None], ahead[:, None], speed[:-1, None], speed[1:, None]
    cubic = start + s**2 * (3.0 - 2.0 * s) * way + s * (1.0 - s) * ((1.0 - s) * leaving - s * arriving)
    onwards = np.where(s < 0.5, start + s * leaving, values[1:, None] - (1.0 - s) * arriving)
    between = np.where(np.isnan(way), onwards, cubic)
    return np.concatenate([between.reshape(len(way) * steps, *values.shape[1:]), values[-1:]])
