"""How people walk: whole paths in time and in steps, feet that do not slide, and bones that the feet move.

Rendering has all of a path, so nothing needs to be predicted. Step length follows from the walk ratio W = step length /
step rate, which healthy adults hold constant from about 1 m/s up (Sekiya and Nagasaki 1998; Murakami and Otaka 2017):
length = √(W · speed), here with W in proportion to the person's height. Slower steps are a little longer than that, and
never shorter than `SHORTEST` of the height.

The cycle of a foot counts strides from the middle of its stance. Stance takes 62 % of a stride at 1.3 m/s and less
when faster; the foot strikes with the heel, lies flat, and rolls off over ball and toes (Perry, Gait Analysis, 1992).

The pelvis is as high as straight legs allow and so goes up and down with the steps, but the head stays at the
person's height: the spine is stretched by the few centimetres in between, because the benchmark's geometry is that
of upright people of constant height.
"""

from dataclasses import dataclass
from enum import IntEnum
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.ndimage import gaussian_filter1d

from vbbench.errors import VbbenchError
from vbbench.geometry import BoolArray, FloatArray, IntArray, runs_of_true
from vbbench.scene import Scene

STEP_AT_1_3 = 0.41
"""Step length over height at 1.3 m/s: W = 0.0064 m min for 1.72 m."""
SHORTEST, LONGEST = 0.10, 0.50
STILL, WALKING = 0.12, 0.40
"""Speeds in m/s below which a person stands, and above which they walk; they shuffle in between."""
SMOOTH_S = 0.25
FINE_S = 0.1
X, Y, PHASE, HEADING, SPEED, SMOOTH_X, SMOOTH_Y = range(7)
STRIKE, PUSH, TUCK = np.radians(17.0), np.radians(36.0), np.radians(16.0)
"""Pitch of the foot at heel strike (toes up), at toe-off (heel up), and by how much it still grows in early swing."""
ANKLE = 0.085
HEEL, BALL, TIP, TIP_UP = -0.066, 0.125, 0.195, 0.012
"""The sole in m for 1.75 m: x of heel, ball and tip before the ankle, and how far the tip is above the ground."""
BEHIND = 0.056
"""How far in m the ankle is behind the middle of the foot, which is below the body."""
TOE_OUT = np.radians(6.0)
TRAIL = 0.032
"""How much farther it is behind when walking: a stride reaches from a heel off the ground to toes in the air."""
ROLL = np.arctan2(TIP_UP, TIP - BALL)
SIDES = np.array([1.0, -1.0])
"""Left and right along y."""
THIGH, SHIN, UPPER_ARM, FOREARM = 0.430, 0.415, 0.290, 0.250
HIP_UP, HIP_ASIDE, SHOULDER_UP, SHOULDER_ASIDE = -0.040, 0.086, 0.434, 0.173
PELVIS, SPINE, CHIN = 0.970, 0.520, 1.530
"""Height of the pelvis when standing, from there to the base of the neck, and of the chin, in m for 1.75 m."""
REACH = 0.998
"""A leg is never quite straight."""
BONES = 18


STYLE = np.dtype(
    [
        ("stance", float, 2),
        *((name, float) for name in ("size", "shoulders", "hips", "track", "stride", "start", "stoop", "glance")),
        *((name, float) for name in ("arm_swing", "arm_forward", "arm_aside", "arm_inward", "elbow")),
    ]
)
"""Build and way of walking, one row per person.

stance : how far in m the feet stand in front, when still.
size : the person's metres per metre of a person of 1.75 m.
shoulders, hips : relative breadth.
track : half the step width in m for 1.75 m.
stride : personal factor of the step length.
start : phase at which the person sets out.
stoop : how far in m the neck is before the hips.
glance : rad that the head turns to the left when still.
arm_swing, arm_forward, arm_aside, arm_inward, elbow : rad.
"""
Style = NDArray[np.void]
"""[N] rows of `STYLE`."""


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


