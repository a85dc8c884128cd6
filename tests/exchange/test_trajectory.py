"""Trajectory files: the layouts that programs write, what is no trajectory, and the axes of the body."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vbbench.errors import FileError
from vbbench.exchange.trajectory import (
    AXES,
    CLOCKWISE,
    COMPASS,
    DEGREES,
    MATRIX,
    WXYZ,
    XYZW,
    YAW,
    Trajectory,
    ground_poses,
    off_course,
    read_trajectory,
)
from vbbench.geometry import motion_between, wrap_angle

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


FLU_TO = {
    "camera": np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], float),
    "opengl": np.array([[0, -1, 0], [0, 0, 1], [-1, 0, 0]], float),
    "ned": np.diag([1.0, -1.0, -1.0]),
    "imu": np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]], float),
    "unity": np.array([[0, -1, 0], [0, 0, 1], [1, 0, 0]], float),
    "unreal": np.diag([1.0, -1.0, 1.0]),
    "body": np.eye(3),
}
"""Rows: the axes x, y, z of a convention in (forward, left, up)."""


def drive(bend: float = 1.57, way: float = 6.0, rows: int = 60, still: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Places [N, 3] and yaws [N] of a body that goes ``way`` m and turns by ``bend`` rad, after it stood."""
    share = np.append(np.zeros(still), np.linspace(0.0, 1.0, rows))
    yaw = bend * share**2
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    steps = way * np.diff(share)[:, None] * np.stack([np.cos(middle), np.sin(middle), 0.0 * middle], axis=-1)
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)]), yaw


def rotations_of(yaw: np.ndarray, pitch: float = 0.0) -> np.ndarray:
    """[N, 3, 3] of a body (forward, left, up) that looks up by ``pitch``."""
    return Rotation.from_euler("ZY", np.stack([yaw, np.full(len(yaw), -pitch)], axis=-1)).as_matrix()


def written(path: Path, places: np.ndarray, rotations: np.ndarray, *, first: bool = False, noise: float = 0.0) -> Path:
    """A TUM file; ``first`` with qw before qx."""
    quaternions = Rotation.from_matrix(rotations).as_quat()
    quaternions = np.roll(quaternions, 1, axis=1) if first else quaternions
    places = places + np.random.default_rng(0).normal(0.0, noise, places.shape)
    rows = np.column_stack([0.1 * np.arange(len(places)), places, quaternions])
    path.write_text("".join(" ".join(f"{value:.7f}" for value in row) + "\n" for row in rows))
    return path


def changed(places, rotations, axes: str, *, world: bool) -> tuple[np.ndarray, np.ndarray]:
    """The same in other axes of the body and, with ``world``, of the world."""
    body = FLU_TO[axes]
    outer = body if world else np.eye(3)
    return places @ outer.T, outer @ rotations @ body.T


def same_motion(poses: np.ndarray, places: np.ndarray, yaw: np.ndarray, atol: float = 2e-3) -> None:
    wanted = np.column_stack([places[:, :2], yaw])
    found, wanted = (motion_between(np.broadcast_to(one[0], one.shape), one) for one in (poses, wanted))
    np.testing.assert_allclose(found[:, :2], wanted[:, :2], atol=atol)
    np.testing.assert_allclose(wrap_angle(found[:, 2] - wanted[:, 2]), 0.0, atol=atol)


def on_ground(path: Path, places, rotations, axes=None, **layout):
    return ground_poses(read_trajectory(written(path / "t.txt", places, rotations, **layout)), axes)


def read_angles(folder: Path, places, angles, name: str = "yaw"):
    """The poses of a file of angles, in a column of this name."""
    rows = np.column_stack([0.1 * np.arange(len(angles)), places[:, :2], angles])
    np.savetxt(folder / "t.csv", rows, delimiter=",", header=f"time,x,y,{name}", comments="")
    return ground_poses(read_trajectory(folder / "t.csv"))


