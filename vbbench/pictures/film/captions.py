"""The words of a film: a title over the pictures, a legend under them."""

import textwrap
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.pictures.film import hues, paint
from vbbench.pictures.film.paint import Canvas, Colour
from vbbench.pictures.film.reel import Reel
from vbbench.pictures.plotting.moment import Moment
from vbbench.scoring.metrics import METRICS

TITLE_HEIGHT = 58
_ROW, _TEXT, _EDGE, _GAP, _MARK = 26, 14, 14, 22, 26  # px
_BAR = 80  # px that the scale of distances is wide

Mark = Callable[[Canvas, float, float], None]
"""Draws a mark of the legend from a column on around a row."""


def draw_title(width: int, moment: Moment) -> Canvas:
    """What is shown, the time, and how far the estimate is off in this frame."""
    canvas, info = paint.blank(width, TITLE_HEIGHT), moment.info
    tier = info.tier if info.pixel_std == 0 else f"{info.tier} (σ = {info.pixel_std:g} px)"
    title = "  ·  ".join([info.split, f"sequence {moment.sequence.index}", info.camera.kind, tier])
    paint.draw_text(canvas, title, (_EDGE, 19), 18, hues.INK, bold=True)
    time = f"frame {moment.frame} / {moment.sequence.frames - 1}    {moment.frame * info.dt:.2f} s"
    paint.draw_text(canvas, time, (width - _EDGE, 19), 18, hues.INK, align="right")
    below = result_line(moment)
    paint.draw_text(canvas, below, (_EDGE, 44), _TEXT, hues.INK)
    room = width - 3 * _EDGE - paint.text_width(below, _TEXT)
    if info.caution:
        text = textwrap.shorten(f"Caution: {info.caution.split('. ')[0]}", max(12, room // 9), placeholder=" …")
        paint.draw_text(canvas, text, (width - _EDGE, 44), 13, hues.CAUTION, align="right")
    return canvas


def result_line(moment: Moment) -> str:
    """Solver, protocol and this frame's errors."""
    people = f"{int(moment.observed.sum())} people seen"
    if moment.estimate is None:
        return f"truth,  {people}"
    errors = moment.errors if moment.frame > 1 else {}
    figures = [f"{METRICS[name].symbol} = {value:.3f} {METRICS[name].unit}" for name, value in errors.items()]
    return ",  ".join([f"{moment.solver or 'estimate'} ({moment.protocol.name})", *(figures or ["given"]), people])


@dataclass(frozen=True)
class Legend:
    """Every mark of the film, in as many rows as it takes; it is the same in all frames."""

    canvas: Canvas

    @staticmethod
    def of(reel: Reel, width: int) -> "Legend":
        """The legend of a film ``width`` px wide."""
        rows: list[list[tuple[Mark, str, float]]] = [[]]
        column = float(_EDGE)
        for mark, label in _entries(reel):
            need = _wide(mark) + 6 + paint.text_width(label, _TEXT) + _GAP
            if column + need - _GAP > width - _EDGE and rows[-1]:
                rows.append([])
                column = float(_EDGE)
            rows[-1].append((mark, label, column))
            column += need
        canvas = paint.blank(width, 14 + _ROW * len(rows))
        for number, row in enumerate(rows):
            middle = 7.0 + _ROW * (number + 0.5)
            for mark, label, left in row:
                mark(canvas, left, middle)
                paint.draw_text(canvas, label, (left + _wide(mark) + 6, middle), _TEXT, hues.INK)
        return Legend(canvas)


def _entries(reel: Reel) -> list[tuple[Mark, str]]:
    some = hues.distance_hues(np.array([0.35]), 1.0)[0]
    entries: list[tuple[Mark, str]] = [(_scale, f"distance told by the box, 0 to {reel.farthest:g} m")]
    entries += [(_arrow(hues.TRUTH), "true observer"), (_line(hues.TRUTH_TAIL), "true path")]
    if reel.estimate is None:
        entries.append((_disc(some, hues.TRUTH), "person"))
    else:
        entries += [
            (_disc(hues.WHITE, hues.TRUTH), "true place"),
            (_arrow(hues.ESTIMATE), "estimated observer"),
            (_disc(some, some), "estimated place"),
            (_line(hues.INK), "error"),
        ]
    entries.append((_disc(hues.WHITE, hues.UNSEEN, 3.5), "there, without a box"))
    if np.isnan(reel.truth.positions[reel.sequence.observed]).any():
        entries.append((_box(hues.CAUTION), "false alarm"))
    if isinstance(reel.dataset.info.camera, PerspectiveCamera):
        entries.append((_wedge, "field of view"))
    return entries


def _disc(colour: Colour, rim: Colour, radius: float = 6.0) -> Mark:
    def draw(canvas: Canvas, left: float, row: float) -> None:
        paint.draw_disc(canvas, (left + _MARK / 2, row), radius, colour, rim)

    return draw


def _line(colour: Colour) -> Mark:
    def draw(canvas: Canvas, left: float, row: float) -> None:
        paint.draw_lines(canvas, np.array([[(left, row), (left + _MARK, row)]]), colour, 2)

    return draw


def _arrow(colour: Colour) -> Mark:
    def draw(canvas: Canvas, left: float, row: float) -> None:
        paint.draw_arrow(canvas, np.array([left + 6.0, row]), np.array([left + _MARK, row]), colour)

    return draw


def _box(colour: Colour) -> Mark:
    def draw(canvas: Canvas, left: float, row: float) -> None:
        paint.draw_box(canvas, np.array([left + 9.0, row - 9.0, 8.0, 18.0]), colour, 2)

    return draw


def _wedge(canvas: Canvas, left: float, row: float) -> None:
    corners = np.array([(left + 3.0, row + 8.0), (left + 23.0, row + 8.0), (left + 13.0, row - 8.0)])
    paint.draw_polygon(canvas, corners, hues.FIELD)
    paint.draw_path(canvas, np.vstack([corners, corners[:1]]), hues.FIELD_EDGE)


def _scale(canvas: Canvas, left: float, row: float) -> None:
    x, y = round(left), round(row)
    canvas[y - 6 : y + 7, x : x + _BAR] = hues.distance_hues(np.arange(_BAR, dtype=np.float64), _BAR - 1.0)


def _wide(mark: Mark) -> int:
    return _BAR if mark is _scale else _MARK
