"""The recipe of tier `field`: statistics of real cameras and boxes, of ``field.toml``, which names their sources.

A carried camera and its boxes: unknown tilt with sway, unknown mount height, uneven ground.

At frame t the camera's pitch and roll are p_t = p + sway and r_t = r + sway, constants p and r of the sequence with a
sway that is an Ornstein–Uhlenbeck process. Its optical centre is at z(x_t, y_t) + h0 + h + bob_t above level zero.

A person at (right X, forward Z), h tall, has the near edge of the body at ρ(X, Z), ρ = (d − δ)/d with d = √(X² + Z²)
and the edge δ, but at least a half. Feet and head are D = m_t + z(camera) − z(person) and D − h below the optical
centre, which is m_t over the ground. In the frame (right, down, forward) of the camera with pitch p and roll r a point
(ρX, D, ρZ) is at

    a = D cos p + ρZ sin p,   right = ρX cos r + a sin r,   down = a cos r − ρX sin r,   forward = ρZ cos p − D sin p,

which `Camera.pixels` maps to the picture. The box reaches from feet to head, about their middle column.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated

import numpy as np

from vbbench.camera import Camera, PerspectiveCamera
from vbbench.generation.generator import Observer
from vbbench.generation.tier import Heights, Sight
from vbbench.geometry import FloatArray, IntArray, shorter_way
from vbbench.parsing.numbers import Checked, Share, Within
from vbbench.parsing.toml_text import read_bundled
from vbbench_generators import _core
from vbbench_generators.tiers.noise import wandering
from vbbench_generators.tiers.tracking import DetectorModel, TrackingSettings, get_tracking

Seconds = Annotated[float, Within(1e-3, 1e4, "s")]
Angle = Annotated[float, Within(0.0, 0.5, "rad")]
Metres = Annotated[float, Within(0.0, 10.0, "m")]


@dataclass(frozen=True, kw_only=True)
class TiltModel(Checked):
    """Tilt of the camera, which solvers are not given.

    Parameters
    ----------
    pitch_std, roll_std : standard deviations in rad of the part that is constant throughout a sequence.
    sway_pitch_std, sway_roll_std : standard deviations in rad of the sway, whose correlation time is ``sway_time`` s.
    """

    pitch_std: Angle
    roll_std: Angle
    sway_pitch_std: Angle
    sway_roll_std: Angle
    sway_time: Seconds


@dataclass(frozen=True, kw_only=True)
class MountModel(Checked):
    """Height of the camera.

    Parameters
    ----------
    std : standard deviation in m about the height that solvers are given, constant throughout a sequence.
    bob : amplitude in m of a walker's vertical motion at the speed ``bob_pace`` in m/s and above; proportional below.
    step_rate : steps per second.
    """

    std: Metres
    bob: Metres
    bob_pace: Annotated[float, Within(0.01, 10.0, "m/s")]
    step_rate: Annotated[float, Within(0.1, 10.0, "Hz")]


@dataclass(frozen=True, kw_only=True)
class GroundModel(Checked):
    """Uneven ground: ``waves`` waves with lengths from ``shortest`` to ``longest`` m, and ``std`` m in all."""

    std: Metres
    shortest: Annotated[float, Within(0.1, 1e4, "m")]
    longest: Annotated[float, Within(0.1, 1e4, "m")]
    waves: Annotated[int, Within(1, 1000)]


@dataclass(frozen=True, kw_only=True)
class BodyModel(Checked):
    """Extent of a body in its box.

    Parameters
    ----------
    nearest_edge, farthest_edge : least and greatest near edge δ in m: the distance by which the edge that bounds a box
        is nearer than the body's axis; constant throughout a sequence.
    aspect : width of a box over its height.
    """

    nearest_edge: Metres
    farthest_edge: Metres
    aspect: Annotated[float, Within(0.05, 5.0)]


@dataclass(frozen=True, kw_only=True)
class AnnotatorModel(Checked):
    """Errors of annotators' boxes, as standard deviations in box heights.

    Parameters
    ----------
    bottom_person_std, column_person_std : of the lower edge and the centre column, constant for each person.
    bottom_std, column_std : of these in time, with the correlation times ``bottom_time`` and ``column_time`` in s.
    top_std : of the upper edge, independent in each frame.
    least_visible : least visible share of the part inside the picture, of a person who has a box.
    least_inside : least share inside the picture of such a box.
    pixel_std : the noise that solvers are given, in px at the focal length of the recipe's camera.
    """

    bottom_person_std: Share
    bottom_std: Share
    bottom_time: Seconds
    top_std: Share
    column_person_std: Share
    column_std: Share
    column_time: Seconds
    least_visible: Share
    least_inside: Share
    pixel_std: Annotated[float, Within(0.0, 100.0, "px")]

    @property
    def box_std(self) -> float:
        """Root mean square of the errors of column, top and bottom, as a share of the box's height."""
        column = self.column_person_std**2 + self.column_std**2
        bottom = self.bottom_person_std**2 + self.bottom_std**2
        return float(((column + bottom + self.top_std**2) / 3.0) ** 0.5)


