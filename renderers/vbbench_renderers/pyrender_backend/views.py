"""A panorama assembled from perspective views, because pyrender has no cylindrical camera."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from vbbench.camera import Camera, PerspectiveCamera
from vbbench.geometry import FloatArray, IntArray
from vbbench_renderers.mesh import Float32
from vbbench_renderers.raster.rays import camera_rays

VIEWS = 6
FINER = 2.0
"""Ratio of the focal lengths of the views and the panorama."""
SPARE = 2
"""px around a view, so that colours can be mixed up to its border."""


@dataclass(frozen=True, kw_only=True)
class View:
    """A perspective view, and where its pixels go.

    Parameters
    ----------
    camera : of the view.
    turn : rad, clockwise from the panorama's axis.
    columns : [N] columns of the panorama that it fills.
    x, y : [H, N] its places (px, 0 at the centre of the first pixel) that are seen through them.
    stretch : [N] horizontal range over depth.
    """

    camera: PerspectiveCamera
    turn: float
    columns: IntArray
    x: Float32
    y: Float32
    stretch: FloatArray


def views_of(camera: Camera) -> list[View]:
    """The views that together are a panorama."""
    rays = camera_rays(camera)
    azimuth = np.arctan2(rays.side, rays.ahead)
    nearest = np.round(azimuth * VIEWS / (2.0 * np.pi)).astype(int)
    slope = (rays.horizon - np.arange(rays.height)) / rays.focal
    focal, half = FINER * rays.focal, np.pi / VIEWS
    width = 2 * int(np.ceil(focal * np.tan(half) + SPARE))
    reach = [focal * bound / np.cos(half) + SPARE for bound in (slope.max(), -slope.min())]
    above, below = (int(np.ceil(max(part, SPARE))) for part in reach)
    views = []
    for index in range(VIEWS):
        turn = 2.0 * np.pi * (index - VIEWS // 2 + 1) / VIEWS
        columns = np.flatnonzero((nearest - (index - VIEWS // 2 + 1)) % VIEWS == 0)
        away = azimuth[columns] - turn
        x = np.broadcast_to(width / 2 + focal * np.tan(away) - 0.5, (len(slope), len(columns)))
        y = above - focal * slope[:, None] / np.cos(away) - 0.5
        view = PerspectiveCamera(width=width, height=above + below, focal=focal, cx=width / 2, cy=above,
                                 mount_height=camera.mount_height)  # fmt: skip
        views.append(View(camera=view, turn=turn, columns=columns, x=np.ascontiguousarray(x, np.float32),
                          y=y.astype(np.float32), stretch=1.0 / np.cos(away)))  # fmt: skip
    return views


def resample(
    view: View, rgb: NDArray[np.uint8], depth: Float32, ids: IntArray
) -> tuple[NDArray[np.uint8], Float32, IntArray]:
    """Colours, range and ids [H, N] of a view's columns of the panorama.

    Ids come from the nearest pixel. 1 / depth is linear on a plane: it is mixed from four pixels where they show one
    surface, and taken from the nearest one elsewhere.
    """
    colours = cv2.remap(rgb, view.x, view.y, cv2.INTER_LINEAR)
    column, row = np.floor(view.x).astype(int), np.floor(view.y).astype(int)
    column, row = np.clip(column, 0, rgb.shape[1] - 2), np.clip(row, 0, rgb.shape[0] - 2)
    fx, fy = view.x - column, view.y - row
    nearest = row + (fy >= 0.5), column + (fx >= 0.5)
    with np.errstate(divide="ignore"):
        near = (1.0 / depth).astype(np.float32)
    corners = [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)]
    shares = [(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy]
    values = np.stack([near[corner] for corner in corners])
    same = np.ptp(values, axis=0) < 0.05 * values.max(axis=0)
    for corner in corners:
        same &= ids[corner] == ids[nearest]
    mixed = np.where(same, sum(share * value for share, value in zip(shares, values, strict=True)), near[nearest])
    with np.errstate(divide="ignore"):
        return np.asarray(colours, np.uint8), (view.stretch / mixed).astype(np.float32), ids[nearest]
