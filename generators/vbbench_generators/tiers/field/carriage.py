"""How a camera is carried, unknown to solvers: tilted, swaying, higher or lower than given, over uneven ground.

At frame t the camera's pitch and roll are p_t = p + sway and r_t = r + sway, constants p and r of the sequence with a
sway that is an Ornstein–Uhlenbeck process. Its optical centre is at z(x_t, y_t) + h0 + h + bob_t above level zero.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.generation.generator import Observer
from vbbench.geometry import FloatArray
from vbbench_generators.tiers.field.recipe import FieldRecipe, GroundModel, MountModel, TiltModel
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
    """A camera's way through a sequence.

    Parameters
    ----------
    pitch, roll : [T] in rad, up and clockwise positive.
    mount : [T] height in m over the ground below.
    ground : what it is carried over.
    """

    pitch: FloatArray
    roll: FloatArray
    mount: FloatArray
    ground: Ground


def carry(
    poses: FloatArray, mount_height: float, dt: float, observer: Observer, recipe: FieldRecipe, rng: np.random.Generator
) -> Carriage:
    """How a camera is carried.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) of it.
    mount_height : h0 in m that solvers are given.
    dt : seconds per frame.
    observer : who carries it; only walkers bob.
    """
    pitch, roll = _tilts(len(poses), dt, recipe.tilt, rng)
    constant = mount_height + recipe.mount.std * rng.standard_normal()
    phase = rng.uniform(0.0, 2.0 * np.pi)
    bob = _bob(poses, dt, phase, recipe.mount) if observer == "walker" else np.zeros(len(poses))
    return Carriage(pitch, roll, np.maximum(constant + bob, 0.5 * mount_height), draw_ground(recipe.ground, rng))


def draw_ground(model: GroundModel, rng: np.random.Generator) -> Ground:
    """Uneven ground."""
    direction, phases = rng.uniform(0.0, 2.0 * np.pi, (2, model.waves))
    lengths = np.exp(rng.uniform(np.log(model.shortest), np.log(model.longest), model.waves))
    waves = (2.0 * np.pi / lengths)[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    return Ground(np.full(model.waves, model.std * np.sqrt(2.0 / model.waves)), phases, waves)


def _tilts(frames: int, dt: float, model: TiltModel, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Pitch and roll [T] in rad."""
    constant = np.array([model.pitch_std, model.roll_std]) * rng.standard_normal(2)
    sway = np.array([model.sway_pitch_std, model.sway_roll_std]) * wandering((frames, 2), model.sway_time, dt, rng)
    pitch, roll = (constant + sway).T
    return pitch, roll


def _bob(poses: FloatArray, dt: float, phase: float, model: MountModel) -> FloatArray:
    """How much higher in m a walker's head is in each frame [T] than on average."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0, append=poses[-1:, :2]).T)
    pace = np.minimum(steps / dt / model.bob_pace, 1.0)
    pace[-1:] = pace[-2:-1]  # nobody knows the step after the last frame
    time = np.arange(len(poses)) * dt
    bob: FloatArray = model.bob * pace * np.sin(2.0 * np.pi * model.step_rate * time + phase)
    return bob