@dataclass(frozen=True, kw_only=True)
class DetectorNoise(Checked):
    """The noise in px of a detector's boxes that solvers are given, in pictures with borders and in panoramas."""

    perspective_std: Annotated[float, Within(0.0, 100.0, "px")]
    panorama_std: Annotated[float, Within(0.0, 100.0, "px")]


@dataclass(frozen=True, kw_only=True)
class FieldRecipe:
    """All models of the tier, each a table of the file."""

    camera: PerspectiveCamera
    tilt: TiltModel
    mount: MountModel
    ground: GroundModel
    body: BodyModel
    heights: Heights
    annotator: AnnotatorModel
    detector: DetectorModel
    told_of_detector: DetectorNoise

    def pixel_std(self, camera: Camera, detects: bool) -> float:
        """The noise in px that solvers are given, of a detector's or an annotator's boxes in a ``camera``."""
        if detects:
            return self.tracking(camera).pixel_std(camera)
        return self.annotator.pixel_std * camera.focal / self.camera.focal

    def tracking(self, camera: Camera) -> TrackingSettings:
        """The detector for the pictures of ``camera``, with the tracker of the tier `tracked`.

        A lidar detects people by their distance: heights in px at which it misses them scale with the focal length.
        """
        small = self.detector.score_small * camera.focal / self.camera.focal
        told = vars(self.told_of_detector)
        return replace(get_tracking(), detector=replace(self.detector, score_small=small), **told)


@cache
def get_field() -> FieldRecipe:
    """The recipe that comes with this package."""
    return read_bundled("vbbench_generators", "tiers/field/field.toml", FieldRecipe, "top level")


@dataclass(frozen=True)
class Ground:
    """Uneven ground: its height z(x, y) = Σ aᵢ sin(kᵢ·(x, y) + φᵢ).

    Parameters
    ----------
    amplitudes, phases : [N] in m and rad.
    waves : [N, 2] wave vectors k in rad/m.
    """

    amplitudes: FloatArray
    phases: FloatArray
    waves: FloatArray


@dataclass(frozen=True)
class Carriage:
    """Tilt and height of a camera in each frame of a sequence.

    Parameters
    ----------
    pitch, roll : [T] in rad, up and clockwise positive.
    mount : [T] height in m over the ground below.
    ground : the uneven ground.
    """

    pitch: FloatArray
    roll: FloatArray
    mount: FloatArray
    ground: Ground


def carry(
    poses: FloatArray, mount_height: float, dt: float, observer: Observer, recipe: FieldRecipe, rng: np.random.Generator
) -> Carriage:
    """Draw tilt, height and ground of a carried camera.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) of the camera in m and rad.
    mount_height : nominal height h0 in m, which solvers are given.
    dt : seconds per frame.
    observer : carrier of the camera; only walkers bob.
    """
    pitch, roll = _tilts(len(poses), dt, recipe.tilt, rng)
    constant = mount_height + recipe.mount.std * rng.standard_normal()
    phase = rng.uniform(0.0, 2.0 * np.pi)
    bob = _bob(poses, dt, phase, recipe.mount) if observer == "walker" else np.zeros(len(poses))
    return Carriage(pitch, roll, np.maximum(constant + bob, 0.5 * mount_height), draw_ground(recipe.ground, rng))


