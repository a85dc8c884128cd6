"""Calibrations as other programs write them, as keys of ``camera.toml``.

ROS ``camera_info`` and ``ost.yaml``, Kalibr's camchain and EuRoC's ``sensor.yaml``, OpenCV's FileStorage (YAML, XML,
JSON) and what is dumped from Python under its names, COLMAP's ``cameras.txt``: each is recognised by its content.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import yaml

from vbbench.errors import FileError, VbbenchError, quoted, suggestion
from vbbench.exchange.own.distortion import COEFFICIENTS, distortion_keys, lens_model, plain_name
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import parse_number

MOST_BYTES = 2**20
"""Of what is read of a file: one calibration is short, a log of them repeats it."""
MOST_SKEW = 1e-3
"""Skew of pixels, as a share of the focal length, that moves no column by a pixel."""
NAMES = {
    "matrix": ("camera_matrix", "K", "mtx", "intrinsic_matrix"),
    "coefficients": ("distortion_coefficients", "distortion_coeffs", "dist_coeffs", "dist_coeff", "dist", "D"),
    "lens": ("distortion_model", "distortion_type"),
    "projection": ("camera_model", "model_type", "Camera.type"),
    "fisheye": ("fisheye_model",),
    "intrinsics": ("intrinsics",),
    "size": ("resolution", "image_size", "image_resolution"),
    "width": ("width", "image_width", "w"),
    "height": ("height", "image_height", "h"),
    "fx": ("fx", "fl_x"),
    "fy": ("fy", "fl_y"),
    "fps": ("fps", "rate_hz"),
    **{name: (name,) for name in ("cx", "cy", "roi", "binning_x", "binning_y", *COEFFICIENTS["opencv"])},
}
"""What a calibration states, by the names that programs give it."""
_QUANTITIES = {plain_name(name): quantity for quantity, names in NAMES.items() for name in names}
PARTS = ("intrinsics", "projection_parameters", "distortion_parameters", "camera_matrix")
"""Tables in a table, in which some programs write what others write next to it."""
WHICH = "distortion_model: plumb_bob (k1 k2 p1 p2 k3) or distortion_model: equidistant (fisheye: k1 k2 k3 k4)"
COLMAP = {
    "SIMPLE_PINHOLE": ("none", "focal cx cy"),
    "PINHOLE": ("none", "fx fy cx cy"),
    "SIMPLE_RADIAL": ("opencv", "focal cx cy k1"),
    "RADIAL": ("opencv", "focal cx cy k1 k2"),
    "OPENCV": ("opencv", "fx fy cx cy k1 k2 p1 p2"),
    "FULL_OPENCV": ("opencv", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"),
    "OPENCV_FISHEYE": ("fisheye", "fx fy cx cy k1 k2 k3 k4"),
    "SIMPLE_RADIAL_FISHEYE": ("fisheye", "focal cx cy k1"),
    "RADIAL_FISHEYE": ("fisheye", "focal cx cy k1 k2"),
}
"""COLMAP's camera models: lens and parameters."""
_ROW = re.compile(r"\d+\s+[A-Z][A-Z_]+(\s+[-+.\deE]+){3,}\s*$")
_KEY = re.compile(r"""["']?[\w./ -]+["']?\s*:(\s|$)""")


class _Loader(yaml.SafeLoader):
    """YAML without objects; OpenCV's matrices are tables."""


_Loader.add_multi_constructor(
    "tag:yaml.org,2002:opencv-", lambda loader, _, node: loader.construct_mapping(node, deep=True)
)


def read_calibration(path: Path) -> dict[str, Any] | None:
    """The keys of ``camera.toml`` that a calibration of another program states; ``None`` of a file that is none.

    Raises
    ------
    FileError
        If it is one that cannot be used.
    """
    try:
        with path.open("rb") as file:
            text = file.read(MOST_BYTES).decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("#", "%", "---"))]
    first = lines[0].strip() if lines else ""
    if _ROW.match(first):
        return _of_colmap(path, lines)
    if first.startswith("<"):
        return calibration_keys(path, _of_xml(path, text))
    if first.startswith("{") or _KEY.match(first):
        return calibration_keys(path, _of_yaml(path, text))
    return None


