"""Boxes as rectangles (left, top, width, height) in px: how much two overlap, and whether they can be people."""

from typing import NamedTuple

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, IntArray, shorter_way

BOX_ASPECT = 0.36
"""Width of a person's box as a fraction of its height; an observation has no width."""


def rectangles(observations: FloatArray, aspect: float = BOX_ASPECT) -> FloatArray:
    """Boxes [..., 3] (u, v, l) in px as [..., 4] (left, top, width, height); a box is ``aspect`` times as wide as high.

    In a panorama a box on the seam begins left of column 0, or ends right of the last one.
    """
    u, v, length = np.moveaxis(observations, -1, 0)
    width = aspect * length
    return np.stack([u - 0.5 * width, v - 0.5 * length, width, length], axis=-1)


def observations_of(boxes: FloatArray, camera: Camera) -> FloatArray:
    """The way back: [..., 4] (left, top, width, height) to [..., 3] (u, v, l) in px; columns wrapped in a panorama."""
    left, top, width, height = np.moveaxis(boxes, -1, 0)
    return np.stack([camera.wrap_column(left + 0.5 * width), top + 0.5 * height, height], axis=-1)


def cut_to_picture(boxes: FloatArray, camera: Camera) -> FloatArray:
    """The part of the boxes [..., 4] inside the camera's picture; a panorama has no left and right border."""
    columns, rows = camera.picture_size
    left, top, width, height = np.moveaxis(boxes, -1, 0)
    right = left + width
    if camera.period is None:
        left, right = np.clip(left, 0.0, columns), np.clip(right, 0.0, columns)
    top, bottom = np.clip(top, 0.0, rows), np.clip(top + height, 0.0, rows)
    return np.stack([left, top, right - left, bottom - top], axis=-1)


def with_seam_copies(boxes: FloatArray, period: float | None) -> tuple[FloatArray, IntArray]:
    """Boxes [N, 4], each that crosses the seam followed by its copy one turn away; and the index of each one's box.

    ``period`` is that of the camera, `vbbench.camera.Camera.period`.
    """
    rows = np.arange(len(boxes))
    if period is None:
        return boxes, rows
    left, right = np.flatnonzero(boxes[:, 0] < 0.0), np.flatnonzero(boxes[:, 0] + boxes[:, 2] > period)
    shift = np.repeat([0.0, period, -period], [len(rows), len(left), len(right)])
    rows = np.concatenate([rows, left, right])
    order = np.argsort(rows, kind="stable")
    return (boxes[rows] + shift[:, None] * np.array([1.0, 0.0, 0.0, 0.0]))[order], rows[order]


def overlaps(first: FloatArray, second: FloatArray, period: float | None = None) -> FloatArray:
    """Intersection over union [N, M] of boxes [N, 4] with boxes [M, 4]; 0 where a box is NaN or empty.

    ``period`` is that of the camera, `vbbench.camera.Camera.period`.
    """
    return pair_overlaps(first[:, None], second[None], period)


def pair_overlaps(first: FloatArray, second: FloatArray, period: float | None = None) -> FloatArray:
    """As `overlaps`, [...] of each box of [..., 4] with the one in its place."""
    a, b = first, second
    apart = shorter_way(b[..., 0] + 0.5 * b[..., 2] - a[..., 0] - 0.5 * a[..., 2], period)
    along = np.minimum(0.5 * (a[..., 2] + b[..., 2]) - np.abs(apart), np.minimum(a[..., 2], b[..., 2]))
    down = np.minimum(a[..., 1] + a[..., 3], b[..., 1] + b[..., 3]) - np.maximum(a[..., 1], b[..., 1])
    shared = np.clip(along, 0.0, None) * np.clip(down, 0.0, None)
    union = a[..., 2] * a[..., 3] + b[..., 2] * b[..., 3] - shared
    found = np.zeros(shared.shape)
    np.divide(shared, union, out=found, where=union > 0.0)
    return found


def suppress(boxes: FloatArray, scores: FloatArray, overlap: float, period: float | None = None) -> IntArray:
    """Non-maximum suppression: indices of the boxes that remain, best first.

    Parameters
    ----------
    boxes : [N, 4] (left, top, width, height) in px.
    scores : [N], the higher the better.
    overlap : intersection over union above which the box with the lower score is removed.
    period : that of the camera, `vbbench.camera.Camera.period`.
    """
    order = np.argsort(-scores, kind="stable")
    shared = overlaps(boxes[order], boxes[order], period) > overlap
    kept = np.ones(len(order), bool)
    for row in np.flatnonzero(np.triu(shared, k=1).any(axis=1)):
        if kept[row]:
            kept[row + 1 :] &= ~shared[row, row + 1 :]
    return np.asarray(order[kept], np.int64)


