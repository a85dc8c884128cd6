"""A scene: one recording or simulation of people walking on the ground plane."""

from dataclasses import dataclass, replace
from math import cos, sin

import numpy as np
from numpy.typing import ArrayLike

from vbbench.errors import VbbenchError
from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze, wrap_angle


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Ground-plane trajectories of all people, one row per frame.

    Parameters
    ----------
    name : the scene's name in messages and files.
    dt : seconds per frame.
    people : [K] integer ids, ascending, stable within the scene.
    positions : [T, K, 2] in m, NaN where a person is absent.
    heights : [K] in m, NaN where unknown.
    """

    name: str
    dt: float
    people: IntArray
    positions: FloatArray
    heights: FloatArray

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(self.people))
        freeze(self, np.int64, people=(count,))
        freeze(self, positions=(None, count, 2), heights=(count,))
        if not (np.isfinite(self.dt) and self.dt > 0):
            raise ValueError(f"dt must be a positive number of seconds, not {self.dt}")
        if np.any(np.diff(self.people) <= 0):
            raise ValueError("people must be unique ids in ascending order")

    @property
    def frames(self) -> int:
        """Number of frames T."""
        return len(self.positions)

    @property
    def present(self) -> BoolArray:
        """[T, K] whether a person is present."""
        return ~np.isnan(self.positions[..., 0])

    def column_of(self, person: int) -> int:
        """Column of a person among the people [K]; raises VbbenchError if the scene has no such person."""
        column = int(np.searchsorted(self.people, person))
        if column == len(self.people) or self.people[column] != person:
            few = len(self.people) <= 8
            ids = ", ".join(map(str, self.people)) if few else f"{self.people[0]} … {self.people[-1]}"
            raise VbbenchError(f"scene '{self.name}' has no person {person}; its people are {ids or 'none'}")
        return column

    def with_heights(self, heights: ArrayLike) -> "Scene":
        """The same scene with heights [K] in m."""
        return replace(self, heights=np.asarray(heights, dtype=np.float64))


@dataclass(frozen=True, kw_only=True)
class World:
    """A point p of the scene is R(yaw)·p + (x, y) in the world of the sequence.

    Parameters
    ----------
    x, y, yaw : in m and rad, counter-clockwise; all 0: the sequence's world is its scene's.
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def positions(self, of_scene: FloatArray) -> FloatArray:
        """Positions [..., 2] of the scene in the sequence's world, in m."""
        x, y = of_scene[..., 0], of_scene[..., 1]
        across, along = cos(self.yaw), sin(self.yaw)
        return np.stack([across * x - along * y + self.x, along * x + across * y + self.y], axis=-1)

    def poses(self, of_scene: FloatArray) -> FloatArray:
        """Poses [..., 3] (x, y, yaw) of the scene in the sequence's world, in m and rad."""
        yaw = wrap_angle(of_scene[..., 2] + self.yaw)
        return np.concatenate([self.positions(of_scene[..., :2]), yaw[..., None]], axis=-1)

    def poses_in_scene(self, poses: FloatArray) -> FloatArray:
        """The inverse of `poses`."""
        x, y = poses[..., 0] - self.x, poses[..., 1] - self.y
        across, along = cos(self.yaw), sin(self.yaw)
        return np.stack([across * x + along * y, across * y - along * x, wrap_angle(poses[..., 2] - self.yaw)], axis=-1)
