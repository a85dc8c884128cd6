"""What it costs to reason about the nearest people only: vb-cv and vb-sf with 100, 200 and all people.

On the first 100 sequences of the made crossing of ``bench_shibuya``, or of the split ``shibuya01`` in
``--source``. Run from the repository: ``python -m benchmarks.selecting_people [--sequences N] [--protocol NAME]``.
"""

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options, Tier
from vbbench.scoring import score
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import Score
from vbbench.solving import solve
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import EVERYBODY, ConstantVelocityBirdifier

COLUMNS = ("dt", "dx", "dx_rel", "dr")


@dataclass(kw_only=True)
class Cv200(ConstantVelocityBirdifier):
    """vb-cv whose pose follows from the 200 nearest."""

    most_people: int = 200


@dataclass(kw_only=True)
class Cv100(ConstantVelocityBirdifier):
    """vb-cv whose pose follows from the 100 nearest, as the paper's."""

    most_people: int = 100


@dataclass(kw_only=True)
class SfAll(SocialForceBirdifier):
    """vb-sf in which everybody interacts."""

    most_interacting: int = EVERYBODY


@dataclass(kw_only=True)
class Sf200(SocialForceBirdifier):
    """vb-sf in which the 200 nearest interact."""

    most_interacting: int = 200


@dataclass(kw_only=True)
class SfPaper(SocialForceBirdifier):
    """vb-sf in which all but the 100 nearest are left out of everything, as the paper's."""

    most_people: int = 100


CASES: list[tuple[str, Tier]] = [
    ("benchmarks.bench_shibuya:CROSSING", "ideal"),
    ("benchmarks.bench_shibuya:CROSSING", "noisy"),
    ("benchmarks.bench_shibuya:JITTERED", "ideal"),
]
SOLVERS = {
    "vb-cv": {
        "all (default)": "vb-cv",
        "200, pose too": "benchmarks.selecting_people:Cv200",
        "100, pose too": "benchmarks.selecting_people:Cv100",
    },
    "vb-sf": {
        "all": "benchmarks.selecting_people:SfAll",
        "200 interact": "benchmarks.selecting_people:Sf200",
        "100 interact (default)": "vb-sf",
        "100, pose too": "benchmarks.selecting_people:SfPaper",
    },
}


def compare(dataset: Dataset, name: str, protocol: str, room: Path, jobs: int) -> None:
    """A row for each number of people, with the change of the means against all people."""
    everybody: Score | None = None
    for people, solver in SOLVERS[name].items():
        answer = solve(dataset, solver, protocol, room / f"{name} {people}", jobs=jobs)
        figures = score(answer, dataset.folder)
        everybody = everybody or figures
        cells = [_cell(figures, everybody, metric) for metric in COLUMNS]
        speed = 1.0 / (figures.info.seconds_per_frame or 1.0)
        case = f"{dataset.info.tier}, jitter {1e3 * dataset.info.definition.get('jitter', 0.0):g} mm"
        print(f"| {case} | {name} | {people} | {' | '.join(cells)} | {speed:.0f} |", flush=True)


def _cell(figures: Score, everybody: Score, metric: str) -> str:
    mean, before = figures.summaries[metric].mean, everybody.summaries[metric].mean
    return f"{1e3 * mean:.3g}" + ("" if figures is everybody else f" ({mean / before - 1:+.0%})")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sequences", type=int, default=100)
    parser.add_argument("--source", type=Path, help="folder of HT21-03: the split shibuya01")
    parser.add_argument("--protocol", default="one-step")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    heads = " | ".join(f"{METRICS[metric].symbol} m{METRICS[metric].unit}" for metric in COLUMNS)
    print(f"| tier | solver | people | {heads} | frames/s |")
    print("|" + "---|" * (len(COLUMNS) + 4))
    for split, tier in [("shibuya01", "ideal"), ("shibuya01", "noisy")] if options.source else CASES:
        with tempfile.TemporaryDirectory() as folder:
            asked = Options(tier=tier, limit=options.sequences, source=options.source)
            dataset = generate(split, Path(folder) / "data", asked, jobs=options.jobs)
            for name in SOLVERS:
                compare(dataset, name, options.protocol, Path(folder), options.jobs)


if __name__ == "__main__":
    main()
