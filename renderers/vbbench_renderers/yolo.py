"""A detector of your own: a network of an ONNX file, of YOLO's families or a transformer, on the processor."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench.boxes import suppress
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.detection import Detections
from vbbench.geometry import FloatArray, IntArray
from vbbench_renderers.onnx_network import OnnxNetwork
from vbbench_renderers.yolo_layouts import LEAST_SCORE, Layout, Size, read_rows, recognise, rows_of

SIDE = 640
"""px of the pictures of a network that takes any size."""
SAME = 0.6
"""Of two boxes that overlap by more than this (intersection over union), only the better is kept."""
MOST_BOXES = 1000
"""Of a picture, before boxes about the same person are removed."""
ELONGATED = 1.5
"""Pictures that are longer than this, in units of the network's shape, are looked at in parts as well."""
OVERLAP = 0.2
"""Share of a part that the next one shows, too."""
CUT = 2.0
"""px of the network: boxes of a part that come so near to an end of it are cut off there, and not used."""
GREY = 114
"""Of the margins of a picture whose shape is not the network's: what such networks are trained with."""
PEOPLE = ("person", "pedestrian", "people")
"""Names of the class; class 0 if the file names none, as in COCO."""


@dataclass(frozen=True, kw_only=True)
class Letterbox:
    """How a picture lies in the network's: scaled, with grey margins or stretched.

    Parameters
    ----------
    scale : px of the network per px of the picture, along columns and rows.
    left, top : margins in px of the network.
    """

    scale: tuple[float, float]
    left: int
    top: int

    def to_picture(self, boxes: FloatArray) -> FloatArray:
        """Boxes [N, 4] (centre column, centre row, width, height) of the network as (left, top, width, height)."""
        corners = boxes[:, :2] - 0.5 * boxes[:, 2:] - [self.left, self.top]
        return np.concatenate([corners, boxes[:, 2:]], axis=1) / (*self.scale, *self.scale)


