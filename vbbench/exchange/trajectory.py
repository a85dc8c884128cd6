"""Trajectory files of other programs: times, places, rotations; the axes of the body; and its poses on the ground.

TUM (``timestamp tx ty tz qx qy qz qw``) with six more columns for a covariance, EuRoC and any CSV whose header names
its columns, KITTI's 3 × 4 matrices, with or without a timestamp, and ``time x y`` or ``time x y z`` without rotations.

A body on the ground moves perpendicular to its vertical, rotates about it, and mostly moves forward. Of the orders of a
quaternion's components and the usual axes, those are chosen under which the trajectory does so. TUM's body (x forward,
z up, in a world whose z is up) is preferred: it needs no motion along x.
"""

import re
from cmath import phase
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from math import dist, hypot
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, quoted
from vbbench.exchange.box_tables import frame_numbers
from vbbench.exchange.text_tables import Layout, NamedColumns, Rows, decode, read_content, read_table
from vbbench.files.tables import MOTION_COVARIANCE
from vbbench.geometry import FloatArray, IntArray, wrap_angle
from vbbench.parsing.column_names import UNITS, Header
from vbbench.parsing.numbers import parse_number

TUM = "timestamp tx ty tz qx qy qz qw"
_TUM = "time:timestamp x:tx y:ty z:tz qx qy qz qw"
_CELLS = "x0 x1 x2 x y0 y1 y2 y z0 z1 z2 z"
_FORMS = ["time x y", "time x y z", _TUM, f"{_TUM} {' '.join(MOTION_COVARIANCE)}"]
_FORMS += [f"{time}{_CELLS}{last}" for time in ("", "time ") for last in ("", " (30) (31) (32) (33)")]
_LAYOUTS = {len(form.split()): form for form in _FORMS}
"""Columns of files without names, by their number."""
_WANTED = "name columns time, x, y, and qx, qy, qz, qw or yaw"
XYZW, WXYZ, MATRIX, YAW, DEGREES = "qx qy qz qw", "qw qx qy qz", "matrix", "yaw", "yaw in degrees"
COMPASS, CLOCKWISE = "heading clockwise from y", "yaw clockwise"
ANGLES = DEGREES, COMPASS, CLOCKWISE
"""Orders in which rotations stand in columns, and what an angle may be."""
_QUATERNION = ("qx", "qy", "qz", "qw")
_NOUNS = ("frame", "time", "nanoseconds", "x", "y", "z", *_QUATERNION, "yaw")
_STATED = re.compile(r"axes: (\w+)|x forward, z up")
"""Words of a comment that state the axes of the body; the latter `vbbench.exchange.tum.export_tum` writes."""
_UNREAD = {
    r"\s*[\[{]": "is JSON",
    r"VERTEX_|EDGE_": "is a graph of g2o",
    r"(?:---\s+)?header:\s": "is printed messages; print CSV, with ros2 topic echo --csv or rostopic echo -p",
    r"(?:#.*\n)*\d+ (?:\S+ ){8}\S+\.\w+\s": "is COLMAP's images.txt, from the world to the camera and in no unit",
    r"(?:(?:[-+.\deE]+[ \t]+){3}[-+.\deE]+[ \t]*\n){3}(?:[-+0.e]+[ \t]+){3}\+?1": "is matrices of four lines each",
}
"""How files begin that are not read, and what they are."""
_ROTATION = re.compile(
    r"(?i)(?:r|rot)[_.]?[xyz]|.*(?:rotation|rotvec|rvec|rodrigues|quat|euler|bearing|compass|course|yaw|theta).*"
)
"""Names of columns of rotations that are not read."""
_FARTHEST, _MOST_RADIANS = 2e7, 7.0
"""Largest distance in m of a pose from the world's origin, and angle in a column that names no unit."""
_HEAD = 100_000
"""Bytes of a file that show what it is."""
_UNIT_TOLERANCE, _SKEW = 1e-3, 1e-2
"""How far the length of a quaternion without a name may be from 1, and others and matrices from rotations."""


@dataclass(frozen=True, kw_only=True)
class Trajectory(Rows):
    """The rows of a trajectory file.

    Parameters
    ----------
    times : [N] timestamps; ``None`` if rows have none, and each is a frame.
    unit : unit of the times in s; 0 if they are numbers of frames, ``None`` if the file names none.
    places : [N, 3] in m.
    rotations : [N, 3, 3] from the body to the world, by the order of their columns: none, one, or two if unclear.
    covariances : [N, 6] of the motion since the line before (`MOTION_COVARIANCE`), if the file has them.
    axes : the body's axes as the file states them, a key of `AXES`.
    """

    times: FloatArray | None
    places: FloatArray
    rotations: Mapping[str, FloatArray]
    unit: float | None = None
    covariances: FloatArray | None = None
    axes: str | None = None


