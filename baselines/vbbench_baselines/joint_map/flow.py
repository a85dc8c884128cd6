"""How fast all move together after a cold start: what boxes do not tell, and people's pace does.

If the camera and everybody moved faster by the same velocity, every box would be where it is. A descent therefore keeps
the common velocity that it has begun with: nobody changes a speed all at once. So all worlds that look alike, in which
all move faster along the camera's heading by so much, are weighed against one another by how people walk
(`motion.pace`) and by how cameras move: as people do, or as vehicles that stand or seldom go backwards. Where another
world is more probable, all is moved there.
"""

import math

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.common.cold_start import OBSERVER_FADE, OBSERVER_SPEED
from vbbench_baselines.joint_map.motion.pace import ANEW, density

FASTER = np.arange(-60, 61) / 10.0
"""In m/s: the worlds."""

HERE = len(FASTER) // 2
"""The world as it is believed to be."""

SURER_BY = 0.2
"""By so much −ln of the probability must be lower."""

OVER = 0.8
"""In s: velocities are those over so long, in which boxes' errors matter less; over half of it of who is new."""

ENOUGH = 7
"""In frames: velocities over so many count even if they last less."""

ALIKE, WITHIN = 2.0, 0.5
"""However many people walk alike, they tell no more than so many who walk as they like: a crowd has a velocity in
common. Two are alike whose velocities are less than about so many m/s apart."""

STANDS, STILL = 0.4, 0.15
"""How probable it is that a vehicle stands, and how fast in m/s it then seems to move."""

REVERSES = 0.1
"""How much less probable than a speed forwards is one backwards."""

OWN_ANEW = 2.0
"""In s: a vehicle's speed is told anew as often."""


class Flow:
    """Weighs the worlds, frame by frame, until anything else tells; earlier frames fade.

    Parameters
    ----------
    dt : in s.
    drives : whether the camera is a vehicle's; else it is a pedestrian's.
    """

    def __init__(self, dt: float, drives: bool) -> None:
        self._dt, self._drives = dt, drives
        self._against: FloatArray = np.zeros(len(FASTER))
        self._before: FloatArray = np.zeros((0, 2))
        self._alone = True

    def is_needed(self, poses: FloatArray, places: FloatArray, motions: FloatArray) -> bool:
        """Whether nothing has told until now how fast all move; to be asked with the last frames as in `is_untold`."""
        self._alone = self._alone and is_untold(poses, places, motions)
        return self._alone

    def follow(self, poses: FloatArray, places: FloatArray, shown: BoolArray) -> FloatArray | None:
        """By how far each of the last frames moves [n, 2] in m, the first not at all; ``None`` if all stay.

        Parameters
        ----------
        poses, places, shown : [n, ≥ 3], [n, K, 2] and [n, K] of the last frames, as believed, and whether somebody is
            seen: those of the call before, of which the oldest may have left, and a new one.
        """
        self._keep_up(poses)
        self._before = poses[:, :2].copy()
        self._against *= math.exp(-self._dt / OBSERVER_FADE)
        weigh(poses, places, shown, self._dt, self._drives, self._against)
        if not shown[-1].any():
            return None
        faster = _surer(self._against)
        if faster == 0.0:
            return None
        self._against = _counted_from(faster, self._against)
        moved = ways_of(faster, poses, self._dt)
        self._before += moved
        return moved

    def _keep_up(self, poses: FloatArray) -> None:
        """Count the worlds from the present one, which the last descent has moved, too."""
        n = min(len(self._before), len(poses) - 1)
        if n > 1:
            before, now = self._before[-n:], poses[-1 - n : -1, :2]
            way = (now[-1] - now[0]) - (before[-1] - before[0])
            ahead = np.array((math.cos(poses[-1, 2]), math.sin(poses[-1, 2])))
            self._against = _counted_from(float(ahead @ way) / ((n - 1) * self._dt), self._against)


def is_untold(poses: FloatArray, places: FloatArray, motions: FloatArray) -> bool:
    """Whether nothing tells how fast all move: no pose [n, 3] but the first, no place [n, K, 2], no motion [n, 3]."""
    return not any(np.isfinite(values).any() for values in (poses[1:], places, motions[1:]))