def calibration_keys(path: Path, table: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of ``camera.toml`` that a calibration of named numbers states, such as a message of ROS.

    Parameters
    ----------
    path : where it was read, for messages.
    table : what it states, by any of `NAMES`.

    Raises
    ------
    FileError
        If something is missing, of no lens model here, of a part of a picture, or of several cameras.
    """
    cameras = [name for name in table if re.fullmatch(r"cam\d+", str(name)) and isinstance(table[name], Mapping)]
    if len(cameras) > 1:
        problem = f"holds {' and '.join(cameras)}; keep the camera that the boxes are of, in a file of its own"
        raise FileError(path, problem)
    try:
        return _keys(_quantities(table[cameras[0]] if cameras else table))
    except (ValueError, TypeError) as error:
        raise FileError(path, str(error)) from error


def _quantities(table: Mapping[str, Any]) -> dict[str, Any]:
    """What a table states, by our names."""
    found: dict[str, Any] = {}
    for name, value in _named(table):
        quantity = _QUANTITIES.get(plain_name(name)) or _QUANTITIES.get(plain_name(name.rpartition(".")[2]))
        if quantity is None or value is None:
            continue
        if quantity in found and found[quantity] != value:
            raise ValueError(f"states {name} twice; keep the camera that the boxes are of, in a file of its own")
        found[quantity] = value
    return found


def _named(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Names and values, those of `PARTS` as well."""
    for name, value in table.items():
        if isinstance(value, Mapping) and "data" not in value and name in PARTS:
            yield from _named(value)
        else:
            yield str(name), value


def _keys(found: Mapping[str, Any]) -> dict[str, Any]:
    keys: dict[str, Any] = dict(zip(("width", "height"), map(int, _size(found)), strict=True))
    _check_whole_picture(found, keys["width"], keys["height"])
    keys |= _intrinsics(found)
    if "fps" in found:
        keys["fps"] = _number("fps", found["fps"])
    lens: dict[str, Any] = {name: _number(name, found[name]) for name in COEFFICIENTS["opencv"] if name in found}
    if "coefficients" in found:
        lens["coefficients"] = _numbers("distortion coefficients", found["coefficients"]).tolist()
    model = _model(found)
    bent = distortion_keys(lens if model is None else {"model": model, **lens}, WHICH)
    return keys if bent is None else {**keys, "distortion": bent}


def _size(found: Mapping[str, Any]) -> tuple[float, float]:
    """Width and height of the picture."""
    size = _numbers("size", found["size"]) if "size" in found else [found.get("width"), found.get("height")]
    if len(size) != 2 or any(value is None for value in size):
        raise ValueError("the size of the picture is missing: write image_width: and image_height: in px into the file")
    return _number("width", size[0]), _number("height", size[1])


def _check_whole_picture(found: Mapping[str, Any], width: float, height: float) -> None:
    """Refuse the calibration of a larger picture of which boxes see a part, or fewer pixels."""
    roi = found["roi"] if isinstance(found.get("roi"), Mapping) else {}
    offset = [roi.get(name) or 0 for name in ("x_offset", "y_offset")]
    part = (roi.get("width") or width, roi.get("height") or height)
    binned = [name for name in ("binning_x", "binning_y") if _number(name, found.get(name, 0)) > 1]
    if any(offset) or part != (width, height) or binned:
        what = binned[0] if binned else "roi"
        raise ValueError(f"has a {what}: write width, height, K of the picture that the boxes are of, without {what}")


def _intrinsics(found: Mapping[str, Any]) -> dict[str, float]:
    """Focal lengths and principal point."""
    names = ("fx", "fy", "cx", "cy")
    if "matrix" in found:
        values = _numbers("camera_matrix", found["matrix"])
        if len(values) != 9 or values[[3, 6, 7]].any() or values[8] != 1.0:
            raise ValueError("camera_matrix must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]")
        if abs(values[1]) > MOST_SKEW * values[0]:
            raise ValueError(
                f"camera_matrix has a skew of {values[1]:g} px; pixels here are rectangles: calibrate without"
            )
        return dict(zip(names, values[[0, 4, 2, 5]].tolist(), strict=True))
    if "intrinsics" in found:
        values = _numbers("intrinsics", found["intrinsics"])
        if len(values) != 4:
            raise ValueError(f"intrinsics has {len(values)} numbers; a pinhole has four: fx, fy, cx, cy")
        return dict(zip(names, values.tolist(), strict=True))
    missing = [name for name in names if name not in found]
    if missing:
        known = "camera_matrix (K), intrinsics, or fx, fy, cx, cy"
        raise ValueError(f"is no calibration of a pinhole: {missing[0]} is missing; known are {known}")
    return {name: _number(name, found[name]) for name in names}


def _model(found: Mapping[str, Any]) -> str | None:
    """The lens model that a calibration names."""
    projection = plain_name(found.get("projection", "pinhole"))
    if "lens" in found:
        if projection != "pinhole":
            raise ValueError(f"camera model {quoted(str(found['projection']))} is not read; a pinhole with a lens is")
        return lens_model(found["lens"] or "none")
    if "fisheye" in found:
        return "fisheye" if _number("fisheye_model", found["fisheye"]) else "opencv"
    return None if projection in ("pinhole", "perspective") else lens_model(found["projection"])


def _number(name: str, value: Any) -> float:
    """A number; YAML takes some, such as 1e-05, for text."""
    number = parse_number(value) if isinstance(value, str) else value
    if isinstance(number, bool) or not isinstance(number, int | float) or not np.isfinite(number):
        raise ValueError(f"{name} is {quoted(str(value))}; write a number")
    return float(number)


def _numbers(name: str, values: Any) -> FloatArray:
    """The numbers of a matrix, row by row."""
    values = values.get("data") if isinstance(values, Mapping) else values
    if not isinstance(values, Sequence | np.ndarray) or isinstance(values, str):
        raise ValueError(f"{name} must be a list of numbers")
    rows = [row if isinstance(row, list) else [row] for row in values]
    return np.array([_number(name, item) for row in rows for item in row], float)


def _of_yaml(path: Path, text: str) -> Mapping[str, Any]:
    """The first document of a file that has something in it."""
    lines = [line for line in text.splitlines() if not line.startswith("%")]
    documents = re.split(r"^(?:---|\.\.\.)[ \t]*$", "\n".join(lines), flags=re.MULTILINE)
    try:
        table = yaml.load(next((one for one in documents if one.strip()), ""), _Loader)  # noqa: S506, a safe loader
    except yaml.MarkedYAMLError as error:
        line = None if error.problem_mark is None else error.problem_mark.line + 1
        raise FileError(path, f"is not YAML: {error.problem or error.context}", line) from error
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise FileError(path, f"is not YAML: {error}") from error
    if not isinstance(table, Mapping):
        raise FileError(path, "is YAML without names; a calibration has camera_matrix, or intrinsics")
    return table


def _of_xml(path: Path, text: str) -> Mapping[str, Any]:
    """OpenCV's FileStorage."""
    if "<!" in text.replace("<!--", ""):
        raise FileError(path, "is XML with declarations; OpenCV's has none")
    try:
        root = ElementTree.fromstring(text)  # noqa: S314, without declarations there is nothing to expand
    except (ElementTree.ParseError, ValueError) as error:
        raise FileError(path, f"is not XML: {error}") from error
    if root.tag != "opencv_storage":
        raise FileError(path, f"is XML of <{root.tag}>; of calibrations <opencv_storage> is read")
    return {one.tag: (one.findtext("data", one.text or "")).split() if len(one) else one.text for one in root}


def _of_colmap(path: Path, lines: Sequence[str]) -> dict[str, Any]:
    if len(lines) > 1:
        raise FileError(path, f"holds {len(lines)} cameras; keep the row of the one that the boxes are of")
    _, model, *rest = lines[0].split()
    if model not in COLMAP:
        raise FileError(path, f"camera model {model} is not read; {suggestion(model, COLMAP)}")
    lens, names = COLMAP[model][0], ["width", "height", *COLMAP[model][1].split()]
    try:
        if len(rest) != len(names):
            raise ValueError(f"{model} has {' '.join(names)}, not {len(rest)} numbers")
        keys: dict[str, Any] = {name: _number(name, text) for name, text in zip(names, rest, strict=True)}
        keys |= {name: int(keys[name]) for name in ("width", "height")}
        bent = distortion_keys({name: keys.pop(name) for name in names if name[1:].isdigit()} | {"model": lens})
    except (ValueError, VbbenchError) as error:
        raise FileError(path, str(error)) from error
    return keys if bent is None else {**keys, "distortion": bent}
