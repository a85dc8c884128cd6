"""Lens distortion of OpenCV's two models; and calibrations of other programs, converted to keys of ``camera.toml``.

``opencv`` (Brown and Conrady): with r² = x² + y² of a direction's (right, down) per forward,

    x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶)/(1 + k4 r² + k5 r⁴ + k6 r⁶) + 2 p1 x y + p2 (r² + 2 x²),
    y' = y (…)/(…) + p1 (r² + 2 y²) + 2 p2 x y;

``fisheye`` (Kannala and Brandt): (x', y') = (x, y) θ'/r, θ = atan r, θ' = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸). In
both u = fx x' + cx and v = fy y' + cy.

ROS ``camera_info`` and ``ost.yaml``, Kalibr's camchain, OpenCV's FileStorage (YAML, XML, JSON) and Python dumps with
its names, COLMAP's ``cameras.txt``: each is recognised by its content.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal
from xml.etree import ElementTree

import numpy as np
import yaml

from vbbench.errors import FileError, quoted, suggestion
from vbbench.exchange.box_rows import Boxes
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import Within, check_ranges, parse_number

Coefficient = Annotated[float, Within(-1e3, 1e3)]
WIDEST = np.radians(80.0)
"""Directions farther from the optical axis have no place on a pinhole's picture that is of any use."""
ON_THE_WAY = np.linspace(0.1, 1.0, 10)
"""Shares of the way from the optical axis to a point on which the model must not fold the picture over."""
ROUNDS, EXACT, STEP = 50, 1e-10, 1e-7
"""Newton steps, and the largest error of an inverse, per forward; step by which derivatives are taken."""

