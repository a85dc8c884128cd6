"""The axes of a trajectory's body, inferred from its motion; and its poses on the ground.

A body on the ground moves perpendicular to its vertical, rotates about it, and mostly moves forward. Of the orders of a
quaternion's components and the usual axes, those are chosen under which the trajectory does so. TUM's body (x forward,
z up, in a world whose z is up) is preferred: it needs no motion along x.
"""

from cmath import phase
from itertools import product
from math import dist
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError
from vbbench.exchange.trajectory import ANGLES, MATRIX, XYZW, Trajectory
from vbbench.geometry import FloatArray, IntArray, wrap_angle

Axes = Literal["body", "camera", "opengl", "ned", "imu", "unity", "unreal"]
AXES = {"body": "flu", "camera": "rdf", "opengl": "rub", "ned": "frd", "imu": "rfu", "unity": "ruf", "unreal": "fru"}
"""Where x, y and z of a body point: f forward, b backward, l left, r right, u up, d down; the last two left-handed."""
_WORDS = dict(zip("fblrud", ("forward", "backward", "left", "right", "up", "down"), strict=True))
_USUAL = ("body", "camera", "opengl", "ned")
_STEEPEST = 0.6
"""Rad by which a body may lean; more is another convention of axes."""
STEP = 0.3
"""M from one place to the next that shows where a body goes, not how its place shakes."""
_CHORD = 0.5
"""M over which a path has the direction that is taken for its yaw."""
_CLIMB = 0.5
"""Share of the way that may lead along the vertical."""
_TURNED, _TURNED_STANDING = 0.35, 0.1
"""Rad of rotation that must be about the vertical, of a body that moves and of one that stands."""
_BACKWARDS = 2.4
"""Rad: motion beyond this angle is backward."""
_STEADY = 0.85
"""Length of the mean direction of motion, in a body's axes, from which on it shows where the body looks."""
_UNUSUAL = 0.1
"""How much better another order than the usual one must fit."""
_AHEAD = 0.8
"""Rad: motion within this angle is forward."""
_BEND, _CUSP = 0.25, 2.1
"""Rad by which a path bends that needs rotations, and by which no path without rotations may turn at once."""


def described(axes: str) -> str:
    """Axes in words, such as ``x forward, y left, z up``."""
    return ", ".join(f"{name} {_WORDS[letter]}" for name, letter in zip("xyz", AXES[axes], strict=True))


class Grounded(NamedTuple):
    """Poses [N, 3] (x, y, yaw) on the ground, yaw in [−π, π), that of the path or not; and notes for the user."""

    poses: FloatArray
    from_path: bool = False
    notes: tuple[str, ...] = ()


def ground_poses(trajectory: Trajectory, axes: str | None = None) -> Grounded:
    """The poses of a trajectory on the ground; the yaw is that of the body's forward axis projected to the ground.

    ``axes``, a key of `AXES`, are inferred from the motion unless they are known.
    """
    axes, orders = axes or (trajectory.axes if trajectory.axes in AXES else None), trajectory.rotations
    places, name = trajectory.places, trajectory.path.name
    if not orders:
        _refuse_yaw_as_height(trajectory)
        return _along_path(trajectory, axes, "there are no rotations")
    first = next(iter(orders.values()))
    still = axes is None and np.abs(first - first[0]).max() < 1e-6
    far = np.diff(places[_corners(places, max(STEP, float(np.ptp(places, axis=0).max()) / 8.0))], axis=0)
    ways = far / np.linalg.norm(far, axis=1, keepdims=True)
    if still and (ways @ ways.T).min(initial=1.0) < np.cos(_BEND):  # more than noise of places bends a path
        return _along_path(trajectory, axes, "its rotation never changes, but its path bends")
    steps = _corners(places, STEP)
    kinds = _USUAL if axes is None else (axes,)
    readings = [_read_as(places, orders[order], order, kind, steps) for order, kind in product(orders, kinds)]
    usual = readings[0].order
    fitting = [one for one in readings if (one.fits if axes is None else one.upright)]
    starts = {order for order in orders if np.allclose(orders[order][0], np.eye(3), atol=1e-3)}
    fitting = [one for one in fitting if one.order == usual or one.ahead or (one.order in starts and one.heading)]
    plain = readings[0].heading or 0j
    ahead = [one for one in fitting if one.ahead and one.axes == readings[0].axes and one.order in ANGLES]
    ways = {one.heading or 0j: one for one in ahead}
    straight = _read_as(places, np.broadcast_to(np.eye(3), first.shape), "", readings[0].axes, steps).heading or 0j
    swings = np.abs(wrap_angle(np.diff(readings[0].poses[:, 2]))).max(initial=0.0) > _TURNED
    # Angles follow the bends of the path, unless they would swing from line to line as given.
    least = abs(plain) if swings else max(abs(plain), 0.5 + 0.5 * abs(straight))
    better = [way for way in ways if way.real >= plain.real + _UNUSUAL and abs(way) > least]
    angle = ways[max(better, key=abs)] if better else None
    unusual = {order: -0.01 if order in starts else _UNUSUAL * (order != usual) for order in orders}
    found = angle or min(fitting, key=lambda one: (one is not readings[0], one.cost + unusual[one.order]), default=None)
    if axes is None:
        _refuse_inverse(trajectory, found)
    if found is None:
        raise _misfit(readings, trajectory)
    notes = []
    moves = found.heading is not None or found.turned > _TURNED_STANDING
    if axes is None and moves and found.axes != "body" and found.order != MATRIX:
        words = f"{name} is read in the axes of '{found.axes}', which its motion fits: {described(found.axes)}"
        notes.append(words + ("; SLAM of one camera has no scale: are places in m?" if found.axes == "camera" else ""))
    if found.order != usual:
        notes.append(f"{name} is read as {found.order}, which its motion fits")
    if axes is not None and found.climb > _CLIMB:
        notes.append(f"{name}: in the axes of '{axes}' {found.climb:.0%} of the way leads up or down: is it '{axes}'?")
    aside = phase(found.heading or 1.0)
    if still and _BEND < abs(aside) <= _AHEAD:
        way = f"its path leads {np.degrees(abs(aside)):.0f}° to a side of where it looks"
        advice = "if nothing measured rotations, remove them: time x y z"
        notes.append(f"{name}: its rotation never changes, and {way}; {advice}")
    return Grounded(poses=found.poses, notes=tuple(notes))


