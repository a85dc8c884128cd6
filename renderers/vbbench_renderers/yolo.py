"""A detector of your own: an ONNX network in the manner of YOLO, run by OpenCV on the processor."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench.boxes import suppress
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.detection import Detections
from vbbench.geometry import FloatArray
from vbbench_renderers.onnx_header import OnnxHeader, read_onnx_header

SIDE = 640
"""px of the pictures of a network that takes any size."""
LEAST_SCORE = 0.1
"""Detections with a lower score are not reported; a tracker uses doubtful ones."""
SAME = 0.6
"""Of two boxes that overlap by more than this (intersection over union), only the better is kept."""
MOST_BOXES = 1000
"""Of a picture, before boxes about the same person are removed."""
GREY = 114
"""Of the margins beside a picture that is not as wide as high: what such networks are trained with."""
PEOPLE = ("person", "pedestrian", "people")
"""Names of the class; class 0 if the file names none, as in COCO."""
_FEWEST_BOXES = 100
_TOLD = "wanted: [1, N, 5 + classes] of YOLOv5, or [1, 4 + classes, N] of YOLOv8 and 11, without suppression at its end"


@dataclass(frozen=True, kw_only=True)
class Letterbox:
    """How a picture lies in the network's: scaled, in the middle of grey margins.

    Parameters
    ----------
    scale : px of the network per px of the picture.
    left, top : margins in px of the network.
    """

    scale: float
    left: int
    top: int

    def to_picture(self, boxes: FloatArray) -> FloatArray:
        """Boxes [N, 4] (centre column, centre row, width, height) of the network as (left, top, width, height)."""
        corners = boxes[:, :2] - 0.5 * boxes[:, 2:] - [self.left, self.top]
        return np.concatenate([corners, boxes[:, 2:]], axis=1) / self.scale


class YoloDetector:
    """Finds people with the network of a file.

    Parameters
    ----------
    weights : an ONNX file whose output is that of YOLOv5 or of YOLOv8.

    Raises
    ------
    VbbenchError
        If no file is named, or it is not such a network.
    """

    def __init__(self, weights: Path | None = None) -> None:
        import cv2

        if weights is None:
            raise VbbenchError("detector yolo needs your network: --weights FILE.onnx, or --detector FILE.onnx")
        header = read_onnx_header(weights)
        self._path, self._size, self._person = weights, _input_size(weights, header), _person_class(weights, header)
        try:
            self._net = cv2.dnn.readNetFromONNX(str(weights))
        except cv2.error as error:
            raise FileError(weights, f"OpenCV cannot read this network: {_reason(error)}") from None

    def detect(self, rgb: NDArray[np.uint8], period: float | None = None) -> Detections:
        """See `vbbench.exchange.detection.Detector`; a panorama is continued beyond its seam."""
        if period is not None:
            rgb = np.concatenate([rgb, rgb[:, : rgb.shape[1] // 6]], axis=1)
        picture, letterbox = letterboxed(rgb, self._size)
        boxes, scores = read_output(self._path, self._forward(picture), self._person)
        likely = np.argsort(-scores, kind="stable")[:MOST_BOXES]
        likely = likely[(scores[likely] >= LEAST_SCORE) & (boxes[likely, 2:] > 0.0).all(axis=1)]
        boxes, scores = letterbox.to_picture(boxes[likely]), scores[likely]
        kept = suppress(boxes, scores, SAME, period)
        return Detections(boxes=boxes[kept], scores=scores[kept])

    def _forward(self, picture: NDArray[np.uint8]) -> FloatArray:
        import cv2

        try:
            self._net.setInput(cv2.dnn.blobFromImage(picture, 1.0 / 255.0))
            outputs = self._net.forward(self._net.getUnconnectedOutLayersNames())
        except cv2.error as error:
            size = f"{self._size[0]} x {self._size[1]} px"
            raise FileError(self._path, f"OpenCV cannot run this network on {size}: {_reason(error)}") from None
        return np.asarray(outputs[0], np.float64)


def letterboxed(rgb: NDArray[np.uint8], size: tuple[int, int]) -> tuple[NDArray[np.uint8], Letterbox]:
    """A picture [H, W, 3] in one of ``size`` (width, height), and how it lies there."""
    import cv2

    height, width = rgb.shape[:2]
    scale = min(size[0] / width, size[1] / height)
    inner = (min(size[0], round(width * scale)), min(size[1], round(height * scale)))
    left, top = (size[0] - inner[0]) // 2, (size[1] - inner[1]) // 2
    picture = np.full((size[1], size[0], 3), GREY, np.uint8)
    smooth = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
    picture[top : top + inner[1], left : left + inner[0]] = cv2.resize(rgb, inner, interpolation=smooth)
    return picture, Letterbox(scale=scale, left=left, top=top)


def read_output(path: Path, output: FloatArray, person: int) -> tuple[FloatArray, FloatArray]:
    """Boxes [N, 4] (centre column, centre row, width, height) in px of the network, and scores [N] of people.

    YOLOv8 has the boxes in columns and the scores of classes below them; YOLOv5 has them in rows, with the score of
    there being anything before those of the classes. The longer side counts the boxes.

    Raises
    ------
    FileError
        If the output has another shape, no such class, or scores that are none.
    """
    if output.ndim != 3 or output.shape[0] != 1 or max(output.shape[1:]) < _FEWEST_BOXES or min(output.shape[1:]) < 5:
        raise FileError(path, f"its output has the shape {list(output.shape)}; {_TOLD}")
    columns = output.shape[1] < output.shape[2]
    rows = output[0].T if columns else output[0]
    if rows.shape[1] == 6 and not columns and (rows[:, 5] == np.round(rows[:, 5])).all():
        shape = list(output.shape)
        raise FileError(
            path, f"its output {shape} ends in numbers of classes, as after a suppression of its own; {_TOLD}"
        )
    first = 4 if columns else 5
    if first + person >= rows.shape[1]:
        raise FileError(path, f"its output {list(output.shape)} has no class {person}; {_TOLD}")
    scores = rows[:, first + person] * (1.0 if columns else rows[:, 4])
    if not np.isfinite(rows[:, :5]).all() or scores.min() < -1e-3 or scores.max() > 1.0 + 1e-3:
        raise FileError(path, f"its scores are {scores.min():.3g} to {scores.max():.3g}, not 0 to 1; {_TOLD}")
    likely = scores >= LEAST_SCORE
    if likely.any() and rows[likely, :4].max() <= 1.5:
        raise FileError(path, f"its boxes are shares of the picture, not px; {_TOLD}")
    return rows[:, :4], np.clip(scores, 0.0, 1.0)


def _input_size(path: Path, header: OnnxHeader) -> tuple[int, int]:
    """Width and height of the pictures that the network takes."""
    shape = header.shape
    if len(shape) != 4 or shape[0] not in (None, 1) or shape[1] not in (None, 3):
        wanted = "[1, 3, height, width], one RGB picture"
        raise FileError(path, f"its input has the shape {['?' if n is None else n for n in shape]}; wanted: {wanted}")
    return shape[3] or SIDE, shape[2] or SIDE


def _person_class(path: Path, header: OnnxHeader) -> int:
    """The number of the class of people."""
    names = header.class_names()
    found = [number for number, name in sorted(names.items()) if name.lower() in PEOPLE]
    if names and not found:
        listed = ", ".join(list(names.values())[:8])
        raise FileError(path, f"has no class '{PEOPLE[0]}'; its classes: {listed}")
    return found[0] if found else 0


def _reason(error: Exception) -> str:
    """The first line of what OpenCV says."""
    return str(error).strip().splitlines()[0].removeprefix("OpenCV").strip()
