"""Who hides whom, without rendering: people are outlines that stand on level ground, nearer ones before farther ones.

An outline is as many upright bands as it has steps: within ``half`` · height of its axis it rises to ``top`` · height.
All stand on the same ground, so the nearer somebody is, the lower the feet in the picture: in every column of the
picture the people before somebody hide everything below the highest of their outlines (their *skyline*) and nothing
above. So one sweep from near to far, which keeps the skyline, tells of everybody what shows.
Rows are exact; columns are sampled `SAMPLES` to the pixel. Where the camera
is tilted or bends straight lines, outlines stand upright about their boxes all the same.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, world_to_relative
from vbbench.kernels import kernel

SAMPLES = 4
"""Sampled columns a px: people far away are a few px wide."""


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
    positions, heights : [T, K, 2] and [K] in m of everybody who can hide anybody; NaN = absent.
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
    visible, boxes = _sweep(figures, distances, halves, tops, columns, np.inf if wraps else float(rows), wraps)
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


@kernel
def _sweep(
    figures: FloatArray,
    distances: FloatArray,
    halves: FloatArray,
    tops: FloatArray,
    width: int,
    bottom: float,
    wraps: bool,
) -> tuple[FloatArray, FloatArray]:
    """Visible fractions [T, K] and boxes [T, K, 4] (u, v, l, width) of what shows; ``figures`` from `_figures`."""
    frames, people = distances.shape
    visible, boxes = np.full((frames, people), np.nan), np.full((frames, people, 4), np.nan)
    skyline = np.full(width * SAMPLES, bottom)
    inside, away = np.empty(people, np.int64), np.empty(people)
    for t in range(frames):
        count, left, right = 0, len(skyline), -1
        for k in range(people):
            if not np.isnan(distances[t, k]):
                _, _, begin, end = _columns(figures[t, k], halves[-1], len(skyline), wraps)
                if begin <= end:  # whoever is beside the picture neither shows nor hides anybody
                    inside[count], away[count], count = k, distances[t, k], count + 1
                    left, right = min(left, begin), max(right, end)
        for n in np.argsort(away[:count], kind="mergesort"):
            k = inside[n]
            visible[t, k] = _show(figures[t, k], halves, tops, skyline, bottom, wraps, boxes[t, k])
        for c in range(0 if wraps else left, len(skyline) if wraps else right + 1):
            skyline[c] = bottom
    return visible, boxes


@kernel
def _columns(figure: FloatArray, half: float, count: int, wraps: bool) -> tuple[int, int, int, int]:
    """The first and last sampled column of a figure, and of the part that is among the ``count`` of the picture.

    Sample c stands at column (c + ½) / SAMPLES. The narrowest figure still has the sample next to its axis.
    """
    u, reach = figure[0], half * figure[2]
    first = int(np.ceil(max((u - reach) * SAMPLES - 0.5, -1e9)))
    last = int(np.floor(min((u + reach) * SAMPLES - 0.5, 1e9)))
    if last < first:
        first = last = int(np.floor(u * SAMPLES))
    if wraps:
        last = min(last, first + count - 1)
        return first, last, first, last
    return first, last, max(first, 0), min(last, count - 1)


@kernel
def _show(
    figure: FloatArray,
    halves: FloatArray,
    tops: FloatArray,
    skyline: FloatArray,
    bottom: float,
    wraps: bool,
    box: FloatArray,
) -> float:
    """Visible fraction of the next farther person, whose ``box`` [4] is filled in and who is added to the skyline."""
    u, feet, size = figure
    reach, count = halves[-1] * size, len(skyline)
    first, last, from_column, to_column = _columns(figure, halves[-1], count, wraps)
    floor = min(feet, bottom)
    whole = shown = head = start = height = 0.0
    near, far = np.inf, -np.inf  # of the axis are the columns of the step
    top, low, left, right = np.inf, -np.inf, last + 1, first - 1
    for c in range(from_column, to_column + 1):
        place = c % count if wraps else c
        away = abs((c + 0.5) / SAMPLES - u)
        if away <= near or away > far:
            step, near = 0, -1.0
            while step < len(halves) - 1 and away > halves[step] * size:
                near = halves[step] * size
                step += 1
            far = halves[step] * size if step < len(halves) - 1 else np.inf
            head = feet - tops[step] * size
            start = head if wraps else max(head, 0.0)
            height = max(floor - start, 0.0)
        whole += height
        end = min(floor, skyline[place])
        if end > start:
            shown += end - start
            top, low = min(top, start), max(low, end)
            left, right = min(left, c), max(right, c)
        skyline[place] = min(skyline[place], head)
    if shown > 0.0:
        # Where the figure's own edge shows it is exact; elsewhere the sample's edge bounds what shows.
        begin = u - reach if left == first else left / SAMPLES
        end = u + reach if right == last else (right + 1) / SAMPLES
        box[0], box[1], box[2], box[3] = 0.5 * (begin + end), 0.5 * (top + low), low - top, end - begin
    return shown / whole if whole > 0.0 else np.nan


def enough(showing: Showing, least: float) -> BoolArray:
    """[T, K] of whom at least the share ``least`` shows."""
    shown: BoolArray = showing.visible >= least
    return shown & ~np.isnan(showing.boxes[..., 2])
