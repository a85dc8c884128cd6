"""Heads in the pictures of a static camera: boxes, centres and sizes."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze
from vbbench.parsing.numbers import Checked, Within

Method = Literal["motion", "prior", "homography"]
"""What closed the focal length, or ``homography``: the user gave all of the camera."""


@dataclass(frozen=True, kw_only=True)
class LiftingSettings(Checked):
    """The table ``[lifting]`` of a recipe.

    Parameters
    ----------
    head_size : size of a head in m: √(width·height) of its box, whose noise is the smallest.
    head_height : height of a head's centre above the ground, in m.
    focal_median, focal_spread : log-normal prior of the focal length in picture widths: median, standard deviation.
    direction_spread : standard deviation of each harmonic of the true dependence of log speed on direction.
    window : seconds over which a walking speed is measured.
    gap : longest gap in s that is interpolated; a track with a longer one becomes two people.
    resamples : how often tracks are resampled for the intervals.
    """

    head_size: Annotated[float, Within(0.01, 10.0, "m")] = 0.24
    head_height: Annotated[float, Within(0.01, 10.0, "m")] = 1.58
    focal_median: Annotated[float, Within(0.01, 100.0)] = 1.0
    focal_spread: Annotated[float, Within(0.001, 10.0)] = 0.4
    direction_spread: Annotated[float, Within(1e-6, 1.0)] = 0.02
    window: Annotated[float, Within(0.01, 3600.0, "s")] = 2.0
    gap: Annotated[float, Within(0.0, 3600.0, "s")] = 4.0
    resamples: Annotated[int, Within(20, 10_000)] = 60


@dataclass(frozen=True, kw_only=True)
class HeadBoxes:
    """Head boxes of one recording, one a row, by track, then by frame; a track has one box a frame at most.

    Parameters
    ----------
    name : name of the recording, such as ``HT21-03``.
    dt : seconds per frame.
    size : width and height of the pictures in px.
    frame : [N] from 0, the recording's first frame.
    track : [N] ids.
    boxes : [N, 4] (left, top, width, height) in px from 0, the corner of the picture.
    visible : [N] visible fraction in (0, 1].
    """

    name: str
    dt: float
    size: tuple[int, int]
    frame: IntArray
    track: IntArray
    boxes: FloatArray
    visible: FloatArray

    def __post_init__(self) -> None:
        count = len(self.frame)
        freeze(self, np.int64, frame=(count,), track=(count,))
        freeze(self, boxes=(count, 4), visible=(count,))
        if np.any((np.diff(self.track) < 0) | ((np.diff(self.track) == 0) & (np.diff(self.frame) <= 0))):
            raise ValueError("head boxes must be ordered by track, then by frame, with one box per frame")

    def __len__(self) -> int:
        return len(self.frame)

    @property
    def centre(self) -> FloatArray:
        """Centre [2] of the picture, in px."""
        return np.array(self.size) / 2.0

    @property
    def whole(self) -> BoolArray:
        """Mask [N] of boxes that the picture's edge does not cut."""
        left, top, width, height = self.boxes.T
        whole: BoolArray = (left > 0.0) & (top > 0.0) & (left + width < self.size[0]) & (top + height < self.size[1])
        return whole

    def heads(self) -> "Heads":
        """The boxes' centres."""
        x, nu = (self.boxes[:, n] + (self.boxes[:, n + 2] - self.size[n]) / 2.0 for n in range(2))
        return Heads(x=x, nu=nu, frame=self.frame, track=self.track, dt=self.dt)


@dataclass(frozen=True, kw_only=True)
class Heads:
    """Head centres in px from the picture's centre, by track, then by frame: [N] each; ``dt`` in s."""

    x: FloatArray
    nu: FloatArray
    frame: IntArray
    track: IntArray
    dt: float

    def take(self, chosen: BoolArray | IntArray) -> "Heads":
        """The heads ``chosen`` by index or mask."""
        x, nu = self.x[chosen], self.nu[chosen]
        return replace(self, x=x, nu=nu, frame=self.frame[chosen], track=self.track[chosen])


