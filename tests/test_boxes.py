"""Boxes that cannot be people in the camera's picture: the same checks of ten boxes and of a thousand."""

import re
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.lib.own_recording import make_walk
from vbbench.boxes import find_misfit, outside_picture
from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.geometry import FloatArray

PICTURE = (1280.0, 720.0)
WALK = make_walk(people=10)
BOXES = WALK.boxes[np.isfinite(WALK.boxes[..., 0])]
COUNTS = (10, 30, 180, len(BOXES))

WRONG: dict[str, tuple[Callable[[FloatArray], FloatArray], str, bool]] = {
    "corners": (lambda b: np.hstack([b[:, :2], b[:, :2] + b[:, 2:]]), "right and lower borders of boxes", True),
    "shares": (lambda b: b / [1280, 720, 1280, 720], "shares of the picture", True),
    "per cent": (lambda b: b / [12.8, 7.2, 12.8, 7.2], "per cent of the picture; write px of 1280 x 720", True),
    "4K": (lambda b: 3.0 * b, "boxes is outside the picture of 1280 x 720 px", True),
    "a third outside": (
        lambda b: b + 2000.0 * (np.arange(len(b)) % 3 == 0)[:, None] * [1, 0, 0, 0],
        "boxes is outside the picture of 1280 x 720 px: they reach column",
        True,
    ),
    "middles": (lambda b: b + 0.5 * b[:, [2, 3, 0, 1]] * [1, 1, 0, 0], "left and top the middle of boxes", False),
    "squeezed": (lambda b: b * [0.5, 640 / 720, 0.5, 640 / 720], "was squeezed", False),
    "letterbox": (
        lambda b: 0.5 * b + [0, 140, 0, 0],
        "640 x 640 px with borders.* 140 from top.* by 0.5$",
        False,
    ),
    "heads": (lambda b: b * [1, 1, 0.35, 1 / 7], "over 0.75 times as wide as high", False),
    "high before wide": (lambda b: b[:, [0, 1, 3, 2]], "100% of boxes are wider than high", False),
    "full HD": (lambda b: 1.5 * b, "of a larger picture than 1280 x 720 px, .* horizon at row 5", False),
    "a third": (lambda b: b / 3.0, "fill only the upper left .* horizon at row 1.*camera at row 360", False),
    "VGA": (lambda b: 0.5 * b, "fill only the upper left .* horizon at row 1.*camera at row 360", False),
}


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("what", WRONG)
def test_what_boxes_are_given_as_is_found_at_any_number(what: str, count: int) -> None:
    change, text, certain = WRONG[what]
    found = find_misfit(change(BOXES[:count]), WALK.camera, PICTURE, 1.72)
    assert found.certain == certain
    assert re.search(text, found.text)


@pytest.mark.parametrize("count", COUNTS)
def test_right_boxes_are_right_at_any_number(count: int) -> None:
    assert find_misfit(BOXES[:count], WALK.camera, PICTURE, 1.72) is None
    assert find_misfit(BOXES[:0], WALK.camera, PICTURE, 1.72) is None


@given(st.integers(0, 50), st.floats(0.0, 60.0), st.floats(0.0, 30.0), st.floats(100.0, 690.0))
def test_a_large_person_in_the_upper_left_is_no_corner(seed: int, left: float, top: float, high: float) -> None:
    """Width and height exceed left and top as those of corners do, and are a person's as they are."""
    boxes = np.array([left, top, 0.4 * high, high]) + np.random.default_rng(seed).normal(0.0, 1.0, (40, 4))
    found = find_misfit(boxes, WALK.camera, PICTURE, 1.72)
    assert found is None or not found.certain


def test_people_in_one_part_of_a_panorama_are_no_misfit() -> None:
    """Their feet and heights put the horizon where the camera has it."""
    camera = PanoramaCamera()
    places = np.random.default_rng(0).uniform([-9.0, 3.0], [-2.0, 9.0], (300, 2))
    u, v, length = camera.project(places, np.full(300, 1.72)).T
    boxes = np.stack([u - 0.2 * length, v - 0.5 * length, 0.4 * length, length], axis=-1)
    assert (boxes[:, 0] + boxes[:, 2]).max() < 0.6 * camera.picture_size[0]
    assert find_misfit(boxes, camera, camera.picture_size, 1.72) is None


def test_a_panorama_has_no_left_and_right_border() -> None:
    box = np.array([[-100.0, 200.0, 40.0, 100.0], [10.0, -200.0, 40.0, 100.0]])
    pinhole = PerspectiveCamera(width=1280, height=720, focal=700.0, cx=640.0, cy=360.0, mount_height=1.5)
    assert outside_picture(box, PanoramaCamera(), (3760.0, 480.0)).tolist() == [False, True]
    assert outside_picture(box, pinhole, PICTURE).tolist() == [True, True]


@given(st.floats(-0.06, 0.06), st.integers(0, 20))
def test_a_wrong_pitch_alone_does_not_put_left_and_top_in_the_middle(pitch: float, seed: int) -> None:
    """Feet are then as many rows off, however high boxes are."""
    boxes = BOXES[np.random.default_rng(seed).permutation(len(BOXES))[:100]] + [0.0, 700.0 * pitch, 0.0, 0.0]
    found = find_misfit(boxes, WALK.camera, PICTURE, 1.72)
    assert found is None or "middle of boxes" not in found.text