def read_trajectory(path: Path) -> Trajectory:
    """Read a file."""
    content = decode(path, read_content(path, "a trajectory"))
    head = content[:_HEAD].decode("utf-8", "replace")
    for begin, kind in _UNREAD.items():
        if re.match(begin, head):
            raise FileError(path, f"{kind}; write lines of '{TUM}', from the body to the world, in m")
    axes = [found[1] or "body" for found in map(_STATED.search, re.findall(r"(?m)^[ \t]*[#%].*$", head)) if found]
    table = read_table(
        path,
        _plain(content),
        _NOUNS,
        layout=_layout,
        required=(*_NOUNS, *MOTION_COVARIANCE),
        usable=lambda header, comment: _is_whole(header) if comment else bool(header.columns),
        repeated=("time", "frame"),
    )
    if not len(table):
        raise FileError(path, f"holds no pose; write lines of '{TUM}'")
    _refuse_unknown(table)
    for noun in (noun for noun in table.columns if noun not in ("time", "frame", "nanoseconds")):
        values = table.numbers(noun)
        table.refuse(np.abs(values) > _FARTHEST, f"{noun} is {{0:g}}; it must be within ±{_FARTHEST:g} m", values)
    zero, numbered = np.zeros(len(table)), "frame" in table and "time" not in table
    times = frame_numbers(table) if numbered else table.numbers("time") if "time" in table else None
    if times is not None and "nanoseconds" in table and re.search("secs?$", table.called("time")):
        times = times + 1e-9 * table.numbers("nanoseconds")
    return Trajectory(
        path=path,
        lines=table.lines,
        times=times,
        unit=0.0 if numbered else UNITS.get(table.unit("time")),
        places=np.stack([table.scaled(name) if name in table else zero for name in "xyz"], axis=-1),
        rotations=_rotations(table),
        covariances=table.stacked(*MOTION_COVARIANCE) if MOTION_COVARIANCE[0] in table else None,
        axes=axes[-1] if axes else None,
    )


def _plain(content: bytes) -> bytes:
    """The text with # before comments, blanks for tabs, and names without the path of a message before them."""
    head, rest = content[:_HEAD], content[_HEAD:]
    head = re.sub(rb"[/\w.]*\b(?=(?:position|orientation)[./])|\b(?:field|pose)\.|\(body.*", b"", head)
    content = re.sub(rb"(?m)^[ \t]*%", b"#", head + rest)
    return content if b"," in content or b";" in content else content.replace(b"\t", b" ")


def _is_whole(header: Header) -> bool:
    turned = sum(name in header for name in _QUATERNION)
    return ("time" in header or "frame" in header) and "x" in header and "y" in header and turned in (0, 4)


def _refuse_unknown(table: NamedColumns) -> None:
    """Raise FileError if named columns are incomplete, or are rotations of an unsupported kind."""
    header = table.header
    if header is None:
        return
    if not _is_whole(header):
        raise FileError(table.path, f"its first line is {quoted(','.join(header.names))}; {_WANTED}", 1)
    lost = [name for name in header.ignored if _ROTATION.fullmatch(name)]
    if lost and not ("qx" in header or "yaw" in header):
        problem = f"rotations are not read by the names {', '.join(lost)}"
        advice = "write 'yaw [rad]' or 'yaw [deg]', or qx, qy, qz, qw, or remove them"
        raise FileError(table.path, f"{problem}; {advice}")


def _layout(row: list[str]) -> Layout:
    """The columns of a file without names, by their number; TUM's may be followed by more."""
    if row and parse_number(row[0]) is None:
        raise ValueError(f"its first line is {quoted(' '.join(row))}; {_WANTED}")
    count = len(row)
    if count in _LAYOUTS or not row:
        return _LAYOUTS.get(count, "")
    length = hypot(*(parse_number(cell) or 0.0 for cell in row[4:8]))
    if count > 8 and abs(length - 1.0) < _UNIT_TOLERANCE:  # a quaternion
        return " ".join([_TUM, *(f"({column})" for column in range(9, count + 1))])
    wanted = f"wanted 8 with spaces between: {TUM}"
    raise ValueError(f"{count} columns, {wanted}; or 3 x 4 matrices; or a first line of names")


def _rotations(table: NamedColumns) -> dict[str, FloatArray]:
    """Rotations [N, 3, 3] by each possible order of their columns."""
    if "x0" in table:
        matrices = table.stacked(*(f"{row}{column}" for row in "xyz" for column in "012")).reshape(-1, 3, 3)
        skew = np.abs(matrices @ matrices.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2))
        skew[np.linalg.det(matrices) < 0.0] = 2.0
        table.refuse(skew > _SKEW, "columns 1 to 3, 5 to 7 and 9 to 11 are no rotation (off by {0:.3g})", skew)
        return {MATRIX: matrices}
    from scipy.spatial.transform import Rotation  # takes a while to import

    if "yaw" in table:
        yaw, named = table.scaled("yaw"), bool(table.unit("yaw"))
        far = (np.abs(yaw) > _MOST_RADIANS) & (not named)
        table.refuse(far, "yaw is {0:g}; name its column 'yaw [deg]' or 'yaw [rad]'", yaw)
        turned = {YAW: yaw, COMPASS: 0.5 * np.pi - yaw, CLOCKWISE: -yaw} | ({} if named else {DEGREES: np.radians(yaw)})
        return {order: Rotation.from_euler("z", angle[:, None]).as_matrix() for order, angle in turned.items()}
    quaternions = table.stacked(*_QUATERNION) if "qw" in table else np.zeros((len(table), 4))
    length = np.linalg.norm(quaternions, axis=-1)
    if not length.any():
        return {}
    problem = "the quaternion (qx qy qz qw) has length {0:.4g}; a rotation has 1: name the columns, or divide by it"
    table.refuse(np.abs(length - 1.0) > _SKEW, problem, length)
    first = {} if table.header else {WXYZ: Rotation.from_quat(np.roll(quaternions, -1, axis=-1)).as_matrix()}
    return {XYZW: Rotation.from_quat(quaternions).as_matrix(), **first}


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
