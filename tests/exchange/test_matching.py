"""Boxes of other frames than the people: found where people or camera move, and not where they stand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vbbench.exchange.matching import MOST_LATER, FrameOffset, frame_offset, in_columns
from vbbench.geometry import FloatArray


def walkers(frames: int = 100, people: int = 6, speed: float = 6.0, seed: int = 0) -> FloatArray:
    """[T, P, 4] boxes of people who walk through a picture, ``speed`` px a frame (standard deviation)."""
    rng = np.random.default_rng(seed)
    height = rng.uniform(80.0, 200.0, people)
    middle = rng.uniform(200.0, 1000.0, people) + np.arange(frames)[:, None] * rng.normal(0.0, speed, people)
    middle = middle + 10.0 * np.sin(np.arange(frames)[:, None] / 9.0 + rng.uniform(0.0, 6.0, people))
    edges = np.broadcast_arrays(middle - 0.18 * height, 300.0 - height, 0.36 * height, height)
    return np.stack(edges, axis=-1)


def standing(frames: int = 300, people: int = 8, seed: int = 0) -> FloatArray:
    """[T, P, 4] boxes of people who stand before a camera that stands."""
    return np.repeat(walkers(1, people, seed=seed), frames, axis=0)


def later(boxes: FloatArray, frames: int) -> FloatArray:
    """The same boxes so many frames later; NaN where there is none."""
    moved = np.full_like(boxes, np.nan)
    kept = max(len(boxes) - abs(frames), 0)
    moved[max(frames, 0) : max(frames, 0) + kept] = boxes[max(-frames, 0) : max(-frames, 0) + kept]
    return moved


def offset_of(found: FloatArray, true: FloatArray, *, own: bool = False) -> FrameOffset | None:
    columns = np.broadcast_to(np.arange(true.shape[1]), true.shape[:2]) if own else None
    return frame_offset(found, lambda frames, shift: true[frames + shift], None, columns)


@settings(max_examples=30, deadline=None)
@given(st.integers(-MOST_LATER, MOST_LATER), st.integers(0, 1000), st.booleans())
def test_a_shift_of_frames_is_found(shift: int, seed: int, own: bool) -> None:
    true = walkers(seed=seed)
    offset = offset_of(later(true, -shift), true, own=own)
    if shift == 0:
        assert offset is None
    else:
        assert offset is not None
        assert offset.later == shift
        assert offset.then == pytest.approx(1.0)
        assert offset.now < 0.99


def test_boxes_that_are_far_from_exact_show_it_too() -> None:
    true = walkers(frames=300)
    found = later(true, 3) + np.random.default_rng(1).normal(0.0, 4.0, true.shape)
    offset = offset_of(found, true)
    assert offset is not None
    assert -4 <= offset.later <= -2
    assert "frames earlier" in str(offset)


def test_ten_boxes_are_enough() -> None:
    true = walkers(frames=6, people=3)
    offset = offset_of(later(true, -1), true)
    assert offset is not None
    assert str(offset).startswith("boxes overlap people one frame later by 1.00, now by 0.")
    assert "do frames count from 0 or from 1?" in str(offset)


@pytest.mark.parametrize("shift", [0, 1, -7, 30])
@pytest.mark.parametrize("lasting", [1, 10, 40], ids="errors that last {} frames".format)
def test_people_who_stand_give_no_alarm(shift: int, lasting: int) -> None:
    """Errors of a detector last: they are alike in frames in a row, and no shift fits better than the others."""
    for seed in range(3):
        true = standing(seed=seed)
        rng = np.random.default_rng(seed)
        errors = np.repeat(rng.normal(0.0, 5.0, (len(true) // lasting + 1, *true.shape[1:])), lasting, axis=0)
        assert offset_of(later(true + errors[: len(true)], shift), true) is None
        assert offset_of(later(true + errors[: len(true)], shift), true, own=True) is None


def test_boxes_in_the_right_frames_give_no_alarm() -> None:
    for seed in range(20):
        true = walkers(seed=seed)
        found = true + np.random.default_rng(seed).normal(0.0, 8.0, true.shape)
        found[np.random.default_rng(seed).random(found.shape[:2]) < 0.3] = np.nan
        assert offset_of(found, true) is None


def test_boxes_of_nobody_have_no_shift() -> None:
    true = walkers()
    assert offset_of(np.full_like(true, np.nan), true) is None
    assert offset_of(true, np.full_like(true, np.nan)) is None
    assert offset_of(true, true[:, :0]) is None
    assert offset_of(true + np.array([5000.0, 0.0, 0.0, 0.0]), true) is None


def test_wrong_heights_are_not_blamed_on_frames() -> None:
    """People who come nearer look as if of a later frame where boxes are too high; their columns do not."""
    frames = np.arange(200)[:, None]
    height = 60.0 + 0.8 * frames + np.zeros(5)
    middle = 600.0 + np.linspace(-1.0, 1.0, 5) * height
    true = np.stack([middle - 0.18 * height, 300.0 - height, 0.36 * height, height], axis=-1)
    found = true.copy()
    found[..., 1], found[..., 3] = 300.0 - 1.15 * height, 1.15 * height
    assert offset_of(in_columns(found), in_columns(true), own=True) is None
