"""Families of detectors: how each takes a picture and writes boxes, recognised by the outputs of a network."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.special import expit

from vbbench.errors import FileError
from vbbench.geometry import FloatArray
from vbbench_renderers.onnx_network import OnnxNetwork

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

    Raises
    ------
    FileError
        If there is no such table, or more than one.
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

    Raises
    ------
    FileError
        If the network is of none of the families.
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

    Raises
    ------
    FileError
        If the output has no such class, scores that are none, or boxes that are not in px.
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