LENSES = {
    **dict.fromkeys(("opencv", "plumb_bob", "radtan", "radial-tangential", "brown_conrady"), "opencv"),
    **dict.fromkeys(("rational", "rational_polynomial", "full_opencv"), "opencv"),
    **dict.fromkeys(("fisheye", "equidistant", "equi", "opencv_fisheye"), "fisheye"),
    **dict.fromkeys(("kannala_brandt", "kannala_brandt4", "kannala_brandt8"), "fisheye"),
    **dict.fromkeys(("none", "undistorted"), "none"),
}
"""Lens models by the names of OpenCV, ROS, Kalibr, COLMAP and SLAM programs, and the model of `Distortion`."""
COEFFICIENTS = {"opencv": ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"), "fisheye": ("k1", "k2", "k3", "k4")}
"""The order of a list of coefficients."""
COUNTS = {"opencv": (4, 5, 8, 12, 14), "fisheye": (4, 5)}
"""How many numbers such lists have; those beyond the names are 0 or refused."""


def plain_name(name: object) -> str:
    """A name without case and punctuation, for the comparison of names from several programs."""
    return "".join(letter for letter in str(name).lower() if letter.isalnum())


def lens_model(name: object) -> str:
    """The model of `Distortion` that a program calls ``name``, or ``none``; raises ValueError if there is none."""
    found = {plain_name(known): model for known, model in LENSES.items()}.get(plain_name(name))
    if found is None:
        raise ValueError(f"no lens model is called '{name}'; {suggestion(str(name), LENSES)}")
    return found


def distortion_keys(table: Mapping[str, Any]) -> dict[str, Any] | None:
    """The keys of a `Distortion`, its ``model`` and coefficients, by their own names; ``None`` without distortion.

    Raises ValueError if the model is unknown, or not stated while coefficients fit two models.

    A ``table`` ``[distortion]`` has ``model`` by any of its names, coefficients by theirs or in a list.
    """
    named = dict(table)
    name, values = named.pop("model", None), named.pop("coefficients", ())
    model = None if name is None else lens_model(name)
    if not isinstance(values, Sequence) or isinstance(values, str):
        raise ValueError("[distortion]: coefficients is a list in [ ]")
    if len(values) and named:
        raise ValueError(f"[distortion]: coefficients and {next(iter(named))} exclude each other; keep one of them")
    if model is None and (len(values) == 4 or (named and set(named) <= set(COEFFICIENTS["fisheye"]))):
        found = ", ".join(named) or "four coefficients"
        models = 'model = "opencv" (plumb_bob, radtan: k1 k2 p1 p2 k3) or "fisheye" (equidistant: k1 k2 k3 k4)'
        models += "; in a calibration distortion_model: plumb_bob or equidistant"
        raise ValueError(f"[distortion]: {found} may be of two lens models; write {models}")
    if model == "none":
        return None
    model = model or "opencv"
    names = COEFFICIENTS[model]
    if len(values) and len(values) not in COUNTS[model]:
        order = f"{', '.join(map(str, COUNTS[model]))} ({' '.join(names)} ...)"
        raise ValueError(f"{len(values)} coefficients; lists of lens model '{model}' have {order}: write them by name")
    if any(values[len(names) :]):
        raise ValueError(f"lens model '{model}' has {' '.join(names)} here; the numbers after them must be 0")
    named |= zip(names, values, strict=False)
    return {"model": model, **named} if model == "fisheye" or any(named.values()) else None


@dataclass(frozen=True, kw_only=True)
class Distortion:
    """The table ``[distortion]`` of a camera file; coefficients are OpenCV's and 0 by default."""

    model: Literal["opencv", "fisheye"] = "opencv"
    k1: Coefficient = 0.0
    k2: Coefficient = 0.0
    p1: Coefficient = 0.0
    p2: Coefficient = 0.0
    k3: Coefficient = 0.0
    k4: Coefficient = 0.0
    k5: Coefficient = 0.0
    k6: Coefficient = 0.0

    def __post_init__(self) -> None:
        check_ranges(self)
        unknown = [name for name in ("p1", "p2", "k5", "k6") if self.model == "fisheye" and getattr(self, name)]
        if unknown:
            raise ValueError(f"[distortion]: OpenCV's fisheye model has k1 to k4 only, not {unknown[0]}; remove it")

    def bend(self, straight: FloatArray) -> FloatArray:
        """Distorted points of the undistorted ones [..., 2] (right, down per forward), in the same units."""
        x, y = np.moveaxis(straight, -1, 0)
        square = x * x + y * y
        if self.model == "fisheye":
            radius = np.sqrt(square)
            angle = np.arctan(radius)
            even = angle * angle
            bent = angle * (1.0 + even * (self.k1 + even * (self.k2 + even * (self.k3 + even * self.k4))))
            return straight * np.where(radius > 0.0, bent / np.maximum(radius, 1e-300), 1.0)[..., None]
        radial = 1.0 + square * (self.k1 + square * (self.k2 + square * self.k3))
        radial = radial / (1.0 + square * (self.k4 + square * (self.k5 + square * self.k6)))
        right = x * radial + 2.0 * self.p1 * x * y + self.p2 * (square + 2.0 * x * x)
        down = y * radial + self.p1 * (square + 2.0 * y * y) + 2.0 * self.p2 * x * y
        return np.stack([right, down], axis=-1)

    def straighten(self, bent: FloatArray) -> FloatArray:
        """The inverse of `bend`, by Newton's method; NaN for points without one, or too far from the optical axis."""
        points = bent.copy()
        if self.model == "fisheye":
            away = np.linalg.norm(bent, axis=-1, keepdims=True)
            points = bent * np.tan(np.minimum(away, WIDEST)) / np.maximum(away, 1e-300)
        with np.errstate(all="ignore"):
            for _ in range(ROUNDS):
                off = self.bend(points) - bent
                if not (np.abs(off) > EXACT).any():
                    break
                (a, b), (c, d) = np.moveaxis(self._jacobian(points), (-2, -1), (0, 1))
                x, y = np.moveaxis(off, -1, 0)  # inverses of 2 x 2, so that singular ones do not stop the others
                points = points - np.stack([d * x - b * y, a * y - c * x], axis=-1) / (a * d - b * c)[..., None]
            exact = (np.abs(self.bend(points) - bent) <= 100.0 * EXACT).all(axis=-1)
            ways = np.stack([self._jacobian(share * points) for share in ON_THE_WAY])
            upright = (np.linalg.det(ways) > 0.0) & (np.trace(ways, axis1=-2, axis2=-1) > 0.0)  # as every lens is
            near = np.linalg.norm(points, axis=-1) <= np.tan(WIDEST)
        return np.where((exact & upright.all(axis=0) & near)[..., None], points, np.nan)

    def _jacobian(self, points: FloatArray) -> FloatArray:
        """[..., 2, 2] the Jacobian of `bend`."""
        steps = STEP * np.eye(2)
        return np.stack([(self.bend(points + step) - self.bend(points - step)) / (2 * STEP) for step in steps], axis=-1)


def straight_rows(rows: Boxes, distortion: Distortion | None, intrinsics: FloatArray | None) -> tuple[Boxes, int]:
    """The boxes as a pinhole camera sees them, and the number of removed ones, which no pinhole camera sees."""
    if distortion is None or intrinsics is None:
        return rows, 0
    boxes = straighten_boxes(rows.boxes, distortion, intrinsics)
    kept = np.asarray(np.isfinite(boxes).all(axis=1) & (boxes[:, 2:] > 0.0).all(axis=1))
    return replace(rows, boxes=boxes).select(kept), int((~kept).sum())


def straighten_boxes(boxes: FloatArray, distortion: Distortion, intrinsics: FloatArray) -> FloatArray:
    """Undistorted boxes [N, 4] (left, top, width, height) in px, for a pinhole of the same ``intrinsics``, or NaN.

    The middle of each edge is mapped, and gives the new edge: head and feet of a standing person are at the middles of
    the upper and lower edge.
    """
    left, top, width, height = boxes.T
    across, down = left + 0.5 * width, top + 0.5 * height
    edges = (left, down), (left + width, down), (across, top), (across, top + height)
    middles = np.stack([np.stack(edge, axis=-1) for edge in edges])
    scale, centre = intrinsics[[0, 1], [0, 1]], intrinsics[:2, 2]
    straight = distortion.straighten((middles - centre) / scale) * scale + centre
    new_left, right, new_top, bottom = straight[0, :, 0], straight[1, :, 0], straight[2, :, 1], straight[3, :, 1]
    return np.stack([new_left, new_top, right - new_left, bottom - new_top], axis=-1)


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
    bent = distortion_keys(lens if model is None else {"model": model, **lens})
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
