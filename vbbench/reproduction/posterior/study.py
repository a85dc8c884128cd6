"""The posteriors of observer and people on ETH: ten frames of four examples, and entropies over all sequences.

The paper draws posteriors over ten frames for few and for more people, walking parallel and crossing, and says that
tails are heavier with few people, and that posteriors are sharper where people walk in diverse directions.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray
from vbbench.parallel.parts import in_parallel, progress_bar
from vbbench.registry import load
from vbbench.reproduction.asked import check_every, stride_of
from vbbench.reproduction.making import Making
from vbbench.reproduction.posterior.effects import FrameSample
from vbbench.reproduction.posterior.failures import Failures, find_failures
from vbbench.reproduction.posterior.measuring import (
    Instant,
    PosteriorTable,
    instants,
    posterior_rows,
    reported_rows,
)
from vbbench.reproduction.posterior.walking import Example, Walking, pick_examples, walking_of
from vbbench.scoring.block_bootstrap import Timeline

SPLIT = "eth"
SOLVER = "vb-sf"
"""Its class names, in ``readings``, the solver that reads the paper's text."""
REPORTED = "map-causal"
"""Whose reported covariance is drawn beside."""
_PART = 8


def text_reading() -> str:
    """The solver of the paper's text: heights from N(μ_h, σ_h²), nothing expected of the observer."""
    pair: tuple[str, str] = load("solver", SOLVER).readings["prior"]
    return pair[1]


def measured_solvers() -> dict[str, str]:
    """The solvers whose posteriors are measured, and what sets each apart; the first is drawn."""
    return {
        text_reading(): "the text: heights from N(1.70 m, σ_h²), nothing expected of the observer",
        SOLVER: "vb-sf as it is: heights learned, the observer expected to walk on",
    }


@dataclass(frozen=True, kw_only=True)
class PosteriorStudy:
    """What to measure.

    Parameters
    ----------
    split : of a recording.
    every : only every so-many-th sequence.
    seed : of the dataset.
    """

    split: str = SPLIT
    every: int = 1
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if ``every`` is no number of sequences."""
        check_every(self.every)


@dataclass(frozen=True, kw_only=True)
class ShownExample:
    """An example with its posteriors, the true path [T, 3] and the true places [T, K, 2] of the people seen."""

    example: Example
    instants: tuple[Instant, ...]
    poses: FloatArray
    positions: FloatArray


@dataclass(frozen=True, kw_only=True)
class Posteriors:
    """The results of a study.

    Parameters
    ----------
    sequences : how many there are.
    walking : [F] of all frames, columns of `vbbench.reproduction.posterior.walking.Walking`.
    sample : of the same frames.
    tables : by solver, of the same frames.
    reported : [F] entropy of the pose by the covariance that `REPORTED` reports.
    examples, failures : the pictures'.
    """

    study: PosteriorStudy
    sequences: int
    walking: Mapping[str, FloatArray]
    sample: FrameSample
    tables: Mapping[str, PosteriorTable]
    reported: FloatArray
    examples: tuple[ShownExample, ...]
    failures: Failures


def measure_posterior(study: PosteriorStudy, out: Path | str, making: Making = Making()) -> Posteriors:  # noqa: B008
    """Generate the split, and measure the posteriors of every frame that somebody helps in.

    The dataset and the submission whose failures are drawn are kept in ``out``, and reused.

    Raises
    ------
    VbbenchError
        If the study is invalid, the split's source is missing, or another dataset or submission is in the way.
    """
    study.check()
    out = Path(out)
    with loose_files(out):
        options = Options(seed=study.seed, stride=stride_of(study.every))
        dataset = making.dataset(study.split, out / "dataset", options)
        walks = walking_of(dataset)
        tables = {
            solver: PosteriorTable.of_rows(_rows(posterior_rows, dataset, solver, making.jobs))
            for solver in measured_solvers()
        }
        reported = {row[:2]: row[2] for row in _rows(reported_rows, dataset, REPORTED, making.jobs)}
        failures = find_failures(dataset, SOLVER, walks, making)
    frames = list(zip(*(getattr(tables[SOLVER], name).tolist() for name in ("sequence", "frame")), strict=True))
    if not frames:
        raise VbbenchError(
            f"{dataset.folder}: in no frame do two people help to find the observer; take more sequences"
        )
    sample, walking = _sample(dataset, walks, frames)
    return Posteriors(
        study=study,
        sequences=len(dataset),
        walking=walking,
        sample=sample,
        tables=tables,
        reported=np.array([reported.get(frame, np.nan) for frame in frames]),
        examples=tuple(one for one in (_shown(dataset, example) for example in pick_examples(walks)) if one.instants),
        failures=failures,
    )


def _rows(measure: Callable[..., list[Any]], dataset: Dataset, solver: str, jobs: int) -> list[Any]:
    """What ``measure`` gives for all sequences, in their order."""
    calls = [(dataset, solver, first, min(first + _PART, len(dataset))) for first in range(0, len(dataset), _PART)]
    found: list[Any] = []
    with progress_bar(len(dataset), f"posteriors of {solver.rpartition(':')[2]}") as bar:
        for part in itertools.starmap(measure, calls) if jobs == 1 else in_parallel(measure, calls, jobs):
            found += part
            bar.update(min(_PART, len(dataset) - bar.n))
    return found


def _sample(
    dataset: Dataset, walks: Sequence[Walking], frames: list[tuple[int, int]]
) -> tuple[FrameSample, dict[str, FloatArray]]:
    """The frames on their timeline, and how people walk in them."""
    rows, names = dataset.rows, ("people", "spread", "lines", "bearings", "standing")
    columns = {
        (walk.sequence, frame): values
        for walk in walks
        for frame, *values in zip(walk.frame.tolist(), *(getattr(walk, name).tolist() for name in names), strict=True)
    }
    values = np.array([columns[frame] for frame in frames]).reshape(-1, len(names))
    walking = dict(zip(names, values.T, strict=True))
    first = rows["first_frame"].astype(np.int64)
    timeline = Timeline.of(rows["scene"].astype(np.int64), first, first + rows["frames"] - 1)
    sequence = np.array([number for number, _ in frames], np.int64)
    return FrameSample(sequence=sequence, people=walking["people"].astype(np.int64), timeline=timeline), walking


def _shown(dataset: Dataset, example: Example) -> ShownExample:
    sequence = dataset.sequence(example.sequence)
    truth = dataset.truth(sequence)
    return ShownExample(
        example=example,
        instants=tuple(instants(dataset, sequence, text_reading(), example.frames)),
        poses=truth.poses,
        positions=np.where(sequence.observed[..., None], truth.positions, np.nan),
    )
