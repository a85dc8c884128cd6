"""Colours, and antialiased marks and texts on a picture in memory: drawn a few hundred times per frame of a film."""

from functools import cache, lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import needs_extra
from vbbench.geometry import FloatArray
from vbbench.pictures.plotting import style

with needs_extra("render", "drawing films"):
    import cv2

Canvas = NDArray[np.uint8]
"""[H, W, 3] uint8 sRGB, row 0 at the top; drawn on in place."""
Colour = tuple[int, int, int]
Point = tuple[float, float] | FloatArray
"""Column and row in px, 0 in the middle of the first pixel."""

_BITS = 4  # of a pixel's fraction in OpenCV's coordinates
_WORDS = 4096  # texts whose masks are kept
_HALO = 2  # px around outlined text


def blank(width: int, height: int) -> Canvas:
    """A white picture."""
    return np.full((height, width, 3), 255, dtype=np.uint8)


def rgb(name: str) -> Colour:
    """The colour that ``#rrggbb`` names."""
    red, green, blue = bytes.fromhex(name.removeprefix("#"))
    return red, green, blue


INK, WHITE = rgb(style.INK), (255, 255, 255)
TRUTH, TRUTH_FAINT, TRUTH_TAIL = rgb(style.TRUTH), rgb(style.TRUTH_FAINT), rgb(style.TRUTH_TAIL)
ESTIMATE, CAUTION, GRID = rgb(style.ESTIMATE), rgb(style.CAUTION), rgb(style.FAINT)
UNSEEN, FIELD, FIELD_EDGE = rgb(style.UNSEEN), rgb(style.FIELD), rgb(style.FIELD_EDGE)


def draw_lines(canvas: Canvas, ends: FloatArray, colour: Colour, width: int = 1) -> None:
    """Draw segments [N, 2, 2] of (column, row); those with a NaN end are omitted."""
    whole = ends[np.isfinite(ends).all(axis=(1, 2))]
    if len(whole):
        cv2.polylines(canvas, list(_fixed(whole)), False, colour, width, cv2.LINE_AA, _BITS)


def draw_path(canvas: Canvas, points: FloatArray, colour: Colour, width: int = 1) -> None:
    """Draw the lines through points [T, 2], interrupted where one is NaN."""
    draw_lines(canvas, np.stack([points[:-1], points[1:]], axis=1), colour, width)


def draw_polygon(canvas: Canvas, points: FloatArray, colour: Colour) -> None:
    """Fill the polygon with corners [N, 2]."""
    corners = _fixed(points)
    if cv2.isContourConvex(corners):
        cv2.fillConvexPoly(canvas, corners, colour, cv2.LINE_AA, _BITS)
    else:
        cv2.fillPoly(canvas, [corners], colour, cv2.LINE_AA, _BITS)


def draw_disc(canvas: Canvas, centre: Point, radius: float, colour: Colour, rim: Colour | None = None) -> None:
    """Draw a disc, with a rim 1 px wide if that has a colour."""
    place, size = _fixed(centre).tolist(), round(radius * (1 << _BITS))
    cv2.circle(canvas, place, size, colour, -1, cv2.LINE_AA, _BITS)
    if rim is not None:
        cv2.circle(canvas, place, size, rim, 1, cv2.LINE_AA, _BITS)


def draw_box(canvas: Canvas, box: FloatArray, colour: Colour, width: int) -> None:
    """Outline a box (left, top, width, height), lines ``width`` px wide."""
    corners = _fixed(np.stack([box[:2], box[:2] + box[2:]]))
    cv2.rectangle(canvas, corners[0].tolist(), corners[1].tolist(), colour, width, cv2.LINE_AA, _BITS)


def draw_text(
    canvas: Canvas,
    text: str,
    at: Point,
    size: int,
    colour: Colour,
    *,
    halo: Colour | None = None,
    bold: bool = False,
    align: Literal["left", "centre", "right"] = "left",
) -> None:
    """Write a line of text whose middle row is at ``at``, which is its left end, centre or right end."""
    fill, outline = _text_masks(text, size, bold, halo is not None)
    height, width = fill.shape
    shift = {"left": _HALO, "centre": width / 2.0, "right": width - _HALO}[align]
    left, top = round(float(at[0]) - shift), round(float(at[1]) - height / 2.0)
    if halo is not None:
        _blend(canvas, outline, left, top, halo)
    _blend(canvas, fill, left, top, colour)