MOST_OUTSIDE = 0.2
"""A larger share of boxes whose middle is outside the picture means that they are of another picture."""
FEWEST, NEARLY_ALL = 5, 0.98
"""Boxes, and the share of them, that decide what their four numbers are."""
SMALLEST_PICTURE = 200.0
"""Width and height in px of pictures in which people do not stay within the upper left 100 px."""
MOST_WIDE, NEARLY_SQUARE, NARROW = 0.6, 0.75, 0.27
"""Shares: of boxes that may be wider than high, or than so much of it; and a width that is the least of a median."""
SMALLER, LARGER, TILT = 0.8, 1.25, 0.07
"""Multiples of the camera's row at which boxes of another picture have the horizon, and rad by which it is off."""
NETWORKS = (320, 384, 416, 480, 512, 576, 608, 640, 736, 768, 800, 896, 960, 1024, 1088, 1280, 1536)
"""Sides in px of the square pictures that detectors see."""
UNFILLED = 0.8
"""Boxes of a smaller picture reach no farther than this share of width and height."""
HALF = 0.12
"""How far feet may be from half a box below where they should be, if left and top are the middle of boxes."""
SAMPLE = 5000
"""Of more boxes, only about so many are looked at where a median or quantile is wanted."""


class Misfit(NamedTuple):
    """What is wrong with boxes, in words, and whether it is ``certain`` enough to refuse them."""

    text: str
    certain: bool