@pytest.mark.parametrize("pitch", [0.0, -0.17])
@pytest.mark.parametrize("bend", [0.0, 0.15, 1.57, -3.0])
@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize(
    ("axes", "world"), [("body", True), ("camera", True), ("camera", False), ("opengl", False), ("unity", True)]
)
def test_motion_shows_axes_and_order(tmp_path, pitch, bend, first, axes, world):
    if first and pitch and not (bend or world):
        pytest.skip("straight on, a pitch in one order is a yaw in the other")
    places, yaw = drive(bend)
    found = on_ground(tmp_path, *changed(places, rotations_of(yaw, pitch), axes, world=world), first=first)
    same_motion(found.poses, places, yaw)
    assert any("qw qx qy qz" in note for note in found.notes) == first or not bend
    assert not found.notes or first or axes != "body"


@pytest.mark.parametrize("world", [False, True])
@pytest.mark.parametrize("axes", AXES)
def test_given_axes_count(tmp_path, axes, world):
    places, yaw = drive(1.2)
    if np.linalg.det(FLU_TO[axes]) < 0.0 and not world:
        pytest.skip("a left-handed body has a left-handed world")
    found = on_ground(tmp_path, *changed(places, rotations_of(yaw, -0.1), axes, world=world), axes)
    same_motion(found.poses, places, yaw)
    assert not found.notes


@pytest.mark.parametrize("axes", ["body", "camera"])
def test_noise_and_a_stop_change_nothing(tmp_path, axes):
    places, yaw = drive(1.57, still=40)
    found = on_ground(tmp_path, *changed(places, rotations_of(yaw), axes, world=True), noise=0.01)
    same_motion(found.poses, places, yaw, atol=0.08)


@pytest.mark.parametrize("axes", ["body", "camera"])
@pytest.mark.parametrize("bend", [0.0, 0.3, 2.0])
def test_a_body_that_stands_shows_its_axes_by_turning(tmp_path, axes, bend):
    _, yaw = drive(bend)
    places = np.zeros((len(yaw), 3))
    same_motion(on_ground(tmp_path, *changed(places, rotations_of(yaw), axes, world=True)).poses, places, yaw)


def test_axes_that_motion_does_not_decide_are_refused_by_name(tmp_path):
    places, yaw = drive(0.15)
    rotations = rotations_of(yaw)
    with pytest.raises(FileError, match=r"180° from where it looks.*OpenGL.*'opengl'"):
        on_ground(tmp_path, *changed(places, rotations, "opengl", world=True))
    places, yaw = drive(1.57)
    for axes in ("body", "camera"):
        places_in, rotations = changed(places, rotations_of(yaw), axes, world=True)
        back = rotations.swapaxes(1, 2)
        with pytest.raises(FileError, match="from the world to the camera"):
            on_ground(tmp_path, -np.einsum("nij,nj->ni", back, places_in), back)


@pytest.mark.parametrize(("turn", "axes"), [(np.pi, "body"), (0.5 * np.pi, "body"), (0.5 * np.pi, "camera")])
def test_a_body_may_drive_backwards_and_sideways(tmp_path, turn, axes):
    places, yaw = drive(1.0)
    found = on_ground(tmp_path, *changed(places, rotations_of(yaw + turn), axes, world=True))
    same_motion(found.poses, places, yaw + turn)
    share, angle = off_course(found.poses)
    assert share == pytest.approx(1.0)
    assert abs(angle) == pytest.approx(turn, abs=0.05)


@pytest.mark.parametrize(("axes", "world"), [("body", True), ("camera", True), ("camera", False)])
def test_a_rotation_that_never_changes_gives_way_to_the_path(tmp_path, axes, world):
    places, yaw = drive(1.57)
    still = np.broadcast_to(np.eye(3), (len(yaw), 3, 3))
    found = on_ground(tmp_path, *changed(places, still, axes, world=world))
    assert found.from_path
    assert "never changes" in found.notes[0]
    same_motion(found.poses, places, yaw, atol=0.04)
    given = on_ground(tmp_path, *changed(places, still, axes, world=world), axes)
    same_motion(given.poses, places, 0.0 * yaw)


@pytest.mark.parametrize(("degrees", "said"), [(10, False), (20, True), (40, True), (60, False)])
def test_a_straight_path_aside_of_a_rotation_that_never_changes_is_said(tmp_path, degrees, said):
    places, yaw = drive(0.0)
    turn = Rotation.from_euler("z", degrees, degrees=True).as_matrix()
    notes = on_ground(tmp_path, places @ turn.T, rotations_of(yaw)).notes
    assert [f"leads {degrees}° to a side" in note for note in notes] == [True] * said


