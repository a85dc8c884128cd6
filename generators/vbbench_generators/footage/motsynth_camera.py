"""The camera of a MOTSynth video: the convention of its angles, and the consistency of poses and boxes.

People are given in the camera's axes (right, down, forward), the camera in the game's world, z up. Reprojection tests
three things: the axes of the joints (they must project onto the joints in the picture), the boxes (the joints must
project into them), and the frames of the poses. The last test predicts people by constant velocity in the world, from
half a second and a second before, and compares the prediction in the picture.
"""

from dataclasses import dataclass, replace
from itertools import permutations, product, starmap

import numpy as np

from vbbench.errors import FileError
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.numbers import BODY_HEIGHT
from vbbench_generators.footage.motsynth_json import Annotations

HEAD_TOP, HIPS, ANKLES = 0, (16, 19), (18, 21)
"""Joints, in the order of JTA, an earlier recording of the same game by the same authors."""
ANKLE_HEIGHT = 0.08
"""Of an ankle above the sole, in m."""

PLACES = {
    "x, -height, y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "x, y, height": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
}
"""How ``cam_world_pos`` is read: the matrix from the three numbers to (x, y, height); files have the first."""


@dataclass(frozen=True)
class AngleReading:
    """A convention of the angles ``cam_world_rot``.

    Parameters
    ----------
    where : indices of pitch, roll and yaw.
    signs : signs of the three; pitch is positive upwards, roll clockwise as the camera sees, yaw to the left.
    fixed_axes : whether roll turns about a fixed axis, after yaw and pitch; else about the camera's own.
    """

    where: tuple[int, ...]
    signs: tuple[int, ...]
    fixed_axes: bool

    def __str__(self) -> str:
        words = dict(zip(self.where, ("pitch", "roll", "yaw"), strict=True))
        signs = dict(zip(self.where, self.signs, strict=True))
        return ", ".join("-" * (signs[n] < 0) + words[n] for n in range(3))


KNOWN_READINGS = (
    AngleReading((0, 2, 1), (1, 1, -1), fixed_axes=True),
    AngleReading((0, 1, 2), (1, 1, 1), fixed_axes=False),
)
"""That of Quo Vadis, a public program that reads the files, and the game's own; they count before equal ones."""
READINGS = tuple(starmap(AngleReading, product(permutations(range(3)), product((1, -1), repeat=3), (True, False))))

MOST_SHIFT = 5
"""Frames by which poses may be too early or too late."""
MOST_LEAN = 8.0
"""Degrees that people may lean on average."""
LEVEL = 1.0
"""Degrees of tilt, of people and ground, by which readings of the angles may differ and count as equal."""
GROUND_RELIEF, GROUND_SLOPE = 0.1, 0.03
"""Of feet around a plane in m, and of that plane: what is usual."""
MOST_JOINT_ERROR = 10.0
"""px that the median joint may be off."""
MOST_BOX_ERROR, MOST_POSE_ERROR = 0.15, 0.25
"""Shares of a box's height that its centre may be off the centre of the joints, and that the place that is predicted
from the past may be off, in the median."""
AHEAD = 0.5
"""s that places are predicted ahead: long enough for a camera's turns, short enough for people's."""
CLEARLY = 0.8
"""A shift is taken if its error is less than so many times the error without."""
EQUAL = 1.05
"""Readings under which speeds of people differ by less than this factor count as equal."""
MOST_TRIPLES = 3000
"""Predictions from which the reading and the shift are chosen."""
FASTEST, QUICKEST = 100.0, 15.0
"""In m/s and rad/s: no camera that walks, drives or turns is faster from a frame to the next."""
MOST_TILT_SPREAD = 0.05
"""rad between the 5th and 95th percentile of pitch, and of roll: a sequence's camera has one of each."""
MOST_HEIGHT_SPREAD = 0.2
"""Of the camera's height, between the 5th and 95th percentile, as a share of it."""


@dataclass(frozen=True, kw_only=True)
class CameraPath:
    """The camera of a video, checked.

    Parameters
    ----------
    annotations : boxes, joints and poses of the same frames; a shift of the poses is corrected.
    poses : [T, 3] (x, y, yaw) in m and rad.
    pitch, roll, mount_height : medians in rad and m.
    people : [N, 2] place of each box's person on the ground: between the hips.
    statures : [N] height in m, from the lower ankle to the top of the head.
    report : figures of the checks.
    """

    annotations: Annotations
    poses: FloatArray
    pitch: float
    roll: float
    mount_height: float
    people: FloatArray
    statures: FloatArray
    report: dict[str, float | str]