class _Reading(NamedTuple):
    """A trajectory under a hypothesis of the quaternion's order and of the axes.

    Parameters
    ----------
    lean : [N] rad between the body's up axis and the vertical.
    climb : share of the way along the vertical; 0 of a body that stands.
    heading : mean of exp(i · angle from the forward axis to the motion) along the path; ``None`` if it stands.
    turned : largest rotation in rad.
    upright : whether the body's lean stays that of a camera that looks ahead.
    drives : whether it is upright, moves perpendicular to the vertical and rotates about it.
    ahead : whether it moves forward.
    fits : whether the hypothesis is possible; in a world with y vertical, only forward motion shows which end is up.
    cost : misfit, 0 for an upright body that moves forward and rotates about the vertical.
    """

    order: str
    axes: str
    poses: FloatArray
    lean: FloatArray
    climb: float
    heading: complex | None
    turned: float
    upright: bool
    drives: bool
    ahead: bool
    fits: bool
    cost: float


def _read_as(places: FloatArray, rotations: FloatArray, order: str, axes: str, steps: IntArray) -> _Reading:
    """Places [N, 3] and rotations [N, 3, 3] under one hypothesis; ``steps`` are rows between which the body moves."""
    from scipy.spatial.transform import Rotation  # takes a while to import

    sides = {letter: np.eye(3)[index] for index, letter in enumerate(AXES[axes])}
    right, looks, up = (sides[one] if one in sides else -sides[other] for one, other in ("rl", "fb", "ud"))
    if np.linalg.det(np.stack([right, looks, up])) < 0.0:  # left-handed: seen in a mirror that turns up to down
        mirror = np.diag(1.0 - 2.0 * np.abs(up))
        places, rotations, up = places @ mirror, mirror @ rotations @ mirror, -up
    upwards, looks = rotations @ up, rotations @ looks
    moves = np.diff(places[steps], axis=0)
    way = np.linalg.norm(moves, axis=1)
    vertical = np.eye(3)[2] if axes == "body" else _vertical(upwards, rotations @ right, moves / way[:, None])
    level = bool(vertical[2] > 0.99)
    ahead = np.eye(3)[2 if abs(vertical[2]) < 0.5 else 0]
    ahead -= (ahead @ vertical) * vertical
    ahead /= np.linalg.norm(ahead)
    ground = np.stack([ahead, np.cross(vertical, ahead)], axis=-1)
    poses = np.column_stack([places @ ground, wrap_angle(np.arctan2(*(looks @ ground).T[::-1]))])
    ways = _ways(poses, steps)
    heading = complex(ways.sum() / max(np.abs(ways).sum(), 1e-9)) if len(ways) else None
    aside, steady = abs(phase(heading or 1.0)), abs(heading or 0.0) > _STEADY
    forward = steady and aside < _AHEAD
    lean = np.arccos(np.clip(upwards @ vertical, -1.0, 1.0))
    climb = float(np.abs(moves @ vertical).sum() / way.sum()) if len(moves) else 0.0
    turns = Rotation.from_matrix(rotations @ rotations[0].T).as_rotvec()
    turned = float(np.linalg.norm(turns, axis=1).max())
    spin = float(((turns @ vertical) ** 2).sum() / max((turns**2).sum(), 1e-12))
    upright = bool(lean.max() < _STEEPEST)
    drives = upright and climb < _CLIMB and (turned < (_TURNED_STANDING if heading is None else _TURNED) or spin > 0.5)
    if heading is None and turned < _TURNED_STANDING:  # nothing shows the axes
        fits = drives and level and axes in ("body", "camera")
    elif not drives or heading is None or forward or axes == "body":
        fits = drives and (level or axes == "camera")
    else:
        sideways = abs(vertical[1]) > np.cos(_STEEPEST) and axes == "camera" and steady and aside < _BACKWARDS
        fits = bool(lean.max() < 0.5 * _STEEPEST) and (level or sideways)
    misfit = (0.0 if heading is None else 1.0 - heading.real) + float(np.mean(1.0 - np.cos(lean)))
    cost = misfit + (1.0 - spin) * min(turned / _TURNED_STANDING, 1.0)
    return _Reading(order, axes, poses, lean, climb, heading, turned, upright, drives, forward, fits, cost)