def parts_of_tracks(frame: IntArray, track: IntArray, length: int) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Parts of ``length`` frames of each track, counted from its first frame.

    Returns
    -------
    [N] number of each head's track, [N] number of its part in the track, [P] first row of each part, [P] its heads.
    """
    opening = np.r_[True, track[1:] != track[:-1]]
    number = np.cumsum(opening) - 1
    part = (frame - frame[opening][number]) // length
    starts = np.flatnonzero(np.r_[True, (part[1:] != part[:-1]) | opening[1:]])
    return number, part, starts, np.diff(np.r_[starts, len(frame)])


def split_at_gaps(heads: Heads, gap: float) -> Heads:
    """The same heads with tracks split at gaps of more than ``gap`` s.

    The first part keeps its id; the others get ids above the highest. Heads stay ordered by track, then by frame.
    """
    limit = max(1, int(np.floor(gap / heads.dt + 1e-9)))
    opening = np.r_[True, heads.track[1:] != heads.track[:-1]]
    broken = np.r_[False, np.diff(heads.frame) > limit] & ~opening
    if not broken.any():
        return heads
    piece = np.cumsum(broken)
    since = np.maximum.accumulate(np.where(opening | broken, np.arange(len(opening)), 0))
    track = np.where(broken[since], heads.track.max() + piece[since], heads.track)
    return replace(heads, track=track).take(np.argsort(track, kind="stable"))


@dataclass(frozen=True, kw_only=True)
class SizePlane:
    """Sizes of heads in px as a plane ŝ = a + b·ν + c·x over the picture.

    Parameters
    ----------
    a, b, c : size at the picture's centre in px, and its growth in px per px downwards and to the right.
    """

    a: float
    b: float
    c: float

    def at(self, x: FloatArray, nu: FloatArray) -> FloatArray:
        """Sizes [N] in px at ``x``, ``nu`` [N]; not positive on the horizon and above it."""
        return self.a + self.b * nu + self.c * x

    @property
    def slope(self) -> float:
        """Gradient of the size, in px per px, in its steepest direction, towards the camera's foot."""
        return float(np.hypot(self.b, self.c))

    @property
    def roll(self) -> float:
        """Clockwise rotation in rad that levels the picture's horizon."""
        return float(np.arctan2(self.c, self.b))

    @property
    def depth(self) -> float:
        """f·tan θ: distance in px from the picture's centre up to the horizon, once that is level."""
        return self.a / self.slope

    def stretch(self, focal: float) -> float:
        """The stretch of depths, g = f / cos θ in px."""
        return float(np.hypot(focal, self.depth))

    def levelled(self, x: FloatArray, nu: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The points [N] after the rotation that levels the picture."""
        cos, sin = np.cos(self.roll), np.sin(self.roll)
        return x * cos - nu * sin, x * sin + nu * cos


_CUT = 0.5


def box_sizes(boxes: FloatArray) -> FloatArray:
    """The size √(width·height) [N] in px of head ``boxes`` [N, 4]."""
    return np.sqrt(boxes[:, 2] * boxes[:, 3])


def roundness(heads: Heads, boxes: FloatArray, focal: float) -> float:
    """Share of a sphere's perspective elongation that boxes have: 0 for discs, 1 for spheres.

    It is the least-squares coefficient of ln(width/height); a track of n boxes weighs √n, and outliers are removed.

    Parameters
    ----------
    boxes : [N, 4] (left, top, width, height) in px of the ``heads``.
    focal : focal length in px.
    """
    ratio = np.log(boxes[:, 2] / boxes[:, 3])
    ratio = ratio - np.median(ratio)
    fair = np.abs(ratio) < _CUT
    ball = 0.5 * (np.log1p((heads.x / focal) ** 2) - np.log1p((heads.nu / focal) ** 2))
    _, number, count = np.unique(heads.track, return_inverse=True, return_counts=True)
    weight = fair / np.sqrt(count[number])
    centred = ball - np.average(ball, weights=weight)
    spread = float((weight * centred**2).sum())
    return float(np.clip((weight * centred * ratio).sum() / spread, 0.0, 1.0)) if spread > 0.0 else 0.0


def lengthening(heads: Heads, focal: float) -> FloatArray:
    """Factor [N] by which a sphere's size in the picture exceeds f·D/Z (diameter D at the depth Z)."""
    across, down = 0.5 * np.log1p((heads.x / focal) ** 2), 0.5 * np.log1p((heads.nu / focal) ** 2)
    return np.exp((across + down) / 2.0)
