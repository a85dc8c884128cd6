"""Which columns of a panorama a plot shows: all people, whole and once, and no wide empty part."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from vbbench.pictures.plotting import ego

PERIOD = 1440.0
BOXES = st.lists(st.tuples(st.floats(-400.0, 2 * PERIOD), st.floats(2.0, 400.0)), max_size=12)


def widest_gap(left: np.ndarray, width: np.ndarray) -> float:
    """The widest stretch of columns without a box, counted column by column."""
    columns = np.arange(0.0, PERIOD, 1.0)
    free = np.all(np.mod(columns[:, None] - left, PERIOD) > width, axis=1)
    longest = run = 0
    for empty in np.concatenate([free, free]):
        run = run + 1 if empty else 0
        longest = max(longest, run)
    return float(min(longest, PERIOD))


@given(BOXES)
@settings(max_examples=60)
def test_every_box_is_whole_in_the_window_which_is_no_wider_than_it_must_be(boxes):
    left, width = np.array(boxes).reshape(-1, 2).T
    low, high = ego.people_window(left, width, PERIOD)
    assert 0.0 <= low < PERIOD
    assert 0.4 * PERIOD - 1e-6 <= high - low <= PERIOD + 1e-9
    if high - low < PERIOD:
        begin = ego.unrolled(left, low, PERIOD)
        assert np.all(begin >= low)
        assert np.all(begin + width <= high + 1e-6)
        np.testing.assert_allclose(np.mod(begin - left + 1.0, PERIOD), 1.0, atol=1e-6)
        needed = PERIOD - widest_gap(left, width) + 0.06 * PERIOD
        assert high - low <= max(needed, 0.4 * PERIOD) + 3.0
    elif len(boxes):
        assert widest_gap(left, width) < 0.22 * PERIOD


@given(st.floats(0.0, PERIOD - 1e-6), st.floats(0.4 * PERIOD, PERIOD), st.sampled_from([50.0, 100.0, 200.0, 500.0]))
def test_ticks_name_the_columns_they_stand_at_and_keep_their_distance(low, width, step):
    ticks = np.array(ego.column_ticks(low, low + width, PERIOD, step))
    assert np.all((ticks >= low - 1e-6) & (ticks <= low + width + 1e-6))
    named = np.mod(ticks, PERIOD)
    np.testing.assert_allclose(np.mod(named + 1e-9, step), 0.0, atol=1e-6)
    assert np.all(np.diff(ticks) >= 0.5 * step - 1e-6)
    assert np.all(np.diff(ticks) <= 1.5 * step + 1e-6)


def test_a_crowd_around_the_seam_is_shown_across_it():
    low, high = ego.people_window(np.array([1400.0, 5.0]), np.array([30.0, 40.0]), PERIOD)
    assert low < 1400.0 < PERIOD < high
    assert ego.unrolled(np.array([5.0]), low, PERIOD)[0] == PERIOD + 5.0


def test_nobody_at_all_is_shown_in_the_whole_picture():
    assert ego.people_window(np.empty(0), np.empty(0), PERIOD) == (0.0, PERIOD)
