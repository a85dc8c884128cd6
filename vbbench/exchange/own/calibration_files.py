"""Calibrations of other programs, converted to keys of ``camera.toml``.

ROS ``camera_info`` and ``ost.yaml``, Kalibr's camchain, OpenCV's FileStorage (YAML, XML, JSON) and Python dumps with
its names, COLMAP's ``cameras.txt``: each is recognised by its content.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import yaml

from vbbench.errors import FileError, quoted
from vbbench.exchange.own.distortion import COEFFICIENTS, distortion_keys, lens_model, plain_name
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import parse_number

MOST_BYTES, LONGEST_KEY = 2**18, 500
"""Of what is read of a file: one calibration is short, a log of them repeats it; and of a line that shows its kind."""
MOST_SKEW = 1e-3
"""Skew of pixels, as a share of the focal length, that moves no column by a pixel."""
NAMES = {
    "matrix": ("camera_matrix", "K", "mtx", "intrinsic_matrix"),
    "coefficients": ("distortion_coefficients", "distortion_coeffs", "dist_coeffs", "dist_coeff", "dist", "D"),
    "lens": ("distortion_model",),
    "projection": ("camera_model", "model_type", "Camera.type", "Camera1.type"),
    "fisheye": ("fisheye_model",),
    "intrinsics": ("intrinsics",),
    "size": ("resolution", "image_size", "DIM"),
    "width": ("width", "image_width"),
    "height": ("height", "image_height"),
    **{name: (name,) for name in ("fx", "fy", "cx", "cy", "roi", "binning_x", "binning_y", *COEFFICIENTS["opencv"])},
}
"""What a calibration states, by the names that programs give it, after ``Camera.`` or ``Camera1.`` or without."""
PARTS = ("distortion_parameters", "projection_parameters")
"""Tables of VINS programs within a calibration."""
_QUANTITIES = {plain_name(name): quantity for quantity, names in NAMES.items() for name in names}
WHICH = "distortion_model: plumb_bob (k1 k2 p1 p2 k3) or distortion_model: equidistant (fisheye: k1 k2 k3 k4)"
ONE = "keep the camera that the boxes are of, in a separate file"
COLMAP = {
    "SIMPLE_PINHOLE": "f cx cy",
    "PINHOLE": "fx fy cx cy",
    "SIMPLE_RADIAL": "f cx cy k1",
    "RADIAL": "f cx cy k1 k2",
    "OPENCV": "fx fy cx cy k1 k2 p1 p2",
    "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6",
    "OPENCV_FISHEYE": "fx fy cx cy k1 k2 k3 k4",
    "SIMPLE_RADIAL_FISHEYE": "f cx cy k1",
    "RADIAL_FISHEYE": "f cx cy k1 k2",
}
"""Parameters of COLMAP's camera models, after width and height."""
_ROW = re.compile(r"\d+\s+[A-Z][A-Z_]+(\s+[-+.\deE]+){3,}\s*$")
_KEY = re.compile(r"""["']?[\w./ -]+["']?\s*:(\s|$)""")


class _Loader(yaml.SafeLoader):
    """YAML without objects; OpenCV's matrices are tables."""


_Loader.add_multi_constructor(
    "tag:yaml.org,2002:opencv-", lambda loader, _, node: loader.construct_mapping(node, deep=True)
)


def read_calibration(path: Path) -> dict[str, Any] | None:
    """The keys of ``camera.toml`` that a calibration of another program states; ``None`` of a file that is none."""
    try:
        with path.open("rb") as file:
            text = file.read(MOST_BYTES).decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("#", "%", "---"))]
    first = lines[0].strip()[:LONGEST_KEY] if lines else ""
    if first == "[image]":
        raise FileError(path, "is ROS's calibration as INI; name the ost.yaml that was written with it")
    try:
        if _ROW.match(first):
            table = _of_colmap(lines)
        elif first.startswith("<"):
            table = _of_xml(text)
        elif first.startswith("{") or _KEY.match(first):
            table = _of_yaml(text)
        else:
            return None
    except (ValueError, yaml.YAMLError, ElementTree.ParseError, RecursionError) as error:
        problem = getattr(error, "problem", None) or error
        raise FileError(path, f"is no calibration that can be read: {problem}") from error
    cameras = [name for name in table if re.fullmatch(r"cam\d+", str(name)) and isinstance(table[name], Mapping)]
    if len(cameras) > 1:
        raise FileError(path, f"holds {' and '.join(cameras)}; {ONE}")
    try:
        return _keys(_quantities(table[cameras[0]] if cameras else table))
    except (ValueError, TypeError, RecursionError) as error:
        raise FileError(path, str(error)) from error


def _quantities(table: Mapping[str, Any]) -> dict[str, Any]:
    """The quantities of a table under the names of this module."""
    found: dict[str, Any] = {}
    parts = [value for name, value in table.items() if name in PARTS and isinstance(value, Mapping)]
    for name, value in [*table.items(), *(item for part in parts for item in part.items())]:
        plain = plain_name(name)
        quantity = _QUANTITIES.get(plain, _QUANTITIES.get(re.sub("^camera1?", "", plain)))
        if quantity is None and re.search("dist|coef", plain) and isinstance(value, list | str):
            known = "call it distortion_coefficients or distortion_model"
            raise ValueError(f"{name} is no name that is read here; {known}")
        if quantity in found and found[quantity] != value:
            raise ValueError(f"states {name} twice; {ONE}")
        if quantity is not None and value is not None:
            found[quantity] = value
    return found


