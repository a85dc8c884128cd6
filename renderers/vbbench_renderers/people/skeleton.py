"""Bones, and how feet move them: legs of two links, a spine that evens out the steps, arms that swing.

The pelvis is as high as straight legs allow and so goes up and down with the steps, but the head stays at the
person's height: the spine is stretched by the few centimetres in between, because the benchmark's geometry is that
of upright people of constant height.
"""

from enum import IntEnum

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.people.gait import ANKLE, SIDES, Feet, Moment, vigour, walking
from vbbench_renderers.people.looks import Style

THIGH, SHIN, UPPER_ARM, FOREARM = 0.430, 0.415, 0.290, 0.250
HIP_UP, HIP_ASIDE, SHOULDER_UP, SHOULDER_ASIDE = -0.040, 0.086, 0.434, 0.173
PELVIS, SPINE, CHIN = 0.970, 0.520, 1.530
"""Height of the pelvis when standing, from there to the base of the neck, and of the chin, in m for 1.75 m."""


class Bone(IntEnum):
    """What a limb can be attached to; left and right alternate."""

    PELVIS = 0
    CHEST = 1
    NECK = 2
    HEAD = 3
    UPPER_ARM = 4
    FOREARM = 6
    THIGH = 8
    SHIN = 10
    FOOT = 12
    SKIRT = 14  # and three more


BONES = 18


REACH = 0.998
"""A leg is never quite straight."""


def pose_bones(moment: Moment, feet: Feet, style: Style) -> FloatArray:
    """Transforms [N, 18, 3, 4] from the bones' frames, in m for 1.75 m, to the world; `style` has the same rows."""
    bones = np.zeros((len(moment.person), BONES, 3, 4))
    size = style.size
    swing = np.sin(2.0 * np.pi * moment.phase) * walking(moment.speed) * vigour(moment.speed)
    facing = _turned(moment.heading + np.radians(4.0) * swing)
    hip = np.empty((len(size), 2, 3))
    hip[..., :2] = moment.position[:, None] + (size * style.hips)[:, None, None] * HIP_ASIDE * (
        SIDES[:, None] * facing[:, None, :2, 1]
    )
    hip[..., 2] = _hip_height(hip, feet.ankle, size)[:, None]
    _legs(bones, hip, feet, facing, size)
    centre = np.column_stack([moment.position, hip[:, 0, 2] - HIP_UP * size])
    bones[:, Bone.PELVIS, :, :3] = facing
    bones[:, Bone.PELVIS, :, 3] = centre
    _skirt(bones, centre, facing, size)
    _spine(bones, moment, centre, swing, style)
    _arms(bones, moment, swing, style)
    bones[..., :3] *= size[:, None, None, None]
    return bones


def _turned(angle: FloatArray) -> FloatArray:
    """Rotations [..., 3, 3] about the vertical."""
    return _rotation(angle, 2)


def _pitched(angle: FloatArray) -> FloatArray:
    """Rotations [..., 3, 3] about the left; positive leans forward."""
    return _rotation(angle, 1)


def _rolled(angle: FloatArray) -> FloatArray:
    """Rotations [..., 3, 3] about the front."""
    return _rotation(angle, 0)


def _rotation(angle: FloatArray, axis: int) -> FloatArray:
    """Rotations [..., 3, 3] about the ``axis``-th axis, from the next one to the one after that."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((*angle.shape, 3, 3))
    matrix[..., first, first] = matrix[..., second, second] = np.cos(angle)
    matrix[..., second, first] = np.sin(angle)
    matrix[..., first, second] = -matrix[..., second, first]
    matrix[..., axis, axis] = 1.0
    return matrix


def _upright(axis: FloatArray, front: FloatArray) -> FloatArray:
    """Rotations [..., 3, 3] whose z is a unit axis and whose x is as near to `front` as that allows."""
    left = _cross(axis, front)
    left /= _length(left)[..., None]
    return np.stack([_cross(left, axis), left, axis], axis=-1)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products; NumPy's own takes several times as long on small arrays."""
    ax, ay, az, bx, by, bz = a[..., 0], a[..., 1], a[..., 2], b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", vectors, vectors)))


def _hip_height(hip: FloatArray, ankle: FloatArray, size: FloatArray) -> FloatArray:
    """The highest z [N] of the hips at which both legs reach their ankles; a smooth minimum."""
    longest = REACH * (THIGH + SHIN) * size[:, None]
    aside = np.minimum(_length(ankle[..., :2] - hip[..., :2]), 0.75 * longest)
    reach = ankle[..., 2] + np.sqrt(longest**2 - aside**2)
    upright = (REACH * (THIGH + SHIN) + ANKLE) * size
    soft = 0.008 * size
    drop = np.exp((upright[:, None] - reach) / soft[:, None]).sum(axis=1)
    return np.asarray(upright - soft * np.log(np.maximum(drop, 1.0)))


