"""Trajectory files as programs write them: times, places and rotations, before anything is assumed of their axes.

TUM (``timestamp tx ty tz qx qy qz qw``) with six more columns for a covariance, EuRoC and any CSV whose header names
its columns, KITTI's 3 × 4 matrices, with or without a timestamp, and ``time x y`` or ``time x y z`` without rotations.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, quoted
from vbbench.exchange.box_tables import frame_numbers
from vbbench.exchange.text_tables import NamedColumns, Rows, decode, read_table
from vbbench.files.tables import MOTION_COVARIANCE
from vbbench.geometry import FloatArray
from vbbench.parsing.column_names import UNITS, Header, header_of, separator_of
from vbbench.parsing.numbers import parse_number

TUM = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
XYZW, WXYZ, MATRIX, YAW, DEGREES = "qx qy qz qw", "qw qx qy qz", "matrix", "yaw", "yaw in degrees"
"""Orders in which rotations stand in columns."""
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
_ROTATION = re.compile(r"(?i)(?:r|rot)[_.]?[xyz]|.*(?:rotation|rotvec|quat|euler|bearing|compass|course).*")
"""Names of columns of rotations that are not read."""
_FARTHEST, _MOST_RADIANS = 2e7, 7.0
"""Largest distance in m of a pose from the world's origin, and angle in a column that names no unit."""
_HEAD = 100_000
"""Bytes of a file that show what it is."""
_UNIT_TOLERANCE, _SKEW = 1e-3, 1e-2
"""How far a quaternion's length may be from 1, and a matrix from a rotation: files often have four digits."""


