"""Trajectory files: the layouts that programs write, and what is no trajectory."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vbbench.errors import FileError
from vbbench.exchange.axes import ground_poses
from vbbench.exchange.trajectory import (
    CLOCKWISE,
    COMPASS,
    DEGREES,
    MATRIX,
    WXYZ,
    XYZW,
    YAW,
    Trajectory,
    read_trajectory,
)

PLACES = [(0.0, 0.0, 0.0), (0.5, 0.1, 0.0), (1.0, 0.3, 0.0)]
YAWS = [0.0, 0.2, 0.4]
Read = Callable[..., Trajectory]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """Write a trajectory, and read it."""

    def make(text: str, name: str = "t.txt", encoding: str = "utf-8") -> Trajectory:
        (tmp_path / name).write_bytes(text.encode(encoding))
        return read_trajectory(tmp_path / name)

    return make


def rows(layout: str, mark: str = " ") -> str:
    """Lines of three poses: ``layout`` is a format of t, x, y, z, w, qz, yaw, c and s."""
    lines = []
    for n, ((x, y, z), yaw) in enumerate(zip(PLACES, YAWS, strict=True)):
        half = {"w": np.cos(yaw / 2), "qz": np.sin(yaw / 2), "c": np.cos(yaw), "s": np.sin(yaw), "n": n}
        values = {"t": 0.1 * n, "x": x, "y": y, "z": z, "yaw": yaw, "deg": np.degrees(yaw), **half}
        lines.append(layout.format(**values).replace(" ", mark))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("text", "orders"),
    [
        (rows("{t} {x} {y} {z} 0 0 {qz} {w}"), [XYZW, WXYZ]),
        (rows("{t} {x} {y} {z} 0 0 {qz} {w}").replace(" ", "\t", 5), [XYZW, WXYZ]),
        ("# timestamp tx ty tz qx qy qz qw\n" + rows("{t} {x} {y} {z} 0 0 {qz} {w}"), [XYZW]),
        ("# timestamp tx ty tz qw qx qy qz\n" + rows("{t} {x} {y} {z} {w} 0 0 {qz}"), [XYZW]),
        ("time,x,y,yaw\n" + rows("{t} {x} {y} {yaw}", ","), [YAW]),
        ("time;x [m];y [m];heading [deg]\n" + rows("{t} {x} {y} {deg}", ";"), [YAW]),
        ("x y yaw time\n" + rows("{x} {y} {yaw} {t}"), [YAW]),
        (rows("{c} -{s} 0 {x} {s} {c} 0 {y} 0 0 1 {z}"), [MATRIX]),
        (rows("{t} {c} -{s} 0 {x} {s} {c} 0 {y} 0 0 1 {z}"), [MATRIX]),
        (rows("{c} -{s} 0 {x} {s} {c} 0 {y} 0 0 1 {z} 0 0 0 1"), [MATRIX]),
        (rows("{t} {x} {y} {z} {w} 0 0 {qz} 1 0 0", ",").replace("\n", ",\n"), [XYZW, WXYZ]),
        (rows("{t} {x} {y} {z} 0 0 {qz} {w}" + 12 * " 0.1"), [XYZW, WXYZ]),
        ("time;x;y;yaw\n" + rows("{t} {x} {y} {yaw}", ";").replace(".", ","), [YAW]),
        (
            "header.stamp.sec,header.stamp.nanosec,x,y,yaw\n" + rows("0 {n}00000000 {x} {y} {yaw}", ","),
            [YAW],
        ),
        (
            "__time,/odom/header/stamp,/odom/pose/pose/position/x,/odom/pose/pose/position/y,"
            "/odom/pose/pose/orientation/x,/odom/pose/pose/orientation/y,/odom/pose/pose/orientation/z,"
            "/odom/pose/pose/orientation/w,/odom/pose/pose/orientation/yaw_deg,/odom/twist/twist/linear/x\n"
            + rows("{t} {t} {x} {y} 0 0 {qz} {w} {deg} 9", ","),
            [XYZW],
        ),
        (
            "Time,header.seq,header.frame_id,pose.pose.position.x,pose.pose.position.y,pose.pose.position.z,"
            "pose.pose.orientation.x,pose.pose.orientation.y,pose.pose.orientation.z,pose.pose.orientation.w,"
            "twist.twist.linear.x\n" + rows("{t} {n} odom {x} {y} {z} 0 0 {qz} {w} 9", ","),
            [XYZW],
        ),
    ],
)
def test_layouts_of_programs(read: Read, text: str, orders: list[str]) -> None:
    found = read(text)
    assert [one for one in found.rotations if one not in (CLOCKWISE, COMPASS, DEGREES)] == orders
    assert (found.times is None) == (text.startswith("1.0 -0.0"))
    if found.times is not None:
        np.testing.assert_allclose(found.times, [0.0, 0.1, 0.2])
    np.testing.assert_allclose(found.places, PLACES)
    if list(found.rotations) != [XYZW, WXYZ] or ",\n" not in text:  # three rows do not show the order
        np.testing.assert_allclose(ground_poses(found).poses[:, 2], YAWS, atol=1e-12)


def test_euroc_has_nanoseconds_and_qw_first(read: Read) -> None:
    head = "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []"
    head += ", v_RS_R_x [m s^-1]"
    body = rows("140363657976355{n}000 {x} {y} {z} {w} 0 0 {qz} 0.3", ",")
    found = read(f"{head}\n{body}")
    assert found.unit == 1e-9
    assert list(found.rotations) == [XYZW]
    np.testing.assert_allclose(ground_poses(found).poses[:, 2], YAWS, atol=1e-12)


@pytest.mark.parametrize("layout", ["{t} {x} {y} {z}", "{t} {x} {y} {z} 0 0 0 0"])
def test_places_may_have_no_rotations(read: Read, layout: str) -> None:
    assert not read(rows(layout)).rotations


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("frame,x,y,yaw\n" + rows("{n} {x} {y} {yaw}", ","), [0, 1, 2]),
        ("image,x,y,yaw\ncam0/left_000007.png,0,0,0\ncam0/left_000008.png,1,0,0\n", [7, 8]),
    ],
)
def test_numbers_and_names_of_pictures_are_frames(read: Read, text: str, frames: list[int]) -> None:
    found = read(text)
    assert found.unit == 0.0
    np.testing.assert_array_equal(found.times, frames)


@pytest.mark.parametrize(
    ("comment", "axes"),
    [
        ("# axes: camera", "camera"),
        ("# body: x forward, z up", "body"),
        ("# made on Monday", None),
        ("# axes: x right, y down, z forward", "x"),
        ("# timesamp tx ty tz qx qy qz qw", None),  # without a name for the time it names nothing
    ],
)
def test_a_comment_may_state_the_axes(read: Read, comment: str, axes: str | None) -> None:
    found = read(f"{comment}\n" + rows("{t} {x} {y} {z} 0 0 {qz} {w}"))
    assert found.axes == axes
    np.testing.assert_allclose(found.times, [0.0, 0.1, 0.2])
    if axes == "x":  # no axes: motion shows them
        np.testing.assert_allclose(ground_poses(found).poses[:, 2], YAWS, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("lat,lon,alt\n1,2,3\n", "names no columns that are known: frame, time"),
        ("time,x,y,qx,qz\n0,1,2,0,0\n", "name columns time, x, y, and qx, qy, qz, qw or yaw"),
        ("x,y,yaw\n1,2,0\n", "name columns time, x, y"),
        ("time,x,tx,y\n0,1,1,2\n", "'x' and 'tx' could both be the x"),
        ("0 1 2 3 4\n", "line 1: 5 columns, wanted 8"),
        ("1 0 0 0 0 1 0 0 0 0 2 0\n", "line 1: columns .* are no rotation"),
        ("time,x,y,yaw\n0,1,2,90\n", "yaw is 90; name its column 'yaw"),
        ("time,x,y\n0,1\n", "line 2: 2 columns, the first line names 3"),
        ("time,x,y\n0,1,east\n", "line 2: y is 'east'"),
        ("1,2,3,4,50,60,1,-1,-1,-1\n", "line 1: 10 columns, wanted 8"),
        ('{"odometry": {}}\n', "is JSON; write lines of 'timestamp"),
        ("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n", "is a graph of g2o"),
        ("1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "is matrices of four lines each"),
        ("time,x,y,cos_yaw,sin_yaw\n0,1,2,1,0\n", "rotations are not read by the names cos_yaw, sin_yaw"),
        ("time,x,y,z,rvec_x,rvec_y,rvec_z\n0,1,2,0,0,0,1\n", "rotations are not read by the names rvec_x"),
        ("time,x,y,z,rx,ry,rz\n0,1,2,0,0,0,1\n", "rotations are not read by the names rx, ry, rz; write 'yaw"),
        ("header:\n  stamp:\n    secs: 1\n", "is printed messages; print CSV"),
        ("0 0 0 0 0 0 0.7 0.8\n", r"line 1: the quaternion .* has length 1\.063; .* or divide by it"),
        ("# Image list\n# points\n1 1 0 0 0 0 0 0 1 a_1.png\n3.5 4.5 -1\n", "COLMAP's images.txt, from the world"),
    ],
)
def test_what_is_no_trajectory(read: Read, text: str, problem: str) -> None:
    with pytest.raises(FileError, match=problem):
        read(text)


def test_units_of_places_count_and_utm_is_no_error(read: Read) -> None:
    found = read("time,x [cm],y_mm,yaw\n0,100,2000,0\n1,200,3000,0\n")
    np.testing.assert_allclose(found.places, [[1, 2, 0], [2, 3, 0]])
    found = read("time,easting,northing,yaw\n0,691234,5334567,0\n1,691235,5334567,0\n", "t.csv", "utf-16")
    np.testing.assert_allclose(found.places[:, :2], [[691234, 5334567], [691235, 5334567]])


def test_quaternions_of_two_digits_are_of_length_one(read: Read) -> None:
    turned = read("0 0 0 0 0 0 0.71 0.71\n1 1 0 0 0 0 0.72 0.70\n").rotations[XYZW]
    np.testing.assert_allclose(turned @ turned.swapaxes(1, 2), np.broadcast_to(np.eye(3), (2, 3, 3)), atol=1e-9)
