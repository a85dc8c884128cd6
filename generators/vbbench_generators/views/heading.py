"""Which way a walker faces, from its past motion only, so that no future leaks through the camera's yaw."""

import numpy as np

from vbbench.geometry import FloatArray

SMOOTHING_TIME = 0.8
"""Time constant in s of the exponential smoothing of velocity: about one stride."""
STANDING_SPEED = 0.3
"""Below this smoothed speed in m/s the heading is held."""
WANDER_STD = 0.5
"""Standard deviation in rad of the head turn of `wander`."""
WANDER_TIME = 3.0
"""Correlation time in s of that turn."""


def causal_headings(positions: FloatArray, dt: float) -> FloatArray:
    """Heading in rad, [T, K], of people at positions [T, K, 2] in m.

    A person's first frame has no past; it gets the heading of its second, and the second that of the first step,
    however slow. No protocol scores those two frames of an observer that enters there.
    """
    gain = 1.0 - np.exp(-dt / SMOOTHING_TIME)
    headings = np.full(positions.shape[:2], np.nan)
    smoothed = np.full(positions.shape[1:], np.nan)
    for t in range(1, len(positions)):
        velocity = (positions[t] - positions[t - 1]) / dt
        walking = ~np.isnan(velocity[:, 0])
        starting = walking & np.isnan(smoothed[:, 0])
        smoothed = np.where(starting[:, None], velocity, smoothed + gain * (velocity - smoothed))
        turned = starting | (np.hypot(smoothed[:, 0], smoothed[:, 1]) >= STANDING_SPEED)
        direction = np.arctan2(smoothed[:, 1], smoothed[:, 0])
        headings[t] = np.where(walking, np.where(turned, direction, headings[t - 1]), np.nan)
        headings[t - 1, starting] = headings[t, starting]
    return headings


def wrapped(angle: FloatArray) -> FloatArray:
    """The angle in rad wrapped to [−π, π].

    Not `vbbench.geometry.wrap_angle`, which rounds differently in the last bit: the bytes of datasets rest on this.
    """
    return np.arctan2(np.sin(angle), np.cos(angle))


def limit_turns(heading: FloatArray, dt: float, rate: float) -> FloatArray:
    """Heading [T] in rad of a person who follows ``heading`` [T] turning by at most ``rate`` rad/s.

    A walker who stops and comes back reverses the motion from one frame to the next; nobody's eyes do.
    """
    followed = heading.copy()
    for t in range(1, len(heading)):
        wanted = wrapped(heading[t] - followed[t - 1])
        followed[t] = followed[t - 1] + np.clip(wanted, -rate * dt, rate * dt)
    return followed
