"""Films of a sequence: the observer's view and the map, a title above and a legend below."""

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Protocol

import numpy as np

from vbbench.boxes import rectangles, with_seam_copies
from vbbench.camera import Camera
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.film import paint
from vbbench.pictures.film.bird import BirdsEyeView
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
    paint.draw_text(canvas, replay.heading(), (_EDGE, 19), 18, paint.INK, bold=True)
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
    room = width - 2 * _EDGE
    lines = [line for text in replay.cautions for line in wrap(text, room, partial(paint.text_width, size=_TEXT))]
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


_LABEL = 13  # px
_LABEL_ROW = 15  # px from one line of labels to the next
_ROWS = 5  # lines over a head in which a free place is sought


class View(Protocol):
    """Makes the pictures of what the observer sees, all of one size."""

    @property
    def width(self) -> int:
        """In px."""

    @property
    def height(self) -> int:
        """In px."""

    @property
    def zoom(self) -> float:
        """Pixels of a picture for a pixel of the camera."""

    @property
    def corner(self) -> tuple[float, float]:
        """Column and row of the camera's picture at its upper left corner."""

    def picture(self, frame: int) -> Canvas:
        """[height, width, 3] of a frame of the sequence; the caller may draw on it."""


def draw_ego(canvas: Canvas, replay: Replay, frame: int, colours: list[Colour], view: View) -> None:
    """Draw boxes in the people's ``colours`` [K] and their ids on a view's picture; false alarms are marked as such.

    Boxes have no fill, and small ones lie on top, so that no box hides another. A box that crosses the seam of a
    panorama is drawn at both ends.
    """
    camera, zoom = replay.camera, view.zoom
    seen, observations = replay.sequence.observed[frame], replay.sequence.observations[frame]
    observations = zoom * (observations - (*view.corner, 0.0))
    near_to_far = np.flatnonzero(seen)[np.argsort(-observations[seen, 2])]
    boxes, period = rectangles(observations), camera.period and camera.period * zoom
    for box, order in zip(*with_seam_copies(boxes[near_to_far], period), strict=True):
        track = near_to_far[order]
        colour = paint.CAUTION if replay.false_alarms[frame, track] else colours[track]
        thin = box[3] < 60.0
        paint.draw_box(canvas, box, paint.contrast(colour), 2 if thin else 4)
        paint.draw_box(canvas, box, colour, 1 if thin else 2)
    _draw_labels(canvas, boxes, replay, near_to_far)
    for text, column in replay.bearings.items():
        if text != "behind":
            place = (column * zoom, 0.8 * _LABEL_ROW)
            paint.draw_text(canvas, text, place, _LABEL, paint.WHITE, halo=paint.INK, align="centre")


def _draw_labels(canvas: Canvas, boxes: FloatArray, replay: Replay, order: IntArray) -> None:
    """Ids over the heads, the nearest person's first; one that finds no free place within five lines is omitted."""
    height, width = canvas.shape[:2]
    taken: list[tuple[float, float, float]] = []
    texts: list[str] = []
    leaders: list[FloatArray] = []
    for track in order:
        text = str(replay.sequence.tracks[track])
        half = 0.5 * paint.text_width(text, _LABEL, bold=True) + 1.0
        column = float(np.clip(boxes[track, 0] + 0.5 * boxes[track, 2], half + 2, width - half - 2))
        head = float(np.clip(boxes[track, 1], 2 * _LABEL_ROW, height - 2))
        rows = [head - 0.6 * _LABEL_ROW - _LABEL_ROW * n for n in range(_ROWS)]
        free = [row for row in rows if row > 0.5 * _LABEL_ROW and _is_free(column, row, half, taken)]
        if not free:
            continue
        taken.append((column, free[0], half))
        texts.append(text)
        if free[0] != rows[0]:
            leaders.append(np.array([(column, free[0] + 0.5 * _LABEL_ROW), (column, head)]))
    for colour, wide in ((paint.INK, 3), (paint.WHITE, 1)):
        paint.draw_lines(canvas, np.array(leaders).reshape(-1, 2, 2), colour, wide)
    for text, (column, row, _) in zip(texts, taken, strict=True):
        paint.draw_text(canvas, text, (column, row), _LABEL, paint.WHITE, halo=paint.INK, bold=True, align="centre")


def _is_free(column: float, row: float, half: float, taken: list[tuple[float, float, float]]) -> bool:
    return all(abs(row - r) >= _LABEL_ROW or abs(column - c) >= half + h for c, r, h in taken)


_MAP = 560  # px, least height of a map
_LEAST_WIDTH = 960  # px, for the words
_FARTHEST = 30.0  # m up to which colours show distances
_WIDE = 2.0
"""Width over height of a picture from which on the map is below it."""


def is_wide(camera: Camera) -> bool:
    """Whether the map goes below a camera's picture, and not next to it."""
    width, height = camera.picture_size
    return camera.period is not None or width >= _WIDE * height


class Film:
    """The frames of a sequence as pictures of one size; none is kept in memory.

    A picture with borders has the map next to it; a panorama or another wide picture has it below.

    Parameters
    ----------
    replay : what to show.
    view : what the observer sees.
    """

    def __init__(self, replay: Replay, view: View) -> None:
        self.replay, self.view = replay, view
        self.farthest = float(np.clip(np.ceil(np.nanmax(replay.distances, initial=1.0)), 1.0, _FARTHEST))
        """Distance in m at the light end of the colours."""
        self._abreast = not is_wide(replay.camera)
        if self._abreast:
            middle = max(view.height, _MAP)
            self.bird = BirdsEyeView(replay, self.farthest, max(middle, _LEAST_WIDTH - view.width), middle)
            self.width = view.width + self.bird.width
        else:
            self.width = max(view.width, _LEAST_WIDTH)
            self.bird = BirdsEyeView(replay, self.farthest, self.width, _MAP)
            middle = view.height + _MAP
        self.width += self.width % 2  # codecs take pairs of columns and rows
        self._legend = draw_legend(self.width, replay, self.farthest)
        self.height = TITLE_HEIGHT + middle + len(self._legend)
        self.height += self.height % 2

    def frames(self, wanted: Iterable[int]) -> Iterator[Canvas]:
        """Pictures [height, width, 3] of the wanted frames of the sequence, each made when it is needed."""
        return map(self._compose, wanted)

    def _compose(self, frame: int) -> Canvas:
        colours = paint.distance_hues(self.replay.distances[frame], self.farthest)
        ego, bird = self.view.picture(frame), self.bird.draw(frame, colours)
        draw_ego(ego, self.replay, frame, colours, self.view)
        canvas = paint.blank(self.width, self.height)
        canvas[:TITLE_HEIGHT] = draw_title(self.width, self.replay, frame)
        rows, columns = ego.shape[:2]
        canvas[TITLE_HEIGHT : TITLE_HEIGHT + rows, :columns] = ego
        top, left = (TITLE_HEIGHT, columns) if self._abreast else (TITLE_HEIGHT + rows, 0)
        bottom = top + self.bird.height
        canvas[top:bottom, left : left + self.bird.width] = bird
        canvas[bottom : bottom + len(self._legend)] = self._legend
        return canvas
