"""Frames of a film: the observer's view and the map, a title above and a legend below."""

from collections.abc import Iterable, Iterator

import numpy as np

from vbbench.boxes import rectangles, with_seam_copies
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.film import paint
from vbbench.pictures.film.bird import BirdsEyeView
from vbbench.pictures.film.captions import TITLE_HEIGHT, draw_legend, draw_title
from vbbench.pictures.film.paint import Canvas, Colour
from vbbench.pictures.rendering import Renderer
from vbbench.pictures.replay import Replay

_LABEL = 13  # px
_ROW = 15  # px from one line of labels to the next
_ROWS = 5  # lines over a head in which a free place is sought


def draw_ego(picture: Canvas, replay: Replay, frame: int, colours: list[Colour]) -> Canvas:
    """The picture with boxes in the people's ``colours`` [K] and their ids; false alarms are marked as such.

    Boxes have no fill, and small ones lie on top, so that no box hides another. A box that crosses the seam of a
    panorama is drawn at both ends.
    """
    canvas, camera = np.array(picture), replay.camera
    seen, observations = replay.sequence.observed[frame], replay.sequence.observations[frame]
    near_to_far = np.flatnonzero(seen)[np.argsort(-observations[seen, 2])]
    boxes = rectangles(observations)
    for box, order in zip(*with_seam_copies(boxes[near_to_far], camera.period), strict=True):
        track = near_to_far[order]
        colour = paint.CAUTION if replay.false_alarms[frame, track] else colours[track]
        thin = box[3] < 60.0
        paint.draw_box(canvas, box, paint.contrast(colour), 2 if thin else 4)
        paint.draw_box(canvas, box, colour, 1 if thin else 2)
    _draw_labels(canvas, boxes, replay, near_to_far)
    for text, column in replay.bearings.items():
        if text != "behind":
            place = (column, 0.8 * _ROW)
            paint.draw_text(canvas, text, place, _LABEL, paint.WHITE, halo=paint.INK, align="centre")
    return canvas


def _draw_labels(canvas: Canvas, boxes: FloatArray, replay: Replay, order: IntArray) -> None:
    """Ids over the heads, the nearest person's first; one that finds no free place within five lines is left out."""
    height, width = canvas.shape[:2]
    taken: list[tuple[float, float, float]] = []
    texts: list[str] = []
    leaders: list[FloatArray] = []
    for track in order:
        text = str(replay.sequence.tracks[track])
        half = 0.5 * paint.text_width(text, _LABEL, bold=True) + 1.0
        column = float(np.clip(boxes[track, 0] + 0.5 * boxes[track, 2], half + 2, width - half - 2))
        head = float(np.clip(boxes[track, 1], 2 * _ROW, height - 2))
        rows = [head - 0.6 * _ROW - _ROW * n for n in range(_ROWS)]
        free = [row for row in rows if row > 0.5 * _ROW and _is_free(column, row, half, taken)]
        if not free:
            continue
        taken.append((column, free[0], half))
        texts.append(text)
        if free[0] != rows[0]:
            leaders.append(np.array([(column, free[0] + 0.5 * _ROW), (column, head)]))
    paint.draw_lines(canvas, np.array(leaders).reshape(-1, 2, 2), paint.WHITE)
    for text, (column, row, _) in zip(texts, taken, strict=True):
        paint.draw_text(canvas, text, (column, row), _LABEL, paint.WHITE, halo=paint.INK, bold=True, align="centre")


def _is_free(column: float, row: float, half: float, taken: list[tuple[float, float, float]]) -> bool:
    return all(abs(row - r) >= _ROW or abs(column - c) >= half + h for c, r, h in taken)


_MAP = 560  # px, least height of a map
_LEAST_WIDTH = 960  # px, for the words
_FARTHEST = 30.0  # m up to which colours show distances


class Film:
    """The frames of a sequence as pictures of one size; none is kept in memory.

    A picture with borders has the map beside it, a panorama below it.

    Parameters
    ----------
    replay : what to show, with its truth.
    """

    def __init__(self, replay: Replay) -> None:
        self.replay = replay
        self.farthest = float(np.clip(np.ceil(np.nanmax(replay.distances, initial=1.0)), 1.0, _FARTHEST))
        """Distance in m at the light end of the colours."""
        width, height = replay.camera.picture_size
        self._beside = replay.camera.period is None
        if self._beside:
            middle = max(height, _MAP)
            self.bird = BirdsEyeView(replay, self.farthest, max(middle, _LEAST_WIDTH - width), middle)
            self.width = width + self.bird.width
        else:
            self.width = max(width, _LEAST_WIDTH)
            self.bird = BirdsEyeView(replay, self.farthest, self.width, _MAP)
            middle = height + _MAP
        self.width += self.width % 2  # codecs take pairs of columns and rows
        self._legend = draw_legend(self.width, replay, self.farthest)
        self.height = TITLE_HEIGHT + middle + len(self._legend)
        self.height += self.height % 2

    def frames(self, renderer: Renderer, wanted: Iterable[int]) -> Iterator[Canvas]:
        """Pictures [height, width, 3] of the wanted frames of the sequence, each made when it is needed."""
        sequence, replay = self.replay.sequence, self.replay
        for frame in wanted:
            pose = replay.known.poses[frame]
            seen = renderer.render(sequence.first_frame + frame, replay.camera, pose, observer=sequence.observer)
            yield self._compose(seen.rgb, frame)

    def _compose(self, picture: Canvas, frame: int) -> Canvas:
        colours = paint.distance_hues(self.replay.distances[frame], self.farthest)
        ego, bird = draw_ego(picture, self.replay, frame, colours), self.bird.draw(frame, colours)
        canvas = paint.blank(self.width, self.height)
        canvas[:TITLE_HEIGHT] = draw_title(self.width, self.replay, frame)
        rows, columns = ego.shape[:2]
        canvas[TITLE_HEIGHT : TITLE_HEIGHT + rows, :columns] = ego
        top, left = (TITLE_HEIGHT, columns) if self._beside else (TITLE_HEIGHT + rows, 0)
        bottom = top + self.bird.height
        canvas[top:bottom, left : left + self.bird.width] = bird
        canvas[bottom : bottom + len(self._legend)] = self._legend
        return canvas