@dataclass(frozen=True, kw_only=True)
class Paths:
    """Tables with a row for every fine time step of every run (a stretch of frames without a gap) of every person.

    Parameters
    ----------
    fine : rows a frame.
    first_row : [T, K] row of a frame, −1 where the person is absent.
    rows : [R, 7] x, y in m, phase in strides, heading in rad (unwrapped), speed in m/s, smoothed x, y in m.
    run : [R] run of a row.
    first_plant : [runs] where the footfalls of a run start in `plants`, less their number of half strides.
    plants : [P, 4] x, y in m of the body in the middle of each stance, cosine and sine of its heading.
    """

    fine: int
    first_row: IntArray
    rows: FloatArray
    run: IntArray
    first_plant: IntArray
    plants: FloatArray


def step_length(speed: FloatArray, height: FloatArray | float) -> FloatArray:
    """Step length in m at a speed in m/s of a person of a height in m."""
    length = STEP_AT_1_3 * np.sqrt(speed / 1.3)
    return np.asarray(np.clip(length, SHORTEST, LONGEST) * height)


def trace_paths(scene: Scene, heights: FloatArray, stride_scale: FloatArray, starts: FloatArray) -> Paths:
    """The paths of a scene.

    Parameters
    ----------
    scene : who is where.
    heights : [K] in m.
    stride_scale : [K] personal factor of the step length.
    starts : [K] phase in strides at which each person sets out.
    """
    fine = max(1, int(np.ceil(scene.dt / FINE_S - 1e-6)))
    first_row = np.full(scene.present.shape, -1, dtype=np.int64)
    tables, plants, first_plant = [], [], []
    rows = footfalls = 0
    for k in range(len(scene.people)):
        phase = starts[k]
        for begin, end in runs_of_true(scene.present[:, k]).tolist():
            table = _trace(scene.positions[begin:end, k], scene.dt, fine, heights[k] * stride_scale[k], phase)
            feet, first = _plants(table, heights[k] * stride_scale[k])
            first_row[begin:end, k] = rows + fine * np.arange(end - begin)
            first_plant.append(footfalls - first)
            tables.append(table)
            plants.append(feet)
            rows, footfalls, phase = rows + len(table), footfalls + len(feet), table[-1, PHASE]
    return Paths(
        fine=fine,
        first_row=first_row,
        rows=np.concatenate([*tables, np.empty((0, 7))]),
        run=np.repeat(np.arange(len(tables)), [len(table) for table in tables]),
        first_plant=np.array(first_plant, dtype=np.int64),
        plants=np.concatenate([*plants, np.empty((0, 4))]),
    )


def _trace(positions: FloatArray, dt: float, fine: int, height: float, phase: float) -> FloatArray:
    """The rows of a run."""
    frames = len(positions)
    if frames == 1:
        heading = 2.0 * np.pi * (phase % 1.0)
        return np.array([[*positions[0], phase, heading, 0.0, *positions[0]]])
    spline = make_interp_spline(np.arange(frames), positions, k=min(3, frames - 1))
    points = spline(np.arange((frames - 1) * fine + 1) / fine)
    points[::fine] = positions
    step = dt / fine
    smooth = _smoothed(points, SMOOTH_S / step)
    velocity = np.gradient(smooth, step, axis=0)
    speed = np.hypot(*velocity.T)
    stride = 2.0 * step_length(speed, height)
    gain = np.concatenate([[0.0], np.cumsum(0.5 * (speed / stride)[1:] + 0.5 * (speed / stride)[:-1]) * step])
    eased = np.minimum(gaussian_filter1d(speed, 0.15 / step, mode="nearest"), speed + 0.2)
    return np.column_stack([points, phase + gain, _headings(velocity, speed, step), eased, smooth])


