"""A detector of your own: a network of an ONNX file, of YOLO's families or a transformer, on the processor."""

import ast
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from vbbench.boxes import suppress
from vbbench.errors import FileError, VbbenchError, needs_extra
from vbbench.exchange.detection import Detections
from vbbench.geometry import FloatArray, IntArray

with needs_extra("render", "finding people in pictures"):
    import cv2

NUMBERS = {"tensor(float)": np.float32, "tensor(float16)": np.float16}
"""Numbers that a network may take, by ONNX Runtime's names."""
TARGET_SIZE = "orig_target_sizes"
"""The second input of D-FINE and RT-DETR: [1, 2] width and height in px in which they write boxes."""


class OnnxNetwork:
    """The network of a file, which takes one picture of floats.

    Raises VbbenchError if ONNX Runtime is not installed, the file is missing or no network, or it takes something else.

    Parameters
    ----------
    path : the ONNX file.
    """

    def __init__(self, path: Path) -> None:
        with needs_extra("onnx", "a detector from an ONNX file"):
            import onnxruntime
        self._path = path
        options = onnxruntime.SessionOptions()
        options.log_severity_level = 4  # what is wrong is raised, too
        try:
            data = path.read_bytes()
            self._session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
        except OSError as error:
            raise FileError(path, f"cannot be read ({error.strerror}); name an ONNX file") from None
        except Exception as error:  # its errors have no public base class
            problem = f"ONNX Runtime cannot read this network: {_reason(error)}"
            raise FileError(path, f"{problem}; export yours again with format=onnx") from None
        first, *others = self._session.get_inputs()
        if first.type not in NUMBERS:
            raise FileError(path, f"its input takes {first.type}; export it with an input of float32 or float16")
        if {other.name for other in others} - {TARGET_SIZE}:
            names = ", ".join(one.name for one in (first, *others))
            raise FileError(path, f"it has the inputs {names}; wanted: one, a picture")
        self._name, self._type, self._others = first.name, NUMBERS[first.type], [other.name for other in others]
        self._outputs = [one.name for one in self._session.get_outputs()]
        self.shape = tuple(size if isinstance(size, int) and size > 0 else None for size in first.shape)
        """Of the input; ``None`` for a dimension that may be anything."""
        self.metadata: dict[str, str] = self._session.get_modelmeta().custom_metadata_map
        """Such as ``names``, the classes."""

    def class_names(self) -> dict[int, str]:
        """The names of the classes by number, as Ultralytics' exporter writes them; none if there are none."""
        try:
            return {int(number): str(name) for number, name in dict(self.value("names")).items()}
        except (ValueError, TypeError):
            return {}

    def value(self, name: str) -> Any:
        """An entry of the metadata that is written as Python has it; ``None`` if there is none."""
        try:
            return ast.literal_eval(self.metadata.get(name, "None"))
        except (ValueError, TypeError, SyntaxError, RecursionError, MemoryError):
            return None

    def run(self, pictures: NDArray[np.float32]) -> dict[str, FloatArray]:
        """The outputs by name for one picture [1, 3, H, W].

        Raises FileError if the network cannot be run on such a picture.
        """
        height, width = pictures.shape[2:]
        given: dict[str, Any] = {self._name: pictures.astype(self._type, copy=False)}
        given |= dict.fromkeys(self._others, np.array([[width, height]], np.int64))
        try:
            outputs = self._session.run(self._outputs, given)
        except Exception as error:
            problem = f"ONNX Runtime cannot run this network on {width} x {height} px: {_reason(error)}"
            raise FileError(self._path, problem) from None
        return {name: np.asarray(one, np.float64) for name, one in zip(self._outputs, outputs, strict=True)}


def _reason(error: Exception) -> str:
    """The first line of a library's message."""
    return str(error).strip().splitlines()[0].removeprefix("[ONNXRuntimeError] :").strip()


