"""The sequences in which a solver fails worst, found by its capped error, and what they have that others have not."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray
from vbbench.pictures.replay import Replay, load_replay
from vbbench.reproduction.making import Making, submission_folder
from vbbench.reproduction.posterior.walking import Walking
from vbbench.scoring.metrics import METRICS

PROTOCOL, METRIC = "sequential", "dx"
SYMBOL = METRICS[METRIC].symbol
SHOWN = 6
"""Sequences that are drawn, none of which shares frames with another."""
WORST = 0.1
"""The share of all sequences whose causes are counted."""


@dataclass(frozen=True, kw_only=True)
class Facts:
    """What a sequence is like, means over its frames from the third on.

    Parameters
    ----------
    people : seen in a frame.
    spread, bearings : of directions, and of bearings, over frames that have them.
    standing : share of walkers who stand, the observer included.
    arrivals : people in a frame who are seen for the first time.
    empty : frames in which nobody is seen.
    """

    people: float
    spread: float
    bearings: float
    standing: float
    arrivals: float
    empty: int


CAUSES: Mapping[str, tuple[str, Callable[[Facts], bool]]] = {
    "few": ("5 people or fewer are seen in the mean frame", lambda one: one.people <= 5.0),
    "one side": ("the mean spread of bearings is below .15", lambda one: one.bearings < 0.15),
    "parallel": ("the mean spread of directions is below .1", lambda one: one.spread < 0.1),
    "standing": ("a quarter of the walkers stand", lambda one: one.standing >= 0.25),
    "few new": ("fewer than one newcomer, whose place is given, in five frames", lambda one: one.arrivals < 0.2),
    "gap": ("in a frame, or more, nobody is seen", lambda one: one.empty > 0),
}
"""What a failure may come from, by name: in words, and whether a sequence has it."""


@dataclass(frozen=True, kw_only=True)
class Failure:
    """One sequence, its errors (m, not capped) and its facts; ``causes`` names those of `CAUSES` that it has."""

    sequence: int
    error: float
    observer_error: float
    facts: Facts
    causes: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Failures:
    """The worst sequences.

    Parameters
    ----------
    solver : whose.
    failures : all scored sequences, the worst first.
    shown : the worst that share no frames, with what the solver answered.
    cap : in m.
    """

    solver: str
    failures: tuple[Failure, ...]
    shown: tuple[tuple[Failure, Replay], ...]
    cap: float

    @property
    def worst(self) -> tuple[Failure, ...]:
        """The worst tenth."""
        return self.failures[: max(1, round(WORST * len(self.failures)))]

    def share(self, cause: str, among: Sequence[Failure]) -> float:
        """Share of some sequences that have a cause."""
        return sum(cause in one.causes for one in among) / len(among)


def find_failures(dataset: Dataset, solver: str, walks: Sequence[Walking], making: Making) -> Failures:
    """Solve and score, rank by the capped error, and by the error itself among those above the cap."""
    ((_, found),) = making.scores(dataset, [solver], PROTOCOL)
    folder = submission_folder(dataset, solver, PROTOCOL)
    own, cap = found.per_sequence, found.protocol.caps[METRIC]
    error, observer = own.figures[METRIC], own.figures["dt"]
    failures = []
    for row in np.lexsort((-np.nan_to_num(error), -np.fmin(np.nan_to_num(error), cap))):
        number = int(own.sequence[row])
        facts = facts_of(walks[number])
        causes = tuple(name for name, (_, has) in CAUSES.items() if has(facts))
        failures.append(
            Failure(
                sequence=number,
                error=float(error[row]),
                observer_error=float(observer[row]),
                facts=facts,
                causes=causes,
            )
        )
    shown = tuple((one, load_replay(dataset, one.sequence, [folder])) for one in _apart(dataset, failures))
    return Failures(solver=solver, failures=tuple(failures), shown=shown, cap=cap)


def facts_of(walk: Walking) -> Facts:
    """The facts of a sequence that has scored frames."""
    return Facts(
        people=float(walk.people.mean()),
        spread=_known_mean(walk.spread),
        bearings=_known_mean(walk.bearings),
        standing=float(walk.standing.mean()),
        arrivals=float(walk.arrivals.mean()),
        empty=int((walk.people == 0).sum()),
    )


def _known_mean(values: FloatArray) -> float:
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else 0.0


def _apart(dataset: Dataset, failures: Sequence[Failure]) -> list[Failure]:
    """The first `SHOWN` of which none shares frames of a scene with another."""
    rows = dataset.rows
    chosen: list[Failure] = []
    for one in failures:
        begin, end = _time(rows, one.sequence)
        taken = [
            _time(rows, other.sequence)
            for other in chosen
            if rows["scene"][other.sequence] == rows["scene"][one.sequence]
        ]
        if all(end <= first or last <= begin for first, last in taken):
            chosen.append(one)
        if len(chosen) == SHOWN:
            break
    return chosen


def _time(rows: Mapping[str, FloatArray], sequence: int) -> tuple[int, int]:
    """First frame of the scene, and the one after the last."""
    first = int(rows["first_frame"][sequence])
    return first, first + int(rows["frames"][sequence])
