"""Calibrations of ROS, Kalibr, OpenCV and COLMAP make the camera that the same numbers make in ``camera.toml``."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.lib.own_recording import make_walk, write_csv
from vbbench.birdify.birdify import birdify
from vbbench.cli import main
from vbbench.errors import FileError
from vbbench.exchange.own.camera_file import OwnCamera, read_camera

K = [701.5, 0.0, 633.25, 0.0, 702.25, 351.5, 0.0, 0.0, 1.0]
BROWN, ROUND = [-0.28, 0.11, 1e-3, -8e-4, -0.02], [0.01, 0.002, -0.001, 5e-4]
MOUNT = {"mount_height": 1.5}
TOML = "width = 1280\nheight = 720\nfx = 701.5\nfy = 702.25\ncx = 633.25\ncy = 351.5\nmount_height = 1.5\n"
LENS = {
    "": "",
    "brown": "[distortion]\nmodel = 'opencv'\nk1 = -0.28\nk2 = 0.11\np1 = 1e-3\np2 = -8e-4\nk3 = -0.02\n",
    "round": "[distortion]\nmodel = 'fisheye'\nk1 = 0.01\nk2 = 0.002\nk3 = -0.001\nk4 = 5e-4\n",
}
OST = {
    "image_width": 1280,
    "image_height": 720,
    "camera_name": "front",
    "camera_matrix": {"rows": 3, "cols": 3, "data": K},
    "distortion_model": "plumb_bob",
    "distortion_coefficients": {"rows": 1, "cols": 5, "data": BROWN},
    "projection_matrix": {"rows": 3, "cols": 4, "data": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]},
}
ROI = {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}
HEADER = {"header": {"seq": 3, "stamp": {"secs": 1, "nsecs": 5}, "frame_id": "front"}, "height": 720, "width": 1280}
ECHO_1 = {**HEADER, "distortion_model": "plumb_bob", "D": BROWN, "K": K, "binning_x": 0, "binning_y": 0, "roi": ROI}
ECHO_2 = {**HEADER, "distortion_model": "equidistant", "d": ROUND, "k": K, "r": [0.0] * 9, "p": [0.0] * 12, "roi": ROI}
CHAIN = {
    "camera_model": "pinhole",
    "intrinsics": [701.5, 702.25, 633.25, 351.5],
    "distortion_model": "equidistant",
    "distortion_coeffs": ROUND,
    "resolution": [1280, 720],
    "rostopic": "/cam0/image_raw",
}
OPENCV = """\
%YAML:1.0
---
calibration_time: "Sun 29 Nov 2026"
image_width: 1280
image_height: 720
flags: 0
fisheye_model: 0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 701.5, 0., 633.25, 0., 7.0225e+02, 351.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -0.28, 0.11, 1e-3, -8.0e-04, -0.02 ]
"""
XML = """\
<?xml version="1.0"?>
<opencv_storage>
<image_width>1280</image_width> <image_height>720</image_height>
<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>701.5 0. 633.25 0. 702.25 351.5 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix"><rows>5</rows><cols>1</cols><dt>d</dt>
  <data>-0.28 0.11 1e-3 -8e-4 -0.02</data></distortion_coefficients>
