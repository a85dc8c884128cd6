"""A plain crowd for demonstrations and tests: people cross a square and step aside for one another.

Everybody walks towards a point on another side of the square and steers away from predicted near collisions: the
avoidance acts on the closest approach of two people who keep their velocities, and is stronger the sooner it comes.
A slow random change of velocity keeps paths from being straight lines, which a solver could exploit. It is no model
of real pedestrians; it needs no data.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.arrays import FloatArray, IntArray
from vbbench.scene import Scene

HALF_SIDE = 8.0
"""Half the side of the square, in m; its centre is the origin."""
SPEED_MEAN, SPEED_STD, SPEED_RANGE = 1.34, 0.26, (0.8, 1.9)
"""Desired speeds in m/s: a truncated normal distribution."""

_STEP = 0.05  # s; longer steps let head-on walkers jump through each other
_WARM_UP = 8.0  # s; hides the random start
_RELAXATION = 0.5  # s to regain the desired velocity
_HORIZON = 3.0  # s over which people foresee a near collision
_CLEARANCE = 0.7  # m of miss distance at which the push is 1
_FALLOFF = 0.15  # m
_PUSH = 1.5  # m/s²
_REACH, _CONTACT = 0.55, 30.0  # m, 1/s²: the spring that keeps bodies apart
_KEEP_RIGHT = 0.15  # m; breaks the tie of two people who meet head-on
_WANDER_STD, _WANDER_TIME = 0.12, 1.0  # m/s, s: a velocity that is added to the desired one
_TOP_SPEED = 1.25  # of the desired speed
_ENTRANCES = 12  # tried for each arrival; the emptiest is taken


@dataclass
class _Walkers:
    """The people inside the square; arrays run over them."""

    positions: FloatArray
    velocities: FloatArray
    goals: FloatArray
    speeds: FloatArray
    wander: FloatArray
    ids: IntArray


def make_crowd(seed: int, index: int, people: int, frames: int, dt: float) -> Scene:
    """Simulate a crowd in a square of 16 m; whoever leaves is replaced by somebody new.

    Parameters
    ----------
    seed, index : the scene follows from ``SeedSequence([seed, index])`` alone.
    people : number of people present at any time.
    frames : number of frames T.
    dt : seconds a frame.

    Returns
    -------
    Scene of T frames; ids count from 0 in order of arrival, heights are unknown (NaN).
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, index]))
    walkers = _start(rng, people)
    for _ in range(round(_WARM_UP / _STEP)):
        _advance(walkers, _STEP, rng)
    steps = max(1, round(dt / _STEP))
    positions, ids = np.empty((frames, people, 2)), np.empty((frames, people), np.int64)
    for frame in range(frames):
        positions[frame], ids[frame] = walkers.positions, walkers.ids
        for _ in range(steps):
            _advance(walkers, dt / steps, rng)
    return _as_scene(f"crowd-{seed}-{index}", dt, positions, ids)


def _as_scene(name: str, dt: float, positions: FloatArray, ids: IntArray) -> Scene:
    present, column = np.unique(ids, return_inverse=True)
    tracks = np.full((len(ids), len(present), 2), np.nan)
    np.put_along_axis(tracks, column.reshape(ids.shape)[..., None], positions, axis=1)
    people = np.arange(len(present))
    return Scene(name=name, dt=dt, people=people, positions=tracks, heights=np.full(len(people), np.nan))


def _start(rng: np.random.Generator, people: int) -> _Walkers:
    inside = rng.uniform(-HALF_SIDE, HALF_SIDE, (people, 2))
    sides = rng.integers(4, size=people)
    goals = _border_points(rng, sides)
    speeds = _desired_speeds(rng, people)
    wander = rng.normal(0.0, _WANDER_STD, (people, 2))
    return _Walkers(inside, speeds[:, None] * _unit(goals - inside), goals, speeds, wander, np.arange(people))


