"""What a solver's row on a board said before: figures that newer ones took the place of, kept in the result's file."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vbbench.parsing.dates import is_day
from vbbench.scoring.metrics import METRICS

MOST = 200
"""Entries of a file; the oldest make room."""

_SAME = 1e-6
"""Figures that differ by less, relative to their size, are the same on another machine."""

DIGITS = 8
"""Of a figure in a file: what newer ones replaced is kept to be seen, not to be computed with."""

Interval = tuple[float | None, float | None, float | None]
"""A capped mean with the low and the high end of its 95 % interval; ``None`` = there is none."""


@dataclass(frozen=True, kw_only=True)
class Past:
    """What a row said.

    Parameters
    ----------
    date : the day of that result, YYYY-MM-DD.
    version : of the solver.
    vbbench : the version that scored it.
    dataset : id of the dataset that was solved; with another, the task was another.
    protocol : name and version.
    capped : metric → capped mean and interval.
    """

    date: str
    version: str
    vbbench: str
    dataset: str
    protocol: str
    capped: Mapping[str, Interval]

    @staticmethod
    def of(score: Mapping[str, Any], **said: str) -> "Past":
        """The entry of a score, as ``vbbench score --json`` prints it; ``said`` are the other parameters."""
        summaries = {**score["metrics"], **score["drift"]}
        return Past(
            **said, capped={name: (found["capped"], *found["capped_ci95"]) for name, found in summaries.items()}
        )

    @staticmethod
    def read(values: Mapping[str, Any]) -> "Past":
        """An entry of a file that keeps to the schema."""
        return Past(**{**values, "capped": {name: tuple(ends) for name, ends in values["capped"].items()}})

    def values(self) -> dict[str, Any]:
        """The entry as the file has it."""
        return {**vars(self), "capped": {name: [_rounded(end) for end in ends] for name, ends in self.capped.items()}}

    def says_the_same(self, other: "Past") -> bool:
        """Whether the figures are those of the other, on the same dataset."""
        if self.dataset != other.dataset or set(self.capped) != set(other.capped):
            return False
        pairs = [pair for name, ends in self.capped.items() for pair in zip(ends, other.capped[name], strict=True)]
        return all(_equal(one, two) for one, two in pairs)


def grown(history: Sequence[Past], old: Past, new: Past) -> tuple[Past, ...]:
    """The history of a row whose figures ``old`` are replaced by ``new``; the same figures add nothing."""
    return tuple(history) if old.says_the_same(new) else (*history, old)[-MOST:]


def history_faults(history: Sequence[Past], date: str) -> Iterator[str]:
    """What is wrong with the history of a result of the day ``date``."""
    days = [*(past.date for past in history), date]
    for n, past in enumerate(history):
        place = f"$.history[{n}]"
        if not is_day(past.date):
            yield f"{place}.date: {past.date} is not a day; write it as YYYY-MM-DD"
        elif days[n + 1] < past.date:
            yield f"{place}.date: {past.date} is after {days[n + 1]}, which follows it; the oldest comes first"
        for name, (value, low, high) in past.capped.items():
            if name not in METRICS:
                yield f"{place}.capped.{name}: is no metric"
            ends = [end for end in (low, value, high) if end is not None]
            if ends != sorted(ends) or (value is None and ends):
                yield f"{place}.capped.{name}: the mean does not lie in its interval"


def _rounded(figure: float | None) -> float | None:
    return None if figure is None else float(f"{figure:.{DIGITS}g}")


def _equal(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return math.isclose(one, other, rel_tol=_SAME, abs_tol=1e-12)