def _smoothed(points: FloatArray, sigma: float) -> FloatArray:
    """Gaussian smoothing that continues in a straight line beyond both ends."""
    pad = int(np.ceil(3 * sigma))
    reach = min(len(points) - 1, max(1, round(sigma)))
    before = points[0] + (points[0] - points[reach]) / reach * np.arange(pad, 0, -1)[:, None]
    after = points[-1] + (points[-1] - points[-1 - reach]) / reach * np.arange(1, pad + 1)[:, None]
    return np.asarray(
        gaussian_filter1d(np.concatenate([before, points, after]), sigma, axis=0)[pad : pad + len(points)]
    )


def _headings(velocity: FloatArray, speed: FloatArray, step: float) -> FloatArray:
    """Unwrapped direction of motion; it is kept while the person is slow."""
    moving = np.flatnonzero(speed > 0.25)
    if len(moving) == 0:
        moving = np.array([int(np.argmax(speed))])
    angles = np.unwrap(np.arctan2(velocity[moving, 1], velocity[moving, 0]))
    last = np.clip(np.searchsorted(moving, np.arange(len(speed)), side="right") - 1, 0, len(moving) - 1)
    return np.asarray(gaussian_filter1d(angles[last], 0.2 / step, mode="nearest"))


def _plants(table: FloatArray, height: float) -> tuple[FloatArray, int]:
    """Where the body is in the middle of each stance, two footfalls more than needed at either end; the first's number.

    Footfall j belongs to phase j/2; even ones are of the left foot.
    """
    phase = table[:, PHASE] + 1e-9 * np.arange(len(table))
    first = int(np.floor(2.0 * phase[0])) - 3
    numbers = np.arange(first, int(np.ceil(2.0 * phase[-1])) + 4)
    at = 0.5 * numbers
    heading = np.interp(at, phase, table[:, HEADING])
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    stride = 2.0 * step_length(np.interp(at, phase, table[:, SPEED]), height)
    beyond = np.where(at > phase[-1], at - phase[-1], np.minimum(at - phase[0], 0.0)) * stride
    place = np.stack([np.interp(at, phase, table[:, column]) for column in (SMOOTH_X, SMOOTH_Y)], axis=-1)
    return np.concatenate([place + beyond[:, None] * ahead, ahead], axis=-1), first


@dataclass(frozen=True, kw_only=True)
class Moment:
    """Everybody who is present at one time, one row per person.

    Parameters
    ----------
    person : [N] column in the scene.
    position : [N, 2] in m.
    phase : [N] in strides; the left foot is in the middle of its stance at whole numbers.
    heading : [N] in rad.
    speed : [N] in m/s.
    run : [N] run in the `Paths`.
    """

    person: IntArray
    position: FloatArray
    phase: FloatArray
    heading: FloatArray
    speed: FloatArray
    run: IntArray


@dataclass(frozen=True, kw_only=True)
class Feet:
    """The feet (left, right) of everybody who is present.

    Parameters
    ----------
    person : [N] column in the scene.
    ankle : [N, 2, 3] in m.
    contact : [N, 2, 3] point of the sole on which the foot stands or rolls, in m; of no meaning in swing.
    pitch, yaw : [N, 2] in rad; pitch is positive with the heel up.
    planted : [N, 2] whether the foot bears weight.
    """

    person: IntArray
    ankle: FloatArray
    contact: FloatArray
    pitch: FloatArray
    yaw: FloatArray
    planted: BoolArray


def moment_at(paths: Paths, frame: float) -> Moment:
    """People's positions at a frame; between two frames only those of people present at both.

    Raises VbbenchError if the scene has no such frame.
    """
    if not 0 <= frame < len(paths.first_row):
        raise VbbenchError(f"the scene has no frame {frame:g}; its frames are 0 to {len(paths.first_row) - 1}")
    before, share = int(np.floor(frame)), frame - np.floor(frame)
    row = paths.first_row[before]
    there = row >= 0
    if share > 0:
        there &= paths.first_row[min(before + 1, len(paths.first_row) - 1)] == row + paths.fine
    person = np.flatnonzero(there)
    at = row[person] + share * paths.fine
    low = at.astype(np.int64)
    part = (at - low)[:, None]
    state = paths.rows[low]
    if share > 0:
        state = (1.0 - part) * state + part * paths.rows[np.minimum(low + 1, len(paths.rows) - 1)]
    return Moment(
        person=person,
        position=state[:, [X, Y]],
        phase=state[:, PHASE],
        heading=state[:, HEADING],
        speed=state[:, SPEED],
        run=paths.run[low],
    )


