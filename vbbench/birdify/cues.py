"""Two measures of distance in every box, held against each other: how high it is, and how low it ends.

A person of height h at distance d is l ∝ h/d high, and the feet are seen s = c/d below the horizon, per metre of
distance, from a camera at height c. By heights, d is known up to the spread of people's heights; so s d = c + p d tells
how high the camera really is, and by which angle p it looks higher than its file says.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vbbench.camera import Camera, CentralCamera
from vbbench.geometry import FloatArray

BORDER = 5.0
"""Boxes that end nearer than this, in px, to the picture's upper or lower border may be cut by it."""
FARTHEST = 60.0
"""Boxes of people farther away, in m, tell nothing."""
FEWEST_BOXES, FEWEST_TRACKS = 50, 3
ROUNDS, TUNING = 15, 1.345
"""Of reweighting, with Huber's constant."""
LOOKS, SAME_TILT, STEEPEST = 15, 1e-4, 0.8
"""Most fits, and, in rad, the tilt that is as good as none, and more than a camera of people has."""
STEEPEST_PITCH = 1.5
"""In rad: a camera that looks straight up or down sees nobody walk."""
STARTS, LOWEST = (0.0, -0.3, 0.3), 0.05
"""Tilts in rad to begin with, one after the other, until the camera is higher than so many m."""
DRAWS = 200
"""Of tracks, with replacement, to tell how certain the figures are."""


@dataclass(frozen=True, kw_only=True)
class Cues:
    """What feet and heights of boxes say together.

    Parameters
    ----------
    boxes, tracks : how many were used.
    mount_height, mount_height_std : of the camera in m if people are of mean height.
    tilt, tilt_std : by how much it looks higher than its file says, in rad.
    """

    boxes: int
    tracks: int
    mount_height: float
    mount_height_std: float
    tilt: float
    tilt_std: float


def compare_cues(boxes: FloatArray, camera: Camera, height_mean: float, height_std: float) -> Cues | None:
    """Hold the feet of boxes [T, K, 3] against their heights; ``None`` if there are too few, or they fit no tilt.

    Boxes weigh by the spread of heights, which is the same share of every distance; Huber's weights keep those out
    whose feet are hidden. The standard deviations are over draws of tracks, and hold the spread of heights. A tilt is
    found again from the camera tilted by it, until it is: s d is a straight line for a small one only.
    """
    looks: Iterable[Cues | None]
    if _can_tilt(camera):
        looks = (_settled(boxes, camera, height_mean, height_std, tilt=start) for start in STARTS)
    else:
        looks = [_compare(boxes, camera, height_mean, height_std)]
    return next((cues for cues in looks if cues is not None and _is_possible(cues)), None)


def _settled(boxes: FloatArray, camera: Any, height_mean: float, height_std: float, *, tilt: float) -> Cues | None:
    """The cues of a camera that can tilt, once a ``tilt`` in rad to begin with is the one that is found again."""
    for _ in range(LOOKS):
        if abs(camera.pitch + tilt) > STEEPEST_PITCH:
            return None
        found = _compare(boxes, replace(camera, pitch=camera.pitch + tilt), height_mean, height_std)
        if found is None or abs(tilt + found.tilt) > STEEPEST:
            return None
        tilt += found.tilt
        if abs(found.tilt) < SAME_TILT:
            return replace(found, tilt=tilt)
    return None


def _can_tilt(camera: Camera) -> bool:
    """Whether all that the camera sees goes up and down with its pitch: not so all around."""
    return isinstance(camera, CentralCamera) and "pitch" in vars(camera) and camera.period is None


def _is_possible(cues: Cues) -> bool:
    """Whether a camera of people may be so high and so tilted."""
    return cues.mount_height > LOWEST and abs(cues.tilt) <= STEEPEST


def _compare(boxes: FloatArray, camera: Camera, height_mean: float, height_std: float) -> Cues | None:
    seen = np.isfinite(boxes[..., 2]) & _uncut(boxes, camera)
    frame, track = np.nonzero(seen)
    used = boxes[frame, track]
    with np.errstate(divide="ignore", invalid="ignore"):
        below, _ = camera.statures(used)
        ahead = camera.unproject(used, np.full(len(used), height_mean))
        distance = np.hypot(ahead[:, 0], ahead[:, 1])
        height = below * height_mean / used[:, 2]  # s d
    good = np.isfinite(height) & np.isfinite(distance) & (distance < FARTHEST) & (np.abs(height) < 100.0)
    distance, height, track = distance[good], height[good], track[good]
    _, track = np.unique(track, return_inverse=True)
    count = int(track.max(initial=-1)) + 1
    if len(track) < FEWEST_BOXES or count < FEWEST_TRACKS:
        return None
    columns = np.stack([np.ones_like(distance), distance], axis=-1)
    weights = np.ones_like(distance)
    for _ in range(ROUNDS):
        fit, *_ = np.linalg.lstsq(columns * np.sqrt(weights)[:, None], height * np.sqrt(weights), rcond=None)
        off = np.abs(height - columns @ fit)
        weights = np.minimum(1.0, TUNING * 1.4826 * np.median(off) / np.maximum(off, 1e-9))
    normal = np.zeros((count, 2, 3))
    both = np.concatenate([columns, height[:, None]], axis=1)
    np.add.at(normal, track, weights[:, None, None] * columns[:, :, None] * both[:, None, :])
    draws = normal[np.random.default_rng(0).integers(0, count, (DRAWS, count))].sum(axis=1)
    draws[:, [0, 1], [0, 1]] += 1e-9
    spread = np.linalg.solve(draws[:, :, :2], draws[:, :, 2:])[..., 0].std(axis=0)
    prior = height_std / height_mean / np.sqrt(count)
    return Cues(
        boxes=len(track),
        tracks=count,
        mount_height=float(fit[0]),
        mount_height_std=float(np.hypot(spread[0], prior * abs(fit[0]))),
        tilt=float(fit[1]),
        tilt_std=float(spread[1]),
    )


def _uncut(boxes: FloatArray, camera: Camera) -> FloatArray:
    """Which boxes [T, K, 3] end inside the picture; a panorama is as high as its boxes need."""
    if camera.period is not None:
        return np.isfinite(boxes[..., 2])
    _, v, length = np.moveaxis(boxes, -1, 0)
    with np.errstate(invalid="ignore"):
        inside = (v + 0.5 * length < camera.picture_size[1] - BORDER) & (v - 0.5 * length > BORDER)
    return np.asarray(inside)
