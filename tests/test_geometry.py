"""Projection and the ground plane: identities over random cameras, people and poses."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vbbench.camera import (
    NEAREST,
    CentralCamera,
    PanoramaCamera,
    PerspectiveCamera,
    camera_from_dict,
    camera_to_dict,
)
from vbbench.errors import VbbenchError
from vbbench.geometry import relative_to_world, runs_of_true, world_to_relative, wrap_angle

metres = st.floats(-100.0, 100.0)
seeds = st.integers(0, 2**32 - 1)
panoramas = st.builds(
    PanoramaCamera,
    width=st.integers(64, 8192),
    focal=st.floats(20.0, 4000.0),
    cy=st.floats(0.0, 1000.0),
    mount_height=st.floats(0.2, 5.0),
)
perspectives = st.builds(
    PerspectiveCamera,
    width=st.integers(64, 4096),
    height=st.integers(64, 4096),
    focal=st.floats(20.0, 4000.0),
    cx=st.floats(0.0, 2000.0),
    cy=st.floats(0.0, 1000.0),
    mount_height=st.floats(0.2, 5.0),
)


def crowd(seed: int, frames: int = 3, people: int = 20) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    relative = rng.uniform(-30.0, 30.0, (frames, people, 2))
    relative[rng.random((frames, people)) < 0.1] = np.nan
    return relative, rng.uniform(1.2, 2.1, (frames, people))


@given(panoramas, seeds)
def test_panorama_unprojects_what_it_projects(camera: PanoramaCamera, seed: int) -> None:
    relative, heights = crowd(seed)
    boxes = camera.project(relative, heights)
    np.testing.assert_allclose(camera.unproject(boxes, heights), relative, rtol=1e-9, atol=1e-9)
    assert np.all(np.isnan(boxes) | (boxes[..., [0]] < camera.width))


@given(perspectives, seeds)
def test_perspective_unprojects_what_it_projects_and_drops_the_rest(camera: PerspectiveCamera, seed: int) -> None:
    relative, heights = crowd(seed)
    boxes = camera.project(relative, heights)
    seen = ~np.isnan(boxes[..., 0])
    back = camera.unproject(boxes, heights)
    np.testing.assert_allclose(back[seen], relative[seen], rtol=1e-9, atol=1e-9)
    with np.errstate(invalid="ignore", divide="ignore"):
        u = camera.cx + camera.focal * relative[..., 0] / relative[..., 1]
        v = camera.cy + camera.focal * (camera.mount_height - heights / 2) / relative[..., 1]
    ahead = relative[..., 1] > NEAREST
    expected = ahead & (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    np.testing.assert_array_equal(seen, expected)


@given(st.sampled_from([PanoramaCamera(), PerspectiveCamera()]), seeds)
def test_projects_what_it_unprojects(camera: PanoramaCamera | PerspectiveCamera, seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes = rng.uniform([0.0, 0.0, 5.0], [camera.width, 480.0, 400.0], (50, 3))
    heights = rng.uniform(1.2, 2.1, 50)
    again = camera.project(camera.unproject(boxes, heights), heights)
    seen = ~np.isnan(again[:, 0])
    np.testing.assert_allclose(again[seen][:, [0, 2]], boxes[seen][:, [0, 2]], rtol=1e-9)


@given(metres, metres, st.floats(-10.0, 10.0), seeds)
def test_world_and_camera_frame_are_inverse(x: float, y: float, yaw: float, seed: int) -> None:
    relative, _ = crowd(seed)
    poses = np.array([[x, y, yaw]] * len(relative))
    world = relative_to_world(relative, poses)
    np.testing.assert_allclose(world_to_relative(world, poses), relative, atol=1e-9)
    np.testing.assert_allclose(
        np.linalg.norm(world - poses[:, None, :2], axis=-1), np.linalg.norm(relative, axis=-1), atol=1e-9
    )


def test_directions_follow_the_convention() -> None:
    pose = np.array([2.0, 3.0, np.pi / 2])  # looking along world +y
    ahead, right = np.array([[0.0, 5.0]]), np.array([[1.0, 0.0]])
    np.testing.assert_allclose(relative_to_world(ahead, pose), [[2.0, 8.0]], atol=1e-12)
    np.testing.assert_allclose(relative_to_world(right, pose), [[3.0, 3.0]], atol=1e-12)
    boxes = PanoramaCamera().project(np.array([[0.0, 5.0], [5.0, 0.0], [0.0, -5.0]]), np.full(3, 1.7))
    np.testing.assert_allclose(boxes[:, 0], [720.0, 1080.0, 0.0], atol=1e-9)


@pytest.mark.parametrize(
    ("relative", "seen"),
    [
        ((0.0, 5.0), True),
        ((0.0, -5.0), False),
        ((0.0, 0.0), False),
        ((0.0, NEAREST / 2), False),
        ((-5.0, 5.0), True),  # column 0 exactly
        ((5.0, 5.0), False),  # column W exactly
        ((4.999, 5.0), True),
        ((np.nan, np.nan), False),
    ],
)
def test_borders_of_the_picture(relative: tuple[float, float], seen: bool) -> None:
    boxes = PerspectiveCamera().project(np.array([relative]), np.array([1.7]))
    assert np.isfinite(boxes).all() == seen
    assert np.isnan(boxes).all() != seen


tilts = st.fixed_dictionaries({"pitch": st.floats(-0.4, 0.4), "roll": st.floats(-0.4, 0.4)})


@given(tilts, st.floats(-3.0, 3.0), st.floats(2.0, 30.0), st.floats(1.2, 2.1), st.floats(300.0, 1200.0))
def test_a_tilted_pinhole_shows_people_where_they_are(
    tilt: dict[str, float], right: float, forward: float, height: float, vertical_focal: float
) -> None:
    camera = PerspectiveCamera(vertical_focal=vertical_focal, **tilt)
    relative, heights = np.array([right, forward]), np.array(height)
    box = camera.project_unbounded(relative, heights)
    np.testing.assert_allclose(camera.unproject(box, heights), relative, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(camera.unproject(box, 2.0 * heights), 2.0 * relative, rtol=1e-8, atol=1e-8)


@given(tilts, st.floats(-3.0, 3.0), st.floats(1.0, 30.0))
def test_a_tilted_panorama_does_so_too(tilt: dict[str, float], azimuth: float, reach: float) -> None:
    camera = PanoramaCamera(**{name: angle / 4.0 for name, angle in tilt.items()})
    relative, height = reach * np.array([np.sin(azimuth), np.cos(azimuth)]), np.array(1.7)
    found = camera.unproject(camera.project(relative, height), height)
    np.testing.assert_allclose(found, relative, atol=1e-7 * reach)


@given(st.one_of(panoramas, perspectives), st.floats(-2.0, 2.0), st.floats(2.0, 30.0))
def test_the_closed_forms_are_those_of_any_central_camera(
    camera: PanoramaCamera | PerspectiveCamera, right: float, forward: float
) -> None:
    relative, height = np.array([right, forward]), np.array(1.7)
    box = camera.project_unbounded(relative, height)
    np.testing.assert_allclose(CentralCamera.project_unbounded(camera, relative, height), box, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(CentralCamera.unproject(camera, box, height), relative, rtol=1e-6, atol=1e-6)


@given(tilts, st.floats(-0.6, 0.6), st.floats(2.0, 30.0))
def test_what_is_as_high_as_the_mount_stands_on_the_horizon(
    tilt: dict[str, float], azimuth: float, reach: float
) -> None:
    relative = reach * np.array([np.sin(azimuth), np.cos(azimuth)])
    for camera in (PerspectiveCamera(**tilt), PanoramaCamera(**tilt)):
        column, row = camera.pixels(camera.to_camera(np.array([relative[0], 0.0, relative[1]])))
        np.testing.assert_allclose(camera.horizon(column), row, atol=1e-6)


def test_pitch_looks_up_and_roll_hangs_to_the_right() -> None:
    ahead = np.array([0.0, 0.0, 1.0])
    camera = PerspectiveCamera(pitch=0.1)
    assert camera.pixels(camera.to_camera(ahead))[1] > camera.cy  # what lies ahead sinks in the picture
    camera = PerspectiveCamera(roll=0.1)
    left, right = camera.horizon(np.array([0.0, 1280.0]))
    assert right < left  # the world turns the other way


def test_nobody_on_top_of_the_panorama_is_seen() -> None:
    assert np.isnan(PanoramaCamera().project(np.zeros((1, 2)), np.array([1.7]))).all()


@given(st.floats(-1e3, 1e3))
def test_wrapped_angles_are_the_same_direction(angle: float) -> None:
    wrapped = float(wrap_angle(angle))
    assert -np.pi <= wrapped < np.pi
    np.testing.assert_allclose([np.cos(wrapped), np.sin(wrapped)], [np.cos(angle), np.sin(angle)], atol=1e-9)


@given(st.one_of(panoramas, perspectives))
def test_cameras_survive_json(camera: PanoramaCamera | PerspectiveCamera) -> None:
    assert camera_from_dict(camera_to_dict(camera)) == camera


def test_a_file_leaves_out_only_what_the_model_has_by_itself() -> None:
    @dataclass(frozen=True, kw_only=True)
    class LooksDown(PerspectiveCamera):
        pitch: float = -0.2

    assert camera_to_dict(LooksDown(pitch=0.0))["pitch"] == 0.0
    assert not {"pitch", "roll", "vertical_focal"} & camera_to_dict(LooksDown()).keys()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"kind": "panorma"}, "did you mean 'panorama'"),
        ({"kind": "panorama", "focal": 0.0}, "focal must be 0.01 to 1e.07 px, not 0"),
        ({"kind": "panorama", "zoom": 2.0}, "zoom"),
    ],
)
def test_bad_cameras_are_refused(values: dict[str, object], message: str) -> None:
    with pytest.raises(VbbenchError, match=message):
        camera_from_dict(values)


def test_runs_of_frames_begin_where_a_mask_is_set_and_end_where_it_no_longer_is() -> None:
    mask = np.array([True, False, True, True, False, False, True])
    assert runs_of_true(mask).tolist() == [[0, 1], [2, 4], [6, 7]]
    assert runs_of_true(mask[:0]).shape == runs_of_true(~mask[:1]).shape == (0, 2)
