"""Yaw of an observer's head in continuous time, for ``look = natural`` and for each of its four laws.

The direction of walking at time t is that of the chord p(t + s/2) − p(t − s/2) over a stride s of the observer's path
p; where the chord is shorter than `standing_speed`·s the person stands, and the direction is held. A sequence has one
of four laws, drawn with the shares of ``looking.toml``:

    follow   the direction of walking at t + δ(t), δ an Ornstein–Uhlenbeck process about the person's own lead
    ahead    the direction of p(t + τ) − p(t), τ the person's own
    glance   the direction of walking, or from it by a share of the angle to a neighbour, for as long as a glance lasts
    sway     the direction of walking + a·sin(π f t + φ), f the step rate

Who stands looks around: directions about the held one, each for a while. No head turns faster than `turn_rate`, and
none is steady: an Ornstein–Uhlenbeck process and an offset of the person's own come on top. All is computed every
`FINE` seconds or faster, and thinned to the frames: the law does not depend on the frame time.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Annotated, Literal

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.parsing.numbers import Checked, Share, Within
from vbbench.parsing.toml_text import read_bundled
from vbbench_generators import _core
from vbbench_generators.tiers.noise import wandering

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

    A person's first frame has the heading of the second, which is that of the first step, however slow. No protocol
    scores these two frames of an observer that enters there.
    """
    gain = 1.0 - np.exp(-dt / SMOOTHING_TIME)
    headings = np.full(positions.shape[:2], np.nan)
    last = np.full(positions.shape[1:], np.nan)  # smoothed velocities
    known = ~np.isnan(positions[..., 0])
    for t in range(1, len(positions)):
        walking = np.flatnonzero(known[t] & known[t - 1])
        before, now = positions[t - 1].take(walking, axis=0), positions[t].take(walking, axis=0)
        velocity, smoothed = (now - before) / dt, last.take(walking, axis=0)
        starting = np.isnan(smoothed[:, 0])
        smoothed = np.where(starting[:, None], velocity, smoothed + gain * (velocity - smoothed))
        turned = starting | (np.hypot(smoothed[:, 0], smoothed[:, 1]) >= STANDING_SPEED)
        direction = np.arctan2(smoothed[:, 1], smoothed[:, 0])
        headings[t, walking] = np.where(turned, direction, headings[t - 1].take(walking))
        headings[t - 1, walking[starting]] = direction[starting]
        last[:] = np.nan
        last[walking] = smoothed
    return headings


def wrapped(angle: FloatArray) -> FloatArray:
    """The angle in rad wrapped to [−π, π].

    `vbbench.geometry.wrap_angle` rounds differently in the last bit, which would change the bytes of datasets.
    """
    return np.arctan2(np.sin(angle), np.cos(angle))


def limit_turns(heading: FloatArray, dt: float, rate: float) -> FloatArray:
    """``heading`` [T] in rad with a limited turning rate ``rate`` in rad/s.

    A walker who turns back reverses the direction of motion within a frame, but not the gaze.
    """
    followed = heading.copy()
    for t in range(1, len(heading)):
        wanted = wrapped(heading[t] - followed[t - 1])
        followed[t] = followed[t - 1] + np.clip(wanted, -rate * dt, rate * dt)
    return followed


Seconds = Annotated[float, Within(0.0, 60.0, "s")]
Span = Annotated[float, Within(0.05, 60.0, "s")]
Angle = Annotated[float, Within(0.0, 3.1416, "rad")]
Rate = Annotated[float, Within(0.0, 100.0)]


@dataclass(frozen=True, kw_only=True)
class Walking(Checked):
    """Parameters that all laws share.

    Parameters
    ----------
    stride : time in s over which the direction of walking is measured, half before and half after.
    standing_speed : speed in m/s below which a person stands.
    turn_rate : greatest turning rate of a head in rad/s.
    offset_std : standard deviation in rad of a person's constant offset.
    unsteady_std, memory : standard deviation in rad and correlation time in s of random deviations.
    """

    stride: Span
    standing_speed: Rate
    turn_rate: Annotated[float, Within(0.1, 100.0)]
    offset_std: Angle
    unsteady_std: Angle
    memory: Span


@dataclass(frozen=True, kw_only=True)
class Follow(Checked):
    """The walking direction ``lead`` s later, drawn per person, with deviations of correlation time ``memory`` s."""

    share: Share
    lead: Seconds
    lead_std: Seconds
    unsteady_std: Seconds
    memory: Span


@dataclass(frozen=True, kw_only=True)
class Ahead(Checked):
    """The direction of the place reached after a time in s, drawn per person between ``nearest`` and ``farthest``."""

    share: Share
    nearest: Span
    farthest: Span


