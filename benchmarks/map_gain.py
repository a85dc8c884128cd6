"""What the joint solvers gain over the paper's cascade, cue by cue.

The cascade tells distances from box heights, and expects nothing of the observer's head. The joint solvers also use
where the feet are and where the head turns. Both cues are taken away, one at a time and together; what is left is joint
inference alone, over walks as they were learned from other recordings.

``python -m benchmarks.map_gain [--sequences 1000] [--jobs 2]`` prints the table of docs/map-solver.md: capped mean Δx
in m under ``sequential``, and in brackets how much more or less than ``vb-cv``'s it is, with the 95 % interval by
blocks of time.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any, get_args

import numpy as np

from benchmarks.map_evaluation import Case, Figures, Maker, evaluate
from vbbench.files.dataset import Dataset
from vbbench.generation.generator import Look
from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.scoring.block_bootstrap import block_means
from vbbench.scoring.timeline import Timeline
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

SPLITS = ("hotel", "eth", "eth-15fps")
TIERS = ("ideal", "noisy")
PROTOCOL = "sequential"


def cues(case: Case) -> dict[str, tuple[Maker, Maker]]:
    """By what is used, ``map-causal`` and ``map-batch``, with the prior of the other recordings."""
    whole = case.prior
    headless = replace(whole, following=(0.0, 0.0))
    settings: dict[str, dict[str, Any]] = {
        "feet and head": {"prior": whole},
        "feet, no head": {"prior": headless},
        "head, no feet": {"prior": whole, "feet": False},
        "neither: joint inference alone": {"prior": headless, "feet": False},
    }
    return {name: (partial(MapCausal, **one), partial(MapBatch, **one)) for name, one in settings.items()}


def rows(case: Case, sequences: int, jobs: int) -> Iterator[str]:
    """The rows of a case's table."""
    with case.made() as dataset:
        measure = partial(evaluate, dataset, protocol=PROTOCOL, sequences=sequences, jobs=jobs)
        cascade = measure(ConstantVelocityBirdifier)
        timeline = timeline_of(dataset, cascade)
        yield f"| {case} | `vb-cv` | {capped(cascade).mean():.3f} | |"
        yield f"| {case} | `vb-sf` | {cell(measure(SocialForceBirdifier), cascade, timeline)} | |"
        for name, makers in cues(case).items():
            cells = [cell(measure(make), cascade, timeline) for make in makers]
            yield f"| {case} | {name} | {' | '.join(cells)} |"


def timeline_of(dataset: Dataset, figures: Figures) -> Timeline:
    """When the sequences were."""
    scene, first, frames = (dataset.rows[name][figures.sequences] for name in ("scene", "first_frame", "frames"))
    return Timeline.of(scene, first, first + frames - 1)


def capped(figures: Figures) -> FloatArray:
    """Δx [N] in m of the sequences, none above the protocol's cap."""
    return np.minimum(figures.errors[:, 0], get_protocol(PROTOCOL).caps["dx"])


def cell(figures: Figures, cascade: Figures, timeline: Timeline) -> str:
    """Δx, and how much more than the cascade's it is, with the interval of that: of the logarithm of their ratio."""
    mine, theirs = capped(figures), capped(cascade)
    ratio = mine.mean() / theirs.mean()
    spread = block_means(timeline, (mine / mine.mean() - theirs / theirs.mean())[:, None])
    low, high = ratio * np.exp(spread.interval()[0])
    return f"{mine.mean():.3f} ({ratio - 1.0:+.0%}, {low - 1.0:+.0%} to {high - 1.0:+.0%})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sequences", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--look", nargs="+", choices=get_args(Look), default=["motion", "wander"])
    options = parser.parse_args()
    print("| | cues | `map-causal` | `map-batch` |\n|---|---|---|---|")
    for look in options.look:
        for case in [Case(split=split, tier=tier, look=look) for split in SPLITS for tier in TIERS]:
            for row in rows(case, options.sequences, options.jobs):
                print(row, flush=True)


if __name__ == "__main__":
    main()
