"""``camera.toml``, the user's description of a camera, read strictly; other calibrations with the same keys."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from vbbench.camera import Camera, make_camera
from vbbench.errors import FileError, VbbenchError, mistakes_in, suggestion
from vbbench.exchange.own.calibration_files import LENSES, Distortion, distortion_keys, read_calibration
from vbbench.exchange.trajectory import Axes
from vbbench.geometry import FloatArray, covariance_along, motion_between, motion_levers, relative_to_world, wrap_angle
from vbbench.parsing.numbers import BODY_HEIGHT, FRAME_TIME, Within, check_ranges
from vbbench.parsing.toml_text import from_table, toml_table
from vbbench.registry import load_registered
from vbbench.solver import BOX_EDGE, Carrier

WIDEST, USUAL_ANGLE, NARROWEST = 150.0, 30.0, 3.0
"""Degrees from the left to the right border of a pinhole's picture that a camera has at most, often and at least."""
Tilt = Annotated[float, Within(-1.2, 1.2, "rad (degrees x 0.01745)")]
Focal = Annotated[float, Within(1.0, 1e6, "px")]
FieldOfView = Annotated[float, Within(NARROWEST, WIDEST, "degrees", "the field of view")]
Pixels = Annotated[float, Within(-1e5, 1e5, "px")]
MOST_TANGENTIAL = 0.02
"""A tangential coefficient that a lens hardly has."""
WIDE = 120.0
"""Degrees from which a lens that bends nothing is rare."""
OTHER_SIZE = 0.1
"""By what share of the picture its middle is off where a principal point belongs to a picture of another size."""
MOST_LEVER, MOST_YAW = 20.0, 7.0
"""M and rad from the body that odometry is of to the camera."""
FARTHEST_CENTRE = 1.5
"""In widths and heights of the picture: no principal point is farther from its middle, not even where it was cut."""