def find_misfit(boxes: FloatArray, camera: Camera, picture: tuple[float, float], height_mean: float) -> Misfit | None:
    """The first thing that is wrong with boxes [N, 4] (left, top, width, height) in px, if anything is.

    Parameters
    ----------
    boxes : of people, from five on; ten or more show what size of picture they are of.
    picture : its width and height in px; infinite where a camera file names none.
    height_mean : of people in m.
    """
    shown, count = f"{picture[0]:g} x {picture[1]:g} px", len(boxes)
    if count and (np.abs(boxes) <= 1.5).all():
        return Misfit(f"all boxes are within 1.5 px: they seem to be shares of the picture; write px of {shown}", True)
    lost = int(outside_picture(boxes, camera, picture).sum())
    boxes = boxes[:: 1 + count // SAMPLE]
    reach = np.quantile(boxes[:, :2] + boxes[:, 2:], NEARLY_ALL, axis=0) if count else np.zeros(2)
    if count >= FEWEST and (reach <= 101.0).all() and min(picture) >= SMALLEST_PICTURE:
        return Misfit(f"boxes end within 100 px: they seem to be per cent of the picture; write px of {shown}", True)
    if count >= FEWEST and _are_corners(boxes):
        text = "width and height seem to be the right and lower borders of boxes; subtract left and top from them"
        return Misfit(text, True)
    if lost > MOST_OUTSIDE * count:
        return Misfit(
            f"the middle of {lost} of {count} boxes is outside the picture of {shown}: they reach column "
            f"{reach[0]:.0f} and row {reach[1]:.0f}; write the size of the picture that the boxes are of",
            True,
        )
    shape = boxes[:, 2] / boxes[:, 3]
    for least, what in ((1.0, "wider than high"), (NEARLY_SQUARE, f"over {NEARLY_SQUARE:g} times as wide as high")):
        wide = float((shape > least).mean()) if count else 0.0
        if _lower_bound(wide, len(boxes)) > MOST_WIDE:
            text = f"{wide:.0%} of boxes are {what}, as people who stand are not"
            return Misfit(f"{text}; is width before height, in px, and are they of whole people, not of heads?", False)
    if count < 2 * FEWEST:
        return None
    if np.median(shape) < NARROW:
        text = f"boxes are {np.median(shape):.2f} times as wide as high (median), people {BOX_ASPECT:g}"
        return Misfit(f"{text}: are boxes of a picture that was squeezed? Then write px of {shown}", False)
    return _middle(boxes, camera, height_mean) or _other_size(boxes, reach, camera, picture, height_mean)


def outside_picture(boxes: FloatArray, camera: Camera, picture: tuple[float, float]) -> BoolArray:
    """[N] which boxes [N, 4] have their middle outside the picture; a panorama has no left and right border."""
    across, down = (boxes[:, :2] + 0.5 * boxes[:, 2:]).T
    aside = (across < 0.0) | (across >= picture[0])
    return np.asarray((down < 0.0) | (down >= picture[1]) | (aside & (camera.period is None)))


def _are_corners(boxes: FloatArray) -> bool:
    """Whether boxes are two corners, and rather people so than by width and height.

    What should be widths follows the left borders where people spread over the picture. Where all are in one place,
    their shape decides: large people in the upper left could be corners, but have a person's shape as they are.
    """
    sound = (boxes[:, 2:] > boxes[:, :2]).all(axis=1)
    if sound.mean() < NEARLY_ALL:
        return False
    far = boxes[sound, 2:]
    size = far - boxes[sound, :2]
    given, meant = (np.median(np.abs(np.log(one[:, 0] / one[:, 1] / BOX_ASPECT))) for one in (far, size))
    return bool(np.var(size[:, 0]) < 0.1 * np.var(far[:, 0]) or given > 2.0 * meant + 0.5)


def _middle(boxes: FloatArray, camera: Camera, height_mean: float) -> Misfit | None:
    """Whether left and top are the middle of boxes: then all feet are half a box too low, which no tilt explains."""
    column, row, length = observations_of(boxes, camera).T
    low = (row + 0.5 * length - camera.horizon(column)) / length - camera.mount_height / height_mean
    off, tilted = (float(np.median(np.abs(low - one))) for one in (0.5, np.median(low * length) / length))
    if abs(np.median(low) - 0.5) > HALF or off > min(HALF, tilted):
        return None
    text = f"people's feet are half a box lower than a camera {camera.mount_height:g} m above the ground has them"
    return Misfit(f"{text}: are left and top the middle of boxes? Then name them u, v in a first line", False)


def _other_size(
    boxes: FloatArray, reach: FloatArray, camera: Camera, picture: tuple[float, float], height_mean: float
) -> Misfit | None:
    """Whether boxes are of a larger or smaller picture, by where they are and where they put the horizon.

    A camera at height m sees the horizon at m / h of a box above the feet of a person of height h.
    """
    column, row, length = observations_of(boxes, camera).T
    level = camera.horizon(column)
    above_feet = camera.mount_height / height_mean * length
    found, wanted = float(np.median(row + 0.5 * length - above_feet)), float(np.median(level))
    tilt = (found - wanted) / camera.focal
    if (border := _letterbox(boxes, reach, picture, found, wanted, 0.5 * TILT * camera.focal)) is not None:
        return border
    larger = found > LARGER * wanted and tilt > TILT
    smaller = found < SMALLER * wanted and tilt < -TILT and (reach < np.multiply(UNFILLED, picture)).all()
    if not (larger or smaller):
        return None
    share = " x ".join(f"{part:.0%}" for part in reach / picture)
    what = f"fill only the upper left {share} of" if smaller else "seem to be of a larger picture than"
    return Misfit(
        f"boxes {what} {picture[0]:g} x {picture[1]:g} px, and people's feet and heights put the horizon at row "
        f"{found:.0f}, the camera at row {wanted:.0f}: are width, height and pitch those of this picture?",
        False,
    )


def _letterbox(
    boxes: FloatArray, reach: FloatArray, picture: tuple[float, float], found: float, wanted: float, least: float
) -> Misfit | None:
    """Whether boxes are of a network's square picture with borders, which puts the horizon at the row ``found``.

    The camera has it at the row ``wanted``; ``least`` is how far apart these rows must be.
    """
    fits = list[tuple[float, int, FloatArray, float]]()
    for side in NETWORKS if abs(found - wanted) > least and np.isfinite(picture).all() else ():
        share = side / max(picture)
        border = 0.5 * (side - share * np.array(picture))
        inside = (reach <= 1.05 * side - border).all() and np.quantile(boxes[:, 1], 0.02) >= border[1] - 0.05 * side
        if inside and reach.max() > 0.7 * side:
            fits.append((abs(found - share * wanted - border[1]), side, border, share))
    off, side, border, share = min(fits, key=lambda one: one[0], default=(np.inf, 0, np.zeros(2), 0.0))
    if off > min(0.25 * abs(found - wanted), 0.025 * side):
        return None
    text = f"boxes seem to be of a picture of {side} x {side} px with borders, as networks see it"
    back = f"subtract {border[0]:g} from left and {border[1]:g} from top, then divide all four by {share:.4g}"
    return Misfit(f"{text}: to have px of {picture[0]:g} x {picture[1]:g}, {back}", False)


def _lower_bound(share: float, count: int) -> float:
    """Wilson's lower bound of 2 σ for a ``share`` of ``count``."""
    doubt = 4.0 / max(count, 1)
    return float((share + 0.5 * doubt - np.sqrt(doubt * (share * (1.0 - share) + 0.25 * doubt))) / (1.0 + doubt))