def find_camera_path(found: Annotations) -> CameraPath:
    """Find the convention of angles, check poses, joints and boxes by reprojection, and correct a shift of poses."""
    off = np.linalg.norm(found.project(found.joints) - found.pixels, axis=-1)
    if not np.isfinite(off).any():
        raise FileError(
            found.path, "no joint of keypoints_3d lies before the camera; wanted (right, down, forward) in m"
        )
    joint_error = float(np.nanmedian(off))
    if not joint_error <= MOST_JOINT_ERROR:
        expected = "keypoints_3d must be (right, down, forward) of the camera in m"
        raise FileError(found.path, f"joints project {joint_error:.0f} px from those in the picture: {expected}")
    box_error = _box_error(found)
    if not box_error <= MOST_BOX_ERROR:
        problem = f"boxes lie {box_error:.0%} of their height from their people"
        raise FileError(found.path, f"{problem}: joints and boxes are not of one video")
    reading = _find_reading(found)
    pose_shift = reading.shift
    turned = replace(found, positions=found.positions @ np.array(PLACES[reading.places]).T)
    found = _shift_poses(turned, pose_shift)
    axes = camera_axes(found.angles, reading.angles)
    _refuse_leaps(found, axes, pose_shift)
    places = _to_world(found, axes, found.joints)
    right, down, forward = np.moveaxis(axes, 2, 0)
    pitch, roll = np.arcsin(forward[:, 2]), np.arctan2(-right[:, 2], -down[:, 2])
    soles = places[:, ANKLES, 2].min(axis=1) - ANKLE_HEIGHT
    above = found.positions[found.frame, 2] - soles
    spreads = {name: float(np.ptp(np.percentile(v, (5, 95)))) for name, v in (("pitch", pitch), ("roll", roll))}
    height, height_spread = _mount_height(found, above)
    statures = places[:, HEAD_TOP, 2] - soles
    try:
        BODY_HEIGHT.check("their median height", float(np.median(statures)))
    except ValueError as error:
        raise FileError(found.path, f"people by keypoints_3d: {error}; it must be in m") from None
    for name, spread in spreads.items():
        if spread > MOST_TILT_SPREAD:
            raise FileError(found.path, f"the camera's {name} changes by {spread:.2f} rad; a sequence has one {name}")
    return CameraPath(
        annotations=found,
        poses=np.column_stack([found.positions[:, :2], np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))]),
        pitch=float(np.median(pitch)),
        roll=float(np.median(roll)),
        mount_height=height,
        people=places[:, HIPS, :2].mean(axis=1),
        statures=statures,
        report={
            "places": reading.places,
            "angles": str(reading.angles),
            "joint_px": joint_error,
            "box_error": box_error,
            "pose_shift": pose_shift,
            "pose_error": reading.motion.error,
            "lean_degrees": reading.lean,
            "pitch_spread": spreads["pitch"],
            "roll_spread": spreads["roll"],
            "mount_height_spread": height_spread,
        },
    )


def _refuse_leaps(found: Annotations, axes: FloatArray, shift: int) -> None:
    """Raise FileError at the first pose too far from the last; poses are ``shift`` frames later in the file."""
    moved = np.linalg.norm(np.diff(found.positions, axis=0), axis=1)
    turned = np.arccos(np.clip(np.einsum("tij,tij->t", axes[1:], axes[:-1]) * 0.5 - 0.5, -1.0, 1.0))
    leaps = (moved > FASTEST / found.fps) | (turned > QUICKEST / found.fps)
    if leaps.any():
        frame = int(leaps.argmax())
        problem = f"frame {found.first + frame + 1 + shift}: the camera moves {moved[frame]:,.1f} m and turns "
        problem += f"{np.degrees(turned[frame]):.0f} degrees from the frame before"
        raise FileError(found.path, f"{problem}; a video is one shot of one camera, in m and degrees")


def camera_axes(angles: FloatArray, reading: AngleReading) -> FloatArray:
    """[T, 3, 3] right, down and forward of the camera as columns, in the world, from angles [T, 3] in degrees.

    The camera looks along +y; pitch turns it about x, roll about y, yaw about z.
    """
    from scipy.spatial.transform import Rotation

    pitch, roll, yaw = np.radians(angles[:, reading.where] * reading.signs).T
    level, rolled = Rotation.from_euler("ZX", np.stack([yaw, pitch], -1)), Rotation.from_euler("y", roll[:, None])
    turned = (rolled * level if reading.fixed_axes else level * rolled).as_matrix()
    return np.stack([turned[..., 0], -turned[..., 2], turned[..., 1]], axis=-1)


def _to_world(found: Annotations, axes: FloatArray, points: FloatArray) -> FloatArray:
    """Points [N, J, 3] from the camera's axes to the world's."""
    return found.positions[found.frame, None] + points @ np.moveaxis(axes[found.frame], 1, 2)


