"""The texts of a film: a title over the pictures, a legend under them."""

from collections.abc import Callable
from functools import partial

import numpy as np

from vbbench.pictures.film import paint
from vbbench.pictures.film.paint import Canvas, Colour
from vbbench.pictures.plotting.style import wrap
from vbbench.pictures.replay import Replay

TITLE_HEIGHT = 58
_ROW, _LINE, _TEXT, _EDGE, _GAP, _MARK = 26, 20, 14, 14, 22, 26  # px
_BAR = 80  # px that the scale of distances is wide

Mark = Callable[[Canvas, float, float], None]
"""Draws a mark of the legend, given its left column and middle row."""


def draw_title(width: int, replay: Replay, frame: int) -> Canvas:
    """What is shown, the time, and the errors of the estimate in this frame."""
    canvas, info = paint.blank(width, TITLE_HEIGHT), replay.info
    tier = info.tier if info.pixel_std == 0 else f"{info.tier} (σ = {info.pixel_std:g} px)"
    title = "  ·  ".join([replay.title, replay.camera.kind, tier])
    paint.draw_text(canvas, title, (_EDGE, 19), 18, paint.INK, bold=True)
    time = f"frame {frame} / {replay.sequence.frames - 1}    {frame * info.dt:.2f} s"
    paint.draw_text(canvas, time, (width - _EDGE, 19), 18, paint.INK, align="right")
    below = f"{replay.headline(frame)},  {int(replay.sequence.observed[frame].sum())} people seen"
    paint.draw_text(canvas, below, (_EDGE, 44), _TEXT, paint.INK)
    return canvas


def draw_legend(width: int, replay: Replay, farthest: float) -> Canvas:
    """Every mark of the film, in as many rows as needed, and the caution of its data; the same in all frames."""
    rows: list[list[tuple[Mark, str, float]]] = [[]]
    column = float(_EDGE)
    for mark, label in _entries(replay, farthest):
        need = _wide(mark) + 6 + paint.text_width(label, _TEXT) + _GAP
        if column + need - _GAP > width - _EDGE and rows[-1]:
            rows.append([])
            column = float(_EDGE)
        rows[-1].append((mark, label, column))
        column += need
    caution = f"Caution: {replay.info.caution}" if replay.info.caution else ""
    lines = wrap(caution, width - 2 * _EDGE, lambda text: paint.text_width(text, _TEXT)) if caution else []
    canvas = paint.blank(width, 14 + _ROW * len(rows) + _LINE * len(lines))
    for number, line in enumerate(lines):
        place = (_EDGE, 7.0 + _ROW * len(rows) + _LINE * (number + 0.5))
        paint.draw_text(canvas, line, place, _TEXT, paint.CAUTION)
    for number, row in enumerate(rows):
        middle = 7.0 + _ROW * (number + 0.5)
        for mark, label, left in row:
            mark(canvas, left, middle)
            paint.draw_text(canvas, label, (left + _wide(mark) + 6, middle), _TEXT, paint.INK)
    return canvas


def _entries(replay: Replay, farthest: float) -> list[tuple[Mark, str]]:
    some = paint.distance_hues(np.array([0.35]), 1.0)[0]
    entries: list[tuple[Mark, str]] = [(_scale, f"distance by the box, 0 to {farthest:g} m")]
    if replay.poses_known or replay.answer is None:
        whose = "true" if replay.poses_known else "given" if replay.truth is None else "the"
        entries.append((partial(_arrow, colour=paint.TRUTH), f"{whose} observer"))
    if replay.truth is not None:
        entries.append((partial(_line, colour=paint.TRUTH_TAIL), "true path"))
    if replay.answer is None:
        if np.isfinite(replay.known.positions).any():
            entries.append((partial(_disc, colour=some, rim=paint.TRUTH), "person"))
    else:
        if replay.places_known:
            entries.append((partial(_disc, colour=paint.WHITE, rim=paint.TRUTH), "true place"))
        entries.append((partial(_arrow, colour=paint.ESTIMATE), "estimated observer"))
        entries.append((partial(_disc, colour=some, rim=some), "estimated place"))
        if replay.truth is not None:
            entries.append((partial(_line, colour=paint.INK), "error"))
    if replay.bystanders[1].size:
        entries.append((partial(_disc, colour=paint.WHITE, rim=paint.UNSEEN, radius=3.5), "present, without a box"))
    if replay.false_alarms.any():
        entries.append((_false_alarm, "no true place known" if replay.is_footage else "false alarm"))
    if replay.camera.view is not None:
        entries.append((_wedge, "field of view"))
    return entries


def _disc(canvas: Canvas, left: float, row: float, *, colour: Colour, rim: Colour, radius: float = 6.0) -> None:
    paint.draw_disc(canvas, (left + _MARK / 2, row), radius, colour, rim)


def _line(canvas: Canvas, left: float, row: float, *, colour: Colour) -> None:
    paint.draw_lines(canvas, np.array([[(left, row), (left + _MARK, row)]]), colour, 2)


def _arrow(canvas: Canvas, left: float, row: float, *, colour: Colour) -> None:
    paint.draw_arrow(canvas, np.array([left + 6.0, row]), np.array([left + _MARK, row]), colour)


def _false_alarm(canvas: Canvas, left: float, row: float) -> None:
    paint.draw_box(canvas, np.array([left + 9.0, row - 9.0, 8.0, 18.0]), paint.CAUTION, 2)


def _wedge(canvas: Canvas, left: float, row: float) -> None:
    corners = np.array([(left + 3.0, row + 8.0), (left + 23.0, row + 8.0), (left + 13.0, row - 8.0)])
    paint.draw_polygon(canvas, corners, paint.FIELD)
    paint.draw_path(canvas, np.vstack([corners, corners[:1]]), paint.FIELD_EDGE)


def _scale(canvas: Canvas, left: float, row: float) -> None:
    x, y = round(left), round(row)
    canvas[y - 6 : y + 7, x : x + _BAR] = paint.distance_hues(np.arange(_BAR, dtype=np.float64), _BAR - 1.0)


def _wide(mark: Mark) -> int:
    return _BAR if mark is _scale else _MARK
