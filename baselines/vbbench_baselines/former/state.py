"""The recurrent state of the network, relative to the last pose and so independent of the world's origin."""

from collections.abc import Callable
from typing import NamedTuple

from vbbench_baselines.former.operations import Array

TRACES = 4
"""Directions that each walk remembers: sums of what it did unexpectedly, each forgotten at its own pace."""
MEMORY, DOUBT = 24, 12
"""Numbers that are remembered of each person and of the observer, and of how unsure the pose is."""


class Walkers(NamedTuple):
    """The state of people, [..., K]; points and velocities are complex, in the axes of the last pose.

    Attributes
    ----------
    place, place_before : in m, in the last frame and the one before it.
    velocity : over the ground, in m/s.
    traces : [..., K, `TRACES`] decaying sums of innovations, in m/s.
    memory : [..., K, `MEMORY`] of a gated recurrent unit.
    offsets : [..., K, 2] ln of the ratio of the distance to that by box height, and to that by feet.
    seen : number of frames in which the person was seen.
    away : time in s since the person was seen.
    shown, traceable : 1 if the last frame showed the person, and if there was a place before that.
    exact, exact_before : 1 if ``place`` and ``place_before`` were given.
    by_height, by_feet, has_feet : what the last frame's boxes measured, see `vbbench_baselines.former.scene.Sights`.
    """

    place: Array
    place_before: Array
    velocity: Array
    traces: Array
    memory: Array
    offsets: Array
    seen: Array
    away: Array
    shown: Array
    traceable: Array
    exact: Array
    exact_before: Array
    by_height: Array
    by_feet: Array
    has_feet: Array


class Observer(NamedTuple):
    """The state of the observer, [...].

    Attributes
    ----------
    step, turn : the last frame's motion, in m/s (complex) and rad/s.
    velocity, turn_rate : predictions for the next frame, in m/s and rad/s.
    smooth, head_odds : smoothed velocity in m/s, and log odds of a head that follows it (`heads`).
    traces, memory : [..., `TRACES`] and [..., `MEMORY`], see `Walkers`.
    doubt : [..., `DOUBT`] recurrent memory of the pose's error.
    moved, given : 1 if there was a last motion, and if it was given.
    frames : number of frames so far.
    """

    step: Array
    turn: Array
    velocity: Array
    turn_rate: Array
    smooth: Array
    head_odds: Array
    traces: Array
    memory: Array
    doubt: Array
    moved: Array
    given: Array
    frames: Array


class State(NamedTuple):
    """The state between two frames."""

    people: Walkers
    observer: Observer


_COMPLEX = ("place", "place_before", "velocity", "traces", "step", "smooth")
_SIZES = {"traces": (TRACES,), "memory": (MEMORY,), "offsets": (2,), "doubt": (DOUBT,)}


def nothing_seen(numbers: Callable[..., Array], points: Callable[..., Array], people: int) -> State:
    """The state before frame 0; ``numbers`` and ``points`` make zeros of a shape, real and complex."""

    def zeros(name: str, *shape: int) -> Array:
        return (points if name in _COMPLEX else numbers)(*shape, *_SIZES.get(name, ()))

    walkers = Walkers(*(zeros(name, people) for name in Walkers._fields))
    return State(walkers, Observer(*(zeros(name) for name in Observer._fields)))