class YoloDetector:
    """Finds people with the network of a file; its layout is recognised from its outputs for a grey picture.

    Parameters
    ----------
    weights : an ONNX file of one of the families of `vbbench_renderers.yolo_layouts`.

    Raises
    ------
    VbbenchError
        If no file is named, or it is not such a network.
    """

    def __init__(self, weights: Path | None = None) -> None:
        if weights is None:
            raise VbbenchError("detector yolo needs your network: --weights FILE.onnx, or --detector FILE.onnx")
        self._path, self._network = weights, OnnxNetwork(weights)
        self._size, self._person = _input_size(weights, self._network), _person_class(weights, self._network)
        grey = np.full((1, 3, self._size[1], self._size[0]), GREY / 255.0, np.float32)
        self._layout = recognise(weights, self._network.run(grey), self._size, self._network)

    def detect(self, rgb: NDArray[np.uint8], period: float | None = None) -> Detections:
        """See `vbbench.exchange.detection.Detector`; a panorama is continued beyond its seam."""
        if period is not None:
            rgb = np.concatenate([rgb, rgb[:, : rgb.shape[1] // 6]], axis=1)
        found = [self._detect_in(rgb, part) for part in parts_of(rgb.shape[1], rgb.shape[0], self._size)]
        boxes, scores = (np.concatenate(one) for one in zip(*found, strict=True))
        kept = suppress(boxes, scores, SAME, period)
        return Detections(boxes=boxes[kept], scores=scores[kept])

    def _detect_in(self, rgb: NDArray[np.uint8], part: IntArray) -> tuple[FloatArray, FloatArray]:
        """Boxes [N, 4] (left, top, width, height) in px of the picture, and scores [N], of people in a part of it."""
        (left, top), (right, bottom) = part[:2], part[2:]
        picture, letterbox = letterboxed(rgb[top:bottom, left:right], self._size, self._layout)
        rows = rows_of(self._path, self._network.run(_numbers(picture, self._layout)))
        boxes, scores = read_rows(self._path, rows, self._layout, self._size, self._person)
        likely = np.argsort(-scores, kind="stable")[:MOST_BOXES]
        likely = likely[(scores[likely] >= LEAST_SCORE) & (boxes[likely, 2:] > 0.0).all(axis=1)]
        boxes = letterbox.to_picture(boxes[likely]) + np.array([left, top, 0, 0])
        ends = np.column_stack([boxes[:, :2], boxes[:, :2] + boxes[:, 2:]])
        inner = part != [0, 0, rgb.shape[1], rgb.shape[0]]
        cut = (inner & ((ends - part) * [1, 1, -1, -1] < CUT / min(letterbox.scale))).any(axis=1)
        return boxes[~cut], scores[likely][~cut]


def parts_of(width: int, height: int, size: Size) -> IntArray:
    """The parts [N, 4] (left, top, right, bottom) of a picture in px in which people are looked for.

    The first is the whole. A picture of another shape than the network's would be small in it: parts of the network's
    shape, which overlap, are looked at as well.
    """
    along = int(height * size[0] < width * size[1])  # 1 if it is wider than the network's, else higher
    longer = width if along else height
    side = round(height * size[0] / size[1] if along else width * size[1] / size[0])
    count = 0 if longer <= ELONGATED * side else int(np.ceil((longer / side - OVERLAP) / (1.0 - OVERLAP)))
    starts = np.linspace(0, longer - side, count).round().astype(np.int64)
    zeros = np.zeros_like(starts)
    if along:
        parts = np.column_stack([starts, zeros, starts + side, zeros + height])
    else:
        parts = np.column_stack([zeros, starts, zeros + width, starts + side])
    return np.concatenate([[[0, 0, width, height]], parts])


def letterboxed(rgb: NDArray[np.uint8], size: Size, layout: Layout) -> tuple[NDArray[np.uint8], Letterbox]:
    """A picture [H, W, 3] in one of ``size`` (width, height), and how it lies there."""
    import cv2

    height, width = rgb.shape[:2]
    scale = (size[0] / width, size[1] / height)
    if layout.place != "stretched":
        scale = (min(scale), min(scale))
    inner = (min(size[0], round(width * scale[0])), min(size[1], round(height * scale[1])))
    middle = layout.place == "centre"
    left, top = ((size[0] - inner[0]) // 2, (size[1] - inner[1]) // 2) if middle else (0, 0)
    picture = np.full((size[1], size[0], 3), GREY, np.uint8)
    smooth = cv2.INTER_AREA if min(scale) < 1.0 else cv2.INTER_LINEAR
    picture[top : top + inner[1], left : left + inner[0]] = cv2.resize(rgb, inner, interpolation=smooth)
    return picture, Letterbox(scale=scale, left=left, top=top)


def _numbers(picture: NDArray[np.uint8], layout: Layout) -> NDArray[np.float32]:
    """A picture [H, W, 3] as the input [1, 3, H, W] of a network."""
    planes = np.moveaxis(picture[..., ::-1] if layout.range255 else picture, -1, 0)[None].astype(np.float32)
    planes = planes if layout.range255 else planes / np.float32(255.0)
    mean, std = (np.reshape(one, (3, 1, 1)).astype(np.float32) for one in (layout.mean, layout.std))
    return np.ascontiguousarray((planes - mean) / std)


def _input_size(path: Path, network: OnnxNetwork) -> Size:
    """Width and height of the pictures that the network takes."""
    shape, own = network.shape, network.value("imgsz")
    if len(shape) != 4 or shape[0] not in (None, 1) or shape[1] not in (None, 3):
        wanted = "[1, 3, height, width], one RGB picture"
        raise FileError(path, f"its input has the shape {['?' if n is None else n for n in shape]}; wanted: {wanted}")
    named = isinstance(own, list) and len(own) == 2 and all(isinstance(side, int) and side > 0 for side in own)
    height, width = own if named else (SIDE, SIDE)
    return shape[3] or width, shape[2] or height


def _person_class(path: Path, network: OnnxNetwork) -> int:
    """The number of the class of people."""
    names = network.class_names()
    found = [number for number, name in sorted(names.items()) if name.lower() in PEOPLE]
    if names and not found:
        listed = ", ".join(list(names.values())[:8])
        raise FileError(path, f"has no class '{PEOPLE[0]}'; its classes: {listed}")
    return found[0] if found else 0
