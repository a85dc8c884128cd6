"""Cuts recordings into runs: consecutive frames in which enough people are seen."""

from dataclasses import dataclass
from typing import NamedTuple

from vbbench.geometry import BoolArray, runs_of_true


@dataclass(frozen=True, kw_only=True)
class RunRules:
    """Which frames become sequences.

    Parameters
    ----------
    fewest : people who must be seen in every frame.
    shortest : frames of the shortest run.
    longest : frames after which a run is cut; ``None`` = never.
    """

    fewest: int = 3
    shortest: int = 5
    longest: int | None = 40


class Run(NamedTuple):
    """Frames first ≤ frame < last of a recording."""

    recording: int
    first: int
    last: int


def find_runs(recording: int, observed: BoolArray, rules: RunRules) -> list[Run]:
    """The runs of a recording, from who is observed in each frame [T, K]."""
    runs = []
    for begin, end in runs_of_true(observed.sum(axis=1) >= rules.fewest).tolist():
        longest = rules.longest or end - begin
        runs += [Run(recording, first, min(first + longest, end)) for first in range(begin, end, longest)]
    return [run for run in runs if run.last - run.first >= rules.shortest]