@dataclass(frozen=True, kw_only=True)
class OdometryFacts:
    """The table ``[odometry]``: extrinsics, and standard deviations if the file of odometry states none.

    Parameters
    ----------
    axes : axes of the body whose poses the file has, if neither file nor motion shows them.
    mount : pose of the camera on that body: forward and left in m, and its yaw to the left in rad.
    distance, sideways : standard deviations along and across the motion, as shares of the distance.
    turn : standard deviation of a turn, as a share of it.
    floor, turn_floor : standard deviations in m and rad after one second of standing still; they grow with the square
        root of time.
    """

    axes: Axes | None = None
    mount: tuple[float, float, float] = (0.0, 0.0, 0.0)
    distance: Annotated[float, Within(1e-6, 10.0)] = 0.05
    sideways: Annotated[float, Within(1e-6, 10.0)] = 0.02
    turn: Annotated[float, Within(1e-6, 10.0)] = 0.05
    floor: Annotated[float, Within(1e-6, 10.0, "m")] = 0.01
    turn_floor: Annotated[float, Within(1e-6, 10.0, "rad")] = 0.005

    def __post_init__(self) -> None:
        check_ranges(self)
        if not (max(map(abs, self.mount[:2])) <= MOST_LEVER and abs(self.mount[2]) <= MOST_YAW):
            wanted = f"[forward, left, yaw] in m and rad, within ±{MOST_LEVER:g} m"
            raise ValueError(f"mount = {list(self.mount)} must be {wanted}")

    def of_camera(self, poses: FloatArray) -> FloatArray:
        """Poses [N, 3] of the camera on a body with these poses."""
        forward, left, yaw = self.mount
        places = relative_to_world(np.array([[-left, forward]]), poses)[:, 0]
        return np.column_stack([places, wrap_angle(poses[:, 2] + yaw)])

    def motion(self, before: ArrayLike, after: ArrayLike, seconds: float) -> tuple[FloatArray, FloatArray]:
        """The camera's motion [3] (forward, left, turn) between two poses of the body, and its covariance [3, 3].

        ``before`` and ``after`` are (x, y, yaw) of the body by its odometry, in m and rad, some ``seconds`` apart.
        """
        motions, covariances = self.motions(np.array([before, after], np.float64), np.array([seconds]))
        return motions[0], covariances[0]

    def motions(
        self, poses: FloatArray, seconds: FloatArray, stated: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """The camera's motions [T − 1, 3] from each pose [T, 3] of the body to the next, and their covariances.

        Covariances [T − 1, 3, 3] of the body's motions are those ``stated``, or follow from the ``seconds`` [T − 1].
        """
        body, camera = (motion_between(one[:-1], one[1:]) for one in (poses, self.of_camera(poses)))
        body[:, 2], camera[:, 2] = wrap_angle(body[:, 2]), wrap_angle(camera[:, 2])
        forward, left, yaw = self.mount
        levers = np.exp(1j * (body[:, 2] - yaw)) * (forward + 1j * left)
        levers = motion_levers(np.full(len(body), np.exp(-1j * yaw)), levers)
        return camera, covariance_along(levers, self.covariances(body, seconds) if stated is None else stated)

    def covariances(self, motions: FloatArray, seconds: FloatArray) -> FloatArray:
        """Covariances [T, 3, 3] of motions [T, 3] (forward, left, turn) that took ``seconds`` [T]."""
        way, turn = np.hypot(motions[:, 0], motions[:, 1]), np.abs(motions[:, 2])
        still = np.stack([self.floor**2 * seconds, self.floor**2 * seconds, self.turn_floor**2 * seconds], axis=-1)
        moving = np.stack([self.distance * way, self.sideways * way, self.turn * turn], axis=-1)
        return np.asarray((still + moving**2)[:, :, None] * np.eye(3))


SAME = ("dt fps", "focal fx", "focal fov", "focal vertical_fov", "fx fov", "fx vertical_fov")
"""Pairs of keys of which a camera file has one at most."""


@dataclass(frozen=True, kw_only=True)
class CameraFile:
    """The keys of ``camera.toml``.

    Parameters
    ----------
    model : a registered camera model, such as ``perspective``, ``panorama`` (a cylinder) or ``equirectangular``.
    width, height : size of the picture in px.
    mount_height : height of the camera over the ground in m.
    focal : focal length in px; or ``fx`` and ``fy``. A panorama's is the vertical one, of square pixels by default.
    fov, vertical_fov : field of view in degrees from left to right, or top to bottom, in place of a focal length.
    cx, cy : principal point in px; the middle of the picture by default.
    pitch, roll : angles in rad of the optical axis above the horizon, and of the right side downwards.
    dt, fps : seconds per frame, or frames per second.
    pixel_std : standard deviation in px of the boxes' columns, tops and bottoms; measured from the boxes by default.
    height_mean, height_std : prior of people's heights in m; by default that of adults in the street.
    box_edge : distance in m from a person's axis to the plane in which top and bottom of a box lie, if known.
    odometry : extrinsics and noise of odometry.
    parameters : further parameters of the user's own camera model.
    """

    mount_height: Annotated[float, Within(0.05, 100.0, "m", "the camera's height over the ground")]
    width: Annotated[int, Within(16, 100_000, "px")]
    model: str = "perspective"
    height: Annotated[int, Within(16, 100_000, "px")] | None = None
    focal: Focal | None = None
    fx: Focal | None = None
    fy: Focal | None = None
    fov: FieldOfView | None = None
    vertical_fov: FieldOfView | None = None
    cx: Pixels | None = None
    cy: Pixels | None = None
    pitch: Tilt = 0.0
    roll: Tilt = 0.0
    dt: Annotated[float, FRAME_TIME] | None = None
    fps: Annotated[float, Within(1 / 60, 1000.0, "frames per second")] | None = None
    pixel_std: Annotated[float, Within(0.0, 1000.0, "px")] | None = None
    height_mean: Annotated[float, BODY_HEIGHT] = 1.72
    height_std: Annotated[float, Within(0.0, 0.5, "m")] = 0.09
    carried_by: Carrier = "unknown"
    box_edge: Annotated[float, BOX_EDGE] | None = None
    distortion: Distortion | None = None
    odometry: OdometryFacts = field(default_factory=OdometryFacts)
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_ranges(self)
        for one, other in (names.split() for names in SAME):
            if getattr(self, one) is not None and getattr(self, other) is not None:
                raise ValueError(f"{one} and {other} are the same quantity; keep one of them")
        if (self.fx is None) != (self.fy is None):
            raise ValueError("fx and fy belong together; write both, or focal alone")
        if (self.fov or self.vertical_fov) and (self.distortion is not None or self.model != "perspective"):
            kind = f"model '{self.model}'" if self.distortion is None else "a lens with [distortion]"
            raise ValueError(f"fov gives the focal length of a lens that bends nothing; of {kind} write focal in px")
        if self.distortion is not None and self.model != "perspective":
            raise ValueError(f"[distortion] is for model 'perspective'; the model is '{self.model}'")
        if self.cx is not None and self.cy is not None and 0.0 < self.cx <= 1.0 and 0.0 < self.cy <= 1.0:
            raise ValueError(f"cx = {self.cx:g} and cy = {self.cy:g} are shares of the picture; write px")
        for name, at, size, lines in self.centre:
            if abs(at - 0.5 * size) > FARTHEST_CENTRE * size:
                middle = f"their middle is {0.5 * size:g}"
                raise ValueError(f"{name} = {at:g} is far outside the {size:g} {lines} of the picture; {middle}")

    @property
    def centre(self) -> list[tuple[str, float, float, str]]:
        """The stated principal point: name, px, size of the picture, and what it counts, of each known coordinate."""
        both = ("cx", self.cx, self.width, "columns"), ("cy", self.cy, self.height, "rows")
        return [(name, at, size, lines) for name, at, size, lines in both if at is not None and size is not None]

    @property
    def seconds(self) -> float | None:
        """Seconds per frame; ``None`` if the file does not state them."""
        return self.dt if self.fps is None else 1.0 / self.fps

    @property
    def picture(self) -> tuple[float, float]:
        """Width and height in px; a height that is not stated is infinite."""
        return float(self.width), float(np.inf if self.height is None else self.height)


@dataclass(frozen=True, kw_only=True)
class OwnCamera:
    """A camera of the user's own.

    Parameters
    ----------
    facts : its keys.
    text : text of a ``camera.toml`` with these keys.
    notes : notes on implausible values, a line each.
    """

    path: Path
    facts: CameraFile
    camera: Camera
    text: str
    notes: tuple[str, ...] = ()


def find_camera(path: Path) -> Path:
    """The camera file at a path: of a folder the ``camera.toml`` in it."""
    found = path / "camera.toml" if path.is_dir() else path
    if found.is_file():
        return found
    if not path.is_dir():
        raise FileError(path, "there is no such file")
    holds = ", ".join(sorted(one.name for one in path.iterdir() if one.is_file())[:10]) or "no file"
    raise FileError(path, f"is a folder without camera.toml; it holds {holds}: name the calibration")


def read_camera(path: Path, mount: Mapping[str, float | str] | None = None) -> OwnCamera:
    """Read ``camera.toml``, or a calibration of another program (`vbbench.exchange.own.calibration_files`).

    ``mount`` has keys that the file lacks: ``mount_height``, ``pitch``, ``carried_by``.
    """
    table, text, way = read_calibration(path), "", "give it with"
    if table is None:
        way = "write how high the camera is over the ground in m, or give"
        try:
            table, text = toml_table(path), path.read_text("utf-8-sig")
        except FileError as error:
            if path.suffix.lower() == ".toml":
                raise
            known = "other than TOML, calibrations of ROS, Kalibr, OpenCV and COLMAP are read"
            raise FileError(path, f"{error.problem}; {known}; were camera and boxes exchanged?", error.line) from error
    for name, value in (mount or {}).items():
        if table.setdefault(name, value) != value:
            given = value if isinstance(value, str) else f"{value:g}"
            raise FileError(path, f"says {name} = {table[name]}, and --{name.replace('_', '-')} {given}; keep one")
        text = f"{name} = {json.dumps(value)}  # given with this file\n{text}" if text else ""
    if "mount_height" not in table:
        raise FileError(path, f"mount_height is missing: {way} --mount-height")
    if isinstance(bent := table.pop("distortion", None), Mapping):
        with mistakes_in(path):
            bent = distortion_keys(bent)
    table |= {} if bent is None else {"distortion": bent}
    return make_own_camera(path, table, text)


def make_own_camera(path: Path, table: Mapping[str, Any], text: str = "") -> OwnCamera:
    """The camera of the keys of a camera file; see `read_camera`."""
    if angle := next((name for name in table if "fov" in name and name not in vars(CameraFile)), ""):
        wanted = "fov is from left to right, vertical_fov from top to bottom, in degrees"
        of_diagonal = "of a diagonal write focal = half of it in px / tan(half the angle)"
        raise FileError(path, f"camera: unknown key '{angle}'; {wanted}; {of_diagonal}")
    facts = from_table(table, CameraFile, path, "camera")
    if facts.model == "equirectangular" and facts.height is None:
        facts = replace(facts, height=round(0.5 * facts.width))
    try:
        model = load_registered("camera", facts.model)
    except VbbenchError as error:
        lens = f"; a lens model stands under [distortion], as model = '{facts.model}'" if facts.model in LENSES else ""
        raise FileError(path, f"{error}{lens}") from error
    given = _perspective(path, facts) if facts.model == "perspective" else _other(path, facts)
    tilt = {name: angle for name, angle in (("pitch", facts.pitch), ("roll", facts.roll)) if angle}
    given |= {"mount_height": facts.mount_height, **tilt, **facts.parameters}
    known = {one.name for one in fields(model)}
    for name in sorted(given.keys() - known):
        raise FileError(path, f"camera model '{facts.model}' has no '{name}'; {suggestion(name, sorted(known))}")
    with mistakes_in(path):
        camera = make_camera(facts.model, **given)
    return OwnCamera(path=path, facts=facts, camera=camera, text=text or _toml(table), notes=_notes(path, facts, given))


def _toml(table: Mapping[str, Any]) -> str:
    """The text of a camera file with these keys: numbers, words and tables of them."""
    flat = [f"{name} = {json.dumps(value)}\n" for name, value in table.items() if not isinstance(value, Mapping)]
    nested = [f"\n[{name}]\n{_toml(value)}" for name, value in table.items() if isinstance(value, Mapping)]
    return "".join(flat + nested)


def _notes(path: Path, facts: CameraFile, given: Mapping[str, Any]) -> tuple[str, ...]:
    """Notes on values that are in range, but implausible for a camera."""
    notes = [
        f"{name} = {at:g} is outside the {length} {lines} of the picture ({path.name}); is it cut?"
        for name, at, length, lines in facts.centre
        if not 0.0 <= at <= length
    ]
    if facts.model == "perspective" and facts.height is not None:
        across, down = given["cx"] / facts.width, given["cy"] / facts.height
        turned = abs(2.0 * given["cx"] / facts.height - 1.0) + abs(2.0 * given["cy"] / facts.width - 1.0) < OTHER_SIZE
        if abs(across - 0.5) > OTHER_SIZE and (turned or abs(across - down) < 0.1 * across):
            whole = f"{2 * given['cx']:.0f} x {2 * given['cy']:.0f} px"
            notes.append(
                f"cx and cy are the middle of a picture of {whole}, not of {facts.width} x {facts.height} "
                f"({path.name}): fx, fy, cx, cy must be those of the size that the boxes are of"
            )
        span = _span_of(facts.width, given["focal"])
        if span > WIDE and facts.distortion is None:
            notes.append(
                f"the picture spans {span:.0f}° without [distortion] ({path.name}): lenses so wide bend straight "
                "lines; write the coefficients of the calibration if the picture is as the lens shows it (and focal in "
                'px, not mm; of a 360° picture model = "equirectangular")'
            )
        tangential = 0.0 if facts.distortion is None else max(abs(facts.distortion.p1), abs(facts.distortion.p2))
        if tangential > MOST_TANGENTIAL:
            notes.append(f"p1 or p2 is {tangential:g} ({path.name}), much for a lens: is the order k1 k2 p1 p2 k3?")
    square = facts.focal is None or abs(facts.focal * 2.0 * np.pi / facts.width - 1.0) < 0.02
    height = facts.height or 2.0 * (facts.cy or 0.0)
    middle = facts.cy is None or abs(facts.cy - 0.5 * height) < 0.02 * height
    if facts.model == "panorama" and abs(height / facts.width - 0.5) < 0.01 and square and middle:
        notes.append(
            f"a picture of 360° that is twice as wide as high is equirectangular as a rule ({path.name}): then write "
            'model = "equirectangular"; panorama is a cylinder, on which people come out too far'
        )
    return tuple(notes)


def _perspective(path: Path, facts: CameraFile) -> dict[str, Any]:
    if facts.height is None:
        raise FileError(path, "camera: key 'height' is missing; add the picture's height in px")
    rows_focal = facts.fy if facts.vertical_fov is None else _focal_of(facts.height, facts.vertical_fov)
    focal = facts.fx if facts.focal is None else facts.focal
    focal = focal if facts.fov is None else _focal_of(facts.width, facts.fov)
    focal = rows_focal if focal is None else focal
    if focal is None:
        problem = "the focal length is missing: write focal = ... in px, fx and fy of a calibration, or fov in degrees"
        raise FileError(path, problem)
    span = _span_of(facts.width, focal)
    if not NARROWEST <= span <= WIDEST:
        known = f"often {0.5 * facts.width:.0f} to {2 * facts.width} px; px = mm x {facts.width} / mm of the sensor"
        known += f"; is it a field of view in degrees? then fov = {focal:g}" if USUAL_ANGLE <= focal <= WIDEST else ""
        problem = f"a focal length of {focal:g} px lets {facts.width} px span {span:.3g}°, which no camera does"
        raise FileError(path, f"{problem}; it is in px ({known})")
    across = 0.5 * facts.width if facts.cx is None else facts.cx
    down = 0.5 * facts.height if facts.cy is None else facts.cy
    given = {"width": facts.width, "height": facts.height, "focal": focal, "cx": across, "cy": down}
    return given | {"vertical_focal": None if rows_focal == focal else rows_focal}


def _span_of(pixels: int, focal: float) -> float:
    """Degrees that the picture of a pinhole spans; `_focal_of` is the inverse."""
    return float(np.degrees(2.0 * np.arctan(0.5 * pixels / focal)))


def _focal_of(pixels: int, degrees: float) -> float:
    """Focal length in px of a pinhole whose picture spans an angle."""
    return float(0.5 * pixels / np.tan(0.5 * np.radians(degrees)))


def _other(path: Path, facts: CameraFile) -> dict[str, Any]:
    """The stated parameters of a panorama, or of a model of an installed package."""
    given: dict[str, Any] = {name: getattr(facts, name) for name in ("width", "focal", "cx", "cy", "fx", "fy")}
    if facts.model in ("panorama", "equirectangular"):
        if facts.cy is None and facts.height is None:
            raise FileError(path, "camera: write cy, the row of the horizon in px, or height, if it is in the middle")
        sphere = facts.model == "panorama" or abs((facts.height or 0) / facts.width - 0.5) < 0.01
        if facts.focal is None and not sphere:
            problem = "is no whole sphere, which has 2 : 1; write focal in px per rad of a column"
            cut, scaled = facts.width / (2.0 * np.pi), (facts.height or 0) / np.pi
            known = f"{cut:.1f} if rows were cut off, {scaled:.1f} if the picture was scaled"
            raise FileError(path, f"camera: a picture of {facts.width} x {facts.height} px {problem} ({known}), and cy")
        given["focal"] = facts.width / (2.0 * np.pi) if facts.focal is None else facts.focal
        given["cy"] = 0.5 * (facts.height or 0) if facts.cy is None else facts.cy
    if facts.model != "panorama":
        given["height"] = facts.height
    return {name: value for name, value in given.items() if value is not None}