def _legs(bones: FloatArray, hip: FloatArray, feet: Feet, facing: FloatArray, size: FloatArray) -> None:
    """Thighs, shins and feet by the law of cosines, the knees to the front."""
    down = feet.ankle - hip
    far = _length(down)
    thigh, shin = THIGH * size[:, None], SHIN * size[:, None]
    used = np.clip(far, 0.3 * thigh, 0.9995 * (thigh + shin))
    axis = down / far[..., None]
    ankle = hip + axis * used[..., None]
    along = (thigh**2 - shin**2 + used**2) / (2.0 * used)
    aside = np.sqrt(np.maximum(thigh**2 - along**2, 0.0))
    toes = _turned(feet.yaw)
    front = toes[..., 0] + facing[:, None, :, 0]
    front -= np.sum(front * axis, axis=-1, keepdims=True) * axis
    front /= _length(front)[..., None]
    knee = hip + along[..., None] * axis + aside[..., None] * front
    bones[:, Bone.THIGH : Bone.THIGH + 2, :, :3] = _upright((hip - knee) / thigh[..., None], front)
    bones[:, Bone.SHIN : Bone.SHIN + 2, :, :3] = _upright((knee - ankle) / shin[..., None], front)
    bones[:, Bone.FOOT : Bone.FOOT + 2, :, :3] = toes @ _pitched(feet.pitch)
    bones[:, Bone.THIGH : Bone.THIGH + 2, :, 3] = hip
    bones[:, Bone.SHIN : Bone.SHIN + 2, :, 3] = knee
    bones[:, Bone.FOOT : Bone.FOOT + 2, :, 3] = ankle


def _skirt(bones: FloatArray, centre: FloatArray, facing: FloatArray, size: FloatArray) -> None:
    """Four skirts that overlap, sheared so that the first follows the knee behind and the last the knee in front."""
    knee = bones[:, Bone.SHIN : Bone.SHIN + 2, :, 3]
    ankle = bones[:, Bone.FOOT : Bone.FOOT + 2, :, 3]
    waist = (0.06 * size)[:, None] * facing[:, :, 2] + centre
    slopes = []
    for joint, share in ((knee, 1.0), (ankle, 0.72)):
        offset = joint - waist[:, None]
        slopes.append(share * np.einsum("nsi,ni->ns", offset, facing[:, :, 0]) / offset[..., 2])
    slope = np.concatenate(slopes, axis=1)
    low, high = slope.min(axis=1), slope.max(axis=1)
    for number in range(4):
        lean = low + number / 3.0 * (high - low)
        bones[:, Bone.SKIRT + number, :, :3] = facing
        bones[:, Bone.SKIRT + number, :, 2] += 0.8 * lean[:, None] * facing[:, :, 0]
        bones[:, Bone.SKIRT + number, :, 3] = waist


def _spine(bones: FloatArray, moment: Moment, centre: FloatArray, swing: FloatArray, style: Style) -> None:
    """Chest, neck and head; the head is upright, and its height is given."""
    size = style.size
    ahead = _turned(moment.heading)
    chest = _turned(moment.heading - np.radians(6.0) * swing)
    lean = style.stoop + 0.012 * walking(moment.speed)
    base = centre.copy()
    base += (size * lean)[:, None] * ahead[:, :, 0]
    base[:, 2] = size * (PELVIS + SPINE - 0.4 * np.maximum(style.stoop, 0.0))
    spine = (base - centre) / (SPINE * size)[:, None]
    stretch = _length(spine)
    chest = _upright(spine / stretch[:, None], chest[:, :, 0])
    bones[:, Bone.CHEST, :, :3] = chest
    bones[:, Bone.CHEST, :, 2] *= stretch[:, None]
    bones[:, Bone.CHEST, :, 3] = centre
    chin = np.column_stack([moment.position, size * CHIN])
    chin += (size * (lean + 0.5 * np.maximum(style.stoop, 0.0)))[:, None] * ahead[:, :, 0]
    neck = chin - base
    bones[:, Bone.NECK, :, :3] = _upright(neck / _length(neck)[:, None], ahead[:, :, 0])
    bones[:, Bone.NECK, :, 3] = chin
    bones[:, Bone.HEAD, :, :3] = _turned(moment.heading + style.glance * (1.0 - 0.7 * walking(moment.speed)))
    bones[:, Bone.HEAD, :, 3] = chin


def _arms(bones: FloatArray, moment: Moment, swing: FloatArray, style: Style) -> None:
    """Arms that swing opposite to the legs, with the elbows more bent in front."""
    size = style.size
    chest = bones[:, Bone.CHEST].copy()
    spread = (SHOULDER_ASIDE * style.shoulders)[:, None] * SIDES
    shoulder = chest[:, None, :, 3] + size[:, None, None] * (
        spread[..., None] * chest[:, None, :, 1] + SHOULDER_UP * chest[:, None, :, 2]
    )
    forward = style.arm_swing * swing[:, None] * SIDES
    upper = style.arm_forward + forward
    bend = style.elbow + 0.55 * np.maximum(forward, -0.1) * (style.arm_swing > 0.2)
    frame = _turned(moment.heading - np.radians(4.0) * swing)[:, None]
    arm = frame @ _rolled(style.arm_aside * SIDES) @ _pitched(-upper)
    lower = arm @ _turned(-style.arm_inward * SIDES) @ _pitched(-bend)
    bones[:, Bone.UPPER_ARM : Bone.UPPER_ARM + 2, :, :3] = arm
    bones[:, Bone.FOREARM : Bone.FOREARM + 2, :, :3] = lower
    bones[:, Bone.UPPER_ARM : Bone.UPPER_ARM + 2, :, 3] = shoulder
    bones[:, Bone.FOREARM : Bone.FOREARM + 2, :, 3] = shoulder - (UPPER_ARM * size)[:, None, None] * arm[..., 2]
