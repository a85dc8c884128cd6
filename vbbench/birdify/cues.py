"""Consistency of the height cue and the foot cue of boxes: a check of mount height, tilt and roll.

A person of height h at distance d has the angular height l = h/d, and the feet are s = c/d below the horizon (both
tangents), for a camera at height c. With the mean of h for h, the regression s = (c/h) l + p yields the true mount
height c and the error p of the pitch. The effect of an angle depends on the azimuth φ: a pitch adds p cos φ, a roll
−q sin φ, and in a panorama an error of the horizon's row adds a constant.

Both cues have errors, and l also the deviation of heights: least squares would underestimate the coefficient c/h
(attenuation). The regression therefore uses an instrumental variable, which is independent of these errors: the foot
cue of the same person some time later (Wald, Reiersøl, 1940s).
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
    """The calibration by height and foot cues of boxes, with standard deviations.

    Parameters
    ----------
    boxes, tracks : numbers of boxes and tracks that were used.
    mount_height, mount_height_std : of the camera in m, if people have the mean height.
    tilt, tilt_std : error of the file's pitch in rad, positive if the camera looks higher; in a panorama 0 unless sure.
    roll, roll_std : error of the file's roll in rad, positive if the right side is lower; 0 unless certain.
    horizon, horizon_std : error of a panorama's horizon in rad, positive if it is lower; 0 for other cameras.
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
    """Mean and standard deviation of people's heights in m."""

    mean: float
    std: float


def compare_cues(boxes: FloatArray, camera: Camera, people: HeightPrior, dt: float) -> Cues | None:
    """Compare foot cues and height cues of boxes [T, K, 3] in px, ``dt`` s apart.

    Weights account for the deviation of heights, which is proportional to the distance; Huber's weights suppress boxes
    with hidden feet. The fit is repeated with the corrected tilt until it converges: the model is linear for small
    tilts only.

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
    """The cues of a camera that can tilt, by fixed-point iteration from an initial ``tilt`` in rad."""
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
    """Whether a pitch shifts the whole picture in one direction, which is not so for a panorama."""
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
    """Mount height in m and angles in rad [1 + A] from boxes [N], and their standard deviations.

    A standard deviation is the larger of two: by resampling tracks, and by the deviation of heights.
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
    """[N, 1 + A, 2 + A] contribution of each box to the normal equations: coefficients, then the right-hand side."""
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
    """[..., n] solution (mount height and angles) of the equations ``moments`` [..., n, n + 1], perhaps singular."""
    ridge = RIDGE * np.eye(moments.shape[-2])
    return np.asarray(np.linalg.solve(moments[..., :-1] + ridge, moments[..., -1:])[..., 0])


def _seen_later(frame: IntArray, track: IntArray, later: int) -> IntArray:
    """For each of N boxes the index of one of its track ``later`` frames later, or as much earlier, or the farthest."""
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
    """Mask of boxes [T, K, 3] that end inside the picture; a panorama has no upper or lower border."""
    if camera.period is not None:
        return np.isfinite(boxes[..., 2])
    _, v, length = np.moveaxis(boxes, -1, 0)
    with np.errstate(invalid="ignore"):
        inside = (v + 0.5 * length < camera.picture_size[1] - BORDER) & (v - 0.5 * length > BORDER)
    return np.asarray(inside)
