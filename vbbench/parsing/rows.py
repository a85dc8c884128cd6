"""Rows of a table from outside, such as a file of boxes."""

from collections.abc import Iterable

import numpy as np

from vbbench.geometry import BoolArray, IntArray


def first_repetition(*columns: IntArray) -> tuple[int, int] | None:
    """The first row, in their order, that says in all ``columns`` [N] what an earlier one says: (earlier, later).

    ``None`` if no two rows are alike. Rows in ascending order, as most files have them, are not sorted.
    """
    if _steps(columns)[1].all():
        return None
    order = np.lexsort(columns)  # stable: of two alike, the earlier row comes first
    same = np.flatnonzero(_steps([column[order] for column in columns])[0])
    if not len(same):
        return None
    place = same[order[same + 1].argmin()]
    return int(order[place]), int(order[place + 1])


def _steps(columns: Iterable[IntArray]) -> tuple[BoolArray, BoolArray]:
    """[N − 1] whether each row is like the one before, and whether it is greater where they first differ."""
    alike: BoolArray = np.array(True)
    greater: BoolArray = np.array(False)
    for column in columns:
        step = np.diff(column)
        greater = greater | (alike & (step > 0))
        alike = alike & (step == 0)
    return alike, greater
