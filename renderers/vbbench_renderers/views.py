"""The rays of a camera, one through the centre of each pixel, and pictures assembled from perspective views.

Eye coordinates are (right, up, forward) in m from the camera, tilted with it. The ray of pixel (column, row) is
(side[column], (horizon − row) / focal, ahead[column]), scaled so that its parameter is the depth of a `Picture`.
It is separable for pinholes and upright cylinders: (side, ahead) = ((u − cx) / f, 1) or (sin φ, cos φ), with
u = column + ½. So in one column of either picture the edges of a triangle are straight and its inverse depth is linear
in the row. A picture of any other camera is cut into regions that pinholes see, each is drawn somewhat finer than it
is wanted, and its pixels are looked up in the directions of the camera model.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from vbbench.camera import Camera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.pictures.rendering import Picture
from vbbench.sequence import NOBODY
from vbbench_renderers import _core
from vbbench_renderers.meshes import Float32

NEAR = _core.NEAR
"""Surfaces nearer than this (m of depth) are not drawn."""
FINER = 1.5
"""px per rad of the views, over the most that the picture has anywhere."""
MOST_PIXELS = 4.0
"""No more px per rad are taken from a picture than so many times its focal length; some have no limit at borders."""
SPARE = 2
"""px around a view, so that colours can be mixed up to its border."""
STEEP = 1.5
"""Pitch in rad of the views up and down."""
SIDES = ((0.0, 0.0), (0.5 * np.pi, 0.0), (np.pi, 0.0), (-0.5 * np.pi, 0.0), (0.0, STEEP), (0.0, -STEEP))
"""Turn clockwise and pitch in rad of the views that together see everything."""


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

    Raises VbbenchError if it is neither a pinhole nor an upright cylinder.
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
    raise VbbenchError(f"the rays of a '{camera.kind}' camera are not in columns")


def eye_transform(camera: Camera, pose: FloatArray) -> FloatArray:
    """[3, 4] from the world to the eye coordinates of a camera at a pose (x, y, yaw)."""
    x, y, yaw = (float(value) for value in pose)
    turn = np.array([[np.sin(yaw), -np.cos(yaw), 0.0], [0.0, 0.0, 1.0], [np.cos(yaw), np.sin(yaw), 0.0]])
    tilt = camera.to_camera(np.eye(3)).T
    if not np.array_equal(tilt, np.eye(3)):
        upwards = np.array([1.0, -1.0, 1.0])
        turn = (upwards[:, None] * tilt * upwards) @ turn
    return np.column_stack([turn, -turn @ np.array([x, y, camera.mount_height])])


@dataclass(frozen=True, kw_only=True)
class View:
    """A perspective view, and where its pixels go.

    Parameters
    ----------
    camera : of the view.
    turn : rad, clockwise from the axis of the camera whose picture is put together.
    rows, columns : [M] and [N] of the picture; the view fills what is ``wanted`` where they cross.
    wanted : [M, N] which pixels those are.
    x, y : [M, N] its places (px, 0 at the centre of the first pixel) that are seen through them.
    stretch : [M, N] horizontal range over depth.
    """

    camera: PerspectiveCamera
    turn: float
    rows: IntArray
    columns: IntArray
    wanted: BoolArray
    x: Float32
    y: Float32
    stretch: FloatArray


def assemble(camera: Camera, pose: FloatArray, shoot: Callable[[Camera, FloatArray], Picture]) -> Picture:
    """The picture of any camera at a pose, from the views that ``shoot`` draws; depth is the horizontal range.

    What no direction shows is black and infinitely far away.
    """
    width, height = camera.picture_size
    rgb, depth = np.zeros((height, width, 3), np.uint8), np.full((height, width), np.inf, np.float32)
    ids = np.full((height, width), NOBODY, np.int32)
    for view in views_of(camera):
        block = np.ix_(view.rows, view.columns)
        seen = resample(view, shoot(view.camera, np.asarray(pose, np.float64) - np.array([0.0, 0.0, view.turn])))
        for whole, part in ((rgb, seen.rgb), (depth, seen.depth), (ids, seen.ids)):
            wanted = view.wanted if whole.ndim == 2 else view.wanted[..., None]
            whole[block] = np.where(wanted, part, whole[block])
    return Picture(rgb=rgb, depth=depth, ids=ids)


@lru_cache(maxsize=4)
def views_of(camera: Camera) -> list[View]:
    """The views that together are a camera's picture: to all sides, up and down, as far as pixels look there."""
    width, height = camera.picture_size
    places = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)
    ways = camera.to_level(camera.directions(places))
    ways = ways / np.linalg.norm(ways, axis=-1, keepdims=True)
    focal = FINER * min(_density(ways), MOST_PIXELS * camera.focal)
    axes = np.array([[np.cos(up) * np.sin(turn), -np.sin(up), np.cos(up) * np.cos(turn)] for turn, up in SIDES])
    nearest = np.where(np.isfinite(ways[..., 0]), np.argmax(ways @ axes.T, axis=-1), -1)
    return [_view(camera, ways, nearest == side, focal, *SIDES[side]) for side in np.unique(nearest[nearest >= 0])]


def _density(ways: FloatArray) -> float:
    """The most px per rad between neighbours along a row or a column of unit vectors [H, W, 3]."""
    steps = [np.linalg.norm(np.diff(ways, axis=axis), axis=-1) for axis in (0, 1)]
    return float(max(1.0 / np.nanmin(step) for step in steps if step.size))


def _view(camera: Camera, ways: FloatArray, chosen: BoolArray, focal: float, turn: float, pitch: float) -> View:
    """The view of the ``chosen`` pixels [H, W], which show the directions ``ways`` [H, W, 3] of a level camera."""
    rows, columns = np.flatnonzero(chosen.any(axis=1)), np.flatnonzero(chosen.any(axis=0))
    block = np.ix_(rows, columns)
    wanted, level = chosen[block], ways[block]
    cos, sin = np.cos(turn), np.sin(turn)
    right, forward = level[..., 0] * cos - level[..., 2] * sin, level[..., 0] * sin + level[..., 2] * cos
    tilted = PerspectiveCamera(pitch=pitch).to_camera(np.stack([right, level[..., 1], forward], axis=-1))
    ahead = np.where(wanted, tilted[..., 2], 1.0)
    x, y = (np.where(wanted, focal * tilted[..., axis] / ahead, 0.0) for axis in (0, 1))
    (left, top), (end, bottom) = (np.floor([x.min(), y.min()]) - SPARE, np.ceil([x.max(), y.max()]) + SPARE)
    view = PerspectiveCamera(width=int(end - left), height=int(bottom - top), focal=focal, cx=-left, cy=-top,
                             mount_height=camera.mount_height, pitch=pitch)  # fmt: skip
    return View(camera=view, turn=turn, rows=rows, columns=columns, wanted=wanted,
                x=(x - left - 0.5).astype(np.float32), y=(y - top - 0.5).astype(np.float32),
                stretch=np.hypot(right, forward) / ahead)  # fmt: skip


def resample(view: View, seen: Picture) -> Picture:
    """The block [M, N] of a picture that a view fills, of what is ``seen`` in it; depth is the horizontal range.

    Ids come from the nearest pixel. 1 / depth is linear on a plane: it is mixed from four pixels where they show one
    surface, and taken from the nearest one elsewhere.
    """
    rgb, depth, ids = seen.rgb, seen.depth, seen.ids
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
        reach = (view.stretch / mixed).astype(np.float32)
    return Picture(rgb=np.asarray(colours, np.uint8), depth=reach, ids=ids[nearest])
