"""Cameras: the observation (u, v, l) of an upright person, and the way back to the ground plane.

Observation model (paper arXiv 2111.05060, eq. 1, with the true vertical offset h0 − h/2 of the box centre
where the paper prints h/2): a person of height h at z = (right, forward) is seen as a box with centre column u,
centre row v (down positive) and height l, all in px. The optical axis is level at mount height h0.
"""

from dataclasses import asdict, dataclass
from typing import Annotated, Any, ClassVar, Protocol, cast, runtime_checkable

import numpy as np

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import Within, check_ranges

NEAREST = 0.01
"""People nearer than this (m) are not observed: their box would be larger than any picture."""

Size = Annotated[int, Within(1, 1e6, "px")]
Focal = Annotated[float, Within(0.01, 1e7, "px")]
Point = Annotated[float, Within(-1e7, 1e7, "px")]
Height = Annotated[float, Within(0.01, 1e3, "m")]


@runtime_checkable
class Camera(Protocol):
    """Intrinsics and mount height. All methods take any leading shape and map NaN to NaN."""

    @property
    def kind(self) -> str:
        """Name used on the command line and in files."""

    @property
    def focal(self) -> float:
        """Focal length in px: a person of height h at depth d is f·h/d px tall."""

    @property
    def mount_height(self) -> float:
        """Height h0 of the optical axis over the ground, in m."""

    @property
    def picture_size(self) -> tuple[int, int]:
        """Width and height in px of the camera's picture."""

    @property
    def period(self) -> float | None:
        """Width in px of a picture that closes on itself, as a panorama's does; ``None`` for one with borders."""

    def project(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """Boxes of people: relative [..., 2] (right, forward) m, heights [...] m → [..., 3] (u, v, l) px.

        NaN where the person is behind the camera, outside the image or absent.
        """

    def unproject(self, observations: FloatArray, heights: FloatArray) -> FloatArray:
        """Ground positions of boxes: [..., 3] px and heights [...] m → [..., 2] (right, forward) m."""

    def depth(self, relative: FloatArray) -> FloatArray:
        """The distance [...] in m that the box height measures, l = f·h/depth."""

    def wrap_column(self, u: FloatArray) -> FloatArray:
        """Columns as they stand in a file: in a picture that closes on itself, wrapped into it."""


@dataclass(frozen=True, kw_only=True)
class PerspectiveCamera:
    """Pinhole camera: u = cx + f·right/forward, v = cy + f·(h0 − h/2)/forward, l = f·h/forward.

    Parameters
    ----------
    width, height : image size in px.
    focal : focal length f in px.
    cx, cy : principal point in px.
    mount_height : h0 in m.
    """

    kind: ClassVar[str] = "perspective"
    width: Size = 1280
    height: Size = 720
    focal: Focal = 640.0
    cx: Point = 640.0
    cy: Point = 360.0
    mount_height: Height = 1.6

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def picture_size(self) -> tuple[int, int]:
        """See `Camera.picture_size`."""
        return self.width, self.height

    @property
    def period(self) -> None:
        """The picture has borders."""

    def project(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.project`; the box centre must lie inside the image."""
        depth = self.depth(relative)
        scale = self.focal / depth
        u = self.cx + scale * relative[..., 0]
        v = self.cy + scale * (self.mount_height - 0.5 * heights)
        boxes = np.stack([u, v, scale * heights], axis=-1)
        inside = (u >= 0) & (u < self.width) & (v >= 0) & (v < self.height)
        boxes[~inside] = np.nan
        return boxes

    def unproject(self, observations: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.unproject`: forward = f·h/l, right = (u − cx)·forward/f."""
        forward = self.focal * heights / observations[..., 2]
        return np.stack([(observations[..., 0] - self.cx) * forward / self.focal, forward], axis=-1)

    def depth(self, relative: FloatArray) -> FloatArray:
        """Distance along the optical axis, NaN behind the camera."""
        forward = relative[..., 1]
        return np.where(forward > NEAREST, forward, np.nan)

    def wrap_column(self, u: FloatArray) -> FloatArray:
        """Columns as they are: the picture has borders."""
        return u


@dataclass(frozen=True, kw_only=True)
class PanoramaCamera:
    """360° cylinder: φ = 2πu/W − π clockwise from forward, v = cy + f·(h0 − h/2)/r, l = f·h/r, z = r(sin φ, cos φ).

    The cylinder has no upper or lower border: everybody around is observed, at any distance.

    Parameters
    ----------
    width : W, px around the full circle.
    focal : f in px; W/2π makes square pixels.
    cy : row of the horizon in px.
    mount_height : h0 in m.
    """

    kind: ClassVar[str] = "panorama"
    width: Size = 1440
    focal: Focal = 1440 / (2.0 * np.pi)
    cy: Point = 240.0
    mount_height: Height = 1.6

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def picture_size(self) -> tuple[int, int]:
        """See `Camera.picture_size`; it is as high below the horizon as above it."""
        return self.width, round(2 * self.cy)

    @property
    def period(self) -> float:
        """The full circle."""
        return float(self.width)

    def project(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.project`; u is in [0, W)."""
        scale = self.focal / self.depth(relative)
        azimuth = np.arctan2(relative[..., 0], relative[..., 1])
        u = (azimuth + np.pi) * (self.width / (2.0 * np.pi))
        u = np.where(u < self.width, u, 0.0) + 0.0 * scale  # column W is column 0; NaN where the scale is
        v = self.cy + scale * (self.mount_height - 0.5 * heights)
        return np.stack([u, v, scale * heights], axis=-1)

    def unproject(self, observations: FloatArray, heights: FloatArray) -> FloatArray:
        """See `Camera.unproject`: r = f·h/l."""
        azimuth = observations[..., 0] * (2.0 * np.pi / self.width) - np.pi
        reach = self.focal * heights / observations[..., 2]
        relative = np.empty((*reach.shape, 2))
        np.multiply(reach, np.sin(azimuth), out=relative[..., 0])
        np.multiply(reach, np.cos(azimuth), out=relative[..., 1])
        return relative

    def depth(self, relative: FloatArray) -> FloatArray:
        """Horizontal range, NaN on top of the camera."""
        reach = np.sqrt(relative[..., 0] ** 2 + relative[..., 1] ** 2)
        return np.where(reach > NEAREST, reach, np.nan)

    def wrap_column(self, u: FloatArray) -> FloatArray:
        """Column wrapped to [0, W)."""
        wrapped = np.mod(u, self.width)
        return cast(FloatArray, np.where(wrapped >= self.width, 0.0, wrapped))


CAMERAS: dict[str, type[PerspectiveCamera] | type[PanoramaCamera]] = {
    "panorama": PanoramaCamera,
    "perspective": PerspectiveCamera,
}


def camera_to_dict(camera: Camera) -> dict[str, Any]:
    """The camera as it stands in ``dataset.json``."""
    return {"kind": camera.kind, **asdict(cast(Any, camera))}


def camera_from_dict(values: dict[str, Any]) -> PerspectiveCamera | PanoramaCamera:
    """The camera that `camera_to_dict` wrote.

    Raises
    ------
    VbbenchError
        If the kind or a parameter is unknown, or a value cannot be.
    """
    kind = values.get("kind", "")
    if not isinstance(kind, str) or kind not in CAMERAS:
        raise UnknownNameError("camera", str(kind), CAMERAS)
    try:
        return CAMERAS[kind](**{name: value for name, value in values.items() if name != "kind"})
    except (TypeError, ValueError) as error:
        raise VbbenchError(f"camera '{kind}': {error}") from error
