"""Cameras whose rays meet in one point, tilted or level: all that is asked of them, from two functions of a model."""

from functools import cached_property
from typing import Annotated, ClassVar, cast

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import Within, check_ranges

NEAREST = 0.01
"""People nearer than this (m) are not observed: their box would be larger than any picture."""

CORRECTIONS, EXACT = 12, 1e-9
"""Times that a box is corrected for verticals that are curved in the picture, and px that are no longer corrected."""

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
            width, height = self.picture_size
            u, v = boxes[..., 0], boxes[..., 1]
            boxes[~((u >= 0) & (u < width) & (v >= 0) & (v < height))] = np.nan
        return boxes

    def project_unbounded(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.project_unbounded`: from the pixels of feet and top of the head."""
        depth = self.depth(relative)
        reach = np.where(np.isnan(depth), np.nan, np.hypot(relative[..., 0], relative[..., 1]))
        azimuth = np.arctan2(relative[..., 0], relative[..., 1])
        return self._box(azimuth, self.mount_height / reach, (self.mount_height - heights) / reach)

    def unproject(self, observations: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.unproject`: the distance at which feet and head are as far apart as the box says.

        They lie on the picture of the vertical at one azimuth. It is taken to be straight over the box, which is exact
        for a pinhole; for other models the box is corrected until the vertical's own, curved picture has the one given.
        """
        corrected = observations
        for _ in range(CORRECTIONS):
            azimuth, lower, upper = self._vertical(corrected)
            off = observations - self._box(azimuth, lower, upper)
            off[..., 0] = self._apart(observations[..., 0], observations[..., 0] - off[..., 0])
            if not (np.abs(off) > EXACT).any():
                break
            corrected = corrected + off
        reach = heights / (lower - upper)
        return np.stack([reach * np.sin(azimuth), reach * np.cos(azimuth)], axis=-1)

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

    def _vertical(self, boxes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Azimuth of boxes [..., 3], and slopes down to their bottom and top, verticals straight over each box."""
        centre, half = boxes[..., :2], 0.5 * boxes[..., 2:]
        middle = self.to_level(self.directions(centre))
        middle = middle / np.hypot(middle[..., 0], middle[..., 2])[..., None]
        step = np.array([0.0, 1e-4, 0.0])
        lower, upper = (self.pixels(self.to_camera(middle + sign * step)) for sign in (1, -1))
        lean = self._apart(lower[..., 0], upper[..., 0]) / (lower[..., 1] - upper[..., 1])
        along = np.concatenate([lean[..., None] * half, half], axis=-1)
        bottom, top = (self._slope(self.directions(centre + sign * along)) for sign in (1, -1))
        return np.arctan2(middle[..., 0], middle[..., 2]), bottom, top

    def _box(self, azimuth: FloatArray, bottom: FloatArray, top: FloatArray) -> FloatArray:
        """Boxes [..., 3] of verticals at an azimuth between two slopes down."""
        foot, head = (
            self.pixels(self.to_camera(np.stack([np.sin(azimuth), slope, np.cos(azimuth)], axis=-1)))
            for slope in (bottom, top)
        )
        u = foot[..., 0] + 0.5 * self._apart(head[..., 0], foot[..., 0])
        length = foot[..., 1] - head[..., 1]
        return np.stack([self.wrap_column(u), head[..., 1] + 0.5 * length, length], axis=-1)

    def _slope(self, directions: FloatArray) -> FloatArray:
        """How many metres directions of the camera go down for each metre along the ground."""
        level = self.to_level(directions)
        return level[..., 1] / np.hypot(level[..., 0], level[..., 2])

    def _apart(self, u: FloatArray, other: FloatArray) -> FloatArray:
        """How far the column u lies right of another one, the shorter way round."""
        apart = u - other
        return apart if self.period is None else apart - self.period * np.round(apart / self.period)
