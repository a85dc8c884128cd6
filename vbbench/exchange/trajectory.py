"""Trajectory files of other programs: times, places and rotations, with axes yet unknown.

TUM (``timestamp tx ty tz qx qy qz qw``) with six more columns for a covariance, EuRoC and any CSV whose header names
its columns, KITTI's 3 × 4 matrices, with or without a timestamp, and ``time x y`` or ``time x y z`` without rotations.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, quoted
from vbbench.exchange.box_tables import frame_numbers
from vbbench.exchange.text_tables import Layout, NamedColumns, Rows, decode, read_table
from vbbench.files.tables import MOTION_COVARIANCE
from vbbench.geometry import FloatArray
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
    axes : the body's axes as the file states them, a key of `vbbench.exchange.axes.AXES`.
    """

    times: FloatArray | None
    places: FloatArray
    rotations: Mapping[str, FloatArray]
    unit: float | None = None
    covariances: FloatArray | None = None
    axes: str | None = None


def read_trajectory(path: Path) -> Trajectory:
    """Read a file."""
    if not path.is_file():
        raise FileError(path, "the file is missing")
    content = decode(path, path.read_bytes())
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
    if (
        count > 8 and abs(hypot(*(parse_number(cell) or 0.0 for cell in row[4:8])) - 1.0) < _UNIT_TOLERANCE
    ):  # a quaternion
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