@dataclass(frozen=True, kw_only=True)
class Trajectory(Rows):
    """The rows of a trajectory file.

    Parameters
    ----------
    times : [N] timestamps; ``None`` where rows have none, a row a frame.
    unit : of the times in s; 0 where they are numbers of frames, ``None`` where the file names none.
    places : [N, 3] in m.
    rotations : [N, 3, 3] from the body to the world by the order of their columns: none, one, or two where it is open.
    covariances : [N, 6] of the motion since the line before (`MOTION_COVARIANCE`), where the file has them.
    axes : what the file states of the body's axes, a key of `vbbench.exchange.axes.AXES`.
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
    named, axes, line, cells, rows = _split(path)
    stated = _header(path, named, len(cells))
    header = stated or _layout(path, line, cells)
    table = _numbers(path, rows, header)
    columns = {noun: table.numbers(noun) for noun in table.columns if noun != "frame"}
    scales = {name: UNITS.get(header.units.get(name, ""), 1.0) for name in ("x", "y", "z")}
    places = np.stack([columns.get(name, np.zeros(len(table))) * scale for name, scale in scales.items()], axis=-1)
    times = columns.get("time", frame_numbers(table) if "time" not in table and "frame" in table else None)
    if "nanoseconds" in columns and "time" in columns and re.search("secs?$", header.names[header.columns["time"]]):
        times = columns["time"] + 1e-9 * columns["nanoseconds"]
    return Trajectory(
        path=path,
        lines=table.lines,
        times=times,
        unit=0.0 if "frame" in table and "time" not in table else UNITS.get(header.units.get("time", "")),
        places=places,
        rotations=_rotations(table, columns, header.units.get("yaw"), stated is not None),
        covariances=np.stack([columns[c] for c in MOTION_COVARIANCE], -1) if MOTION_COVARIANCE[0] in columns else None,
        axes=axes,
    )


def _split(path: Path) -> tuple[str, str | None, int, list[str], bytes]:
    """The line of names, a comment or the first line; axes that a comment states; line and cells of the first row.

    Last come all rows, after as many empty lines as the file has other ones before them.
    """
    whole = decode(path, path.read_bytes())
    head = whole[:_HEAD].decode("utf-8", "replace")
    for begin, kind in _UNREAD.items():
        if re.match(begin, head):
            raise FileError(path, f"{kind}; write lines of '{' '.join(TUM)}', from the body to the world, in m")
    axes = [found[1] or "body" for found in map(_STATED.search, re.findall(r"(?m)^[ \t]*[#%].*$", head)) if found]
    first, comment, line = "", "", 0
    for line, found in enumerate(re.finditer(rb"[^\n]*\n|[^\n]+$", whole)):  # noqa: B007
        text = found[0].decode("utf-8", "replace").strip()
        if text.startswith(("#", "%")):
            comment = text
        elif first or parse_number(re.split(r"[\s,;|]", text)[0]) is not None:
            if text:
                break
        else:
            first = text
    else:
        raise FileError(path, f"holds no pose; write lines of '{' '.join(TUM)}'")
    mark, rows = separator_of(text), b"\n" * line + whole[found.start() :]
    if b"%" in rows:
        rows = re.sub(rb"(?m)^[ \t]*%.*$", b"", rows)
    if mark == "\t":
        rows, text, mark = rows.replace(b"\t", b" "), text.replace("\t", " "), " "
    elif not first and text.endswith(mark):  # lines of VINS end with a comma
        rows, text = re.sub(rb"%b[ \t]*(?=\n|$)" % re.escape(mark.encode()), b"", rows), text.removesuffix(mark)
    return first or comment, axes[-1] if axes else None, line + 1, text.split(None if mark == " " else mark), rows


def _header(path: Path, named: str, count: int) -> Header | None:
    """What a line names, if it is the header of ``count`` columns."""
    plain = re.sub(r"[/\w.]*\b(?=(?:position|orientation)[./])", "", named)  # of messages, by any path
    plain = re.sub(r"\b(?:field|pose)\.|\(body.*", "", plain)  # also the end of our own comment
    header = header_of(plain, _NOUNS, least=0)
    comment = named[:1] in ("#", "%", "")
    if header is None or (comment and len(header.names) != count):
        return None
    turned = [name for name in _QUATERNION if name in header]
    timed = "time" in header or "frame" in header
    if not (timed and {"x", "y"} <= set(header.columns)) or 0 < len(turned) < len(_QUATERNION):
        if comment:
            return None
        problem = f"its first line is {quoted(named)}; name columns time, x, y, and qx, qy, qz, qw or yaw"
        raise FileError(path, problem, 1)
    for noun, names in header.doubtful.items():
        if noun not in ("time", "frame"):
            raise FileError(path, f"columns {' and '.join(names)} are both {noun}; keep one of them", 1)
    lost = [] if turned or "yaw" in header else [name for name in header.ignored if _ROTATION.fullmatch(name)]
    if lost:
        wanted = "'yaw [rad]' or 'yaw [deg]', or qx, qy, qz, qw"
        raise FileError(path, f"rotations are not read by the names {', '.join(lost)}; write {wanted}, or remove them")
    return header


def _layout(path: Path, line: int, row: list[str]) -> Header:
    """The columns of a file without a header, by how many there are; more may stand after those of TUM."""
    cells = ["x0", "x1", "x2", "x", "y0", "y1", "y2", "y", "z0", "z1", "z2", "z"]
    whole, quaternion = [*cells, "30", "31", "32", "33"], ["time", "x", "y", "z", *_QUATERNION]
    spread = [*quaternion, *MOTION_COVARIANCE]
    known = (quaternion[:3], quaternion[:4], quaternion, spread, cells, ["time", *cells], whole, ["time", *whole])
    count, turn = len(row), [parse_number(cell) or 0.0 for cell in row[4:8]]
    more = quaternion if count > len(TUM) and abs(np.linalg.norm(turn) - 1.0) < _UNIT_TOLERANCE else None
    names = next((one for one in known if len(one) == count), more)
    if names is None:
        wanted = f"wanted {len(TUM)} with spaces between: {' '.join(TUM)}"
        raise FileError(path, f"{count} columns, {wanted}; or 3 x 4 matrices; or a first line of names", line)
    rest = [""] * (count - len(TUM)) if names is quaternion else names[len(TUM) :]
    shown = (*TUM, *rest) if names in (quaternion, spread) else tuple(names)
    return Header(shown, {name: column for column, name in enumerate(names)}, {}, {})


def _numbers(path: Path, rows: bytes, header: Header) -> NamedColumns:
    """The columns of rows, by a header that need not be theirs."""
    nouns, count = {column: noun for noun, column in header.columns.items()}, len(header.names)
    order = {nouns.get(column, f"column {column}"): name for column, name in enumerate(header.names)}
    table = read_table(path, rows, (), order=order, columns=(count, count), read=tuple(header.columns))
    for noun in table.columns.keys() - {"time", "frame", "nanoseconds"}:
        values = table.numbers(noun)
        problem = f"it must be within ±{_FARTHEST:g} m"
        table.refuse(np.abs(values) > _FARTHEST, f"{noun} is {{0:g}}; {problem}", values)
    return table


def _rotations(rows: Rows, table: Mapping[str, FloatArray], unit: str | None, named: bool) -> dict[str, FloatArray]:
    """Rotations [N, 3, 3] by the orders that their columns may be in."""
    if "x0" in table:
        matrices = np.stack([table[f"{row}{column}"] for row in "xyz" for column in "012"], -1).reshape(-1, 3, 3)
        skew = np.abs(matrices @ matrices.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2))
        skew[np.linalg.det(matrices) < 0.0] = 2.0
        rows.refuse(skew > _SKEW, "columns 1 to 3, 5 to 7 and 9 to 11 are no rotation (off by {0:.3g})", skew)
        return {MATRIX: matrices}
    from scipy.spatial.transform import Rotation  # takes a while to import

    if "yaw" in table:
        yaw = table["yaw"] * UNITS.get(unit or "", 1.0)
        far = (np.abs(yaw) > _MOST_RADIANS) & (unit is None)
        rows.refuse(far, "yaw is {0:g}; name its column 'yaw [deg]' or 'yaw [rad]'", yaw)
        turned = {YAW: yaw} | ({DEGREES: np.radians(yaw)} if unit is None else {})
        return {order: Rotation.from_euler("z", angle[:, None]).as_matrix() for order, angle in turned.items()}
    quaternions = np.stack([table.get(name, np.zeros(len(rows))) for name in _QUATERNION], axis=-1)
    length = np.linalg.norm(quaternions, axis=-1)
    if not length.any():
        return {}
    wrong = np.abs(length - 1.0) > _UNIT_TOLERANCE
    rows.refuse(wrong, "the quaternion (qx qy qz qw) has length {0:.4g}; a rotation has length 1", length)
    first = {} if named else {WXYZ: Rotation.from_quat(np.roll(quaternions, -1, axis=-1)).as_matrix()}
    return {XYZW: Rotation.from_quat(quaternions).as_matrix(), **first}
