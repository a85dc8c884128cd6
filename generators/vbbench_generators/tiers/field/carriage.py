"""A carried camera and its boxes: unknown tilt with sway, unknown mount height, uneven ground.

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

import numpy as np

from vbbench.camera import Camera
from vbbench.generation.generator import Observer
from vbbench.generation.tier import Sight
from vbbench.geometry import BoolArray, FloatArray, IntArray, shorter_way
from vbbench_generators import _core
from vbbench_generators.tiers.field.recipe import AnnotatorModel, FieldRecipe, GroundModel, MountModel, TiltModel
from vbbench_generators.tiers.noise import wandering


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


@dataclass(frozen=True)
class Framed:
    """Boxes cut off at the borders of the picture.

    Parameters
    ----------
    boxes : [T, K, 3] (u, v, l) in px of the part inside; NaN where nothing is inside.
    inside : [T, K] share of the box's area inside.
    """

    boxes: FloatArray
    inside: FloatArray

    def where(self, kept: BoolArray) -> "Framed":
        """Only the boxes marked in ``kept`` [T, K]."""
        return replace(self, boxes=np.where(kept[..., None], self.boxes, np.nan))


def frame(boxes: FloatArray, camera: Camera, aspect: float) -> Framed:
    """Cut boxes [T, K, 3], ``aspect`` times as wide as high, off at the borders; a panorama has none."""
    if camera.period is not None:
        wrapped = np.concatenate([camera.wrap_column(boxes[..., :1]), boxes[..., 1:]], axis=-1)
        return Framed(wrapped, np.where(np.isnan(boxes[..., 2]), np.nan, 1.0))
    size = np.stack([aspect * boxes[..., 2], boxes[..., 2]], axis=-1)
    last = np.array(camera.picture_size) - 1.0
    low = np.clip(boxes[..., :2] - 0.5 * size, 0.0, last)
    high = np.clip(boxes[..., :2] + 0.5 * size, 0.0, last)
    inside = np.prod(high - low, axis=-1) / np.prod(size, axis=-1)
    cut = np.concatenate([0.5 * (low + high), (high - low)[..., 1:]], axis=-1)
    return Framed(np.where((inside > 0.0)[..., None], cut, np.nan), inside)


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