def _box_error(found: Annotations) -> float:
    """Median distance of boxes' centres from those of joints, if all are in the picture, as a share of the height."""
    joints = found.project(found.joints)
    whole = ((joints >= 0.0) & (joints < [found.width, found.height])).all(axis=(1, 2))
    if not whole.any():
        return np.inf
    joints, boxes = joints[whole], found.boxes[whole]
    middle = 0.5 * (joints.min(axis=1) + joints.max(axis=1))
    away = np.linalg.norm(boxes[:, :2] + 0.5 * boxes[:, 2:] - middle, axis=1)
    return float(np.median(away / boxes[:, 3]))


def _partners(found: Annotations, shift: int) -> tuple[IntArray, IntArray]:
    """Rows [M], and the rows [M] of the same person ``shift`` frames later."""
    margin = abs(shift)
    key = found.person * (found.frames + 2 * margin) + found.frame + margin
    place = np.searchsorted(key, key + shift).clip(max=len(key) - 1)
    here = np.flatnonzero(key[place] == key + shift)
    return here, place[here]


@dataclass(frozen=True, kw_only=True)
class _Reading:
    """A convention of places and angles, a shift of poses, and people's motion under both: see `_find_reading`."""

    places: str
    angles: AngleReading
    lean: float
    shift: int
    motion: "_Motion"


@dataclass(frozen=True)
class _Motion:
    """Median error of predicted places in box heights; mean speed, and median of its vertical part, in m/s."""

    error: float = np.inf
    speed: float = np.inf
    climb: float = np.inf


def _find_reading(found: Annotations) -> _Reading:
    """Choose the convention of places and angles.

    The criteria, in turn, are upright people on level ground, small errors of prediction, small vertical speed, and low
    speed. (If the camera moves straight on, predictions fit under any convention, but the last two criteria do not.)
    """
    triples = _triples(found)
    tried: dict[bytes, _Reading] = {}
    for angles, lean in _level_readings(found):
        axes = camera_axes(found.angles, angles)
        for places, matrix in PLACES.items():
            positions = found.positions @ np.array(matrix).T
            key = _relative_poses(axes, positions)
            if key not in tried:
                motions = _motions(found, axes, positions, triples)
                shift = _best({shift: motion.error for shift, motion in motions.items()})
                tried[key] = _Reading(places=places, angles=angles, lean=lean, shift=shift, motion=motions[shift])
    left = list(tried.values())
    for name, more, factor in (("error", 0.003, 1.0 / CLEARLY), ("climb", 0.05, 1.0), ("speed", 0.01, EQUAL)):
        values = [getattr(reading.motion, name) for reading in left]
        left = [reading for reading, value in zip(left, values, strict=True) if value <= factor * min(values) + more]
    best = left[0]
    if not best.motion.error <= MOST_POSE_ERROR:
        problem = f"people jump by {best.motion.error:.0%} of their height, at best ({best.shift:+d} frames, "
        problem += f"cam_world_pos as {best.places}, cam_world_rot as {best.angles})"
        raise FileError(found.path, f"{problem}: the camera's poses are not those of these boxes")
    return best


def _level_readings(found: Annotations) -> list[tuple[AngleReading, float]]:
    """Conventions under which people are upright and the ground is level, best first, with the lean in degrees."""
    rows = np.linspace(0, len(found.frame) - 1, min(len(found.frame), MOST_TRIPLES)).astype(int)
    ankles = found.joints[rows][:, ANKLES]
    bodies = found.joints[rows, HEAD_TOP] - ankles.mean(axis=1)
    bodies = bodies / np.maximum(np.linalg.norm(bodies, axis=1, keepdims=True), 1e-9)
    leans, tilts = {}, {}
    for reading in READINGS:
        axes = camera_axes(found.angles, reading)[found.frame[rows]]
        mean = np.einsum("nwc,nc->nw", axes, bodies).mean(axis=0)
        leans[reading] = float(np.degrees(np.arctan2(np.hypot(mean[0], mean[1]), mean[2])))
        tilts[reading] = float(np.hypot(leans[reading], _ground_slope(np.einsum("nwc,njc->njw", axes, ankles))))
    upright = [reading for reading in READINGS if leans[reading] <= MOST_LEAN]
    if not upright:
        best = min(leans, key=lambda reading: leans[reading])
        problem = f"they lean {leans[best]:.0f} degrees at best, as ({best})"
        raise FileError(found.path, f"people do not stand upright however cam_world_rot is read: {problem}")
    least = min(tilts[reading] for reading in upright)
    level = [reading for reading in upright if tilts[reading] <= least + LEVEL]
    level.sort(key=lambda reading: (reading not in KNOWN_READINGS, tilts[reading]))
    return [(reading, leans[reading]) for reading in level]


