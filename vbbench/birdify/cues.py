"""Two measures of distance in every box, held against each other: how high it is, and how low it ends.

A person of height h at distance d is l = h/d high, and the feet are seen s = c/d below the horizon, per metre of
distance, from a camera at height c. With the mean of h for h, s = (c/h) l + p gives how high the camera really is, and
by which angle p it looks higher than its file says. What an angle does depends on the azimuth φ: a pitch adds p cos φ,
a roll −q sin φ, and in a picture of 360° the row of the horizon adds the same all around.

Both are measured, and l has besides the spread of heights for an error: a line through them by least squares is too
flat, so that the camera comes out too low and to look up. So the line is the one whose errors have nothing to do with
another measure of how near the person is, which knows nothing of these errors: the feet of the same person a while
later (an instrumental variable; Wald's and Reiersøl's of the 1940s).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from vbbench.camera import Camera, CentralCamera
from vbbench.geometry import FloatArray, IntArray

BORDER = 5.0
"""Boxes that end nearer than this, in px, to the picture's upper or lower border may be cut by it."""
FARTHEST, HIGHEST = 60.0, 100.0
"""Boxes of people farther away, in m, or seen from higher up, have no information."""
FEWEST_BOXES, FEWEST_TRACKS = 50, 3
ROUNDS, TUNING = 15, 1.345
"""Of reweighting, with Huber's constant."""
LOOKS, SAME_TILT, STEEPEST = 15, 1e-4, 0.8
"""Most fits, and, in rad, the tilt that is as good as none, and more than a camera of people has."""
STEEPEST_PITCH = 1.5
"""In rad: a camera that looks straight up or down sees nobody walk."""
STARTS, LOWEST = (0.0, -0.3, 0.3), 0.05
"""Tilts in rad to begin with, one after the other, until the camera is higher than so many m."""
LATER = (1.0, 1.15, 1.3, 1.45, 1.6, 1.75)
"""In s: a box's error is no more that of a box of the same person before so long. A camera that bobs up and down with
its bearer's steps, 1.5 to 2 times a second, is, averaged over these, where it would be without bobbing."""
DRAWS, MIDDLE = 200, (15.87, 84.13)
"""Draws of tracks, with replacement, for how certain the figures are; the percentiles one σ to either side."""
CERTAIN, SIDES = 3.0, 0.02
"""What differs from side to side counts from so many σ and rad on; else all of it is noise, and removed."""
RIDGE = 1e-9


@dataclass(frozen=True, kw_only=True)
class Cues:
    """What feet and heights of boxes say together.

    Parameters
    ----------
    boxes, tracks : how many were used.
    mount_height, mount_height_std : of the camera in m if people are of mean height.
    tilt, tilt_std : by how much it looks higher than its file says, in rad; all around 0 unless it is certain.
    roll, roll_std : by how much its right side hangs lower than its file says, in rad; 0 unless it is certain.
    horizon, horizon_std : by how much the horizon is lower than its file says, in rad; 0 but all around.
    """

    boxes: int
    tracks: int
    mount_height: float
    mount_height_std: float
    tilt: float
    tilt_std: float
    roll: float = 0.0
    roll_std: float = 0.0
    horizon: float = 0.0
    horizon_std: float = 0.0


class HeightPrior(NamedTuple):
    """Of people, in m."""

    mean: float
    std: float


def compare_cues(boxes: FloatArray, camera: Camera, people: HeightPrior, dt: float) -> Cues | None:
    """Hold the feet of boxes [T, K, 3], ``dt`` s apart, against their heights.

    Boxes weigh by the spread of heights, which is the same share of every distance; Huber's weights keep those out
    whose feet are hidden. A tilt is found again from the camera tilted by it, until it is: feet hold a straight line
    for a small one only.

    Returns
    -------
    cues : ``None`` if there are too few boxes, or they fit no tilt.
    """
    looks: Iterable[Cues | None]
    later = sorted({max(1, round(seconds / dt)) for seconds in LATER})
    if _can_tilt(camera):
        starts = (*STARTS, -camera.pitch) if isinstance(camera, CentralCamera) else STARTS
        looks = (_solution(boxes, camera, people, later, tilt=start) for start in starts)
    else:
        looks = [_compare(boxes, camera, people, later)]
    possible = (cues for cues in looks if cues is not None and cues.mount_height > LOWEST)
    return next((cues for cues in possible if abs(cues.tilt) <= STEEPEST_PITCH), None)


def _solution(boxes: FloatArray, camera: Any, people: HeightPrior, later: Sequence[int], *, tilt: float) -> Cues | None:
    """The cues of a camera that can tilt, once a ``tilt`` in rad to begin with is the one that is found again."""
    for _ in range(LOOKS):
        if abs(camera.pitch + tilt) > STEEPEST_PITCH:
            return None
        found = _compare(boxes, replace(camera, pitch=camera.pitch + tilt), people, later)
        if found is None or min(abs(tilt + found.tilt), abs(camera.pitch + tilt + found.tilt)) > STEEPEST:
            return None
        tilt += found.tilt
        if abs(found.tilt) < SAME_TILT:
            return replace(found, tilt=tilt)
    return None


def _can_tilt(camera: Camera) -> bool:
    """Whether all that the camera sees goes up and down with its pitch: not so all around."""
    return isinstance(camera, CentralCamera) and "pitch" in vars(camera) and camera.period is None


