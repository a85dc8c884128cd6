"""Cameras: the observation (u, v, l) of an upright person, and the way back to the ground plane.

Observation model (paper arXiv 2111.05060, eq. 1, with the true vertical offset h0 − h/2 of the box centre
where the paper prints h/2): a person of height h at z = (right, forward) is seen as a box with centre column u,
centre row v (down positive) and height l, all in px. The camera stands at mount height h0. Pitch is how far its
optical axis points above the horizon, roll how far its right side hangs lower than its left, both in rad; a level
camera has neither.

A camera model is one frozen dataclass, registered under ``vbbench.cameras`` by its ``kind``. `CentralCamera` makes it a
`Camera` once it says which pixel shows which direction and which direction is shown at which pixel.
"""

from dataclasses import asdict, fields
from typing import Any, Protocol, cast, runtime_checkable

from vbbench.camera.central import NEAREST, CentralCamera, Focal, MountHeight, PrincipalPoint, Size, Tilt
from vbbench.camera.equirectangular import EquirectangularCamera
from vbbench.camera.models import PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.registry import load_registered

__all__ = [
    "NEAREST",
    "Camera",
    "CentralCamera",
    "EquirectangularCamera",
    "Focal",
    "MountHeight",
    "PanoramaCamera",
    "PerspectiveCamera",
    "PrincipalPoint",
    "Size",
    "Tilt",
    "camera_from_dict",
    "camera_to_dict",
    "make_camera",
]


@runtime_checkable
class Camera(Protocol):
    """Intrinsics, mount height and tilt. All methods take any leading shape and map NaN to NaN."""

    def __hash__(self) -> int:
        """Cameras are values: what follows from one is kept by it."""

    @property
    def kind(self) -> str:
        """Name used on the command line and in files."""

    @property
    def focal(self) -> float:
        """Focal length in px: pixels per radian in the middle of the picture, along a row where the two differ."""

    @property
    def mount_height(self) -> float:
        """Height h0 of the optical centre over the ground, in m."""

    @property
    def picture_size(self) -> tuple[int, int]:
        """Width and height in px of the camera's picture."""

    @property
    def period(self) -> float | None:
        """Width in px of a picture that closes on itself, as a panorama's does; ``None`` for one with borders."""

    @property
    def view(self) -> tuple[float, float] | None:
        """Azimuths in rad, clockwise from forward, of the view's left and right border; ``None`` for all around."""

    @property
    def intrinsics(self) -> FloatArray | None:
        """[3, 3] matrix K in px of a pinhole camera; ``None`` for other models, whose pictures bend straight lines."""

    @property
    def cylinder(self) -> FloatArray | None:
        """[2] focal length of the rows and row of the horizon, in px, of a panorama on a level upright cylinder.

        Its columns are even in azimuth, from straight behind clockwise. ``None`` for other models and tilted cameras.
        """

    def project(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """Boxes of people: relative [..., 2] (right, forward) m, heights [...] m → [..., 3] (u, v, l) px.

        NaN where the person is behind the camera or absent, or the box's centre lies outside the picture; where
        pictures of verticals bend, also where the middle of the body does.
        """

    def project_unbounded(self, relative: FloatArray, heights: FloatArray) -> FloatArray:
        """As `project`, wherever the box's centre lies."""

    def unproject(self, observations: FloatArray, heights: FloatArray) -> FloatArray:
        """Ground positions of boxes: [..., 3] px and heights [...] m → [..., 2] (right, forward) m.

        They are linear in the heights.
        """

    def to_horizon(self, observations: FloatArray) -> FloatArray:
        """Boxes [..., 3] of people as tall as the mount whose feet are where these boxes end: they reach the horizon.

        Boxes that end above the horizon, as noise may have it, become about a pixel high or have no height above 0.
        """

    def statures(self, observations: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Heights of people who stand where their boxes [..., 3] end, by both edges; they belong to one sight of each.

        Returns
        -------
        px [...] from the horizon down to their feet, the heights of the boxes of `to_horizon`; and heights [...] in m.
        """

    def depth(self, relative: FloatArray) -> FloatArray:
        """Distance [...] in m by which people hide one another; NaN behind the camera and on top of it."""

    def wrap_column(self, u: FloatArray) -> FloatArray:
        """Columns as they stand in a file: in a picture that closes on itself, wrapped into it."""

    def horizon(self, u: FloatArray) -> FloatArray:
        """Row [...] in px of the horizon in the columns u [...]: where everything as high as the mount appears."""

    def pixels(self, directions: FloatArray) -> FloatArray:
        """Pixels [..., 2] (u, v) that show directions [..., 3] (right, down, forward) of the camera; NaN where none."""

    def directions(self, pixels: FloatArray) -> FloatArray:
        """The way back: a direction [..., 3] (right, down, forward) of the camera, of any length, for each pixel."""

    def to_camera(self, directions: FloatArray) -> FloatArray:
        """Directions [..., 3] (right, down, forward) of a level camera in the frame of this one."""

    def to_level(self, directions: FloatArray) -> FloatArray:
        """The way back from `to_camera`."""


_LATER = ("pitch", "roll", "vertical_focal")
"""Parameters that files omit where they are a model's defaults, as files from before there were any do."""


def make_camera(kind: str, **parameters: Any) -> Camera:
    """A camera of a registered model.

    Raises UnknownNameError if no model is called so; VbbenchError if a parameter is unknown, or a value is not valid.
    """
    model = load_registered("camera", kind)
    try:
        made: Camera = model(**parameters)
    except (TypeError, ValueError) as error:
        raise VbbenchError(f"camera '{kind}': {error}") from error
    return made


def camera_to_dict(camera: Camera) -> dict[str, Any]:
    """The camera as it stands in ``dataset.json``."""
    model = cast(Any, camera)
    usual = {field.name: field.default for field in fields(model) if field.name in _LATER}
    stated = {name: value for name, value in asdict(model).items() if name not in usual or value != usual[name]}
    return {"kind": camera.kind, **stated}


def camera_from_dict(values: dict[str, Any]) -> Camera:
    """The camera that `camera_to_dict` wrote.

    Raises VbbenchError as of `make_camera`.
    """
    return make_camera(str(values.get("kind", "")), **{name: value for name, value in values.items() if name != "kind"})
