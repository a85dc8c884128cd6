"""Cameras whose rays meet in one point, tilted or level: all that is asked of them, from two functions of a model."""

from functools import cached_property
from typing import Annotated, ClassVar, cast

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, shorter_way
from vbbench.parsing.numbers import Within, check_ranges

NEAREST = 0.01
"""People nearer than this (m) are not observed: their box would be larger than any picture."""

NEWTON_STEPS, EXACT, DIFFERENCE, RIDGE = 30, 1e-9, 1e-6, 1e-9
"""Most steps to find a vertical that is curved in the picture; px that need none; rad of differences; px
per rad that keep them invertible where a box says nothing."""

Size = Annotated[int, Within(1, 1e6, "px")]
Focal = Annotated[float, Within(0.01, 1e7, "px")]
PrincipalPoint = Annotated[float, Within(-1e7, 1e7, "px")]
MountHeight = Annotated[float, Within(0.01, 1e3, "m")]
Tilt = Annotated[float, Within(-1.5, 1.5, "rad")]


class CentralCamera:
    """A camera whose rays meet in one point: all of `Camera` follows from ``pixels`` and ``directions``.

    Subclasses are frozen dataclasses with a class attribute ``kind`` and at least ``focal``, ``mount_height`` and
    ``picture_size``; ``pitch`` and ``roll`` if they can be tilted.
    """

    kind: ClassVar[str]
    focal: float
    mount_height: float
    pitch: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def picture_size(self) -> tuple[int, int]:
        """See `Camera.picture_size`."""
        raise NotImplementedError

    @property
    def period(self) -> float | None:
        """See `Camera.period`; borders unless a model says otherwise."""
        return None

    @property
    def view(self) -> tuple[float, float] | None:
        """See `Camera.view`; borders are taken where the horizon meets them."""
        if self.period is not None:
            return None
        columns = np.array([0.0, self.picture_size[0]])
        left, right = self.to_level(self.directions(np.stack([columns, self.horizon(columns)], axis=-1)))
        return float(np.arctan2(left[0], left[2])), float(np.arctan2(right[0], right[2]))

    @property
    def intrinsics(self) -> FloatArray | None:
        """See `Camera.intrinsics`; none unless a model says otherwise."""
        return None

    @property
    def cylinder(self) -> FloatArray | None:
        """See `Camera.cylinder`; none unless a model says otherwise."""
        return None

    @property
    def level(self) -> bool:
        """Whether the camera has neither pitch nor roll."""
        return self.pitch == 0.0 and self.roll == 0.0

    def pixels(self, directions: FloatArray) -> FloatArray:
        """See `Camera.pixels`."""
        raise NotImplementedError

    def directions(self, pixels: FloatArray) -> FloatArray:
        """See `Camera.directions`."""
        raise NotImplementedError

    def project(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.project`."""
        boxes = self.project_unbounded(relative, heights)
        if self.period is None:
            shown = self._in_picture(boxes)
            if self.intrinsics is None:  # a box may be about a bend that leads around the picture
                shown &= self._in_picture(self._pixels_of(relative, self.mount_height - 0.5 * heights))
            boxes[~shown] = np.nan
        return boxes

    def project_unbounded(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.project_unbounded`: from the pixels of feet and top of the head."""
        below = np.where(np.isnan(self.depth(relative)), np.nan, self.mount_height)
        return self._box(*(self._pixels_of(relative, down) for down in (below, below - heights)))

    def unproject(self, observations: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.unproject`: the distance at which feet and head are as far apart as the box says.

        Exact for a pinhole, tilted or not, and to rounding where pictures of verticals bend.
        """
        ahead, foot, head = self._sightlines(observations)
        return ahead * (heights / (foot - head))[..., None]

    def to_horizon(self, observations: FloatArray) -> FloatArray:
        """See `Camera.to_horizon`."""
        if self._plumb:
            boxes, horizon = np.array(observations), self.horizon(observations[..., 0])
            boxes[..., 2] = boxes[..., 1] + 0.5 * boxes[..., 2] - horizon
            boxes[..., 1] = horizon + 0.5 * boxes[..., 2]
            return boxes
        ahead, foot, _ = self._sightlines(observations)
        return self._as_tall_as_mount(ahead, foot)

    def statures(self, observations: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See `Camera.statures`."""
        with np.errstate(divide="ignore", invalid="ignore"):  # of boxes that end on the horizon
            if self._plumb:
                feet = observations[..., 1] + 0.5 * observations[..., 2] - self.horizon(observations[..., 0])
                return feet, self.mount_height * observations[..., 2] / feet
            ahead, foot, head = self._sightlines(observations)
            return self._as_tall_as_mount(ahead, foot)[..., 2], self.mount_height * (foot - head) / foot

    def depth(self, relative: FloatArray) -> FloatArray:
        """Horizontal range, NaN on top of the camera."""
        reach = np.sqrt(relative[..., 0] ** 2 + relative[..., 1] ** 2)
        return np.where(reach > NEAREST, reach, np.nan)

    def wrap_column(self, u: FloatArray) -> FloatArray:
        """See `Camera.wrap_column`."""
        if self.period is None:
            return u
        wrapped = np.mod(u, self.period)
        return cast(FloatArray, np.where(wrapped >= self.period, 0.0, wrapped))

    def horizon(self, u: FloatArray) -> FloatArray:
        """See `Camera.horizon`; interpolated between directions a tenth of a degree apart.

        Where a picture with borders shows the horizon twice in a column, the part around straight ahead counts.
        """
        azimuth = np.linspace(-np.pi, np.pi, 3601)
        level = np.stack([np.sin(azimuth), np.zeros_like(azimuth), np.cos(azimuth)], axis=-1)
        shown = self.pixels(self.to_camera(level))
        if self.period is None:
            turns = np.flatnonzero(~(np.diff(shown[:, 0]) > 0.0))  # where columns no longer rise, or are NaN
            ahead = len(azimuth) // 2
            shown = shown[turns[turns < ahead].max(initial=-1) + 1 : turns[turns >= ahead].min(initial=3600) + 1]
        column, row = shown.T
        order = np.argsort(column)
        rows: FloatArray = np.interp(self.wrap_column(np.asarray(u)), column[order], row[order])
        return rows

    def to_camera(self, directions: FloatArray) -> FloatArray:
        """See `Camera.to_camera`."""
        return directions if self.level else directions @ self._tilt.T

    def to_level(self, directions: FloatArray) -> FloatArray:
        """See `Camera.to_level`."""
        return directions if self.level else directions @ self._tilt

    @cached_property
    def _tilt(self) -> FloatArray:
        """[3, 3] the camera's right, down and forward as rows, in the frame of a level camera."""
        (s, c), (sr, cr) = ((np.sin(angle), np.cos(angle)) for angle in (self.pitch, self.roll))
        right, down = np.array([1.0, 0.0, 0.0]), np.array([0.0, c, s])
        return np.stack([cr * right + sr * down, cr * down - sr * right, np.array([0.0, -s, c])])

    def _in_picture(self, pixels: FloatArray) -> BoolArray:
        """Whether (u, v), the first two of ``pixels`` [..., ≥ 2], are within the borders."""
        (u, v), (width, height) = np.moveaxis(pixels[..., :2], -1, 0), self.picture_size
        inside: BoolArray = (u >= 0) & (u < width) & (v >= 0) & (v < height)
        return inside

    def _pixels_of(self, relative: FloatArray, down: FloatArray) -> FloatArray:
        """Pixels [..., 2] of points ``down`` m [...] below the camera at ``relative`` [..., 2]."""
        points = np.stack(np.broadcast_arrays(relative[..., 0], down, relative[..., 1]), axis=-1)
        return self.pixels(self.to_camera(points))

    def _as_tall_as_mount(self, ahead: FloatArray, foot: FloatArray) -> FloatArray:
        """Boxes [..., 3] of people as tall as the mount, ``foot`` [...] m down per metre ``ahead`` [..., 2]."""
        reach = self.mount_height / np.maximum(foot, 1.0 / self.focal)
        return self.project_unbounded(ahead * reach[..., None], np.full(reach.shape, self.mount_height))

    @cached_property
    def _plumb(self) -> bool:
        """Whether whatever is upright stands in one column, in which rows count metres down per metre of depth."""
        return self.cylinder is not None or (self.level and self.intrinsics is not None)

    def _sightlines(self, observations: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Way along the ground [..., 2], a unit vector, to people, and the tangents [...] down to their feet and heads.

        The vertical through the box's centre is taken to be straight in the picture, as a pinhole's is; where verticals
        bend, Newton's method goes on from there.
        """
        centre, half = observations[..., :2], 0.5 * observations[..., 2:]
        middle = self.to_level(self.directions(centre))
        middle = middle / np.hypot(middle[..., 0], middle[..., 2])[..., None]
        step = np.array([0.0, 1e-4, 0.0])
        lower, upper = (self.pixels(self.to_camera(middle + sign * step)) for sign in (1, -1))
        lean = self._apart(lower[..., 0], upper[..., 0]) / (lower[..., 1] - upper[..., 1])
        along = np.concatenate([lean[..., None] * half, half], axis=-1)
        foot, head = (self._slope(self.directions(centre + sign * along)) for sign in (1, -1))
        if self.intrinsics is not None:
            return middle[..., ::2], foot, head
        vertical = np.stack([np.arctan2(middle[..., 0], middle[..., 2]), foot, head], axis=-1)
        off, share = self._off(observations, vertical), np.ones((*observations.shape[:-1], 1))
        for _ in range(NEWTON_STEPS):
            far = np.abs(off).max(axis=-1, keepdims=True) > EXACT
            if not far.any():
                break
            columns = [(off - self._off(observations, vertical + DIFFERENCE * axis)) / DIFFERENCE for axis in np.eye(3)]
            jacobian: FloatArray = np.where(far[..., None], np.stack(columns, axis=-1), 0.0) + RIDGE * np.eye(3)
            moved = vertical + share * np.linalg.solve(jacobian, np.where(far, off, 0.0)[..., None])[..., 0]
            left = self._off(observations, moved)
            better = np.linalg.norm(left, axis=-1, keepdims=True) < np.linalg.norm(off, axis=-1, keepdims=True)
            vertical, off = np.where(better, moved, vertical), np.where(better, left, off)
            share = np.where(better, 1.0, 0.5 * share)
        azimuth, foot, head = np.moveaxis(vertical, -1, 0)
        return np.stack([np.sin(azimuth), np.cos(azimuth)], axis=-1), foot, head

    def _off(self, boxes: FloatArray, verticals: FloatArray) -> FloatArray:
        """How far boxes [..., 3] are from those of verticals [..., 3] (azimuth, tangents to feet and head), in px."""
        way = np.stack([np.sin(verticals[..., 0]), np.cos(verticals[..., 0])], axis=-1)
        seen = self._box(*(self._pixels_of(way, verticals[..., end]) for end in (1, 2)))
        off = boxes - seen
        off[..., 0] = self._apart(boxes[..., 0], seen[..., 0])
        return off

    def _box(self, foot: FloatArray, head: FloatArray) -> FloatArray:
        """Boxes [..., 3] from the pixels of feet and head."""
        u = foot[..., 0] + 0.5 * self._apart(head[..., 0], foot[..., 0])
        length = foot[..., 1] - head[..., 1]
        return np.stack([self.wrap_column(u), head[..., 1] + 0.5 * length, length], axis=-1)

    def _slope(self, directions: FloatArray) -> FloatArray:
        """How many metres directions of the camera go down for each metre along the ground."""
        level = self.to_level(directions)
        return level[..., 1] / np.hypot(level[..., 0], level[..., 2])

    def _apart(self, u: FloatArray, other: FloatArray) -> FloatArray:
        """How far the column u lies right of another one, the shorter way round."""
        return shorter_way(u - other, self.period)