def _advance(walkers: _Walkers, step: float, rng: np.random.Generator) -> None:
    kept = np.exp(-step / _WANDER_TIME)
    walkers.wander = kept * walkers.wander + rng.normal(0.0, _WANDER_STD * np.sqrt(1.0 - kept**2), walkers.wander.shape)
    velocities = walkers.velocities + step * _accelerations(walkers)
    pace = np.linalg.norm(velocities, axis=-1, keepdims=True)
    velocities *= np.minimum(1.0, _TOP_SPEED * walkers.speeds[:, None] / np.maximum(pace, 1e-9))
    walkers.velocities = velocities
    walkers.positions = walkers.positions + step * velocities
    for left in np.flatnonzero(np.abs(walkers.positions).max(axis=-1) > HALF_SIDE):
        _replace(walkers, int(left), rng)


def _accelerations(walkers: _Walkers) -> FloatArray:
    desired = walkers.speeds[:, None] * _unit(walkers.goals - walkers.positions) + walkers.wander
    return (desired - walkers.velocities) / _RELAXATION + _avoidance(walkers.positions, walkers.velocities)


def _avoidance(positions: FloatArray, velocities: FloatArray) -> FloatArray:
    apart = positions[:, None] - positions
    closing = velocities[:, None] - velocities
    soonest = -np.sum(apart * closing, axis=-1) / np.maximum(np.sum(closing**2, axis=-1), 1e-9)
    soonest = np.clip(soonest, 0.0, _HORIZON)
    ahead = _unit(velocities)
    to_the_right = _KEEP_RIGHT * np.stack([ahead[:, 1], -ahead[:, 0]], axis=-1)
    miss = apart + closing * soonest[..., None] + to_the_right[:, None]
    distance = np.linalg.norm(miss, axis=-1)
    foreseen = _PUSH * np.exp((_CLEARANCE - distance) / _FALLOFF).clip(max=3.0) * (1.0 - soonest / _HORIZON)
    touching = _CONTACT * np.clip(_REACH - np.linalg.norm(apart, axis=-1), 0.0, None)
    for strength in (foreseen, touching):
        np.fill_diagonal(strength, 0.0)
    push: FloatArray = np.sum(foreseen[..., None] * _unit(miss) + touching[..., None] * _unit(apart), axis=1)
    return push


def _replace(walkers: _Walkers, slot: int, rng: np.random.Generator) -> None:
    sides = rng.integers(4, size=_ENTRANCES)
    entrances = _border_points(rng, sides)
    others = np.delete(walkers.positions, slot, axis=0)
    room = np.linalg.norm(entrances[:, None] - others, axis=-1).min(axis=1, initial=np.inf)
    best = int(np.argmax(room))
    # Half of the arrivals cross to the opposite side, the others leave by a neighbouring one.
    exit_side = (sides[best] + rng.choice([1, 2, 2, 3])) % 4
    walkers.positions[slot] = entrances[best]
    walkers.goals[slot] = _border_points(rng, np.array([exit_side]))[0]
    walkers.speeds[slot] = _desired_speeds(rng, 1)[0]
    walkers.velocities[slot] = walkers.speeds[slot] * _unit(walkers.goals[slot] - entrances[best])
    walkers.ids[slot] = walkers.ids.max() + 1


def _border_points(rng: np.random.Generator, sides: IntArray) -> FloatArray:
    """Random points [N, 2] on sides 0 to 3, counter-clockwise from the eastern one; corners left out."""
    along = rng.uniform(-0.85 * HALF_SIDE, 0.85 * HALF_SIDE, len(sides))
    turn = sides * (np.pi / 2.0)
    x = HALF_SIDE * np.cos(turn) - along * np.sin(turn)
    y = HALF_SIDE * np.sin(turn) + along * np.cos(turn)
    points: FloatArray = np.clip(np.stack([x, y], axis=-1), -HALF_SIDE, HALF_SIDE)
    return points


def _desired_speeds(rng: np.random.Generator, count: int) -> FloatArray:
    speeds: FloatArray = np.clip(rng.normal(SPEED_MEAN, SPEED_STD, count), *SPEED_RANGE)
    return speeds


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: FloatArray = vectors / np.maximum(length, 1e-9)
    return unit
