"""Boxes as directions and slopes: those of the person that a camera shows, whatever the camera; and what is cut off."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.extensions.fisheye import Fisheye
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench_baselines.common.bearings import (
    BORDER,
    FEET_CUT,
    HALF_WIDTH,
    HEAD_CUT,
    SIDE_CUT,
    bearings_of,
    each,
)

CAMERAS: dict[str, Camera] = {
    "perspective": PerspectiveCamera(),
    "oblong pixels": PerspectiveCamera(vertical_focal=500.0),
    "tilted": PerspectiveCamera(pitch=-0.2, roll=0.1),
    "panorama": PanoramaCamera(),
    "fisheye": Fisheye(),
    "tilted fisheye": Fisheye(pitch=-0.3, roll=0.2),
}
REACH, AZIMUTH, HEIGHT = st.floats(2.5, 60.0), st.floats(-0.7, 0.7), st.floats(1.0, 2.1)


def at(reach: float, azimuth: float) -> np.ndarray:
    """Somebody's place (right, forward)."""
    return reach * np.array((np.sin(azimuth), np.cos(azimuth)))


@pytest.mark.parametrize("name", CAMERAS)
@settings(max_examples=40, deadline=None)
@given(reach=REACH, azimuth=AZIMUTH, height=HEIGHT)
def test_they_are_those_of_the_person_that_the_camera_shows(
    name: str, reach: float, azimuth: float, height: float
) -> None:
    camera = CAMERAS[name]
    seen = bearings_of(camera, camera.project_unbounded(at(reach, azimuth)[None], np.array([height])))
    assert seen.azimuth[0] == pytest.approx(azimuth, abs=1e-6)
    assert seen.foot[0] == pytest.approx(camera.mount_height / reach, rel=1e-5)
    assert seen.length[0] == pytest.approx(height / reach, rel=1e-5)


@pytest.mark.parametrize("name", ["perspective", "tilted", "panorama", "fisheye"])
@settings(max_examples=20, deadline=None)
@given(reach=st.floats(4.0, 40.0), azimuth=AZIMUTH)
def test_a_column_s_noise_is_as_wide_as_the_picture_says(name: str, reach: float, azimuth: float) -> None:
    """A box moved along the row by a hundredth of its height is seen by so much of ``width`` elsewhere."""
    camera = CAMERAS[name]
    box = camera.project_unbounded(at(reach, azimuth)[None], np.array([1.7]))
    seen = bearings_of(camera, box)
    moved = bearings_of(camera, box + np.array((0.01 * box[0, 2], 0.0, 0.0)))
    assert moved.azimuth[0] - seen.azimuth[0] == pytest.approx(0.01 * seen.width[0], rel=0.02)
    assert seen.size[0] == box[0, 2]


def test_all_around_there_is_no_border_at_the_seam() -> None:
    camera = CAMERAS["panorama"]
    for azimuth in (np.pi - 1e-4, -np.pi + 1e-4):
        box = camera.project(at(8.0, azimuth)[None], np.array([1.7]))
        seen = bearings_of(camera, box)
        assert seen.azimuth[0] == pytest.approx(azimuth, abs=1e-9)
        assert seen.width[0] == pytest.approx(box[0, 2] / camera.focal, rel=1e-6)
        assert seen.cut[0] == 0


@pytest.mark.parametrize("name", CAMERAS)
def test_borders_are_flagged(name: str) -> None:
    camera = CAMERAS[name]
    columns, rows = camera.picture_size
    size, middle = 0.25 * rows, (0.5 * columns, 0.5 * rows)
    boxes = np.array(
        (
            (*middle, size),
            (middle[0], rows - 0.5 * size - BORDER - 1.0, size),
            (middle[0], rows - 0.5 * size - BORDER + 1.0, size),
            (middle[0], 0.5 * size + BORDER + 1.0, size),
            (middle[0], 0.5 * size + BORDER - 1.0, size),
            (HALF_WIDTH * size + 1.0, middle[1], size),
            (HALF_WIDTH * size - 1.0, middle[1], size),
            (columns - HALF_WIDTH * size + 1.0, middle[1], size),
            (1.0, middle[1], rows - 1.0),
        )
    )
    side = SIDE_CUT if camera.period is None else 0
    wanted = (0, 0, FEET_CUT, 0, HEAD_CUT, 0, side, side, FEET_CUT + HEAD_CUT + side)
    assert bearings_of(camera, boxes).cut.tolist() == list(wanted)


@pytest.mark.parametrize("name", CAMERAS)
def test_boxes_that_show_nobody_tell_nothing(name: str) -> None:
    """Absent ones, and ones without a height."""
    camera = CAMERAS[name]
    u, v = (0.5 * size for size in camera.picture_size)
    boxes = np.array(((np.nan, np.nan, np.nan), (u, v, 0.0), (u, v, -50.0), (u, np.nan, 100.0)))
    seen = bearings_of(camera, boxes)
    for field in seen[:5]:
        assert np.isnan(field).all()
    assert seen.cut.tolist() == [0] * len(boxes)
    assert np.shape(bearings_of(camera, np.zeros((4, 0, 3))).azimuth) == (4, 0)


def test_feet_above_the_horizon_are_a_slope_upwards() -> None:
    """Such a box still says how far its person is; a rough camera's tilt explains the feet."""
    camera = CAMERAS["perspective"]
    seen = bearings_of(camera, np.array([[640.0, 300.0, 60.0]]))
    assert seen.foot[0] < 0.0 < seen.length[0]


def test_every_field_is_changed_alike() -> None:
    seen = bearings_of(CAMERAS["perspective"], np.array([[640.0, 400.0, 100.0], [np.nan] * 3]))
    for field, changed in zip(seen, each(lambda rows: rows[:1], seen), strict=True):
        np.testing.assert_array_equal(changed, field[:1])
