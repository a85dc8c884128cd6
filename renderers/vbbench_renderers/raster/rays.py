"""The rays of a camera, one through the centre of each pixel.

Eye coordinates are (right, up, forward) in m from the camera. The ray of pixel (column, row) is
(side[column], (horizon − row) / focal, ahead[column]), scaled so that its parameter is the depth of a `Picture`.
It is separable for both cameras: (side, ahead) = ((u − cx) / f, 1) or (sin φ, cos φ), with u = column + ½.
So in one column of either picture the edges of a triangle are straight and its inverse depth is linear in the row.
"""

from typing import NamedTuple

import numpy as np

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray

NEAR = 0.1
"""Surfaces nearer than this (m of depth) are not drawn."""


class Rays(NamedTuple):
    """Rays of a W x H picture.

    Parameters
    ----------
    side, ahead : [W] horizontal parts.
    focal : in px.
    horizon : row of the horizon, counted between pixel centres.
    centre : column of the optical axis in px; unused in a panorama.
    height : H, in px.
    closed : whether the picture closes on itself.
    """

    side: FloatArray
    ahead: FloatArray
    focal: float
    horizon: float
    centre: float
    height: int
    closed: bool


def camera_rays(camera: Camera) -> Rays:
    """The rays of a camera's picture.

    Raises
    ------
    VbbenchError
        If it is neither a perspective camera nor a panorama.
    """
    width, height = camera.picture_size
    u = np.arange(width, dtype=np.float64) + 0.5
    if isinstance(camera, PanoramaCamera):
        azimuth = 2.0 * np.pi * u / width - np.pi
        return Rays(np.sin(azimuth), np.cos(azimuth), camera.focal, camera.cy - 0.5, 0.0, height, True)
    if isinstance(camera, PerspectiveCamera):
        side = (u - camera.cx) / camera.focal
        return Rays(side, np.ones(width), camera.focal, camera.cy - 0.5, camera.cx, height, False)
    raise VbbenchError(f"a '{camera.kind}' camera cannot be rendered; use perspective or panorama")


def eye_transform(camera: Camera, pose: FloatArray) -> FloatArray:
    """[3, 4] from the world to the eye coordinates of a camera at a pose (x, y, yaw)."""
    x, y, yaw = (float(value) for value in pose)
    turn = np.array([[np.sin(yaw), -np.cos(yaw), 0.0], [0.0, 0.0, 1.0], [np.cos(yaw), np.sin(yaw), 0.0]])
    return np.column_stack([turn, -turn @ np.array([x, y, camera.mount_height])])