@dataclass(frozen=True, kw_only=True)
class Glance(Checked):
    """Along the path, except for glances at neighbours.

    Parameters
    ----------
    time_share : share of the time spent on glances, if there are neighbours.
    duration : mean duration of a glance in s.
    distance, widest : greatest distance in m of a neighbour, and angle in rad to either side of the path.
    head_share : share of the angle to the neighbour by which the head turns.
    """

    share: Share
    time_share: Annotated[float, Within(0.001, 0.9)]
    duration: Span
    distance: Annotated[float, Within(0.1, 1000.0)]
    head_share: Share
    widest: Angle


@dataclass(frozen=True, kw_only=True)
class Sway(Checked):
    """Along the path, oscillating at half the ``step_rate`` in 1/s with an ``amplitude`` in rad, drawn per person."""

    share: Share
    step_rate: Rate
    step_rate_std: Rate
    amplitude: Angle
    amplitude_std: Angle


@dataclass(frozen=True, kw_only=True)
class Standing(Checked):
    """Looking around while standing: directions held for ``held_for`` s on average, ``spread`` rad about the path's."""

    held_for: Span
    spread: Angle


@dataclass(frozen=True, kw_only=True)
class NaturalLook:
    """The laws of ``look = natural``; a law's ``share`` is that of the sequences in which it holds."""

    walking: Walking
    follow: Follow
    ahead: Ahead
    glance: Glance
    sway: Sway
    standing: Standing

    def __post_init__(self) -> None:
        if abs(sum(self.shares) - 1.0) > 1e-9:
            raise ValueError(f"the shares of the laws add up to {sum(self.shares):g}, not 1")

    @property
    def shares(self) -> tuple[float, float, float, float]:
        """The shares of `vbbench_generators.views.looking.LAWS`, in their order."""
        return self.follow.share, self.ahead.share, self.glance.share, self.sway.share


@cache
def natural_look() -> NaturalLook:
    """The settings that come with this package."""
    return read_bundled("vbbench_generators", "views/looking.toml", NaturalLook, "top level")


Law = Literal["follow", "ahead", "glance", "sway"]
LAWS: tuple[Law, ...] = ("follow", "ahead", "glance", "sway")
FINE = 0.1
"""The longest time in s between two yaws."""
LONGEST_LEAD = 3.0
"""Time in s by which a path is continued at its first and last speed, and by which heads look ahead at most."""


