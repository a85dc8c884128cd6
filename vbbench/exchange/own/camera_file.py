"""``camera.toml``: what a user knows of a camera, read strictly."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vbbench.camera import Camera, make_camera
from vbbench.errors import FileError, VbbenchError, suggestion
from vbbench.exchange.own.distortion import Distortion
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import BODY_HEIGHT, FRAME_TIME, Within, check_ranges
from vbbench.parsing.toml_text import read_toml
from vbbench.registry import load_registered

Pixels = Annotated[float, Within(-1e5, 1e5, "px")]
WIDEST, NARROWEST = 150.0, 3.0
"""Degrees from the left to the right border of a pinhole's picture that a camera may have."""
FARTHEST_CENTRE = 1.5
"""In widths and heights of the picture: no principal point is farther from its middle, not even where it was cut."""


@dataclass(frozen=True, kw_only=True)
class OdometryNoise:
    """The table ``[odometry]``: standard deviations of a motion from frame to frame, where its file states none.

    Parameters
    ----------
    distance : of the distance moved, as a share of it.
    sideways : of the motion to the side, as a share of the distance.
    turn : of the turn, as a share of it.
    floor : of the distance in m, and ``turn_floor`` of the turn in rad, after one second of standing still; they grow
        with the square root of time.
    """

    distance: Annotated[float, Within(1e-6, 10.0)] = 0.05
    sideways: Annotated[float, Within(1e-6, 10.0)] = 0.02
    turn: Annotated[float, Within(1e-6, 10.0)] = 0.05
    floor: Annotated[float, Within(1e-6, 10.0, "m")] = 0.01
    turn_floor: Annotated[float, Within(1e-6, 10.0, "rad")] = 0.005

    def __post_init__(self) -> None:
        check_ranges(self)

    def covariances(self, motions: FloatArray, seconds: FloatArray) -> FloatArray:
        """[T, 3, 3] of motions [T, 3] (forward, left, turn) that took ``seconds`` [T]."""
        way, turn = np.hypot(motions[:, 0], motions[:, 1]), np.abs(motions[:, 2])
        still = np.stack([self.floor**2 * seconds, self.floor**2 * seconds, self.turn_floor**2 * seconds], axis=-1)
        moving = np.stack([self.distance * way, self.sideways * way, self.turn * turn], axis=-1)
        return np.asarray((still + moving**2)[:, :, None] * np.eye(3))


@dataclass(frozen=True, kw_only=True)
class CameraFile:
    """The keys of ``camera.toml``.

    Parameters
    ----------
    model : a registered camera model, such as ``perspective`` or ``panorama``.
    width, height : of the picture in px.
    mount_height : of the camera over the ground in m.
    focal : focal length in px; or ``fx`` and ``fy``. A panorama's is the vertical one, of square pixels if left out.
    cx, cy : principal point in px; the middle of the picture if left out.
    pitch, roll : how far the optical axis points above the horizon, and the right side hangs lower, in rad.
    dt, fps : seconds per frame, or frames per second.
    pixel_std : standard deviation in px of the boxes' columns, tops and bottoms; measured from the boxes if left out.
    height_mean, height_std : of people's heights in m, where they are others than adults in the street.
    distortion : of the lens.
    odometry : how good the odometry is, where its file does not say.
    parameters : of a camera model of your own, besides those above.
    """

    mount_height: Annotated[float, Within(0.05, 100.0, "m", "the camera's height over the ground")]
    width: Annotated[int, Within(16, 100_000, "px")]
    model: str = "perspective"
    height: Annotated[int, Within(16, 100_000, "px")] | None = None
    focal: Annotated[float, Within(1.0, 1e6, "px")] | None = None
    fx: Annotated[float, Within(1.0, 1e6, "px")] | None = None
    fy: Annotated[float, Within(1.0, 1e6, "px")] | None = None
    cx: Pixels | None = None
    cy: Pixels | None = None
    pitch: Annotated[float, Within(-1.2, 1.2, "rad")] = 0.0
    roll: Annotated[float, Within(-1.2, 1.2, "rad")] = 0.0
    dt: Annotated[float, FRAME_TIME] | None = None
    fps: Annotated[float, Within(1 / 60, 1000.0, "frames per second")] | None = None
    pixel_std: Annotated[float, Within(0.0, 1000.0, "px")] | None = None
    height_mean: Annotated[float, BODY_HEIGHT] = 1.72
    height_std: Annotated[float, Within(0.0, 0.5, "m")] = 0.09
    distortion: Distortion | None = None
    odometry: OdometryNoise = field(default_factory=OdometryNoise)
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.dt is not None and self.fps is not None:
            raise ValueError("dt and fps say the same; keep one of them")
        if self.focal is not None and (self.fx is not None or self.fy is not None):
            raise ValueError("focal and fx, fy say the same; keep focal, or fx and fy")
        if (self.fx is None) != (self.fy is None):
            raise ValueError("fx and fy belong together; write both, or focal alone")
        if self.distortion is not None and self.model != "perspective":
            raise ValueError(f"[distortion] is for model 'perspective'; the model is '{self.model}'")
        for name, size, lines in (("cx", self.width, "columns"), ("cy", self.height, "rows")):
            point = getattr(self, name)
            if point is not None and size is not None and abs(point - 0.5 * size) > FARTHEST_CENTRE * size:
                middle = f"their middle is {0.5 * size:g}"
                raise ValueError(f"{name} = {point:g} is far outside the {size:g} {lines} of the picture; {middle}")

    @property
    def seconds(self) -> float | None:
        """Seconds per frame, if it is said."""
        return self.dt if self.fps is None else 1.0 / self.fps

    @property
    def picture(self) -> tuple[float, float]:
        """Width and height in px; a height that is not said is without limit."""
        return float(self.width), float(np.inf if self.height is None else self.height)


