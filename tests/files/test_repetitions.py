"""Rows that say the same twice, such as two boxes of a track in a frame."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vbbench.files.tables import first_repetition

KEY = st.tuples(st.integers(-3, 3), st.integers(-3, 3))


def by_hand(keys: list[tuple[int, ...]]) -> tuple[int, int] | None:
    last: dict[tuple[int, ...], int] = {}
    for row, key in enumerate(keys):
        if key in last:
            return last[key], row
        last[key] = row
    return None


@given(st.one_of(st.lists(KEY, max_size=12), st.lists(KEY, max_size=12).map(sorted), st.lists(KEY, unique=True)))
def test_it_is_the_one_that_a_reader_from_top_to_bottom_meets_first(keys: list[tuple[int, int]]) -> None:
    frame, track = np.array(keys, np.int64).reshape(-1, 2).T
    assert first_repetition(frame, track) == first_repetition(track, frame) == by_hand(keys)
    assert first_repetition(frame) == by_hand([key[:1] for key in keys])