Size = tuple[int, int]
"""Width and height in px of the network's picture."""
LEAST_SCORE = 0.1
"""Detections with a lower score are not reported; a tracker uses doubtful ones."""
STRIDES = (8, 16, 32, 64)
"""px of the cells of a network's grids; most networks have the first three."""
SUPPRESSED_COLUMNS = (6, 6 + 32, 6 + 17 * 3)
"""Columns of final detections: corners, score, class; and 32 coefficients of a mask, or 17 keypoints."""
TASKS = ("detect", "segment", "pose")
"""Tasks of Ultralytics' networks whose boxes are upright rectangles."""
_D_FINE, _RF_DETR = {"labels", "boxes", "scores"}, {"dets", "labels"}
"""Names of outputs."""
_COCO_NUMBERS = 91
"""COCO's own numbers of classes go from 0, which is none, to 90."""
_FIRST_CLASS = {"classes": 4, "object": 5}
_FEWEST_BOXES = 100
_WANTED = (
    "wanted: [1, 4 + classes, N] of YOLOv8 and 11, [1, N, 5 + classes] of YOLOv5 and YOLOX, "
    "or [1, N, 6], [1, N, 38], [1, N, 57] of YOLO26 and nms=True"
)


@dataclass(frozen=True, kw_only=True)
class Layout:
    """How a family of networks takes a picture and writes boxes.

    Parameters
    ----------
    name : of the family.
    boxes : the first four columns: centres and sizes in px, or corners, or centres and sizes as shares of the picture,
        or offsets from a grid's cells with logarithms of sizes, in strides.
    scores : the columns after them: of classes, of any object and of classes, or a score and the number of its class.
    place : where the film's picture lies in the network's: amid grey margins, left of and above them, or stretched.
    range255 : pictures are BGR from 0 to 255, not RGB from 0 to 1.
    mean, std : of each colour, subtracted and divided by.
    """

    name: str
    boxes: Literal["centres", "corners", "shares", "grids"] = "centres"
    scores: Literal["classes", "object", "number"] = "classes"
    place: Literal["centre", "corner", "stretched"] = "centre"
    range255: bool = False
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    std: tuple[float, float, float] = (1.0, 1.0, 1.0)


YOLO8 = Layout(name="YOLOv8")
YOLO5 = Layout(name="YOLOv5", scores="object")
YOLOX = Layout(name="YOLOX", boxes="grids", scores="object", place="corner", range255=True)
YOLOX_DECODED = replace(YOLOX, name="YOLOX, decoded", boxes="centres")
SUPPRESSED = Layout(name="YOLO, suppressed", boxes="corners", scores="number")
RT_DETR = Layout(name="RT-DETR", boxes="shares", place="stretched")
D_FINE = Layout(name="D-FINE", boxes="corners", scores="number", place="stretched")
RF_DETR = replace(RT_DETR, name="RF-DETR", mean=(0.485, 0.456, 0.406), std=(0.229, 0.224, 0.225))


def rows_of(path: Path, outputs: dict[str, FloatArray]) -> FloatArray:
    """The one table [A, B] in a network's outputs, of which those of transformers are joined.

    Raises FileError if there is no such table, or more than one.
    """
    if outputs.keys() == _D_FINE and outputs["boxes"].ndim == 3:
        return np.column_stack([outputs[name][0] for name in ("boxes", "scores", "labels")])
    if outputs.keys() == _RF_DETR and outputs["labels"].shape[2:] == (_COCO_NUMBERS,):
        return np.column_stack([outputs["dets"][0], expit(outputs["labels"][0, :, 1:])])
    tables = [one for one in outputs.values() if one.ndim == 3 and one.shape[0] == 1]
    if len(tables) != 1:
        shapes = ", ".join(f"{name} {list(one.shape)}" for name, one in sorted(outputs.items()))
        raise FileError(path, f"its output is {shapes}; {_WANTED}")
    table: FloatArray = tables[0][0]
    return table


def recognise(path: Path, outputs: dict[str, FloatArray], size: Size, network: OnnxNetwork) -> Layout:
    """The layout of a network, from its outputs for any picture of ``size``.

    Raises FileError if the network is of none of the families.
    """
    task = network.metadata.get("task", TASKS[0])
    if task not in TASKS:
        raise FileError(path, f"is a network for the task '{task}'; wanted: one for {', '.join(TASKS)}")
    rows, classes, grids = rows_of(path, outputs), len(network.class_names()), _grids(size)
    count, columns = rows.shape
    if outputs.keys() == _D_FINE:
        return D_FINE
    if outputs.keys() == _RF_DETR and columns == 4 + _COCO_NUMBERS - 1:
        return RF_DETR
    if _is_suppressed(rows, network, dense=count in {times * cells for cells in grids for times in (1, 3)}):
        return SUPPRESSED
    if count and classes and columns == 4 + classes and rows[:, :4].max() <= 1.5:
        return RT_DETR
    if count in grids and 6 <= columns < count and (rows[:, 4] != 1.0).any():  # YOLOv6 has objectness 1
        return YOLOX if np.median(np.abs(rows[:, :2])) < min(size) / STRIDES[0] else YOLOX_DECODED
    if max(rows.shape) < min(_FEWEST_BOXES, min(grids)) or min(rows.shape) < 5:
        raise FileError(path, f"its output has the shape {[1, *rows.shape]}; {_WANTED}")
    return YOLO8 if count < columns else YOLO5