@dataclass(frozen=True, kw_only=True)
class Way:
    """An observer's path and the people around it.

    Parameters
    ----------
    path : [N, 2] places in m in the frames in which the observer is present.
    times : [N] times of these frames, in s from the sequence's start.
    around : [T, K, 2] places in m of people in the sequence's frames; NaN = absent. The observer may be among them.
    dt : seconds per frame.
    """

    path: FloatArray
    times: FloatArray
    around: FloatArray
    dt: float

    def at(self, times: FloatArray) -> FloatArray:
        """Places [n, 2] at ``times`` [n]: linear interpolation, and extrapolation at constant velocity."""
        known, x, y = self._continued
        return np.column_stack((np.interp(times, known, x), np.interp(times, known, y)))

    @cached_property
    def _continued(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Times [M] in s and coordinates x and y [M] in m of the path, extended by a place before and one after it."""
        known, path = self.times, self.path
        if len(path) > 1:
            known = np.concatenate([known[:1] - LONGEST_LEAD, known, known[-1:] + LONGEST_LEAD])
            first, last = path[1] - path[0], path[-1] - path[-2]
            before = path[0] - first * (LONGEST_LEAD / (self.times[1] - self.times[0]))
            after = path[-1] + last * (LONGEST_LEAD / (self.times[-1] - self.times[-2]))
            path = np.concatenate([before[None], path, after[None]])
        return known, path[:, 0].copy(), path[:, 1].copy()


def natural_yaws(way: Way, look: NaturalLook, rng: np.random.Generator, law: Law | None = None) -> FloatArray:
    """Yaw [T] in rad of the observer's head by ``law``; by default one is drawn."""
    drawn = LAWS[int(rng.choice(len(LAWS), p=look.shares))]
    law = law or drawn
    frames = len(way.around)
    steps = int(np.ceil(way.dt / FINE - 1e-9))
    times: FloatArray = way.dt / steps * np.arange((frames - 1) * steps + 1, dtype=np.float64)
    course, standing = _course(way, times, law, look, rng)
    course = course + np.where(standing, _looks_around(times, look, rng), 0.0)
    if law == "glance":
        course = course + np.where(standing, 0.0, _glances(way, times, course, look, rng))
    yaws = _core.turn_towards(course, look.walking.turn_rate * way.dt / steps)
    if law == "sway":
        yaws += np.where(standing, 0.0, _sways(times, look, rng))
    yaws += look.walking.offset_std * rng.standard_normal()
    yaws += look.walking.unsteady_std * _unsteady(times, look.walking.memory, rng)
    return yaws[::steps]


def _course(
    way: Way, times: FloatArray, law: Law, look: NaturalLook, rng: np.random.Generator
) -> tuple[FloatArray, BoolArray]:
    """Yaw [n] in rad of the head by the ``law`` while walking, held while standing, and a mask [n] of standing."""
    behind = ahead = np.full(len(times), 0.5 * look.walking.stride)
    if law == "follow":
        lead = look.follow.lead + look.follow.lead_std * rng.standard_normal()
        delay = lead + look.follow.unsteady_std * _unsteady(times, look.follow.memory, rng)
        behind, ahead = behind - delay, ahead + delay
    elif law == "ahead":
        tau = rng.uniform(look.ahead.nearest, look.ahead.farthest)
        behind, ahead = np.zeros(len(times)), np.full(len(times), tau)
    places = way.at(np.concatenate([times - behind, times + ahead]))
    chord = places[len(times) :] - places[: len(times)]
    walked = np.hypot(chord[:, 0], chord[:, 1]) >= look.walking.standing_speed * (behind + ahead)
    course = np.arctan2(chord[:, 1], chord[:, 0])
    somewhere = rng.uniform(-np.pi, np.pi)
    if not walked.any():
        return np.full(len(times), somewhere), ~walked
    last = np.maximum.accumulate(np.where(walked, np.arange(len(times)), -1))
    held: FloatArray = course[np.where(last < 0, np.argmax(walked), last)]
    return held, ~walked


def _looks_around(times: FloatArray, look: NaturalLook, rng: np.random.Generator) -> FloatArray:
    """Random offsets [n] in rad from the path's direction, piecewise constant."""
    number = 8 + int(4.0 * (times[-1] - times[0]) / look.standing.held_for)
    ends = np.cumsum(rng.exponential(look.standing.held_for, number))
    sides = look.standing.spread * rng.standard_normal(number + 1)
    turned: FloatArray = sides[np.searchsorted(ends, times)]
    return turned


def _glances(
    way: Way, times: FloatArray, course: FloatArray, look: NaturalLook, rng: np.random.Generator
) -> FloatArray:
    """Offsets [n] in rad from the ``course`` [n] by glances at neighbours."""
    glance = look.glance
    pause = glance.duration * (1.0 / glance.time_share - 1.0)
    number = 8 + int(4.0 * (times[-1] - times[0]) / (pause + glance.duration))
    pauses, lasting = rng.exponential(pause, number), rng.exponential(glance.duration, number)
    begins = np.cumsum(pauses) + np.cumsum(lasting) - lasting
    chosen = rng.uniform(size=number)
    first, last = np.searchsorted(times, begins), np.searchsorted(times, begins + lasting)
    frames = np.minimum((times / way.dt + 1e-9).astype(np.int64), len(way.around) - 1)
    here = way.at(times)
    turned = np.zeros(len(times))
    for begin, end, which in zip(first, last, chosen, strict=True):
        if begin >= min(end, len(times)):
            continue
        bearing = _bearing_from(way.around[frames[begin]] - here[begin], course[begin])
        apart = np.hypot(*(way.around[frames[begin]] - here[begin]).T)
        near = np.flatnonzero((apart > 0.2) & (apart < glance.distance) & (np.abs(bearing) < glance.widest))
        if len(near):
            person = near[int(which * len(near))]
            there = way.around[frames[begin:end], person]
            side = _bearing_from(there - here[begin:end], course[begin:end])
            turned[begin:end] = np.nan_to_num(glance.head_share * np.clip(side, -glance.widest, glance.widest))
    return turned


def _bearing_from(apart: FloatArray, course: FloatArray) -> FloatArray:
    """Angles [n] in rad from the ``course`` [n] to the vectors ``apart`` [n, 2], positive to the left."""
    return wrapped(np.arctan2(apart[:, 1], apart[:, 0]) - course)


def _sways(times: FloatArray, look: NaturalLook, rng: np.random.Generator) -> FloatArray:
    """Oscillation [n] in rad with random rate, amplitude and phase."""
    rate = look.sway.step_rate + look.sway.step_rate_std * rng.standard_normal()
    amplitude = look.sway.amplitude + look.sway.amplitude_std * rng.standard_normal()
    swayed: FloatArray = amplitude * np.sin(np.pi * rate * times + rng.uniform(-np.pi, np.pi))
    return swayed


def _unsteady(times: FloatArray, memory: float, rng: np.random.Generator) -> FloatArray:
    """An Ornstein–Uhlenbeck process [n] with unit variance and the correlation time ``memory`` in s."""
    return wandering((len(times),), memory, (times[-1] - times[0]) / max(len(times) - 1, 1), rng)
