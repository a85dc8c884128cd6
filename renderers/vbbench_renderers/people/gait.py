"""Where the feet are: planted in stance, in an arc between two plants in swing, side by side when still.

The cycle of a foot counts strides from the middle of its stance. Stance takes 62 % of a stride at 1.3 m/s and less
when faster; the foot strikes with the heel, lies flat, and rolls off over ball and toes (Perry, Gait Analysis, 1992).
"""

from dataclasses import dataclass

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_renderers.people.paths import HEADING, PHASE, SPEED, STILL, WALKING, Paths, X, Y

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

    Raises
    ------
    VbbenchError
        If the scene has no such frame.
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


def place_feet(paths: Paths, moment: Moment, size: FloatArray, track: FloatArray, stance: FloatArray) -> Feet:
    """The feet at a moment.

    Parameters
    ----------
    paths, moment : see there.
    size : [N] the person's metres per metre of a person of 1.75 m.
    track : [N] half the step width in m for 1.75 m.
    stance : [N, 2] how far in m the feet of each stand in front, when still.
    """
    size, gait = size[:, None], walking(moment.speed)[:, None, None]
    steps = _steps(paths, moment, size * track[:, None])
    planted = steps.planted[..., None]
    here, contact, rolling = _roll(steps, size)
    arc, ahead, swung = _swing(steps, size)
    still, facing = _still(moment, size, track, stance)
    ahead = gait * np.where(planted, steps.old[..., 2:], ahead) + (1.0 - gait) * facing
    return Feet(
        person=moment.person,
        ankle=gait * np.where(planted, here, arc) + (1.0 - gait) * still,
        contact=contact,
        pitch=np.where(steps.planted, rolling, swung) * gait[..., 0],
        yaw=np.arctan2(ahead[..., 1], ahead[..., 0]),
        planted=(steps.planted & (gait[..., 0] == 1.0)) | (gait[..., 0] == 0.0),
    )


@dataclass(frozen=True, kw_only=True)
class _Steps:
    """Where in its step each foot [N, 2] is.

    Parameters
    ----------
    planted : whether in stance.
    rolled, share : how much of the stance, or of the swing, is over, 0 … 1.
    old, new : [N, 2, 4] the foothold that it stands on or comes from, and the next one; see `_foothold`.
    strike, push : pitch at heel strike and at toe-off.
    swing : `vigour`, [N, 1].
    """

    planted: BoolArray
    rolled: FloatArray
    share: FloatArray
    old: FloatArray
    new: FloatArray
    strike: FloatArray
    push: FloatArray
    swing: FloatArray


def _steps(paths: Paths, moment: Moment, aside: FloatArray) -> _Steps:
    """Each foot's step; footholds are `aside` [N, 1] m from the path."""
    half = 0.5 * np.clip(0.62 - 0.06 * (moment.speed - 1.3), 0.35, 0.66)[:, None]
    from_left = moment.phase[:, None] - (0.0, 0.5)
    cycle = np.round(from_left)
    since = from_left - cycle
    number = np.array([0, 1]) + (2.0 * cycle).astype(np.int64) - 2 * (since < -half)
    plants = paths.plants[(paths.first_plant[moment.run][:, None] + number)[..., None] + (0, 2)]
    old, new = (_foothold(plants[:, :, i], aside) for i in (0, 1))
    swing = vigour(moment.speed)[:, None]
    return _Steps(
        planted=np.abs(since) <= half,
        rolled=np.clip(0.5 * since / half + 0.5, 0.0, 1.0),
        share=np.clip((np.where(since > 0, since, since + 1.0) - half) / (1.0 - 2.0 * half), 0.0, 1.0),
        old=old,
        new=new,
        strike=-STRIKE * swing + 0.0 * since,
        push=PUSH * swing + 0.0 * since,
        swing=swing,
    )


def _roll(steps: _Steps, size: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Ankles and contacts [N, 2, 3] and pitch [N, 2] of feet in stance: heel strike, flat, off over the toes."""
    landing = steps.strike * (1.0 - smooth_step(steps.rolled / 0.16))
    pitch = landing + steps.push * smooth_step((steps.rolled - 0.5) / 0.5) ** 1.5
    return *_stand(steps.old, pitch, size), pitch


def _swing(steps: _Steps, size: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Ankles [N, 2, 3], directions [N, 2, 2] and pitch [N, 2] of feet in the air, clear of the ground."""
    share, eased = steps.share, smooth_step(steps.share)[..., None]
    tuck = TUCK * steps.swing * np.sin(np.pi * np.clip(2.0 * share, 0.0, 1.0)) ** 2
    pitch = steps.push * (1.0 - smooth_step(share / 0.6)) + steps.strike * smooth_step((share - 0.45) / 0.55) + tuck
    lifted, landed = _stand(steps.old, steps.push, size)[0], _stand(steps.new, steps.strike, size)[0]
    arc = (1.0 - eased) * lifted + eased * landed
    bow = np.sin(np.pi * share)
    arc[..., 2] = np.maximum(arc[..., 2] + 0.02 * size * steps.swing * bow, size * (_clearance(pitch) + 0.012 * bow))
    return arc, (1.0 - eased) * steps.old[..., 2:] + eased * steps.new[..., 2:], pitch


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


def _still(moment: Moment, size: FloatArray, track: FloatArray, stance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ankles [N, 2, 3] and directions [N, 2, 2] of feet side by side."""
    angle = moment.heading[:, None] + 1.8 * TOE_OUT * SIDES
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    ahead = np.stack([np.cos(moment.heading), np.sin(moment.heading)], axis=-1)[:, None]
    left = np.stack([-ahead[..., 1], ahead[..., 0]], axis=-1)
    aside, along = size * (track[:, None] + 0.045) * SIDES, size * stance
    middle = moment.position[:, None] + aside[..., None] * left + along[..., None] * ahead
    ankle = middle - (size * BEHIND)[..., None] * direction
    return np.concatenate([ankle, (ANKLE * size + 0.0 * along)[..., None]], axis=-1), direction
