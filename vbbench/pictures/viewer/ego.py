"""What the observer sees: boxes, and the rendered picture, depth and ids where they are asked for."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from vbbench.boxes import rectangles
from vbbench.camera import PerspectiveCamera
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.renderer import NOBODY, Picture
from vbbench.pictures.viewer import palette
from vbbench.pictures.viewer.take import Take
from vbbench.pictures.viewer.tape import Tape
from vbbench.pictures.viewer.world import CAMERA

QUALITY = 90
"""Of the JPEG pictures, in percent."""
CENTIMETRES = 100.0
"""Units of the depth pictures in a metre; 16 bits reach 655 m."""


def ego_root(take: Take) -> str:
    """Where the picture hangs: on a pinhole camera whose pose is known, else in a plane of its own."""
    pinhole = isinstance(take.dataset.info.camera, PerspectiveCamera)
    return CAMERA if pinhole and take.truth is not None else "ego"


def record_boxes(tape: Tape, take: Take) -> None:
    """Record everybody's box in their colour, false alarms in red; at both ends where it crosses a panorama's seam."""
    root, sequence, camera = ego_root(take), take.sequence, take.dataset.info.camera
    frame, track = np.nonzero(sequence.observed)
    boxes = rectangles(sequence.observations[frame, track])
    colours = palette.id_colours(sequence.tracks)[track]
    colours[take.false_alarms[frame, track]] = palette.ALARM
    boxes, row = _with_seam(boxes, camera.period)
    order = np.argsort(frame[row], kind="stable")
    boxes, row = boxes[order], row[order]
    tape.many(
        f"{root}/boxes",
        tape.rr.Boxes2D,
        np.bincount(frame[row], minlength=sequence.frames),
        centers=boxes[:, :2] + 0.5 * boxes[:, 2:],
        half_sizes=0.5 * boxes[:, 2:],
        colors=colours[row],
        labels=sequence.tracks[track[row]].astype(str),
    )
    _record_frame(tape, take, root)


def record_pictures(tape: Tape, take: Take, people: IntArray, pictures: Iterable[Picture]) -> None:
    """Record rendered pictures, one a frame; an id's number among the ``people`` [N], from 1, is its class."""
    rr, root = tape.rr, ego_root(take)
    colours = palette.id_colours(people).tolist()
    classes = [(n, str(person), colour) for n, (person, colour) in enumerate(zip(people, colours, strict=True), 1)]
    tape.always(root, rr.AnnotationContext([(0, "nobody", (0, 0, 0, 0)), *classes]))
    for frame, picture in enumerate(pictures):
        centimetres = np.where(np.isfinite(picture.depth), picture.depth * CENTIMETRES, 0.0).clip(0, 65535)
        ids = np.where(picture.ids == NOBODY, 0, np.searchsorted(people, picture.ids) + 1)
        tape.now(frame, f"{root}/picture", rr.Image(picture.rgb).compress(jpeg_quality=QUALITY))
        tape.now(frame, f"{root}/depth", rr.DepthImage(centimetres.astype(np.uint16), meter=CENTIMETRES))
        tape.now(frame, f"{root}/ids", rr.SegmentationImage(ids.astype(np.uint16)))


def _with_seam(boxes: FloatArray, period: float | None) -> tuple[FloatArray, IntArray]:
    """Boxes [N, 4], and again a turn further those that cross the seam; and which box each of them is."""
    rows = np.arange(len(boxes))
    if period is None:
        return boxes, rows
    left, right = boxes[:, 0] < 0.0, boxes[:, 0] + boxes[:, 2] > period
    shift = np.array([period, 0.0, 0.0, 0.0])
    return np.concatenate([boxes, boxes[left] + shift, boxes[right] - shift]), np.concatenate(
        [rows, rows[left], rows[right]]
    )


def _thin(rr: Any) -> Any:
    """Lines of one pixel of the screen."""
    return rr.Radius.ui_points(0.5)


def _record_frame(tape: Tape, take: Take, root: str) -> None:
    """The picture's border, and in a panorama the horizon and where its columns look."""
    rr, camera = tape.rr, take.dataset.info.camera
    width, height = camera.picture_size
    border = rr.Boxes2D(mins=[(0, 0)], sizes=[(width, height)], colors=[palette.FRAME], radii=_thin(rr))
    tape.always(f"{root}/border", border)
    if camera.period is not None:
        horizon = rr.LineStrips2D([[(0, height / 2), (width, height / 2)]], colors=[palette.FRAME], radii=_thin(rr))
        tape.always(f"{root}/horizon", horizon)
        places = [(width * quarter / 4, 0.04 * height) for quarter in (1, 2, 3)]
        words = ["left 90°", "ahead", "right 90°"]
        tape.always(f"{root}/directions", rr.Points2D(places, labels=words, colors=[palette.TRUTH] * 3, radii=2.0))