def smooth_step(values: FloatArray) -> FloatArray:
    """From 0 to 1 with level ends, as the values go from 0 to 1."""
    t = np.clip(values, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def walking(speed: FloatArray) -> FloatArray:
    """How much of the pose is that of walking: 0 when still, 1 when walking."""
    return smooth_step((speed - STILL) / (WALKING - STILL))


def vigour(speed: FloatArray) -> FloatArray:
    """How far limbs swing, relative to 1.3 m/s."""
    return np.asarray(np.minimum(np.sqrt(speed / 1.3), 1.25))


def place_feet(paths: Paths, moment: Moment, style: Style) -> Feet:
    """The feet at a moment, of people with a style [N] each."""
    size, gait = style["size"][:, None], walking(moment.speed)[:, None, None]
    half = 0.5 * np.clip(0.62 - 0.06 * (moment.speed - 1.3), 0.35, 0.66)[:, None]
    from_left = moment.phase[:, None] - (0.0, 0.5)
    cycle = np.round(from_left)
    since = from_left - cycle
    number = np.array([0, 1]) + (2.0 * cycle).astype(np.int64) - 2 * (since < -half)
    plants = paths.plants[(paths.first_plant[moment.run][:, None] + number)[..., None] + (0, 2)]
    old, new = (_foothold(plants[:, :, i], size * style["track"][:, None]) for i in (0, 1))
    stands = np.abs(since) <= half
    swing = vigour(moment.speed)[:, None]
    strike, push = -STRIKE * swing + 0.0 * since, PUSH * swing + 0.0 * since

    rolled = np.clip(0.5 * since / half + 0.5, 0.0, 1.0)  # heel strike, flat, off over the toes
    landing = strike * (1.0 - smooth_step(rolled / 0.16))
    rolling = landing + push * smooth_step((rolled - 0.5) / 0.5) ** 1.5
    here, contact = _stand(old, rolling, size)

    share = np.clip((np.where(since > 0, since, since + 1.0) - half) / (1.0 - 2.0 * half), 0.0, 1.0)  # of the swing
    eased, bow = smooth_step(share)[..., None], np.sin(np.pi * share)
    tuck = TUCK * swing * np.sin(np.pi * np.clip(2.0 * share, 0.0, 1.0)) ** 2
    swung = push * (1.0 - smooth_step(share / 0.6)) + strike * smooth_step((share - 0.45) / 0.55) + tuck
    arc = (1.0 - eased) * _stand(old, push, size)[0] + eased * _stand(new, strike, size)[0]
    arc[..., 2] = np.maximum(arc[..., 2] + 0.02 * size * swing * bow, size * (_clearance(swung) + 0.012 * bow))
    ahead = (1.0 - eased) * old[..., 2:] + eased * new[..., 2:]

    still, facing = _still(moment, style)
    planted = stands[..., None]
    ahead = gait * np.where(planted, old[..., 2:], ahead) + (1.0 - gait) * facing
    return Feet(
        person=moment.person,
        ankle=gait * np.where(planted, here, arc) + (1.0 - gait) * still,
        contact=contact,
        pitch=np.where(stands, rolling, swung) * gait[..., 0],
        yaw=np.arctan2(ahead[..., 1], ahead[..., 0]),
        planted=(stands & (gait[..., 0] == 1.0)) | (gait[..., 0] == 0.0),
    )


def _foothold(plant: FloatArray, aside: FloatArray) -> FloatArray:
    """Middle of the foot and its direction [N, 2, 4], from those of the body; the toes turn out."""
    ahead = plant[..., 2:]
    left = np.stack([-ahead[..., 1], ahead[..., 0]], axis=-1)
    out = np.tan(TOE_OUT) * SIDES[:, None]
    direction = (ahead + out * left) * np.cos(TOE_OUT)
    return np.concatenate([plant[..., :2] + (aside * SIDES)[..., None] * left, direction], axis=-1)


def _stand(foothold: FloatArray, pitch: FloatArray, size: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ankle and point of contact [N, 2, 3] of a foot that rolls over heel, ball and tip of the sole at a foothold."""
    tip = pitch > ROLL
    pivot = np.where(tip, BALL + (TIP - BALL) / np.cos(ROLL), np.where(pitch > 0.0, BALL, HEEL))
    x, z = np.where(tip, -TIP, np.where(pitch > 0.0, -BALL, -HEEL)), np.where(tip, ANKLE - TIP_UP, ANKLE)
    along = pivot - BEHIND - TRAIL + x * np.cos(pitch) + z * np.sin(pitch)
    height = z * np.cos(pitch) - x * np.sin(pitch)
    ankle = foothold[..., :2] + (size * along)[..., None] * foothold[..., 2:]
    contact = foothold[..., :2] + (size * (pivot - BEHIND - TRAIL))[..., None] * foothold[..., 2:]
    up = (size * height)[..., None]
    return np.concatenate([ankle, up], axis=-1), np.concatenate([contact, 0.0 * up], axis=-1)


def _clearance(pitch: FloatArray) -> FloatArray:
    """Height in m of the ankle at which the sole just touches the ground."""
    cos, sin = np.cos(pitch), np.sin(pitch)
    points = ((HEEL, ANKLE), (BALL, ANKLE), (TIP, ANKLE - TIP_UP))
    return np.asarray(np.max([z * cos + x * sin for x, z in points], axis=0))


def _still(moment: Moment, style: Style) -> tuple[FloatArray, FloatArray]:
    """Ankles [N, 2, 3] and directions [N, 2, 2] of feet side by side."""
    size = style["size"][:, None]
    angle = moment.heading[:, None] + 1.8 * TOE_OUT * SIDES
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    ahead = np.stack([np.cos(moment.heading), np.sin(moment.heading)], axis=-1)[:, None]
    left = np.stack([-ahead[..., 1], ahead[..., 0]], axis=-1)
    aside, along = size * (style["track"][:, None] + 0.045) * SIDES, size * style["stance"]
    middle = moment.position[:, None] + aside[..., None] * left + along[..., None] * ahead
    ankle = middle - (size * BEHIND)[..., None] * direction
    return np.concatenate([ankle, (ANKLE * size + 0.0 * along)[..., None]], axis=-1), direction


def pose_bones(moment: Moment, feet: Feet, style: Style) -> FloatArray:
    """Transforms [N, 18, 3, 4] from the bones' frames, in m for 1.75 m, to the world; `style` has the same rows."""
    bones = np.zeros((len(moment.person), BONES, 3, 4))
    size = style["size"]
    swing = np.sin(2.0 * np.pi * moment.phase) * walking(moment.speed) * vigour(moment.speed)
    facing = _turned(moment.heading + np.radians(4.0) * swing)
    hip = np.empty((len(size), 2, 3))
    hip[..., :2] = moment.position[:, None] + (size * style["hips"])[:, None, None] * HIP_ASIDE * (
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


def _rotation(angle: FloatArray, axis: int) -> FloatArray:
    """Rotations [..., 3, 3] about the ``axis``-th axis, from the next one to the one after that."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((*angle.shape, 3, 3))
    matrix[..., first, first] = matrix[..., second, second] = np.cos(angle)
    matrix[..., second, first] = np.sin(angle)
    matrix[..., first, second] = -matrix[..., second, first]
    matrix[..., axis, axis] = 1.0
    return matrix


_rolled, _pitched, _turned = (partial(_rotation, axis=axis) for axis in range(3))
"""About the front, about the left, where positive leans forward, and about the vertical."""


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
    gradients = []
    for joint, share in ((knee, 1.0), (ankle, 0.72)):
        offset = joint - waist[:, None]
        gradients.append(share * np.einsum("nsi,ni->ns", offset, facing[:, :, 0]) / offset[..., 2])
    slope = np.concatenate(gradients, axis=1)
    low, high = slope.min(axis=1), slope.max(axis=1)
    for number in range(4):
        lean = low + number / 3.0 * (high - low)
        bones[:, Bone.SKIRT + number, :, :3] = facing
        bones[:, Bone.SKIRT + number, :, 2] += 0.8 * lean[:, None] * facing[:, :, 0]
        bones[:, Bone.SKIRT + number, :, 3] = waist


def _spine(bones: FloatArray, moment: Moment, centre: FloatArray, swing: FloatArray, style: Style) -> None:
    """Chest, neck and head; the head is upright, and its height is given."""
    size = style["size"]
    ahead = _turned(moment.heading)
    chest = _turned(moment.heading - np.radians(6.0) * swing)
    lean = style["stoop"] + 0.012 * walking(moment.speed)
    base = centre.copy()
    base += (size * lean)[:, None] * ahead[:, :, 0]
    base[:, 2] = size * (PELVIS + SPINE - 0.4 * np.maximum(style["stoop"], 0.0))
    spine = (base - centre) / (SPINE * size)[:, None]
    stretch = _length(spine)
    chest = _upright(spine / stretch[:, None], chest[:, :, 0])
    bones[:, Bone.CHEST, :, :3] = chest
    bones[:, Bone.CHEST, :, 2] *= stretch[:, None]
    bones[:, Bone.CHEST, :, 3] = centre
    chin = np.column_stack([moment.position, size * CHIN])
    chin += (size * (lean + 0.5 * np.maximum(style["stoop"], 0.0)))[:, None] * ahead[:, :, 0]
    neck = chin - base
    bones[:, Bone.NECK, :, :3] = _upright(neck / _length(neck)[:, None], ahead[:, :, 0])
    bones[:, Bone.NECK, :, 3] = chin
    bones[:, Bone.HEAD, :, :3] = _turned(moment.heading + style["glance"] * (1.0 - 0.7 * walking(moment.speed)))
    bones[:, Bone.HEAD, :, 3] = chin


def _arms(bones: FloatArray, moment: Moment, swing: FloatArray, style: Style) -> None:
    """Arms that swing opposite to the legs, with the elbows more bent in front."""
    size = style["size"]
    chest = bones[:, Bone.CHEST].copy()
    spread = (SHOULDER_ASIDE * style["shoulders"])[:, None] * SIDES
    shoulder = chest[:, None, :, 3] + size[:, None, None] * (
        spread[..., None] * chest[:, None, :, 1] + SHOULDER_UP * chest[:, None, :, 2]
    )
    arm_swing, arm_forward, elbow = (style[name][:, None] for name in ("arm_swing", "arm_forward", "elbow"))
    forward = arm_swing * swing[:, None] * SIDES
    bend = elbow + 0.55 * np.maximum(forward, -0.1) * (arm_swing > 0.2)
    frame = _turned(moment.heading - np.radians(4.0) * swing)[:, None]
    arm = frame @ _rolled(style["arm_aside"][:, None] * SIDES) @ _pitched(-(arm_forward + forward))
    lower = arm @ _turned(-style["arm_inward"][:, None] * SIDES) @ _pitched(-bend)
    bones[:, Bone.UPPER_ARM : Bone.UPPER_ARM + 2, :, :3] = arm
    bones[:, Bone.FOREARM : Bone.FOREARM + 2, :, :3] = lower
    bones[:, Bone.UPPER_ARM : Bone.UPPER_ARM + 2, :, 3] = shoulder
    bones[:, Bone.FOREARM : Bone.FOREARM + 2, :, 3] = shoulder - (UPPER_ARM * size)[:, None, None] * arm[..., 2]
