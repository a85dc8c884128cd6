"""Lens distortion: the formulas are OpenCV's, and boxes come out where a pinhole sees people."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.lib.own_recording import CAMERA_TOML, make_walk, write_csv, write_folder
from vbbench.errors import FileError
from vbbench.exchange.own.calibration_files import Distortion, straighten_boxes
from vbbench.exchange.own.camera_file import read_camera
from vbbench.exchange.own.recording import files_in, read_recording

K = np.array([[700.0, 0.0, 640.0], [0.0, 690.0, 360.0], [0.0, 0.0, 1.0]])
PHONE = Distortion(k1=-0.28, k2=0.11, p1=1e-3, p2=-8e-4, k3=-0.02)
RATIONAL = Distortion(k1=0.4, k2=-0.1, p1=5e-4, p2=2e-4, k3=0.01, k4=0.7, k5=-0.05, k6=0.02)
ROUND = Distortion(model="fisheye", k1=-0.02, k2=0.004, k3=-0.001, k4=2e-4)
coordinates = st.floats(-0.8, 0.8)


@pytest.mark.parametrize("lens", [PHONE, RATIONAL, ROUND])
def test_the_formulas_are_those_of_opencv(lens):
    straight = np.random.default_rng(0).uniform(-0.7, 0.7, (200, 2))
    points = np.concatenate([straight, np.ones((200, 1))], axis=1)
    if lens.model == "fisheye":
        coefficients = np.array([lens.k1, lens.k2, lens.k3, lens.k4])
        expected = cv2.fisheye.distortPoints(straight[:, None], np.eye(3), coefficients)[:, 0]
    else:
        coefficients = np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3, lens.k4, lens.k5, lens.k6])
        expected = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), coefficients)[0][:, 0]
    np.testing.assert_allclose(lens.bend(straight), expected, atol=1e-12)


@pytest.mark.parametrize("lens", [PHONE, RATIONAL, ROUND])
@given(x=coordinates, y=coordinates)
def test_the_way_back_is_exact(lens, x, y):
    straight = np.array([[x, y]])
    np.testing.assert_allclose(lens.straighten(lens.bend(straight)), straight, atol=1e-8)


def test_what_the_lens_shows_nowhere_has_no_place():
    barrel = Distortion(k1=-0.3)  # r (1 - 0.3 r²) is nowhere more than 0.703
    assert np.isnan(barrel.straighten(np.array([[0.9, 0.0]]))).all()
    assert np.isfinite(barrel.straighten(np.array([[0.69, 0.0]]))).all()
    assert np.isnan(ROUND.straighten(np.array([[1.6, 0.0]]))).all()


@pytest.mark.parametrize("lens", [PHONE, ROUND])
def test_the_middles_of_edges_are_mapped(lens):
    boxes = np.array([[200.0, 150.0, 60.0, 180.0], [900.0, 330.0, 40.0, 110.0]])
    found = straighten_boxes(boxes, lens, K)
    edges = np.array([[[x, y + h / 2], [x + w, y + h / 2], [x + w / 2, y], [x + w / 2, y + h]] for x, y, w, h in boxes])
    flat = edges.reshape(-1, 1, 2)
    if lens.model == "fisheye":
        straight = cv2.fisheye.undistortPoints(flat, K, np.array([lens.k1, lens.k2, lens.k3, lens.k4]), P=K)
    else:
        coefficients = np.array([lens.k1, lens.k2, lens.p1, lens.p2, lens.k3])
        until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 200, 1e-12)
        straight = cv2.undistortPointsIter(flat, K, coefficients, np.eye(3), K, until)
    straight = straight.reshape(-1, 4, 2)
    expected = [[e[0, 0], e[2, 1], e[1, 0] - e[0, 0], e[3, 1] - e[2, 1]] for e in straight]
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_a_recording_through_a_lens_is_as_one_without(tmp_path: Path):
    walk = make_walk(noise=0.0)
    plain = read_recording(files_in(write_folder(tmp_path / "plain", walk))).footage
    pinhole = np.array([[700.0, 0.0, 640.0], [0.0, 700.0, 360.0], [0.0, 0.0, 1.0]])
    x, y, w, h = np.moveaxis(walk.boxes, -1, 0)
    middles = np.stack([[x, y + h / 2], [x + w, y + h / 2], [x + w / 2, y], [x + w / 2, y + h]]).transpose(0, 2, 3, 1)
    bent = PHONE.bend((middles - pinhole[:2, 2]) / 700.0) * 700.0 + pinhole[:2, 2]
    left, right, top, bottom = bent[0, ..., 0], bent[1, ..., 0], bent[2, ..., 1], bent[3, ..., 1]
    lens = make_walk(noise=0.0)
    object.__setattr__(lens, "boxes", np.stack([left, top, right - left, bottom - top], axis=-1))
    table = "\n[distortion]\nk1 = -0.28\nk2 = 0.11\np1 = 1e-3\np2 = -8e-4\nk3 = -0.02\n"
    folder = write_folder(tmp_path / "lens", lens, camera=CAMERA_TOML + table)
    np.testing.assert_allclose(read_recording(files_in(folder)).footage.boxes, plain.boxes, atol=1.5)
    bare = write_folder(tmp_path / "bare", lens)
    off = np.abs(read_recording(files_in(bare)).footage.boxes - plain.boxes)
    assert np.nanmax(off) > 15.0
    (folder / "camera.toml").write_text(f"{CAMERA_TOML}\n[distortion]\nk1 = -40.0\np1 = 0.0\n")
    with pytest.raises(FileError, match=r"\[distortion\] leaves \d+ of 480 boxes without a place"):
        read_recording(files_in(folder))
    assert write_csv(tmp_path / "again.csv", lens).is_file()


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("k1 = -0.28\nk2 = 0.11\np1 = 1e-3\np2 = -8e-4\nk3 = -0.02", PHONE),
        ("coefficients = [-0.28, 0.11, 1e-3, -8e-4, -0.02]", PHONE),
        ("model = 'radtan'\ncoefficients = [0.1, 0.2, 0, 0]", Distortion(k1=0.1, k2=0.2)),
        ("model = 'plumb_bob'\nk1 = 0.1\nk2 = 0.2", Distortion(k1=0.1, k2=0.2)),
        ("k1 = 0.1\nk2 = 0.2\np1 = 0.0\np2 = 0.0", Distortion(k1=0.1, k2=0.2)),
        ("k1 = 0.4\nk2 = -0.1\nk3 = 0.01\nk4 = 0.7\nk5 = -0.05\nk6 = 0.02\np1 = 5e-4\np2 = 2e-4", RATIONAL),
        ("model = 'equidistant'\ncoefficients = [-0.02, 0.004, -0.001, 2e-4]", ROUND),
        ("model = 'fisheye'", Distortion(model="fisheye")),
        ("model = 'none'", None),
        ("k1 = 0.0\np1 = 0.0", None),
    ],
)
def test_a_lens_model_is_named_or_follows_from_the_coefficients(table, expected, tmp_path):
    (tmp_path / "camera.toml").write_text(f"{CAMERA_TOML}\n[distortion]\n{table}\n")
    assert read_camera(tmp_path / "camera.toml").facts.distortion == expected


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ("k1 = -0.02\nk2 = 0.004\nk3 = -0.002\nk4 = 4e-4", 'write model = "opencv" .* or "fisheye" .*'),
        ("coefficients = [-0.02, 0.004, -0.002, 4e-4]", 'write model = "opencv" .* or "fisheye" .*'),
        ("k1 = -0.02\nk2 = 0.004", "k1, k2 may be of two lens models"),
        ("model = 'barrel'\nk1 = 0.1", "no lens model is called 'barrel'"),
        ("coefficients = [1.0, 2.0, 3.0]", "3 coefficients; lists of lens model 'opencv' have 4, 5, 8"),
        ("coefficients = [1.0, 2.0, 3.0, 4.0, 5.0]\nk1 = 1.0", "coefficients and k1 exclude each other"),
        ("coefficients = 1.0", "coefficients is a list"),
        ("coefficients = ['a', 'b', 'c', 'd', 'e']", "wrong type; Expected `float`, got `str`"),
    ],
)
def test_coefficients_that_two_lens_models_may_have_are_asked_about(table, problem, tmp_path):
    (tmp_path / "camera.toml").write_text(f"{CAMERA_TOML}\n[distortion]\n{table}\n")
    with pytest.raises(FileError, match=problem):
        read_camera(tmp_path / "camera.toml")
