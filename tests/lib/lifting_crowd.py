"""Crowds under a known surveillance camera, for tests of lifting: a small simulator that shares no code with it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from vbbench.geometry import FloatArray
from vbbench_generators.lifting.heads import HeadBoxes

HEAD, HEAD_HEIGHT, SIZE = 0.24, 1.58, (1920, 1080)


@dataclass(frozen=True, kw_only=True)
class Camera:
    focal: float = 1600.0
    tilt: float = np.radians(30.0)
    roll: float = 0.0
    height: float = 12.0

    @property
    def horizon(self) -> float:
        """Row where the horizon crosses the middle column."""
        return SIZE[1] / 2.0 - self.focal * np.tan(self.tilt) / np.cos(self.roll)

    def view(self, ground: FloatArray, head_height: FloatArray | float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """u, v and size in px of heads over ``ground`` [..., 2]; size is negative behind the camera."""
        sin, cos = np.sin(self.tilt), np.cos(self.tilt)
        below = self.height - head_height
        depth = ground[..., 1] * cos + below * sin
        x = self.focal * ground[..., 0] / depth
        nu = self.focal * (below * cos - ground[..., 1] * sin) / depth
        c, s = np.cos(self.roll), np.sin(self.roll)
        return SIZE[0] / 2 + x * c + nu * s, SIZE[1] / 2 - x * s + nu * c, self.focal * HEAD / depth


@dataclass(frozen=True, kw_only=True)
class Crowd:
    """``truth`` [T, K, 2] on the ground, and boxes of those in the picture."""

    camera: Camera
    truth: FloatArray
    boxes: HeadBoxes


def photograph(
    camera: Camera,
    truth: FloatArray,
    dt: float,
    rng: Generator,
    *,
    size_noise: float = 0.0,
    jitter: float = 0.0,
    key: int = 1,
    person: float = 0.0,
    height: float = 0.0,
    balls: bool = False,
) -> HeadBoxes:
    """Head boxes; noise relative to the box, drawn for every ``key``-th frame and interpolated between.

    With ``balls``, the lens draws heads longer off its axis.
    """
    frames, people = truth.shape[:2]
    heads = HEAD_HEIGHT + height * rng.normal(size=people)
    u, v, size = camera.view(truth, heads)
    own = np.exp(person * rng.normal(size=people) - person**2 / 2)
    noise = interpolated(rng.normal(size=(3, frames // key + 2, people)), frames, key)
    box = size * own * (1 + size_noise * noise[0])
    u, v = u + jitter * size * noise[1], v + jitter * size * noise[2]
    inside = (size > 0) & (u > 0) & (u < SIZE[0]) & (v > 0) & (v < SIZE[1]) & (box > 1)
    track, frame = np.nonzero(inside.T)
    u, v, box = (value.T[track, frame] for value in (u, v, box))
    tangent = (np.stack([u, v]) - np.array(SIZE)[:, None] / 2) / camera.focal
    width, height = box * (np.hypot(1.0, tangent) if balls else np.ones_like(tangent))
    boxes = np.stack([u - width / 2, v - height / 2, width, height], axis=1)
    return HeadBoxes(
        name="made", dt=dt, size=SIZE, frame=frame, track=track + 1, boxes=boxes, visible=np.ones(len(frame))
    )


def interpolated(keys: FloatArray, frames: int, key: int) -> FloatArray:
    """Values at key frames joined by straight lines."""
    at = np.arange(frames) / key
    low = at.astype(int)
    part = (at - low)[:, None]
    return keys[:, low] * (1 - part) + keys[:, low + 1] * part


def walk(
    rng: Generator,
    people: int,
    frames: int,
    dt: float,
    directions: FloatArray,
    *,
    area: tuple[float, float, float, float],
    pace: float = 0.2,
    wander: float = 0.15,
    prefer: Callable[[FloatArray], FloatArray] = np.zeros_like,
) -> FloatArray:
    """People [T, K, 2] who cross ``area`` (x0, y0, x1, y1) at lognormal speeds, each roughly in its direction.

    ``prefer`` is how log speed depends on the direction.
    """
    low, high = np.array(area[:2]), np.array(area[2:])
    speed = 1.3 * np.exp(pace * rng.normal(size=people))
    turn = np.cumsum(rng.normal(size=(frames, people)) * wander * np.sqrt(dt), axis=0)
    turn -= turn[frames // 2]
    moment = 1 + 0.05 * interpolated(rng.normal(size=(1, frames // 25 + 2, people)), frames, 25)[0]
    angle = directions + turn
    moment *= np.exp(prefer(angle.ravel())).reshape(angle.shape)
    steps = dt * (speed * moment)[..., None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    path = np.cumsum(steps, axis=0)
    middle = rng.integers(0, frames, people)
    path -= path[middle, np.arange(people)]
    return path + rng.uniform(low, high, size=(people, 2))


def ground_matrix(camera: Camera) -> FloatArray:
    """[3, 3] from ground metres to px."""
    sin, cos, c, s = np.sin(camera.tilt), np.cos(camera.tilt), np.cos(camera.roll), np.sin(camera.roll)
    view = np.array([[1.0, 0.0, 0.0], [0.0, -sin, camera.height * cos], [0.0, cos, camera.height * sin]])
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.array([[camera.focal, 0, SIZE[0] / 2], [0, camera.focal, SIZE[1] / 2], [0, 0, 1]]) @ turn @ view