def _compare(boxes: FloatArray, camera: Camera, people: HeightPrior, later: Sequence[int]) -> Cues | None:
    frame, track = np.nonzero(np.isfinite(boxes[..., 2]) & _uncut(boxes, camera))
    used = boxes[frame, track]
    with np.errstate(divide="ignore", invalid="ignore"):
        _, heights = camera.statures(used)
        ahead = camera.unproject(used, np.full(len(used), people.mean))
        near = 1.0 / np.hypot(ahead[:, 0], ahead[:, 1])
        feet = near * camera.mount_height * people.mean / heights
        good = np.isfinite(feet) & (near > 1.0 / FARTHEST) & (np.abs(feet) < HIGHEST * near)
    near, feet, track, frame, ahead = near[good], feet[good], track[good], frame[good], ahead[good]
    _, track = np.unique(track, return_inverse=True)
    count = int(track.max(initial=-1)) + 1
    if len(track) < FEWEST_BOXES or count < FEWEST_TRACKS:
        return None
    elsewhen = np.mean([feet[_seen_later(frame, track, frames)] for frames in later], axis=0)
    right, forward = near * ahead.T
    level = np.ones_like(near)
    angles = [forward, -right] if camera.period is None else [level, forward, -right]
    fits = [_fit(near, feet, elsewhen, track, angles[:some], people) for some in (1, len(angles))]
    (found, std), (all_found, all_std) = fits
    sides = slice(2, None)
    if (np.abs(all_found[sides]) > np.maximum(CERTAIN * all_std[sides], SIDES)).any():
        found, std = all_found, all_std
    found, std = (np.pad(values, (0, len(angles) + 1 - len(values))) for values in (found, std))
    names = ["mount_height", *(("tilt", "roll") if camera.period is None else ("horizon", "tilt", "roll"))]
    measured = {"tilt": 0.0, "tilt_std": 0.0}
    for name, value, spread in zip(names, found.tolist(), std.tolist(), strict=True):
        measured |= {name: value, f"{name}_std": spread}
    return Cues(boxes=len(track), tracks=count, **measured)


def _fit(
    near: FloatArray,
    feet: FloatArray,
    elsewhen: FloatArray,
    track: IntArray,
    angles: Sequence[FloatArray],
    people: HeightPrior,
) -> tuple[FloatArray, FloatArray]:
    """Mount height and angles [1 + A] by boxes [N], and their standard deviations.

    These are the larger of two: over draws of tracks, and by the spread of heights, which few tracks do not show.
    """
    moments = _moments(near, feet, elsewhen, angles)
    of_track = np.zeros((int(track.max()) + 1, *moments.shape[1:]))
    np.add.at(of_track, track, moments)
    whole = of_track.sum(axis=0)
    found = _line(whole)
    draws = of_track[np.random.default_rng(0).integers(0, len(of_track), (DRAWS, len(of_track)))].sum(axis=1)
    drawn = 0.5 * np.diff(np.percentile(_line(draws), MIDDLE, axis=0), axis=0)[0]
    taller = np.linalg.solve(whole[:, :-1] + RIDGE * np.eye(len(whole)), found[0] * of_track[:, :, 0].T)
    by_heights = people.std / people.mean * np.linalg.norm(taller, axis=1)
    return found, np.maximum(drawn, by_heights)


def _moments(near: FloatArray, feet: FloatArray, elsewhen: FloatArray, angles: Sequence[FloatArray]) -> FloatArray:
    """[N, 1 + A, 2 + A] what each box adds to the equations of the line: its coefficients, and ``feet``."""
    share = 1.0 / np.maximum(elsewhen, 1.0 / FARTHEST)  # all errors are shares of how near a person is
    known, both = np.stack([elsewhen, *angles], axis=-1), np.stack([near, *angles, feet], axis=-1)
    moments = (share**2)[:, None, None] * known[:, :, None] * both[:, None, :]
    weights = np.ones_like(near)
    for _ in range(ROUNDS):
        line = _line((weights[:, None, None] * moments).sum(axis=0))
        off = np.abs(feet - both[:, :-1] @ line) * share
        weights = np.minimum(1.0, TUNING * 1.4826 * np.median(off) / np.maximum(off, 1e-9))
    return weights[:, None, None] * moments


def _line(moments: FloatArray) -> FloatArray:
    """[..., n] mount height and angles by ``moments`` [..., n, n + 1], of which some may hold no information."""
    ridge = RIDGE * np.eye(moments.shape[-2])
    return np.asarray(np.linalg.solve(moments[..., :-1] + ridge, moments[..., -1:])[..., 0])


def _seen_later(frame: IntArray, track: IntArray, later: int) -> IntArray:
    """For each of N boxes, in order of frames, one of its track ``later`` frames on, as long before, or farthest."""
    order = np.argsort(track, kind="stable")
    frame, track = frame[order], track[order]
    span = int(frame.max()) + later + 1
    key, rows = track * span + frame, np.arange(len(frame))
    first, last = np.searchsorted(track, track), np.searchsorted(track, track, side="right") - 1
    after, before = np.searchsorted(key, key + later), np.searchsorted(key, key - later, side="right") - 1
    farthest = np.where(2 * frame > frame[first] + frame[last], first, last)
    chosen = np.where(after <= last, after, np.where(before >= first, before, farthest))
    found = np.empty_like(rows)
    found[order] = order[chosen]
    return found


def _uncut(boxes: FloatArray, camera: Camera) -> FloatArray:
    """Which boxes [T, K, 3] end inside the picture; a panorama is as high as its boxes need."""
    if camera.period is not None:
        return np.isfinite(boxes[..., 2])
    _, v, length = np.moveaxis(boxes, -1, 0)
    with np.errstate(invalid="ignore"):
        inside = (v + 0.5 * length < camera.picture_size[1] - BORDER) & (v - 0.5 * length > BORDER)
    return np.asarray(inside)