def text_width(text: str, size: int, *, bold: bool = False) -> int:
    """Width of a text in px."""
    return int(_text_masks(text, size, bold, False)[0].shape[1]) - 2 * _HALO


def draw_arrow(canvas: Canvas, tail: FloatArray, tip: FloatArray, colour: Colour) -> None:
    """Draw an arrow with the observer's place marked at its tail."""
    along = (tip - tail) / max(float(np.hypot(*(tip - tail))), 1e-9)
    across = np.array([-along[1], along[0]])
    draw_lines(canvas, np.stack([tail, tip - 6.0 * along])[None], colour, 3)
    draw_polygon(canvas, np.stack([tip, tip - 11.0 * along + 5.5 * across, tip - 11.0 * along - 5.5 * across]), colour)
    draw_disc(canvas, tail, 6.5, colour, (255, 255, 255))


def distance_hues(distances: FloatArray, farthest: float) -> list[Colour]:
    """Colours of people at distances [K] in m, from dark near to light at ``farthest``; ink where NaN."""
    place = np.clip(np.asarray(distances) / farthest, 0.0, 1.0)
    steps = np.where(np.isnan(place), 0.0, np.round(255.0 * place)).astype(int)
    return [INK if np.isnan(p) else _ramp()[step] for p, step in zip(place, steps, strict=True)]


def contrast(colour: Colour) -> Colour:
    """White or ink, whichever shows next to ``colour`` (luminance as in Rec. 601)."""
    red, green, blue = colour
    return WHITE if 0.299 * red + 0.587 * green + 0.114 * blue < 140.0 else INK


def _fixed(points: Any) -> NDArray[np.int32]:
    """Coordinates as OpenCV's fixed-point numbers, clipped far outside the picture."""
    return np.asarray(np.round(np.clip(points, -3e4, 3e4) * (1 << _BITS)), dtype=np.int32)


def _blend(canvas: Canvas, mask: Canvas, left: int, top: int, colour: Colour) -> None:
    """Mix ``colour`` into the canvas where ``mask`` [h, w] covers it; parts outside are cut off."""
    right, bottom = min(left + mask.shape[1], canvas.shape[1]), min(top + mask.shape[0], canvas.shape[0])
    x, y = max(left, 0), max(top, 0)
    if x >= right or y >= bottom:
        return
    cover = mask[y - top : bottom - top, x - left : right - left, None].astype(np.uint16)
    under = canvas[y:bottom, x:right]
    under[:] = (under * (255 - cover) + np.array(colour, np.uint16) * cover + 127) // 255


@lru_cache(maxsize=_WORDS)
def _text_masks(text: str, size: int, bold: bool, outlined: bool) -> tuple[Canvas, Canvas]:
    """Coverage [h, w] of the text and of its outline; every text of a size has the same height."""
    from PIL import Image, ImageDraw

    font = _font(size, bold)
    width, (ascent, descent) = int(np.ceil(font.getlength(text))) + 2 * _HALO, font.getmetrics()
    masks = []
    for stroke in (0, _HALO if outlined else 0):
        picture = Image.new("L", (width, ascent + descent + 2 * _HALO))
        ImageDraw.Draw(picture).text((_HALO, _HALO), text, fill=255, font=font, stroke_width=stroke)
        masks.append(np.asarray(picture))
    return masks[0], masks[1]


@cache
def _font(size: int, bold: bool) -> Any:
    """The typeface of the plots, which comes with Matplotlib."""
    from matplotlib import get_data_path
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(Path(get_data_path(), "fonts", "ttf", name), size)


@cache
def _ramp() -> list[Colour]:
    colours = style.distance_colours()(np.linspace(0.0, 1.0, 256))[:, :3]
    return [(int(r), int(g), int(b)) for r, g, b in np.round(255.0 * colours)]