def _vertical(upwards: FloatArray, rights: FloatArray, moves: FloatArray) -> FloatArray:
    """The vertical [3]: the world's z if the body's up axis is near it, else the normal of all motion.

    The body's axes ``upwards`` and ``rights`` [N, 3] and directions of motion ``moves`` [M, 3] are in the world; on the
    ground ``rights`` stay level.
    """
    mean = upwards.mean(axis=0)
    length = float(np.linalg.norm(mean))
    if length < 0.1 or abs(mean[2]) > np.cos(_STEEPEST) * length:
        return np.array([0.0, 0.0, -1.0 if mean[2] < 0.0 else 1.0])
    mean /= length
    across = rights.T @ rights / len(rights) + 0.01 * (np.eye(3) - np.outer(mean, mean))
    if len(moves):
        across += moves.T @ moves / len(moves)
    found = np.linalg.eigh(across)[1][:, 0]
    return np.asarray(found * (1.0 if found @ mean >= 0.0 else -1.0))


def _refuse_inverse(trajectory: Trajectory, found: _Reading | None) -> None:
    """Raise FileError if the motion is plausible only for inverse poses, from the world to the body."""
    least = 0.95
    if found is not None:
        if found.heading is None or found.heading.real > 0.8:
            return
        least = max(least, abs(found.heading) + 0.02)
    for order, rotations in trajectory.rotations.items():
        back = rotations.swapaxes(1, 2)
        places = -np.einsum("nij,nj->ni", back, trajectory.places)
        steps = _corners(places, STEP)
        for kind in _USUAL:
            one = _read_as(places, back, order, kind, steps)
            if one.drives and one.turned > _TURNED and one.heading and one.heading.real > least and len(steps) > 10:
                problem = "poses move as a camera does only if they are from the world to the camera (Tcw)"
                raise FileError(trajectory.path, f"{problem}; write their inverses, from the camera to the world")


def _misfit(readings: list[_Reading], trajectory: Trajectory) -> FileError:
    """The error about a trajectory that fits no hypothesis of order and axes."""
    first, row = readings[0], None
    keys = ", ".join(f"'{name}'" for name in AXES)
    angles = [abs(phase(one.heading)) for one in readings if one.axes == "camera" and one.drives and one.heading]
    if angles and angles[0] > _BACKWARDS:
        what = (
            f"in camera axes ({described('camera')}) it moves {np.degrees(angles[0]):.0f}° from where it looks: it is "
            f"driven backwards, or has others, such as OpenGL's ({described('opengl')}), or poses are from the world "
            "to the camera"
        )
    elif not first.upright:
        row = int(first.lean.argmax())
        what = f"the body leans by {np.degrees(first.lean[row]):.3g}°, and no usual axes or order fit its motion"
    else:
        what = f"{first.climb:.0%} of the way leads along z, and no usual axes or order of {XYZW} fit the motion"
    problem = f"{what}; write poses of a body with {described('body')}, or axes = ... in [odometry] ({keys})"
    return FileError(trajectory.path, problem) if row is None else trajectory.fault(row, problem)


def _corners(places: FloatArray, reach: float) -> IntArray:
    """Rows of places [N, 2 or 3] that are ``reach`` m or more from the one before, and the first."""
    rows, points = [0], places.tolist()
    for row, point in enumerate(points):
        if dist(points[rows[-1]], point) >= reach:
            rows.append(row)
    return np.array(rows)


