"""Where the camera is by people whose places are given, once all that is believed has drifted away from them.

What arrives is given exactly. A camera that has lost its way sees these people in directions in which nobody is
expected. To the joint problem each of them is one more outlier, and the past, in which nothing else contradicts it,
holds the camera where it is. Several of them who agree with one another find it again, and what is moved is the past.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import (
    BoolArray,
    FloatArray,
    carried_along,
    moved_as_one,
    relative_to_world,
    world_to_relative,
    wrap_angle,
)
from vbbench_baselines.common.bearings import Bearings
from vbbench_baselines.common.ego_motion import Factors, fit_pose
from vbbench_baselines.common.motion import ANCHOR_STD
from vbbench_baselines.common.uncertainty import pose_covariance
from vbbench_baselines.joint_map.real_camera.alone import places_alone, spread_alone
from vbbench_baselines.joint_map.real_camera.joint import Point
from vbbench_baselines.joint_map.real_camera.newest import Start

ASIDE = 0.15
"""In rad: people who are seen so far beside where they are given contradict the pose."""

AGREEING = 0.06
"""In rad: people who are seen no farther beside it agree with a pose that is found."""

UNNOTICED = 15.0
"""−ln of how probable it is that a camera lost its way long ago, beside that it has moved in the newest frames."""

FEWEST = 2
"""People that find a camera."""

LATELY = 8
"""Frames in which a camera may have moved in a way that was not noticed."""

REACHES, TURNS = (0.3, 1.0, 3.0, 10.0), 2.0
"""In m and rad: standard deviations of how far a lost camera is off. A camera is moved no farther than it must: the
directions of two people who are far away tell how it is turned, and little of where it is."""


class Relocation(NamedTuple):
    """Where a camera is that has lost its way.

    Attributes
    ----------
    believed, pose : [3] of the newest frame, as it was believed and as those given have it.
    covariance : [3, 3] of the latter.
    since : the first frame that may be elsewhere; if it is the first of all, nothing holds the past either.
    """

    believed: FloatArray
    pose: FloatArray
    covariance: FloatArray
    since: int

    def starts(self, point: Point, given: FloatArray) -> list[Start]:
        """Two ways to get there from a ``point``: in the newest frames, and long ago; ``given`` [n, K, 2] stay."""
        lately, long_ago = (_carried(point, frames, given) for frames in (self._lately(point), self._long_ago(point)))
        return [Start(lately), Start(long_ago, UNNOTICED)]

    def _lately(self, point: Point) -> FloatArray:
        """The frames [n, 7] of a camera that moved in a way that was not noticed in the newest of them."""
        frames, count = point.frames.copy(), min(LATELY, len(point.frames) - self.since)
        off = self.pose - self.believed
        off[2] = wrap_angle(off[2])
        frames[-count:, :3] += np.linspace(0.0, 1.0, count + 1)[1:, None] * off
        return frames

    def _long_ago(self, point: Point) -> FloatArray:
        """The frames [n, 7] of a camera that lost its way before them: all are moved as one."""
        frames, moving = point.frames.copy(), slice(self.since, None)
        frames[moving, :3] = moved_as_one(frames[moving, :3], self.believed, self.pose)
        frames[:, 2] = np.unwrap(frames[:, 2])
        return frames

    def moved(self, places: FloatArray) -> FloatArray:
        """Places [n, K, 2] as believed, where they are if the camera lost its way long ago."""
        places = places.copy()
        places[self.since :] = carried_along(places[self.since :], self.believed, self.pose)
        return places


def _carried(point: Point, frames: FloatArray, given: FloatArray) -> Point:
    """The ``point`` with other ``frames`` [n, 7], which take along whom they show; ``given`` [n, K, 2] stay."""
    places = carried_along(point.places, point.frames[:, :3], frames[:, :3])
    return point._replace(frames=frames, places=np.where(np.isnan(given), places, point.places))


def relocate(
    frames: FloatArray, given: FloatArray, boxes: Bearings, free: BoolArray, person: FloatArray
) -> Relocation | None:
    """Where the newest frame is by those given, if it is elsewhere than believed.

    Parameters
    ----------
    frames : [n, ≥ 3] as believed.
    given : [n, K, 2] places in m, NaN = not given.
    boxes : rows [n, K].
    free : [n] whose poses are not given.
    person : [2] as of people of whom nothing is known.
    """
    told = ~np.isnan(given[..., 0]) & ~np.isnan(boxes.azimuth)
    if not told[-1].any():
        return None
    wrong = told & (_aside(frames, given, boxes.azimuth) > ASIDE)
    since = _contradicted_since(told, wrong, free)
    if np.count_nonzero(wrong[since:].any(axis=0)) < FEWEST:
        return None
    at, who = np.nonzero(told[since:])
    at += since
    shown = places_alone(boxes.azimuth[at, who], boxes.length[at, who], person)
    shown = world_to_relative(relative_to_world(shown[:, None], frames[at, :3])[:, 0], frames[-1, :3])
    factors = Factors(
        relative=shown,
        covariance=spread_alone(shown) * len(at) / len(np.unique(who)),
        expected=given[at, who],
        std=np.full(len(at), ANCHOR_STD),
        walk=frames[-1, :3].copy(),
        walk_std=REACHES[-1],
    )
    near = [factors._replace(walk_std=far) for far in REACHES]
    found = [fit_pose(fit, TURNS**-2) for fit in near]
    best = int(np.argmin([_unlikely(pose, fit) for pose, fit in zip(found, near, strict=True)]))
    if not _agrees(found[best], factors):
        return None
    covariance = pose_covariance(found[best], near[best], TURNS**-2)
    return Relocation(factors.walk, found[best], covariance, since)


def _unlikely(pose: FloatArray, factors: Factors) -> float:
    """−ln of the density of where the camera is and of what it shows then, up to a constant."""
    rr, rf, ff = factors.covariance.T
    off = factors.relative - world_to_relative(factors.expected, pose)
    squares = (ff * off[:, 0] ** 2 - 2.0 * rf * off[:, 0] * off[:, 1] + rr * off[:, 1] ** 2) / (rr * ff - rf**2)
    moved = np.sum((pose[:2] - factors.walk[:2]) ** 2)
    return float(0.5 * squares.sum() + 0.5 * moved / factors.walk_std**2 + 2.0 * np.log(factors.walk_std))


def _agrees(pose: FloatArray, factors: Factors) -> bool:
    """Whether people are shown where they are expected from a ``pose`` [3]."""
    expected, shown = world_to_relative(factors.expected, pose), factors.relative
    beside = wrap_angle(np.arctan2(expected[:, 0], expected[:, 1]) - np.arctan2(shown[:, 0], shown[:, 1]))
    return bool(np.abs(beside).max() < AGREEING)


def _aside(frames: FloatArray, given: FloatArray, azimuth: FloatArray) -> FloatArray:
    """[n, K] in rad, how far people are seen beside where they are given; NaN where nothing tells."""
    place = world_to_relative(given, frames[:, :3])
    return np.asarray(np.abs(wrap_angle(np.arctan2(place[..., 0], place[..., 1]) - azimuth)))


def _contradicted_since(told: BoolArray, wrong: BoolArray, free: BoolArray) -> int:
    """The first frame after the last whose pose is given, or whose given people are seen where they are."""
    agree = (np.count_nonzero(told, axis=1) > 2 * np.count_nonzero(wrong, axis=1)) | ~free
    return len(agree) - int(np.argmax(agree[::-1])) if agree.any() else 0
