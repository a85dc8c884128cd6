"""The rays of a camera, one through the centre of each pixel.

Eye coordinates are (right, up, forward) in m from the camera, tilted with it. The ray of pixel (column, row) is
(side[column], (horizon − row) / focal, ahead[column]), scaled so that its parameter is the depth of a `Picture`.
It is separable for pinholes and upright cylinders: (side, ahead) = ((u − cx) / f, 1) or (sin φ, cos φ), with
u = column + ½. So in one column of either picture the edges of a triangle are straight and its inverse depth is linear
in the row. Other cameras are put together by `vbbench_renderers.views`.
"""

from typing import NamedTuple

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench_renderers import _core

NEAR = _core.NEAR
"""Surfaces nearer than this (m of depth) are not drawn."""


class Rays(NamedTuple):
    """Rays of a W x H picture.

    Parameters
    ----------
    side, ahead : [W] horizontal parts.
    focal : of the rows, in px.
    across : of the columns, in px; unused in a panorama.
    horizon : row of the horizon of a level camera, counted between pixel centres.
    centre : column of the optical axis in px; unused in a panorama.
    height : H, in px.
    closed : whether the picture closes on itself.
    """

    side: FloatArray
    ahead: FloatArray
    focal: float
    across: float
    horizon: float
    centre: float
    height: int
    closed: bool


def camera_rays(camera: Camera) -> Rays:
    """The rays of a camera's picture.

    Raises
    ------
    VbbenchError
        If it is neither a pinhole nor an upright cylinder.
    """
    width, height = camera.picture_size
    u = np.arange(width, dtype=np.float64) + 0.5
    if camera.cylinder is not None:
        focal, row = map(float, camera.cylinder)
        azimuth = 2.0 * np.pi * u / width - np.pi
        return Rays(np.sin(azimuth), np.cos(azimuth), focal, 0.0, row - 0.5, 0.0, height, True)
    if camera.intrinsics is not None:
        (across, _, cx), (_, focal, cy) = camera.intrinsics[:2].tolist()
        return Rays((u - cx) / across, np.ones(width), focal, across, cy - 0.5, cx, height, False)
    raise VbbenchError(f"the rays of a '{camera.kind}' camera are not in columns; it is drawn from views")


def eye_transform(camera: Camera, pose: FloatArray) -> FloatArray:
    """[3, 4] from the world to the eye coordinates of a camera at a pose (x, y, yaw)."""
    x, y, yaw = (float(value) for value in pose)
    turn = np.array([[np.sin(yaw), -np.cos(yaw), 0.0], [0.0, 0.0, 1.0], [np.cos(yaw), np.sin(yaw), 0.0]])
    tilt = tilt_of(camera)
    if not np.array_equal(tilt, np.eye(3)):
        upwards = np.array([1.0, -1.0, 1.0])
        turn = (upwards[:, None] * tilt * upwards) @ turn
    return np.column_stack([turn, -turn @ np.array([x, y, camera.mount_height])])


def tilt_of(camera: Camera) -> FloatArray:
    """[3, 3] the camera's right, down and forward as rows, in the frame of a level camera."""
    return camera.to_camera(np.eye(3)).T