</opencv_storage>
"""
PYTHON = {"camera_matrix": [K[:3], K[3:6], K[6:]], "dist_coeff": [BROWN], "image_size": [1280, 720]}
EUROC = {**CHAIN, "distortion_model": "radial-tangential", "distortion_coefficients": BROWN}
del EUROC["distortion_coeffs"]
SIZE, INTRINSICS = {"width": 1280, "height": 720}, {"fx": 701.5, "fy": 702.25, "cx": 633.25, "cy": 351.5}
NAMED = dict(zip(("k1", "k2", "p1", "p2", "k3"), BROWN, strict=True))
ORB = {"type": "PinHole", "fps": 30.0, **SIZE, **INTRINSICS, **NAMED}
WIDE = {**SIZE, **INTRINSICS, **{f"k{n}": value for n, value in enumerate(ROUND, 1)}}
VINS = {
    "model_type": "PINHOLE",
    "image_width": 1280,
    "image_height": 720,
    "distortion_parameters": NAMED,
    "projection_parameters": INTRINSICS,
}
HEAD = "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
PINHOLE, COEFFICIENTS = "1280 720 701.5 702.25 633.25 351.5", "-0.28 0.11 1e-3 -8e-4"
FILES = {
    "ost": (yaml.dump(OST), "brown"),
    "ost of floats": (yaml.dump(OST, default_flow_style=None), "brown"),
    "rostopic echo": (yaml.dump(ECHO_1) + "---\n" + yaml.dump({**ECHO_1, "K": [0.0] * 9}) + "---\n", "brown"),
    "ros2 topic echo": ("---\n" + yaml.dump(ECHO_2), "round"),
    "rational": (yaml.dump({**ECHO_1, "distortion_model": "rational_polynomial", "D": [*BROWN, 0.0, 0, 0]}), "brown"),
    "no distortion": (yaml.dump({**ECHO_1, "D": []}), ""),
    "no model": (yaml.dump({**ECHO_1, "distortion_model": ""}), "brown"),
    "no model, no distortion": (yaml.dump({**ECHO_1, "distortion_model": "", "D": [0.0] * 5}), ""),
    "camchain": (yaml.dump({"cam0": CHAIN}), "round"),
    "sensor.yaml": (yaml.dump(EUROC), "brown"),
    "opencv": (OPENCV, "brown"),
    "opencv of a fisheye": (yaml.dump({**PYTHON, "fisheye_model": 1, "dist_coeff": ROUND}), "round"),
    "opencv xml": (XML, "brown"),
    "opencv json": (json.dumps(PYTHON), "brown"),
    "opencv of rows first": (json.dumps({**PYTHON, "image_size": [720, 1280]}), "brown"),
    "orb-slam": (yaml.dump({f"Camera.{name}": value for name, value in ORB.items()}), "brown"),
    "orb-slam of a fisheye": (
        yaml.dump({f"Camera1.{name}": value for name, value in {**WIDE, "type": "KannalaBrandt8"}.items()}),
        "round",
    ),
    "vins": (yaml.dump(VINS), "brown"),
    "colmap pinhole": (f"{HEAD}# Number of cameras: 1\n1 PINHOLE {PINHOLE}\n", ""),
    "colmap full": (f"{HEAD}1 FULL_OPENCV {PINHOLE} {COEFFICIENTS} -0.02 0 0 0\n", "brown"),
    "colmap fisheye": (f"{HEAD}7 OPENCV_FISHEYE {PINHOLE} 0.01 0.002 -0.001 5e-4\n", "round"),
}


def read(folder: Path, text: str, mount: dict[str, float] | None = None) -> OwnCamera:
    path = folder / "calibration.yaml"
    path.write_text(text)
    return read_camera(path, MOUNT if mount is None else mount)


@pytest.mark.parametrize("kind", FILES)
def test_a_calibration_is_the_camera_file_of_its_numbers(kind, tmp_path):
    text, lens = FILES[kind]
    found, expected = read(tmp_path, text), read(tmp_path, TOML + LENS[lens], {})
    assert found.camera == expected.camera
    assert found.facts.distortion == expected.facts.distortion
    assert found.facts == expected.facts
    again = read(tmp_path, found.text, {})
    assert (again.facts, again.notes) == (found.facts, ())


def test_a_calibration_written_by_opencv_is_read(tmp_path):
    for name in ("one.yml", "one.xml", "one.json"):
        storage = cv2.FileStorage(str(tmp_path / name), cv2.FILE_STORAGE_WRITE)
        storage.write("image_width", 1280)
        storage.write("image_height", 720)
        storage.write("camera_matrix", np.reshape(K, (3, 3)))
        storage.write("distortion_coefficients", np.reshape(BROWN, (5, 1)))
        storage.release()
        found = read_camera(tmp_path / name, MOUNT)
        assert found.facts == read(tmp_path, TOML + LENS["brown"], {}).facts


FOUR = {**PYTHON, "dist_coeff": ROUND}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (yaml.dump(FOUR), "two lens models; .*; in a calibration distortion_model: plumb_bob or equidistant"),
        (yaml.dump({**OST, "distortion_model": "double_sphere"}), "no lens model is called 'double_sphere'"),
        (yaml.dump({**CHAIN, "distortion_model": "fov"}), "no lens model is called 'fov'"),
        (yaml.dump({**CHAIN, "camera_model": "omni"}), "camera model 'omni' is not read"),
        (yaml.dump({**CHAIN, "intrinsics": [0.6, *CHAIN["intrinsics"]]}), "5 numbers; a pinhole has four"),
        (yaml.dump({"cam0": CHAIN, "cam1": CHAIN}), "holds cam0 and cam1; keep the camera that the boxes are of"),
        (OPENCV + "K: [1, 0, 2, 0, 1, 2, 0, 0, 1]\n", "states K twice"),
        (yaml.dump({**ECHO_1, "roi": {**ROI, "x_offset": 100}}), "has a roi: write width, height and K"),
        (yaml.dump({**ECHO_1, "binning_x": 2, "binning_y": 2}), "has a binning_x"),
        (yaml.dump({**ECHO_1, "K": [0.0] * 9}), "is zero: this camera has not been calibrated"),
        (yaml.dump({**ECHO_1, "K": [*K[:1], 9.0, *K[2:]]}), "has a skew of 9 px"),
        (yaml.dump({**ECHO_1, "D": [*BROWN, 0.0]}), "6 coefficients; lists of lens model 'opencv' have 4, 5, 8"),
        (yaml.dump({**ECHO_1, "D": [*BROWN, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0]}), "the numbers after them must be 0"),
        (yaml.dump({**ECHO_1, "width": None}), "the size of the picture is missing: write image_width"),
        (yaml.dump({"image_width": 1280, "image_height": 720}), "is no calibration of a pinhole: fx is missing"),
        (yaml.dump({**OST, "image_width": "wide"}), "width or height is 'wide'; write a number"),
        ("cam0: [1, 2", "is no calibration that can be read: expected"),
        ("a: !!python/object/apply:os.getcwd []", "could not determine a constructor"),
        ("<calibration/>", "XML of <calibration>"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><opencv_storage/>", "XML with declarations"),
        (f"{HEAD}1 PINHOLE {PINHOLE}\n2 PINHOLE {PINHOLE}\n", "2 cameras; keep the camera that the boxes are of"),
        (
            f"{HEAD}1 THIN_PRISM_FISHEYE {PINHOLE} 0 0 0 0 0 0 0 0\n",
            "camera model THIN_PRISM_FISHEYE is not read; calibrate with one of",
        ),
        (
            yaml.safe_dump({**OST, "distortion_coefficients": None, "distortion": BROWN}),
            "distortion is no name that is read",
        ),
        (yaml.safe_dump({"cameras": [{"f": 700}], "width": 1280}), "no calibration of a pinhole: fx is missing"),
        ("# oST version 5.0 parameters\n\n[image]\n\nwidth\n1280\n", "INI; name the ost.yaml"),
        (f"{HEAD}1 OPENCV {PINHOLE}\n", "OPENCV has width height fx fy cx cy k1 k2 p1 p2, not 6 numbers"),
    ],
)
def test_what_is_of_no_known_lens_or_not_of_the_whole_picture_is_refused(text, problem, tmp_path):
    with pytest.raises(FileError, match=problem):
        read(tmp_path, text)


def test_the_mount_height_is_asked_for_and_never_contradicts(tmp_path):
    with pytest.raises(FileError, match=r"mount_height is missing: give it with --mount-height"):
        read(tmp_path, OPENCV, {})
    with pytest.raises(FileError, match=r"exchanged\?"):
        read(tmp_path, "1,7,602.5,170.2,31.0,88.4,1,-1,-1,-1\n", {})
    with pytest.raises(FileError, match=r"says mount_height = 1\.5, and --mount-height 2; keep one"):
        read(tmp_path, TOML, {"mount_height": 2.0})
    found = read(tmp_path, TOML.replace("mount_height = 1.5\n", ""), {"mount_height": 1.5, "pitch": -0.1})
    assert (found.facts.pitch, found.camera.mount_height) == (-0.1, 1.5)
    assert read(tmp_path, found.text, {}).facts == found.facts
    with pytest.raises(FileError, match="says carried_by = robot, and --carried-by person; keep one"):
        read(tmp_path, f'carried_by = "robot"\n{TOML}', {"carried_by": "person"})
    found = read(tmp_path, TOML, {"carried_by": "person"})
    assert (found.facts.carried_by, read(tmp_path, found.text, {}).facts) == ("person", found.facts)
    with pytest.raises(FileError, match=r"pitch must be -1\.2 to 1\.2 rad .*, not 5"):
        read(tmp_path, OPENCV, {**MOUNT, "pitch": 5.0})


names = st.sampled_from([*OST, *ECHO_1, *CHAIN, "fx", "k1", "cam0", "dist"])
leaves = st.none() | st.booleans() | st.floats() | st.integers() | st.text()
values = st.recursive(leaves, lambda kind: st.lists(kind) | st.dictionaries(names, kind), max_leaves=4)


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changed=st.dictionaries(names, values, min_size=1), chain=st.booleans())
def test_any_table_is_read_or_refused_in_one_line(changed, chain, tmp_path):
    try:
        found = read(tmp_path, yaml.dump({**(CHAIN if chain else OST), **changed}))
    except FileError:
        return
    assert np.isfinite(found.camera.focal)


def test_a_file_of_another_kind_is_no_toml(tmp_path):
    np.savez(tmp_path / "one.npz", mtx=np.eye(3))
    with pytest.raises(FileError, match=r"calibrations of ROS, Kalibr, OpenCV and COLMAP are read"):
        read_camera(tmp_path / "one.npz", MOUNT)
    with pytest.raises(FileError):
        read(tmp_path, "a" + " " * 200_000 + "b")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
def test_the_command_takes_calibrations_and_folders(tmp_path, capsys):
    boxes = write_csv(tmp_path / "boxes.csv", make_walk(20))
    camera = tmp_path / "camera_info.yaml"
    camera.write_text(yaml.dump(ECHO_1))
    asked = ["birdify", str(boxes), "--camera", str(camera), "--solver", "tests.birdify.test_birdify:Odometer"]
    given = ["--mount-height", "1.5", "--dt", "0.1", "--out", str(tmp_path / "map")]
    assert main([*asked, *given]) == 0
    kept = tmp_path / "map" / "recording"
    assert read_camera(kept / "camera.toml").facts.seconds == 0.1
    again = birdify(kept / "boxes.csv", kept, tmp_path / "again", solver="tests.birdify.test_birdify:Odometer")
    assert (again.folder / "positions.csv").read_bytes() == (tmp_path / "map" / "positions.csv").read_bytes()
    asked[3] = str(tmp_path)
    assert main([*asked, "--out", str(tmp_path / "other")]) == 2
    assert "is a folder without camera.toml; it holds boxes.csv, camera_info.yaml" in capsys.readouterr().err


def test_coefficients_in_another_order_are_warned_of(tmp_path):
    (tmp_path / "camera.toml").write_text(TOML + "[distortion]\ncoefficients = [-0.28, 0.11, -0.08, 1e-3, -8e-4]\n")
    (note,) = read_camera(tmp_path / "camera.toml").notes
    assert "is the order k1 k2 p1 p2 k3?" in note