@dataclass(frozen=True, kw_only=True)
class OwnCamera:
    """A camera of the user's own: the file, and the model made of it."""

    path: Path
    facts: CameraFile
    camera: Camera


def read_camera(path: Path) -> OwnCamera:
    """Read a camera file.

    Raises
    ------
    FileError
        If it is missing or not TOML, a key is unknown, missing, out of range or not of this model, or the picture would
        span an angle that no camera has.
    """
    facts = read_toml(path, CameraFile, "camera")
    model = _model(path, facts.model)
    given = _perspective(path, facts) if facts.model == "perspective" else _other(facts)
    known = {one.name for one in fields(model)}
    for name in given:
        if name not in known:
            raise FileError(path, f"camera model '{facts.model}' has no '{name}'; {suggestion(name, sorted(known))}")
    try:
        camera = make_camera(facts.model, **given)
    except VbbenchError as error:
        raise FileError(path, str(error)) from error
    return OwnCamera(path=path, facts=facts, camera=camera)


def _model(path: Path, model: str) -> Any:
    """The class of a camera model that a file names."""
    try:
        return load_registered("camera", model)
    except VbbenchError as error:
        raise FileError(path, str(error)) from error


def _perspective(path: Path, facts: CameraFile) -> dict[str, Any]:
    focal = facts.fx if facts.focal is None else facts.focal
    if focal is None:
        raise FileError(path, "the focal length is missing: write focal = ... in px, or fx and fy of a calibration")
    if facts.height is None:
        raise FileError(path, "camera: key 'height' is missing; add the picture's height in px")
    span = np.degrees(2.0 * np.arctan(0.5 * facts.width / focal))
    if not NARROWEST <= span <= WIDEST:
        usual = f"{0.5 * facts.width:.0f} to {2 * facts.width} px"
        raise FileError(
            path,
            f"a focal length of {focal:g} px lets {facts.width} px span {span:.3g}°, which no camera does; it is in px "
            f"(often {usual}; px = mm x {facts.width} / width of the sensor in mm)",
        )
    return {
        "width": facts.width,
        "height": facts.height,
        "focal": focal,
        "vertical_focal": facts.fy,
        "cx": 0.5 * facts.width if facts.cx is None else facts.cx,
        "cy": 0.5 * facts.height if facts.cy is None else facts.cy,
        **_mount(facts),
        **facts.parameters,
    }


def _other(facts: CameraFile) -> dict[str, Any]:
    """Parameters of a panorama, or of a model that an installed package brings: those that are said."""
    given: dict[str, Any] = {name: getattr(facts, name) for name in ("width", "focal", "cx", "cy", "fx", "fy")}
    if facts.model == "panorama":
        if facts.focal is None:
            given["focal"] = facts.width / (2.0 * np.pi)
        if facts.cy is None and facts.height is not None:
            given["cy"] = 0.5 * facts.height
    else:
        given["height"] = facts.height
    return {name: value for name, value in given.items() if value is not None} | _mount(facts) | dict(facts.parameters)


def _mount(facts: CameraFile) -> dict[str, float]:
    tilt = {"pitch": facts.pitch, "roll": facts.roll}
    return {"mount_height": facts.mount_height, **{name: angle for name, angle in tilt.items() if angle}}
