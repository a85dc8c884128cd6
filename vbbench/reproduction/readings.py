"""Every reading of the paper's Table 2: what is given when, what is given of heights and observer, and the scale.

The text of arXiv 2111.05060 gives two frames and estimates the rest one after the other, draws heights from
N(1.70, σ_h²), and scales recordings to [−8, 8] m. Its figures fit another reading. This study measures all of them.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Options
from vbbench.generation.planning import thinned
from vbbench.paper import BEST, HEADLINE, PROTOCOLS, SIGMA_H, SPLITS, the_paper
from vbbench.registry import load
from vbbench.reproduction.grid import Making, Row, Study, check_every, check_splits
from vbbench.reproduction.report import Report
from vbbench.scoring.metrics import METRICS, section
from vbbench.scoring.scorecard import Summary
from vbbench.table import Table

SOLVER = "vb-sf"
"""Its class names, in ``readings`` and ``literal``, the solver of each reading."""
HEIGHTS = {"learned": "learned", "known": "known", "prior": "N(μ, σ²)"}
"""Heights follow from given positions; everybody has the mean height; or only N(μ_h, σ_h²) is given."""
HALF_WIDTH = 8.0
"""In m: the paper's text scales recordings to [−8, 8] m."""
LABEL = METRICS[HEADLINE].label
FACT = (
    f"{LABEL}: mean over sequences / over frames. Last column: geometric mean over splits of the same by the paper's. "
    f"Scaled: to [−{HALF_WIDTH:g}, {HALF_WIDTH:g}] m, in metres of the scaled field."
)


def all_readings() -> list[Row]:
    """Every reading: one-step first, as ``vb-sf`` is before what the text says.

    Its ``ego_prior`` expects the observer to walk like the others; all else of a ``literal`` one is the text's as well,
    and ``text`` marks the one from which nothing differs.
    """
    solver = load("solver", SOLVER)
    pairs: Mapping[str, tuple[str, str]] = solver.readings
    kinds: list[tuple[str, str, bool, bool]] = [
        (pairs["prior" if heights == "known" else heights][not ego_prior], heights, ego_prior, False)
        for heights, ego_prior in itertools.product(HEIGHTS, (True, False))
    ]
    kinds.append((solver.literal, "prior", False, True))
    return [
        {
            "protocol": protocol,
            "solver": name,
            "heights": heights,
            "ego_prior": ego_prior,
            "scaled": scaled,
            "literal": literal,
            "text": literal and scaled and protocol == "sequential",
        }
        for protocol, scaled, (name, heights, ego_prior, literal) in itertools.product(PROTOCOLS, (False, True), kinds)
    ]


@dataclass(frozen=True, kw_only=True)
class ReadingsStudy(Study):
    """Errors under every reading, on every ``every``-th sequence of ``splits`` of the paper's Table 2."""

    name = "readings"
    splits: Sequence[str] = SPLITS[2]
    every: int = 1
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if a split or ``every`` is invalid."""
        check_splits(self.splits, SPLITS[2], "split of the paper's Table 2")
        check_every(self.every)

    def measure(self, out: Path, making: Making) -> dict[str, Any]:
        """Four datasets a split: σ_h as in the paper and 0, in metres and scaled."""
        sequences, readings = {}, [{**one, "figures": {}} for one in all_readings()]
        for split, height_std, scaled in itertools.product(self.splits, (SIGMA_H, 0.0), (False, True)):
            generator = load("generator", split)
            if scaled and not hasattr(generator, "scaled"):
                raise VbbenchError(f"split {split} is another package's and cannot be scaled; remove it")
            options = Options(height_std=height_std, seed=self.seed)
            plan = (generator.scaled(HALF_WIDTH) if scaled else generator).plan(options)
            folder = out / f"{split}-{'scaled' if scaled else 'metres'}-sigma-{height_std:g}" / "dataset"
            dataset = making.planned(thinned(plan, self.every), folder)
            sequences[split] = len(dataset)
            for one in readings:
                if one["scaled"] == scaled and (one["heights"] == "known") == (height_std == 0.0):
                    own = making.cell(dataset, one["solver"], one["protocol"]).summaries
                    one["figures"][split] = {name: own[name] for name in section("metrics")}
        for one in readings:
            one["times_the_paper"] = {name: _times_the_paper(one, name) for name in section("metrics")}
        paper = {split: dict(the_paper().figures(split, BEST)) for split in self.splits}
        facts = {"every": self.every, "seed": self.seed, "sequences": sequences, "paper": paper}
        return {**facts, "readings": readings}

    def report(self, found: dict[str, Any]) -> Report:
        """A row a reading: Δx over sequences and over frames, and how many times the paper's it is."""
        printed = [f"{own[HEADLINE]:.3f}" for own in found["paper"].values()]
        counts = ", ".join(f"{split} {count}" for split, count in found["sequences"].items())
        some = "all sequences" if self.every == 1 else f"every {self.every}th sequence"
        conditions = f"tier ideal, seed {self.seed}, {some} ({counts})"
        table = Table(
            head=["protocol", "heights", "observer walks", "field", "solver", *self.splits, "times the paper's"],
            rows=[["the paper", "", "", "", BEST, *printed, "1"], *map(_line, found["readings"])],
            names=5,
        )
        return Report(
            name=self.name,
            title=f"Every reading of the paper's {BEST}, {conditions}",
            facts=(FACT,),
            tables=[table],
            values=found,
        )


def _times_the_paper(one: Row, metric: str) -> dict[str, float]:
    """Geometric mean over splits of the error by the paper's, averaged over sequences and over frames."""
    figures: Mapping[str, Mapping[str, Summary]] = one["figures"]
    printed = np.array([the_paper().figures(split, BEST)[metric] for split in figures])
    errors = np.array([(own[metric].mean, own[metric].frame_mean) for own in figures.values()])
    ratios = np.exp(np.mean(np.log(errors / printed[:, None]), axis=0)).tolist()
    return dict(zip(("sequences", "frames"), ratios, strict=True))


def _line(one: Row) -> list[str]:
    cells = [f"{own[HEADLINE].mean:.3f} / {own[HEADLINE].frame_mean:.3f}" for own in one["figures"].values()]
    times = " / ".join(f"{value:.2f}" for value in one["times_the_paper"][HEADLINE].values())
    facts = [one["protocol"], HEIGHTS[one["heights"]], "yes" if one["ego_prior"] else "no"]
    name = f"`{one['solver']}`" if one["literal"] or one["solver"] == SOLVER else f"`{SOLVER}`, changed"
    return [*facts, "scaled" if one["scaled"] else "metres", name, *cells, times]