def _along_path(trajectory: Trajectory, axes: str | None, why: str) -> Grounded:
    """Poses whose yaw is the direction of the path, over `_CHORD` m; it is held while the body stands."""
    path, count, axes = trajectory.path, len(trajectory), axes or _axes_of_path(trajectory)
    still = np.broadcast_to(np.eye(3), (count, 3, 3))
    places = _read_as(trajectory.places, still, "", axes, np.array([0])).poses[:, :2]
    rows = _corners(places, _CHORD)
    if len(rows) < 2:
        problem = f"{why}, and no place is {_CHORD:g} m from the first"
        raise FileError(path, f"{problem}: nothing gives the yaw; write qx qy qz qw")
    chords = np.diff(places[rows], axis=0)
    turns = wrap_angle(np.diff(np.arctan2(chords[:, 1], chords[:, 0])))
    if (np.abs(turns) > _CUSP).any():
        corner = int((np.abs(turns) > _CUSP).argmax()) + 1
        problem = f"{why}, and the path turns back by {np.degrees(abs(turns[corner - 1])):.0f}°"
        advice = "places do not show if the camera turned; write qx qy qz qw"
        raise trajectory.fault(int(rows[corner]), f"{problem}: {advice}")
    at = np.searchsorted(rows, np.arange(count), side="right").clip(1, len(rows) - 1) - 1
    share = ((places - places[rows[at]]) * chords[at]).sum(axis=1) / (chords[at] ** 2).sum(axis=1)
    yaws = np.arctan2(*chords[0, ::-1]) + np.append(0.0, np.cumsum(turns))
    knots, last = np.arange(len(yaws)) + 0.5, turns if len(turns) else np.zeros(1)
    ends = np.concatenate([[yaws[0] - 0.5 * last[0]], yaws, [yaws[-1] + 1.5 * last[-1]]])
    share = share.clip(0.0, np.where(at == len(yaws) - 1, 2.0, 1.0))
    yaw = np.interp(at + share, np.concatenate([[0.0], knots, [len(yaws) + 1.0]]), ends)
    note = f"{path.name}: {why}: the yaw is taken from the path, as of a camera that looks where it goes"
    return Grounded(poses=np.column_stack([places, wrap_angle(yaw)]), from_path=True, notes=(note,))


def _refuse_yaw_as_height(trajectory: Trajectory) -> None:
    """Raise FileError if z follows the direction of the path: then it is a yaw, not a height."""
    ground, z = trajectory.places[:, :2], trajectory.places[:, 2]
    rows = _corners(ground, _CHORD)
    ways = np.unwrap(np.arctan2(*np.diff(ground[rows], axis=0).T[::-1]))
    if len(ways) < 3 or np.ptp(ways) < _TURNED:
        return
    for unit in (1.0, np.radians(1.0)):
        angles = np.unwrap(unit * z)[rows]
        if np.ptp(0.5 * (angles[1:] + angles[:-1]) - ways) < 0.3 * np.ptp(ways):
            problem = "z turns as the path does: is it the yaw? Then write 'time x y yaw' in a first line"
            raise FileError(trajectory.path, f"{problem}, or 'yaw_deg'")


def _axes_of_path(trajectory: Trajectory) -> str:
    """The world's axes under which places [N, 3] are on the ground; the world of a first camera has z ahead."""
    moves = np.diff(trajectory.places[_corners(trajectory.places, STEP)], axis=0)
    shares = np.abs(moves).sum(axis=0) / max(float(np.linalg.norm(moves, axis=1).sum()), 1e-9)
    if shares[2] < _CLIMB:
        return "body"
    start = moves[0] / np.linalg.norm(moves[0])
    if shares[1] > 0.2 or start[2] < 0.5:
        problem = f"{shares[2]:.0%} of the way leads along z, which is up in a body's world and ahead in a camera's"
        raise FileError(trajectory.path, f"{problem}; write axes = 'body' or 'camera' in [odometry]")
    return "camera"


def off_course(poses: FloatArray) -> tuple[float, float]:
    """The share of the path of poses [N, 3] that does not lead forward, and the mean angle to the left in rad."""
    ways = _ways(poses, _corners(poses[:, :2], STEP))
    share = float(np.abs(ways)[np.abs(np.angle(ways)) > _AHEAD].sum() / max(float(np.abs(ways).sum()), 1e-9))
    return share, float(np.angle(ways.sum()))


def _ways(poses: FloatArray, steps: IntArray) -> NDArray[np.complex128]:
    """[M − 1] motions between rows ``steps`` [M] of poses [N, 3], forward + i · left, in axes of the mean yaw."""
    x, y = np.diff(poses[steps, :2], axis=0).T
    seen = np.exp(1j * poses[steps[:-1], 2]) + np.exp(1j * poses[steps[1:], 2])
    return np.asarray((x + 1j * y) * np.exp(-1j * np.angle(seen)))
