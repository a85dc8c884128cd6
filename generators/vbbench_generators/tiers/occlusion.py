"""Who hides whom, without rendering: people are outlines that stand on level ground, nearer ones before farther ones.

An outline is as many upright bands as it has steps: within ``half`` · height of its axis it rises to ``top`` · height.
All stand on the same ground, so the nearer a person is, the lower the feet in the picture: in every column of the
picture the people before a person hide everything below the highest of their outlines (their *skyline*) and nothing
above. So one sweep from near to far, which keeps the skyline, finds what shows of everybody.
Rows are exact; columns are sampled four to the pixel, since people far away are a few px wide. Where the camera
is tilted or bends straight lines, outlines stand upright about their boxes all the same.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, world_to_relative
from vbbench_generators import _core


@dataclass(frozen=True, kw_only=True)
class Outline:
    """What people look like from afar, in parts of their height.

    Parameters
    ----------
    half, top : from the axis outwards, each step's half width and height above the ground.
    """

    half: tuple[float, ...] = (0.05, 0.12)
    top: tuple[float, ...] = (1.0, 0.80)

    def __post_init__(self) -> None:
        half, top = np.array(self.half), np.array(self.top)
        if half.shape != top.shape or not half.size or np.any(np.diff(half, prepend=0.0) <= 0.0):
            raise ValueError(f"half = {list(self.half)} must grow from above 0, with one top for each")
        if np.any(np.diff(top) >= 0.0) or top[0] != 1.0 or top[-1] <= 0.0:
            raise ValueError(f"top = {list(self.top)} must fall from 1 and stay above 0")


@dataclass(frozen=True)
class Showing:
    """What shows of people.

    Parameters
    ----------
    visible : [T, K] share of the outline's area in the picture that nobody hides; NaN where nothing would be there.
    boxes : [T, K, 3] boxes (u, v, l) in px about what shows; NaN where nothing does.
    widths : [T, K] of these boxes, in px.
    """

    visible: FloatArray
    boxes: FloatArray
    widths: FloatArray


def see(
    positions: FloatArray, heights: FloatArray, poses: FloatArray, camera: Camera, outline: Outline | None = None
) -> Showing:
    """What a camera carried along shows of people.

    Parameters
    ----------
    positions, heights : [T, K, 2] and [K] in m of everybody who can hide others; NaN = absent.
    poses : [T, 3] (x, y, yaw) of the camera.
    camera : the borders of its picture cut people off; a picture that closes on itself has none, up and down either.
    outline : everybody's.
    """
    relative = world_to_relative(positions, poses)
    figures = _figures(relative, np.broadcast_to(heights, relative.shape[:-1]), camera)
    return see_figures(figures, np.ascontiguousarray(camera.depth(relative)), camera, outline or Outline())


def see_figures(figures: FloatArray, distances: FloatArray, camera: Camera, outline: Outline) -> Showing:
    """What shows of people who stand in the picture as ``figures`` [T, K, 3], (u, row of the feet, l) in px.

    Parameters
    ----------
    figures, distances : the latter [T, K] in m, by which people hide one another; both NaN = not there.
    camera, outline : as of `see`.
    """
    columns, rows = camera.picture_size
    wraps = camera.period is not None
    halves, tops = np.array(outline.half), np.array(outline.top)
    bottom = np.inf if wraps else float(rows)
    visible, boxes = _core.sweep(np.ascontiguousarray(figures), distances, halves, tops, int(columns), bottom, wraps)
    boxes[..., 0] = camera.wrap_column(boxes[..., 0])
    return Showing(visible, boxes[..., :3], boxes[..., 3])


def _figures(relative: FloatArray, heights: FloatArray, camera: Camera) -> FloatArray:
    """Boxes [T, K, 3] (u, row of the feet, l) in px as if the picture had no borders; NaN behind the camera."""
    figures = camera.project_unbounded(relative, heights)
    if camera.cylinder is None:
        figures[..., 1] = camera.project_unbounded(relative, np.zeros(heights.shape))[..., 1]
    else:  # the same but for the last bit, which stays as it was in datasets that were made before
        scale = camera.cylinder[0] / camera.depth(relative)
        figures[..., 1] = figures[..., 1] - scale * (camera.mount_height - 0.5 * heights) + scale * camera.mount_height
    return figures


def enough(showing: Showing, least: float) -> BoolArray:
    """[T, K] of whom at least the share ``least`` shows."""
    shown: BoolArray = showing.visible >= least
    return shown & ~np.isnan(showing.boxes[..., 2])
