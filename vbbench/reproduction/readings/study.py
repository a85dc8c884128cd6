"""Every reading of the paper's Table 2: what is given when, what is known of heights and observer, and the scale.

The text of arXiv 2111.05060 gives two frames and estimates the rest one after the other, draws heights from
N(1.70, σ_h²), and scales recordings to [−8, 8] m. Its figures fit another reading. This study measures all of them.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol, runtime_checkable

import numpy as np

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.generation.generator import Generator, Options
from vbbench.generation.planning import thinned
from vbbench.paper import BEST, HEADLINE, PROTOCOLS, SIGMA_H, SPLITS, the_paper
from vbbench.registry import load
from vbbench.reproduction.asked import check_every
from vbbench.reproduction.making import Making
from vbbench.scoring.metrics import section
from vbbench.scoring.scorecard import Summary

Heights = Literal["known", "learned", "prior"]
"""Everybody has the mean height; heights follow from given positions; nothing but N(μ_h, σ_h²) is known."""

SOLVER = "vb-sf"
"""Its class names, in ``readings`` and ``literal``, the solver of each reading."""
HALF_WIDTH = 8.0
"""In m: the paper's text scales recordings to [−8, 8] m."""


@runtime_checkable
class ScalableGenerator(Generator, Protocol):
    """The maker of a split whose recordings can be scaled."""

    def scaled(self, half_width: float) -> Generator:
        """The same split within ±``half_width`` m."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One way to read the paper.

    Parameters
    ----------
    solver : registered name or ``module:attribute``.
    heights : what is known of them.
    ego_prior : whether the observer is expected to walk like the others.
    scaled : whether recordings are scaled to ±`HALF_WIDTH`.
    literal : whether everything else is the text's, too.
    """

    protocol: str
    solver: str
    heights: Heights
    ego_prior: bool
    scaled: bool
    literal: bool = False

    @property
    def height_std(self) -> float:
        """σ_h in m of the people."""
        return 0.0 if self.heights == "known" else SIGMA_H

    @property
    def is_text(self) -> bool:
        """Whether nothing differs from the paper's text."""
        return self.literal and self.scaled and self.protocol == "sequential"


def all_readings() -> tuple[Reading, ...]:
    """Every reading: one-step first, as ``vb-sf`` is before what the text says."""
    solver = load("solver", SOLVER)
    pairs: Mapping[str, tuple[str, str]] = solver.readings
    knowledge: tuple[Heights, ...] = ("learned", "known", "prior")
    kinds: list[tuple[Heights, bool, str, bool]] = [
        (heights, ego_prior, pairs["prior" if heights == "known" else heights][not ego_prior], False)
        for heights, ego_prior in itertools.product(knowledge, (True, False))
    ]
    kinds.append(("prior", False, solver.literal, True))
    return tuple(
        Reading(protocol=protocol, solver=name, heights=heights, ego_prior=ego, scaled=scaled, literal=literal)
        for protocol, scaled, (heights, ego, name, literal) in itertools.product(PROTOCOLS, (False, True), kinds)
    )


@dataclass(frozen=True, kw_only=True)
class ReadingsStudy:
    """What to measure.

    Parameters
    ----------
    splits : of the paper's Table 2.
    every : only every so-many-th sequence of each.
    seed : of the datasets.
    """

    splits: Sequence[str] = SPLITS[2]
    every: int = 1
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if a split is not the paper's, none is named, or ``every`` is no number of sequences."""
        if not self.splits:
            raise VbbenchError(f"nothing to measure: name a split of {', '.join(SPLITS[2])}")
        for split in self.splits:
            if split not in SPLITS[2]:
                raise UnknownNameError("split of the paper's Table 2", split, SPLITS[2])
        check_every(self.every)


@dataclass(frozen=True, kw_only=True)
class MeasuredReading:
    """A reading and its scores: split → metric → figures."""

    reading: Reading
    summaries: Mapping[str, Mapping[str, Summary]]

    def times_the_paper(self, metric: str = HEADLINE, *, frames: bool = False) -> float:
        """Geometric mean over splits of the error by the paper's, averaged over sequences or over ``frames``."""
        ratios = [
            (found[metric].frame_mean if frames else found[metric].mean) / the_paper().figures(split, BEST)[metric]
            for split, found in self.summaries.items()
        ]
        return float(np.exp(np.mean(np.log(ratios))))


@dataclass(frozen=True, kw_only=True)
class Readings:
    """The results of a study; ``sequences`` says how many each split has."""

    study: ReadingsStudy
    sequences: Mapping[str, int]
    rows: tuple[MeasuredReading, ...]


def measure_readings(study: ReadingsStudy, out: Path | str, making: Making = Making()) -> Readings:  # noqa: B008
    """Generate, solve and score every reading on every split.

    Datasets and submissions are kept in ``out``; complete ones are reused.

    Raises
    ------
    VbbenchError
        If the study is invalid, or another dataset or submission is in the way.
    """
    study.check()
    found: dict[tuple[Reading, str], Mapping[str, Summary]] = {}
    sequences, out, readings = {}, Path(out), all_readings()
    with loose_files(out):
        for split, height_std, scaled in itertools.product(study.splits, (SIGMA_H, 0.0), (False, True)):
            dataset = _dataset(study, split, height_std, scaled, out, making)
            sequences[split] = len(dataset)
            chosen = [one for one in readings if (one.height_std, one.scaled) == (height_std, scaled)]
            for protocol in PROTOCOLS:
                own = {one.solver: one for one in chosen if one.protocol == protocol}
                for solver, score in making.scores(dataset, tuple(own), protocol):
                    found[own[solver], split] = {name: score.summaries[name] for name in section("metrics")}
    rows = [
        MeasuredReading(reading=one, summaries={split: found[one, split] for split in study.splits}) for one in readings
    ]
    return Readings(study=study, sequences=sequences, rows=tuple(rows))


def _dataset(study: ReadingsStudy, split: str, height_std: float, scaled: bool, out: Path, making: Making) -> Dataset:
    generator = load("generator", split)
    if scaled:
        if not isinstance(generator, ScalableGenerator):
            raise VbbenchError(f"split {split} is another package's and cannot be scaled; leave it out")
        generator = generator.scaled(HALF_WIDTH)
    plan = thinned(generator.plan(Options(height_std=height_std, seed=study.seed)), study.every)
    folder = out / f"{split}-{'scaled' if scaled else 'metres'}-sigma-{height_std:g}" / "dataset"
    return making.planned(plan, folder)