def read_rows(path: Path, rows: FloatArray, layout: Layout, size: Size, person: int) -> tuple[FloatArray, FloatArray]:
    """Boxes [N, 4] (centre column, centre row, width, height) in px of the network, and scores [N] of people.

    Raises FileError if the output has no such class, scores that are none, or boxes that are not in px.
    """
    shape, rows = [1, *rows.shape], rows.T if layout is YOLO8 else rows
    if layout.scores == "number":
        scores = np.where(rows[:, 5] == person, rows[:, 4], 0.0)
    elif _FIRST_CLASS[layout.scores] + person >= rows.shape[1]:
        raise FileError(path, f"its output {shape} has no class {person}; {_WANTED}")
    else:
        scores = rows[:, _FIRST_CLASS[layout.scores] + person] * (rows[:, 4] if layout.scores == "object" else 1.0)
    boxes = _boxes(rows, layout, size)
    if not np.isfinite(boxes).all():
        raise FileError(path, "some of its boxes are not numbers; export it with float32 in place of float16")
    if not (np.abs(scores - 0.5) <= 0.5 + 1e-3).all():
        raise FileError(path, f"its scores are {scores.min():.3g} to {scores.max():.3g}, not 0 to 1; {_WANTED}")
    likely = scores >= LEAST_SCORE
    if likely.any() and boxes[likely].max() <= 1.5:
        raise FileError(path, f"its boxes are shares of the picture, not px; {_WANTED}")
    return boxes, np.clip(scores, 0.0, 1.0)


def _boxes(rows: FloatArray, layout: Layout, size: Size) -> FloatArray:
    """Boxes [N, 4] (centre column, centre row, width, height) in px of the network."""
    first, second = rows[:, :2], rows[:, 2:4]
    if layout.boxes == "corners":
        return np.column_stack([0.5 * (first + second), second - first])
    if layout.boxes == "grids":
        cells = _cells(size, len(rows))
        return np.column_stack([first + cells[:, :2], np.exp(np.minimum(second, 10.0))]) * cells[:, 2:]
    return rows[:, :4] * ([*size, *size] if layout.boxes == "shares" else 1.0)


def _cells(size: Size, count: int) -> FloatArray:
    """Column, row and stride in px [count, 3] of the cells of a network's grids, as YOLOX orders them."""
    found = []
    for stride in STRIDES[: _grids(size)[count]]:
        row, column = np.mgrid[: size[1] // stride, : size[0] // stride]
        found.append(np.column_stack([column.ravel(), row.ravel(), np.full(row.size, stride)]))
    return np.concatenate(found).astype(np.float64)


def _is_suppressed(rows: FloatArray, network: OnnxNetwork, dense: bool) -> bool:
    """Whether rows are final detections: corners, score, number of the class, and more; ``dense`` counts are not."""
    arguments = network.value("args")
    named = bool(network.value("end2end") or (isinstance(arguments, dict) and arguments.get("nms")))
    if rows.shape[1] < 6 or (not named and (dense or rows.shape[1] not in SUPPRESSED_COLUMNS)):
        return False
    numbers = rows[:, 5]
    return bool(((numbers == np.round(numbers)) & (numbers >= 0.0)).all())


def _grids(size: Size) -> dict[int, int]:
    """How many cells grids of the first strides have together, and how many strides these are."""
    cells = [(size[0] // stride) * (size[1] // stride) for stride in STRIDES]
    return {sum(cells[:count]): count for count in (3, 4)}


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

    Raises VbbenchError if no file is named, or it is not such a network.

    Parameters
    ----------
    weights : an ONNX file of one of the families above.
    """

    def __init__(self, weights: Path | None = None) -> None:
        if weights is None:
            raise VbbenchError("detector yolo needs your network: --detector FILE.onnx")
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