def _keys(found: Mapping[str, Any]) -> dict[str, Any]:
    """Keys of ``camera.toml`` from quantities."""
    model, keys = _model(found), _intrinsics(found)
    stated = found["size"] if "size" in found else [found.get("width", 0), found.get("height", 0)]
    size = _numbers("width or height", stated).tolist()
    if len(size) != 2 or not all(size):
        raise ValueError("the size of the picture is missing: write image_width: and image_height: in px into the file")
    sizes = np.array([size, size[::-1]])
    off, off_turned = np.abs([keys["cx"], keys["cy"]] / sizes - 0.5).max(axis=1)  # from the middle, as a share
    if "size" in found and size[0] < size[1] and off_turned < 0.1 < off:
        size.reverse()  # rows first, as OpenCV's shapes are
    roi = found["roi"] if isinstance(found.get("roi"), Mapping) else {}
    uncut = [roi.get("width") or size[0], roi.get("height") or size[1]] == size
    parts = {"roi": roi.get("x_offset") or roi.get("y_offset") or not uncut}
    parts |= {name: _number(name, found.get(name, 0)) > 1 for name in ("binning_x", "binning_y")}
    if part := next((name for name, has in parts.items() if has), None):
        raise ValueError(f"has a {part}: write width, height and K of the picture that the boxes are of, without it")
    lens: dict[str, Any] = {name: _number(name, found[name]) for name in COEFFICIENTS["opencv"] if name in found}
    if "coefficients" in found:
        lens["coefficients"] = _numbers("distortion coefficients", found["coefficients"]).tolist()
    bent = distortion_keys(lens if model is None else {"model": model, **lens}, WHICH)
    whole = {"width": int(size[0]), "height": int(size[1]), **keys}
    return whole if bent is None else {**whole, "distortion": bent}


def _intrinsics(found: Mapping[str, Any]) -> dict[str, float]:
    """Focal lengths and principal point."""
    names = ("fx", "fy", "cx", "cy")
    if "matrix" in found:
        values = _numbers("camera_matrix", found["matrix"])
        if not values.any():
            raise ValueError("camera_matrix (K) is zero: this camera has not been calibrated")
        if len(values) != 9 or values[[3, 6, 7]].any() or values[8] != 1.0:
            raise ValueError("camera_matrix must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]")
        if abs(skew := values[1]) > MOST_SKEW * values[0]:
            raise ValueError(f"camera_matrix has a skew of {skew:g} px, which no camera has here; calibrate without")
        values = values[[0, 4, 2, 5]]
    elif "intrinsics" in found:
        values = _numbers("intrinsics", found["intrinsics"])
        if len(values) != 4:
            raise ValueError(f"intrinsics has {len(values)} numbers; a pinhole has four: fx, fy, cx, cy")
    elif missing := next((name for name in names if name not in found), None):
        known = "camera_matrix (K), intrinsics, or fx, fy, cx, cy; a camera.toml has lines such as width = 1280"
        raise ValueError(f"is no calibration of a pinhole: {missing} is missing; known are {known}")
    else:
        values = np.array([_number(name, found[name]) for name in names])
    return dict(zip(names, values.tolist(), strict=True))


def _model(found: Mapping[str, Any]) -> str | None:
    """The lens model that a calibration names."""
    projection = str(found.get("projection", "pinhole"))
    if "lens" not in found and plain_name(projection).startswith("kannalabrandt"):
        return lens_model(projection)
    if plain_name(projection) != "pinhole":
        raise ValueError(f"camera model {quoted(projection)} is not read; a pinhole with a lens is")
    if "fisheye" in found and "lens" not in found:
        return "fisheye" if _number("fisheye_model", found["fisheye"]) else "opencv"
    return lens_model(found["lens"]) if found.get("lens") else None


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


def _of_yaml(text: str) -> Mapping[str, Any]:
    """The first document of a YAML file that is not empty."""
    lines = [line for line in text.splitlines() if not line.startswith("%")]
    documents = re.split(r"^(?:---|\.\.\.)[ \t]*$", "\n".join(lines), flags=re.MULTILINE)
    table = yaml.load(next((one for one in documents if one.strip()), ""), _Loader)  # noqa: S506, a safe loader
    if not isinstance(table, Mapping):
        raise ValueError("YAML without names; a calibration has camera_matrix, or intrinsics")
    return table


def _of_xml(text: str) -> Mapping[str, Any]:
    """The quantities of a file that OpenCV's FileStorage wrote as XML."""
    if "<!" in text.replace("<!--", ""):
        raise ValueError("XML with declarations; OpenCV's has none")
    root = ElementTree.fromstring(text)  # noqa: S314, without declarations there is nothing to expand
    if root.tag != "opencv_storage":
        raise ValueError(f"XML of <{root.tag}>; of calibrations <opencv_storage> is read")
    return {one.tag: (one.findtext("data") or "").split() if len(one) else one.text for one in root}


def _of_colmap(lines: Sequence[str]) -> Mapping[str, Any]:
    """A row of COLMAP's ``cameras.txt``."""
    _, model, *values = lines[0].split()
    if len(lines) > 1:
        raise ValueError(f"{len(lines)} cameras; {ONE}")
    if model not in COLMAP:
        raise ValueError(f"camera model {model} is not read; calibrate with one of {', '.join(COLMAP)}")
    names = f"width height {COLMAP[model]}".split()
    if len(values) != len(names):
        raise ValueError(f"{model} has {' '.join(names)}, not {len(values)} numbers")
    row: dict[str, Any] = dict(zip(names, values, strict=True))
    focal = row.pop("f", None)
    lens = {"distortion_model": "fisheye" if "FISHEYE" in model else "opencv"}
    return row | lens | ({} if focal is None else {"fx": focal, "fy": focal})