def draw_ground(model: GroundModel, rng: np.random.Generator) -> Ground:
    """Draw uneven ground."""
    direction, phases = rng.uniform(0.0, 2.0 * np.pi, (2, model.waves))
    lengths = np.exp(rng.uniform(np.log(model.shortest), np.log(model.longest), model.waves))
    waves = (2.0 * np.pi / lengths)[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    return Ground(np.full(model.waves, model.std * np.sqrt(2.0 / model.waves)), phases, waves)


def _tilts(frames: int, dt: float, model: TiltModel, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Draw pitch and roll [T] in rad."""
    constant = np.array([model.pitch_std, model.roll_std]) * rng.standard_normal(2)
    sway = np.array([model.sway_pitch_std, model.sway_roll_std]) * wandering((frames, 2), model.sway_time, dt, rng)
    pitch, roll = (constant + sway).T
    return pitch, roll


def _bob(poses: FloatArray, dt: float, phase: float, model: MountModel) -> FloatArray:
    """Vertical displacement [T] in m of a walker's head about its mean."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0, append=poses[-1:, :2]).T)
    pace = np.minimum(steps / dt / model.bob_pace, 1.0)
    pace[-1:] = pace[-2:-1]  # nobody knows the step after the last frame
    time = np.arange(len(poses)) * dt
    bob: FloatArray = model.bob * pace * np.sin(2.0 * np.pi * model.step_rate * time + phase)
    return bob


def drawn(boxes: FloatArray, who: IntArray, dt: float, model: AnnotatorModel, rng: np.random.Generator) -> FloatArray:
    """Boxes [N, 3] (u, v, l) in px with the errors of an annotator.

    Parameters
    ----------
    boxes : [T, K, 3] exact boxes (u, v, l) in px.
    who : [N] flat indices into [T, K] of the returned boxes; errors are drawn for all boxes, and do not depend on it.
    dt : seconds per frame.
    """
    shape, person = boxes.shape[:2], who % max(boxes.shape[1], 1)
    column_bias, bottom_bias = rng.standard_normal((2, shape[1]))[:, person]
    column_walk = wandering(shape, model.column_time, dt, rng).take(who)
    bottom_walk = wandering(shape, model.bottom_time, dt, rng).take(who)
    column = model.column_person_std * column_bias + model.column_std * column_walk
    bottom = model.bottom_person_std * bottom_bias + model.bottom_std * bottom_walk
    top = model.top_std * rng.standard_normal(shape).take(who)
    u, v, length = boxes.reshape(-1, 3).take(who, axis=0).T
    return np.stack([u + column * length, v + 0.5 * (top + bottom) * length, length * (1.0 + bottom - top)], axis=-1)


def whole_boxes(relative: FloatArray, sight: Sight, carriage: Carriage, near_edge: float) -> FloatArray:
    """Boxes [T, K, 3] (u, v, l) in px without borders of the picture or occlusion; NaN behind the camera.

    Parameters
    ----------
    relative : [T, K, 2] (right, forward) in m of all people.
    sight : the scene, and the camera that solvers are given.
    carriage : tilt, height and ground of the camera.
    near_edge : δ in m.
    """
    truth, camera = sight.truth, sight.camera
    there = np.flatnonzero(~np.isnan(camera.depth(relative)))
    ground = carriage.ground
    where = np.ascontiguousarray(relative), np.ascontiguousarray(truth.positions), truth.poses, truth.heights
    tilt = np.stack([np.cos(carriage.pitch), np.sin(carriage.pitch), np.cos(carriage.roll), np.sin(carriage.roll)])
    sights = _core.sights(
        there, *where, carriage.mount, tilt, ground.amplitudes, ground.phases, ground.waves, near_edge
    )
    boxes = np.full((relative.shape[0] * relative.shape[1], 3), np.nan)
    boxes[there] = _about(camera.pixels(camera.to_camera(sights)), camera)
    return boxes.reshape(*relative.shape[:2], 3)


def frame(boxes: FloatArray, camera: Camera, aspect: float) -> tuple[FloatArray, FloatArray]:
    """The parts of boxes [..., 3] inside the picture, NaN where nothing is, and the shares [...] of their areas.

    Boxes are ``aspect`` times as wide as high. A panorama has no borders.
    """
    if camera.period is not None:
        wrapped = np.concatenate([camera.wrap_column(boxes[..., :1]), boxes[..., 1:]], axis=-1)
        return wrapped, np.where(np.isnan(boxes[..., 2]), np.nan, 1.0)
    size = np.stack([aspect * boxes[..., 2], boxes[..., 2]], axis=-1)
    last = np.array(camera.picture_size) - 1.0
    low = np.clip(boxes[..., :2] - 0.5 * size, 0.0, last)
    high = np.clip(boxes[..., :2] + 0.5 * size, 0.0, last)
    inside = np.prod(high - low, axis=-1) / np.prod(size, axis=-1)
    cut = np.concatenate([0.5 * (low + high), (high - low)[..., 1:]], axis=-1)
    return np.where((inside > 0.0)[..., None], cut, np.nan), inside


def cut_rows(boxes: FloatArray, camera: Camera) -> FloatArray:
    """Boxes [T, K, 3] cut off at the first and last row, NaN where nothing is left; a panorama has no such borders."""
    if camera.period is not None:
        return boxes
    last, half = camera.picture_size[1] - 1.0, 0.5 * boxes[..., 2]
    top, bottom = (np.clip(boxes[..., 1] + end, 0.0, last) for end in (-half, half))
    cut = np.stack([boxes[..., 0], 0.5 * (top + bottom), bottom - top], axis=-1)
    return np.where((bottom > top)[..., None], cut, np.nan)


def _about(ends: FloatArray, camera: Camera) -> FloatArray:
    """Boxes [N, 3] (u, v, l) in px between feet and heads, ``ends`` [N, 2, 2] in px."""
    (column, feet), (other, head) = np.moveaxis(ends[:, 0], -1, 0), np.moveaxis(ends[:, 1], -1, 0)
    column = column + 0.5 * shorter_way(other - column, camera.period)
    boxes = np.stack([column, 0.5 * (feet + head), feet - head], axis=-1)
    boxes[~(boxes[:, 2] > 0.0)] = np.nan
    return boxes
