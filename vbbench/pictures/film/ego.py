"""The ego view of a film: the rendered picture with everybody's box and id."""

import numpy as np

from vbbench.boxes import rectangles, with_seam_copies
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.film import paint
from vbbench.pictures.film.paint import Canvas, Colour
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