def test_given_axes_in_which_a_body_climbs_are_said(tmp_path):
    places, yaw = drive(0.3)
    found = on_ground(tmp_path, *changed(places, rotations_of(yaw), "camera", world=True), "body")
    assert "99% of the way leads up or down: is it 'body'?" in found.notes[0]


@pytest.mark.parametrize(("unit", "aside"), [(1.0, 0.0), (1.0, 1.5), (57.29578, 0.0)])
def test_a_yaw_without_a_name_is_no_height(tmp_path, unit, aside):
    places, yaw = drive(1.57)
    rows = np.column_stack([0.1 * np.arange(len(yaw)), places[:, :2], unit * wrap_angle(yaw + aside)])
    np.savetxt(tmp_path / "t.txt", rows)
    with pytest.raises(FileError, match="z turns as the path does: is it the yaw"):
        ground_poses(read_trajectory(tmp_path / "t.txt"))


def test_a_yaw_without_a_unit_is_in_degrees_where_motion_shows_it(tmp_path):
    places, yaw = drive(0.1)
    found = read_angles(tmp_path, places, np.degrees(yaw))
    same_motion(found.poses, places, yaw)
    assert "is read as yaw in degrees" in found.notes[0]


@pytest.mark.parametrize(("bend", "read_as"), [(1.57, "heading clockwise from y"), (1.57, "yaw clockwise"), (0.0, "")])
def test_an_angle_that_runs_clockwise_is_told_by_a_path_that_bends(tmp_path, bend, read_as):
    places, yaw = drive(bend)
    angle = np.degrees((0.0 if read_as == "yaw clockwise" else 0.5 * np.pi) - yaw)
    found = read_angles(tmp_path, places, angle, "heading_deg")
    same_motion(found.poses, places, yaw if bend else yaw + 0.5 * np.pi)
    assert [f"is read as {read_as}" in note for note in found.notes] == [True] * bool(bend)


def test_a_yaw_aside_of_the_way_is_not_taken_for_degrees(tmp_path):
    places, yaw = drive(0.5)
    found = read_angles(tmp_path, places, yaw + 1.57)
    same_motion(found.poses, places, yaw + 1.57)
    assert not found.notes


def test_a_camera_that_looks_about_is_not_read_in_degrees(tmp_path):
    """Degrees would make its yaw that of a path that hardly bends."""
    places, yaw = drive(0.3)
    looks = 0.9 * np.sin(0.1 * np.arange(len(yaw)))
    same_motion(read_angles(tmp_path, places, looks).poses, places, looks)


def test_places_alone_give_the_yaw_of_their_path_or_none(tmp_path):
    path, (places, yaw) = tmp_path / "t.txt", drive(1.0, still=10)
    path.write_text("".join(f"{0.1 * n} {x} {y}\n" for n, (x, y, _) in enumerate(places)))
    same_motion(ground_poses(read_trajectory(path)).poses, places, yaw, atol=0.03)
    path.write_text("".join(f"{0.1 * n} {-y} 0.0 {x}\n" for n, (x, y, _) in enumerate(places)))
    same_motion(ground_poses(read_trajectory(path)).poses, places, yaw, atol=0.03)
    path.write_text("".join(f"{0.1 * n} {min(n, 40 - n) * 0.1} 0\n" for n in range(40)))
    with pytest.raises(FileError, match="turns back by 180°"):
        ground_poses(read_trajectory(path))
    path.write_text("".join(f"{0.1 * n} {0.01 * n} 0\n" for n in range(40)))
    with pytest.raises(FileError, match="nothing gives the yaw"):
        ground_poses(read_trajectory(path))


@pytest.mark.parametrize("sequence", ["0015", "0019"])
def test_real_poses_of_a_car(data_folder, tmp_path, sequence):
    """KITTI's matrices, the same as TUM in both orders, and the path alone."""
    path = data_folder / "kitti" / "poses" / f"{sequence}.txt"
    matrices = np.loadtxt(path).reshape(-1, 3, 4)
    found = ground_poses(read_trajectory(path))
    assert not found.notes
    assert off_course(found.poses)[0] == 0.0
    for first in (False, True):
        again = on_ground(tmp_path, matrices[:, :, 3], matrices[:, :, :3], first=first)
        np.testing.assert_allclose(again.poses, found.poses, atol=1e-5)
