"""What a motion prior is fitted on: second differences of true walks."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from vbbench.generation.generator import Plan
from vbbench.geometry import FloatArray, IntArray
from vbbench.scene import Scene

STANDING = 0.5
"""Who ends nearer than this (m) to the start is left out: splits do not show them, and rounded stillness is no walk."""


class Walks(NamedTuple):
    """Every second difference of a crowd, with what came before it.

    Attributes
    ----------
    differences : [N, 3, 2] in m: a_t, a_{t−1} and a_{t−2}; zero where the walk had not begun.
    order : [N] how many of the two past ones there are, 0 to 2.
    first : [P] row at which each person begins; persons stand one after the other.
    speed : mean square of a velocity component in m²/s².
    """

    differences: FloatArray
    order: IntArray
    first: IntArray
    speed: float


def walks_of(plan: Plan, most: int) -> Walks:
    """The walks of a split's shared scenes, or of the scenes of its first ``most`` sequences."""
    return gather(plan.scenes or _built_scenes(plan, most))


def gather(scenes: Iterable[Scene]) -> Walks:
    """All walks in some scenes; somebody who comes back is a new walk of the same person."""
    people: list[list[FloatArray]] = []
    squares: list[FloatArray] = []
    for scene in scenes:
        for column in range(len(scene.people)):
            runs = _runs(scene.positions[:, column])
            if np.hypot(*(runs[-1][-1] - runs[0][0])) < STANDING:
                continue
            squares += [(np.diff(run, axis=0) / scene.dt) ** 2 for run in runs]
            if any(len(run) > 2 for run in runs):
                people.append([np.diff(run, 2, axis=0) for run in runs if len(run) > 2])
    order = [np.minimum(np.arange(len(a)), 2) for person in people for a in person]
    lengths = [sum(map(len, person)) for person in people]
    return Walks(
        differences=np.concatenate([_with_past(a) for person in people for a in person]),
        order=np.concatenate(order).astype(np.int64),
        first=np.cumsum([0, *lengths[:-1]], dtype=np.int64),
        speed=float(np.concatenate(squares).mean()),
    )


def _built_scenes(plan: Plan, most: int) -> Iterator[Scene]:
    for index in range(min(most, len(plan))):
        scene = plan.build(index).scene
        if scene is not None:
            yield scene


def _runs(path: FloatArray) -> list[FloatArray]:
    """The stretches without gap of a path [T, 2]."""
    there = np.flatnonzero(~np.isnan(path[:, 0]))
    return [path[frames] for frames in np.split(there, np.flatnonzero(np.diff(there) > 1) + 1)]


def _with_past(differences: FloatArray) -> FloatArray:
    """[n, 2] → [n, 3, 2]: each beside the two before it."""
    rows = np.zeros((len(differences), 3, 2))
    for lag in range(3):
        rows[lag:, lag] = differences[: len(differences) - lag]
    return rows
