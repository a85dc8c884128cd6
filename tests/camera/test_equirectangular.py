"""The camera of a 360° film: angles in rows and columns, wherever a camera goes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vbbench.birdify.cues import HeightPrior, compare_cues
from vbbench.camera import EquirectangularCamera, PanoramaCamera, camera_from_dict, camera_to_dict, make_camera
from vbbench.cli import main
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.scoring import score
from vbbench.solving import solve

CAMERA = EquirectangularCamera(width=3840, height=1920, focal=1920 / np.pi, cy=960.0, mount_height=1.5)
angles, reaches = st.floats(-3.1, 3.1), st.floats(0.6, 40.0)


@given(azimuth=angles, reach=reaches, height=st.floats(1.0, 2.2))
def test_boxes_are_angles_of_feet_and_heads(azimuth, reach, height):
    relative = reach * np.array([np.sin(azimuth), np.cos(azimuth)])
    u, v, length = CAMERA.project(relative, np.array(height))
    foot, head = (np.degrees(np.arctan2(down, reach)) for down in (1.5, 1.5 - height))
    assert u == pytest.approx((np.degrees(azimuth) + 180.0) * 3840 / 360)
    assert (v, length) == (
        pytest.approx(960 + (foot + head) / 2 * 1920 / 180),
        pytest.approx((foot - head) * 1920 / 180),
    )


@given(azimuth=angles, reach=reaches, height=st.floats(1.0, 2.2), pitch=st.floats(-0.3, 0.3), roll=st.floats(-0.3, 0.3))
def test_the_way_back_is_exact(azimuth, reach, height, pitch, roll):
    camera = replace(CAMERA, pitch=pitch, roll=roll)
    relative, heights = reach * np.array([[np.sin(azimuth), np.cos(azimuth)]]), np.array([height])
    boxes = camera.project_unbounded(relative, heights)
    np.testing.assert_allclose(camera.unproject(boxes, heights), relative, atol=2e-3 * reach)
    np.testing.assert_allclose(camera.statures(boxes)[1], heights, atol=2e-3)


@given(u=st.floats(0.0, 3839.0), v=st.floats(1.0, 1919.0))
def test_pixels_and_directions_are_inverse(u, v):
    pixels = np.array([u, v])
    np.testing.assert_allclose(CAMERA.pixels(CAMERA.directions(pixels)), pixels, atol=1e-6)


def test_a_cylinder_puts_people_of_a_sphere_too_far():
    near, far = (CAMERA.project(np.array([0.0, reach]), np.array(1.72)) for reach in (1.5, 5.0))
    cylinder = PanoramaCamera(width=3840, focal=CAMERA.focal, cy=960.0, mount_height=1.5)
    found = [float(cylinder.unproject(box, np.array(1.72))[1]) for box in (near, far)]
    assert found == [pytest.approx(1.85, abs=0.01), pytest.approx(5.13, abs=0.01)]


def test_it_survives_files():
    camera = make_camera("equirectangular", pitch=-0.2)
    assert camera_from_dict(camera_to_dict(camera)) == camera
    assert (camera.period, camera.view, camera.picture_size) == (1440.0, None, (1440, 720))
    assert (camera.intrinsics, camera.cylinder) == (None, None)


def test_feet_and_heights_agree_with_the_camera_that_made_them():
    rng = np.random.default_rng(0)
    start, steps = rng.uniform(-6, 6, (40, 2)), rng.normal(0.0, 0.1, (30, 40, 2))
    heights = np.broadcast_to(rng.normal(1.72, 0.08, 40), (30, 40))
    boxes = CAMERA.project(start + np.cumsum(steps, axis=0), heights)
    cues = compare_cues(boxes, CAMERA, HeightPrior(1.72, 0.09), 0.4)
    assert cues.mount_height == pytest.approx(1.5, abs=3 * cues.mount_height_std)
    assert abs(cues.tilt) < 3 * cues.tilt_std + 2e-3


@pytest.mark.slow
def test_datasets_are_made_and_solved_with_it(tmp_path: Path):
    simulation, error = Simulation(sequences=1, people=(8,)), {}
    for name in ("equirectangular", "panorama"):
        options = Options(camera=make_camera(name), tier="occluded", simulation=simulation)
        folder = generate("sim", tmp_path / name, options)
        verify(folder.folder)
        answer = solve(folder, "map-causal", "sequential", tmp_path / f"answer-{name}")
        error[name] = score(answer, folder.folder).values()["metrics"]["dx"]["mean"]
    assert error["equirectangular"] < 1.5 * error["panorama"] + 0.02
    tracked = Options(camera=make_camera("equirectangular"), tier="tracked", simulation=simulation)
    verify(generate("sim", tmp_path / "tracked", tracked).folder)


@pytest.mark.slow
def test_the_command_line_takes_its_name(tmp_path: Path):
    words = ["generate", "sim", "--camera", "equirectangular", "--sequences", "1", "--options", "people=6"]
    assert main([*words, "--out", str(tmp_path / "sim")]) == 0
    assert Dataset(tmp_path / "sim").info.camera == EquirectangularCamera()