def flow_of(poses: FloatArray, places: FloatArray, shown: BoolArray, dt: float, drives: bool) -> FloatArray:
    """By how far each frame of a whole sequence moves [T, 2] in m, to the most probable world; the rest as `Flow`."""
    against = np.zeros(len(FASTER))
    for end in range(1, len(poses) + 1):
        start = max(0, end - 1 - _frames_of(OVER, dt))
        weigh(poses[start:end], places[start:end], shown[start:end], dt, drives, against)
    return ways_of(_surer(against), poses, dt)


def ways_of(faster: float, poses: FloatArray, dt: float) -> FloatArray:
    """[n, 2] in m: how much farther along their headings frames with these ``poses`` get that all move ``faster``."""
    ways: FloatArray = np.zeros((len(poses), 2))
    headings = np.column_stack((np.cos(poses[1:, 2]), np.sin(poses[1:, 2])))
    np.cumsum(faster * dt * headings, axis=0, out=ways[1:])
    return ways


def weigh(
    poses: FloatArray, places: FloatArray, shown: BoolArray, dt: float, drives: bool, against: FloatArray
) -> None:
    """Add −ln of the densities of the newest velocities in each world to ``against``; the rest as of `Flow`."""
    newest, unknown, velocities = len(poses) - 1, shown[-1].copy(), [np.zeros((0, 2))]
    spans = [_frames_of(seconds, dt) for seconds in (OVER, 0.5 * OVER)]
    spans = [min(back, newest) for back in spans if newest >= min(back, ENOUGH)]
    if not spans:
        return
    for back in spans:
        here = unknown & shown[newest - back]
        velocities.append((places[newest, here] - places[newest - back, here]) / (back * dt))
        unknown &= ~here
    people = np.concatenate(velocities)
    if len(people) == 0:
        return
    own = (poses[newest, :2] - poses[newest - spans[0], :2]) / (spans[0] * dt)
    ahead = np.array((math.cos(poses[newest, 2]), math.sin(poses[newest, 2])))
    if drives:
        _weigh_vehicle(float(ahead @ own), dt / OWN_ANEW, against)
    else:
        people = np.concatenate((people, own[None]))
    _weigh_people(people, ahead, dt / ANEW, against)


def _frames_of(seconds: float, dt: float) -> int:
    """At least one."""
    return max(1, round(seconds / dt))


def _surer(against: FloatArray) -> float:
    """The most probable world, in m/s; 0 if it is hardly more so than the present one."""
    best = int(np.argmin(against))
    return float(FASTER[best]) if against[HERE] - against[best] >= SURER_BY else 0.0


def _counted_from(faster: float, against: FloatArray) -> FloatArray:
    """The same counted from the world in which all move ``faster``; beyond the last one worlds are alike."""
    return np.interp(FASTER + faster, FASTER, against)


@kernel
def _weigh_people(velocities: FloatArray, ahead: FloatArray, weight: float, against: FloatArray) -> None:
    """Velocities [M, 2]; ``ahead`` [2] is the camera's heading."""
    counts = _counts(velocities)
    for world in range(len(against)):
        x, y = FASTER[world] * ahead[0], FASTER[world] * ahead[1]
        for k in range(len(velocities)):
            against[world] -= weight * counts[k] * np.log(density(velocities[k, 0] + x, velocities[k, 1] + y))


@kernel
def _counts(velocities: FloatArray) -> FloatArray:
    """[M] how much each of the ``velocities`` [M, 2] counts beside those that are like it."""
    counts = np.empty(len(velocities))
    for k in range(len(velocities)):
        alike = 0.0
        for other in range(len(velocities)):
            x, y = velocities[k, 0] - velocities[other, 0], velocities[k, 1] - velocities[other, 1]
            alike += np.exp(-0.5 * (x * x + y * y) / WITHIN**2)
        counts[k] = min(1.0, ALIKE / alike)
    return counts


@kernel
def _weigh_vehicle(speed: float, weight: float, against: FloatArray) -> None:
    """A vehicle's ``speed`` ahead."""
    for world in range(len(against)):
        own = speed + FASTER[world]
        moves = (1.0 - STANDS) * np.exp(-0.5 * (own / OBSERVER_SPEED) ** 2) / OBSERVER_SPEED
        moves *= REVERSES if own < 0.0 else 1.0
        against[world] -= weight * np.log(moves + STANDS * np.exp(-0.5 * (own / STILL) ** 2) / STILL)