def _ground_slope(ankles: FloatArray) -> float:
    """Inclination in degrees of the plane through the lower of two ``ankles`` [N, 2, 3], relative to level axes."""
    feet = ankles[np.arange(len(ankles)), ankles[..., 2].argmin(axis=1)]
    feet = feet - feet.mean(axis=0)
    level, usual = feet[:, :2], (GROUND_RELIEF / GROUND_SLOPE) ** 2
    slope = np.linalg.solve(level.T @ level + usual * np.eye(2), level.T @ feet[:, 2])
    return float(np.degrees(np.arctan(np.linalg.norm(slope))))


def _relative_poses(axes: FloatArray, positions: FloatArray) -> bytes:
    """A key of the camera's relative poses under a convention; conventions with equal keys are equivalent."""
    moved = np.einsum("twc,tw->tc", axes, positions - positions[0])
    whole = [np.einsum("twc,wd->tcd", axes, axes[0]).reshape(len(axes), 9), axes[:, 2], moved]
    return bytes((np.round(np.hstack(whole), 5) + 0.0).tobytes())


def _triples(found: Annotations) -> IntArray:
    """Rows [3, M] of the same person at three times, `AHEAD` apart."""
    step = max(1, round(AHEAD * found.fps))
    (late, before), (later, long_before) = (_partners(found, -steps) for steps in (step, 2 * step))
    last, n, m = np.intersect1d(late, later, return_indices=True)
    if not len(last):
        raise FileError(found.path, f"nobody is seen for {2 * AHEAD:g} s: the camera's poses cannot be checked")
    rows = np.stack([long_before[m], before[n], last])
    return rows[:, np.linspace(0, len(last) - 1, min(len(last), MOST_TRIPLES)).astype(int)]


def _motions(found: Annotations, axes: FloatArray, positions: FloatArray, rows: IntArray) -> dict[int, _Motion]:
    """The motion of people of ``rows`` [3, M] by each shift of the poses, in frames."""
    hips = found.joints[rows][:, :, HIPS].mean(axis=2)
    motions = {}
    for shift in range(-MOST_SHIFT, MOST_SHIFT + 1):
        frames = found.frame[rows] + shift
        known = ((frames >= 0) & (frames < found.frames)).all(axis=0)
        if not known.any():
            motions[shift] = _Motion()
            continue
        here, seen = frames[:, known], hips[:, known]
        world = positions[here] + np.einsum("sntc,snc->snt", axes[here], seen)
        expected = np.einsum("ntc,nt->nc", axes[here[2]], 2.0 * world[1] - world[0] - positions[here[2]])
        off = np.linalg.norm(found.project(expected) - found.project(seen[2]), axis=-1)
        walk = (world[2] - world[0]) / (2.0 * AHEAD)
        motions[shift] = _Motion(
            error=float(np.nanmedian(off / found.boxes[rows[2, known], 3])),
            speed=float(np.linalg.norm(walk, axis=-1).mean()),
            climb=float(np.median(np.abs(walk[:, 2]))),
        )
    return motions


def _best(errors: dict[int, float]) -> int:
    """The shift with the least error; 0 unless another is clearly better."""
    best = min(errors, key=lambda shift: (errors[shift], abs(shift)))
    return best if errors[best] < CLEARLY * errors[0] else 0


def _shift_poses(found: Annotations, shift: int) -> Annotations:
    """The video with the poses of ``shift`` frames later; frames that have none are removed."""
    if not shift:
        return found
    frames = np.arange(max(0, -shift), found.frames - max(0, shift))
    rows = (found.frame >= frames[0]) & (found.frame <= frames[-1])
    kept = {name: getattr(found, name)[rows] for name in ("person", "boxes", "joints", "pixels", "visible")}
    poses = {name: getattr(found, name)[frames + shift] for name in ("positions", "angles")}
    return replace(found, **kept, **poses, frame=found.frame[rows] - frames[0], first=found.first + int(frames[0]))


def _mount_height(found: Annotations, above: FloatArray) -> tuple[float, float]:
    """Median height in m of the camera above the soles of people, [N], and how much it changes between frames."""
    frames = np.unique(found.frame)
    heights = [float(np.median(above[found.frame == frame])) for frame in frames]
    middle, spread = float(np.median(above)), float(np.ptp(np.percentile(heights, (5, 95))))
    if not 0.3 <= middle <= 100.0 or spread > MOST_HEIGHT_SPREAD * middle:
        problem = f"the camera is {middle:.2f} m above people's feet, and this changes by {spread:.2f} m"
        raise FileError(found.path, f"{problem}: people and camera must be on one level ground")
    return middle, spread
