"""What the measurements of the joint solvers share: datasets, solvers with the prior left out, and their figures."""

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from vbbench.camera import PerspectiveCamera
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Look, Options
from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol, scored_frames, scored_positions
from vbbench.registry import held_out, load, make_solver
from vbbench.scoring.metrics import position_error, rotation_error, translation_error
from vbbench.solver import Estimate
from vbbench.solving.runner import run_sequence
from vbbench.solving.warming import warm_up
from vbbench_baselines.joint_map.prior import Prior

Maker = Callable[[], Any]
"""Makes a solver."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A dataset to make."""

    split: str
    tier: str = "ideal"
    look: Look = "motion"
    perspective: bool = False

    def __str__(self) -> str:
        words = [self.split, self.tier, self.look * (self.look != "motion"), "perspective" * self.perspective]
        return ", ".join(word for word in words if word)

    @property
    def prior(self) -> Prior:
        """The one fitted without this split's source."""
        sources = load("generator", self.split).plan(Options()).info.sources
        prior: Prior = make_solver(held_out("map-causal", sources)).prior
        return prior

    @contextmanager
    def made(self) -> Iterator[Dataset]:
        """The dataset, in a folder that goes away."""
        camera = PerspectiveCamera() if self.perspective else None
        with tempfile.TemporaryDirectory() as folder:
            yield generate(self.split, Path(folder) / "data", Options(tier=self.tier, look=self.look, camera=camera))


@dataclass(frozen=True, kw_only=True)
class Figures:
    """Of every sequence solved.

    Parameters
    ----------
    sequences : [N] their numbers.
    errors : [N, 3] Δx, Δt, Δr.
    flagged : [N] whether the solver itself said that it had not converged.
    frames_per_second : on one core.
    """

    sequences: FloatArray
    errors: FloatArray
    flagged: FloatArray
    frames_per_second: float

    def __str__(self) -> str:
        return " / ".join(f"{value:.3f}" for value in self.errors.mean(axis=0)[:2])


def spread_over(dataset: Dataset, sequences: int) -> range:
    """About so many sequences, evenly spread."""
    return range(0, len(dataset), max(round(len(dataset) / sequences), 1))


def evaluate(dataset: Dataset, make: Maker, protocol: str, sequences: int, jobs: int = 1) -> Figures:
    """Solve about so many sequences of a dataset under a protocol."""
    chosen = np.array_split(np.array(spread_over(dataset, sequences)), max(4 * jobs, 1))
    parts = Parallel(n_jobs=jobs)(delayed(_some)(dataset, make, protocol, some) for some in chosen if len(some))
    rows = np.concatenate([part[0] for part in parts])
    seconds, frames = np.sum([part[1] for part in parts], axis=0)
    return Figures(
        sequences=rows[:, 0].astype(int),
        errors=rows[:, 1:4],
        flagged=rows[:, 4] > 0,
        frames_per_second=frames / seconds,
    )


def answer(dataset: Dataset, solver: Any, protocol: str, index: int) -> tuple[Estimate, float]:
    """A solver's estimate of one sequence, and the seconds it took."""
    sequence = dataset.sequence(index)
    rules = get_protocol(protocol)
    truth = dataset.truth(sequence) if rules.needs_truth else None
    return run_sequence(solver, dataset.problem(sequence), sequence, rules, truth)


def _some(dataset: Dataset, make: Maker, protocol: str, chosen: FloatArray) -> tuple[FloatArray, FloatArray]:
    solver, rows, spent = make(), [], np.zeros(2)
    sample = dataset.sequence(int(chosen[0]))
    warm_up(solver, dataset.problem(sample), get_protocol(protocol))
    for index in chosen:
        estimate, seconds = answer(dataset, solver, protocol, int(index))
        errors = sequence_errors(dataset, int(index), estimate, protocol)
        spent += seconds, len(estimate.poses)
        if np.isfinite(errors).all():
            converged = getattr(estimate, "converged", None)
            rows.append((index, *errors, converged is not None and not np.all(converged)))
    return np.array(rows).reshape(-1, 5), spent


def sequence_errors(dataset: Dataset, index: int, estimate: Estimate, protocol: str) -> FloatArray:
    """Δx, Δt and Δr of a sequence, as scored; NaN where nothing is."""
    sequence = dataset.sequence(index)
    truth = dataset.truth(sequence)
    given = get_protocol(protocol).select_given(sequence.given)
    frames, rows = scored_frames(sequence.observed), scored_positions(sequence.observed, given)
    if not rows.any():
        return np.full(3, np.nan)
    return np.array(
        (
            position_error(estimate.positions[rows], truth.positions[rows]).mean(),
            translation_error(estimate.poses[frames], truth.poses[frames]).mean(),
            rotation_error(estimate.poses[frames], truth.poses[frames]).mean(),
        )
    )
