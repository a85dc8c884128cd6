"""What all solvers share when nothing is given but the observer's pose in frame 0 (protocol ``cold-start``).

People are first placed where the heights of their boxes say. How fast anybody moves is not known then, and how fast all
move together never becomes quite certain: nothing in a picture of people tells a crowd that walks past from an observer
who walks the other way. Only what is likely helps: people are slow, and so their velocities count as drawn from N(0,
`PEOPLE_SPEED`²) about once every `FADE` seconds; what is expected of the next frame fades towards a standstill as
quickly. The observer may drive.
"""

import math

from vbbench.sequence import Given

PEOPLE_SPEED = 1.0
"""In m/s, standard deviation of each component of people's velocities."""

OBSERVER_SPEED = 4.0
"""The same of the observer, who may be a vehicle."""

FADE, OBSERVER_FADE = 4.0, 16.0
"""In s: how long a velocity that nothing confirms is believed of people, and of the observer."""


def begins_cold(given: Given, frame: int) -> bool:
    """Whether ``given`` of the frames up to ``frame`` (the last rows) shows that the sequence began cold.

    Only frame 1 can tell: every other protocol gives its pose.
    """
    return frame == 1 and math.isnan(given.poses[-1, 0])


def kept_velocities(dt: float) -> tuple[float, float]:
    """The shares of the velocities of people and of the observer that are still expected ``dt`` seconds later."""
    return math.exp(-dt / FADE), math.exp(-dt / OBSERVER_FADE)
