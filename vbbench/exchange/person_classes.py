"""Which boxes are of people, by their classes: numbers of COCO or MOTChallenge, or names."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError
from vbbench.geometry import BoolArray

UNKNOWN = -1
"""The class of a box that has none; it counts as a person."""
PEOPLE = frozenset(
    ("person", "persons", "people", "pedestrian", "pedestrians", "ped", "human", "humans", "man", "woman", "child")
)
"""Names of classes of people."""
RIVAL = 0.5
"""Boxes of class 1 per box of class 0 from which 0 need not be people, as it is in COCO."""


def of_people(
    path: Path, classes: NDArray[Any], given: int | str | None = None, names: Mapping[int, str] | None = None
) -> tuple[BoolArray, str]:
    """Which boxes are of people, [N], and what is left out, class by class; empty where nothing is.

    Class 0 means people where it is there, as trackers write that count as COCO does; else class 1, as in MOTChallenge.
    Ground truth of MOTChallenge has no class 0.

    Parameters
    ----------
    path : the file, for messages.
    classes : [N] numbers, `UNKNOWN` or NaN for none, or names.
    given : the class of people, if the user states it.
    names : of class numbers, if the file has them.

    Raises
    ------
    FileError
        If the classes do not show which one is of people; boxes are counted by class.
    """
    if classes.dtype.kind in "if":
        known = np.isfinite(classes) & (classes != UNKNOWN)
        words = [(names or {}).get(int(one), f"{one:g}") for one in np.unique(classes[known])]
        values = np.unique(classes[known])
    else:
        known = classes != ""
        values = np.unique(classes[known])
        words = [str(one) for one in values]
    counts = {word: int((classes == value).sum()) for word, value in zip(words, values, strict=True)}
    if not counts:
        return np.ones(len(classes), np.bool_), ""
    chosen = _chosen(path, counts, given)
    kept = ~known | np.isin(classes, [value for word, value in zip(words, values, strict=True) if word in chosen])
    rest = {word: count for word, count in counts.items() if word not in chosen}
    return kept, f"{_listed(rest)} (people are class {' or '.join(sorted(chosen))})" if rest else ""


def _chosen(path: Path, counts: Mapping[str, int], given: int | str | None) -> set[str]:
    if given is not None:
        chosen = {word for word in counts if word.lower() == str(given).strip().lower()}
        if not chosen:
            raise FileError(path, f"has no box of class {given}; it has {_listed(counts)}")
        return chosen
    named = {word for word in counts if PEOPLE & set(word.lower().replace(".", " ").split())}
    if named:
        return named
    zero, one = counts.get("0", 0), counts.get("1", 0)
    if zero and one <= RIVAL * zero:
        return {"0"}
    if one and not zero:
        return {"1"}
    problem = f"has {_listed(counts)}; people are class 0 in COCO, 1 in MOTChallenge"
    raise FileError(path, f"{problem}; write which one is people: `person_class` N, or a name")


def _listed(counts: Mapping[str, int]) -> str:
    most = sorted(counts.items(), key=lambda one: -one[1])
    shown = ", ".join(f"{count} of class {word}" for word, count in most[:6])
    return f"{shown} and {len(most) - 6} other classes" if len(most) > 6 else shown
