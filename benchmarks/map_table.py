"""The joint solvers beside ``vb-cv``: every protocol, tier, way of looking and camera, with priors fitted elsewhere.

``python -m benchmarks.map_table [--sequences 60] [--jobs 2]`` prints the tables of docs/map-solver.md, Δx / Δt in m.
"""

import argparse
from functools import partial

from benchmarks.map_evaluation import Case, Maker, evaluate
from vbbench.protocol import PROTOCOLS
from vbbench_baselines.joint_map import MapBatch
from vbbench_baselines.joint_map import MapCausal
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

CASES = (
    *(Case(split=split, tier=tier) for tier in ("ideal", "noisy") for split in ("hotel", "eth")),
    *(Case(split=split, look="wander") for split in ("hotel", "eth")),
    *(Case(split=split, perspective=True) for split in ("hotel", "eth")),
    *(Case(split=split, tier="noisy", perspective=True) for split in ("hotel", "eth")),
    *(Case(split=split, tier="occluded") for split in ("hotel", "eth")),
    *(Case(split=split, tier="tracked") for split in ("hotel", "eth")),
    *(Case(split=split, tier="noisy") for split in ("sim", "students", "students-resampled")),
)


def solvers(case: Case) -> dict[str, Maker]:
    """Every solver, with the prior of the other scenes."""
    return {
        "vb-cv": ConstantVelocityBirdifier,
        "map-causal": partial(MapCausal, prior=case.prior),
        "map-causal, by height": partial(MapCausal, prior=case.prior, feet=False),
        "map-batch": partial(MapBatch, prior=case.prior),
        "map-batch, by height": partial(MapBatch, prior=case.prior, feet=False),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sequences", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="part of the name of the cases wanted")
    options = parser.parse_args()
    print("| | solver | " + " | ".join(PROTOCOLS) + " | frames/s |")
    print("|---" * (len(PROTOCOLS) + 3) + "|")
    for case in CASES:
        if options.only not in str(case):
            continue
        with case.made() as dataset:
            for name, make in solvers(case).items():
                asked = [
                    protocol for protocol in PROTOCOLS if not (name.startswith("map-batch") and protocol == "one-step")
                ]
                found = {each: evaluate(dataset, make, each, options.sequences, options.jobs) for each in asked}
                cells = [str(found[each]) if each in found else "" for each in PROTOCOLS]
                speed = " / ".join(f"{figures.frames_per_second:,.0f}" for figures in found.values())
                print(f"| {case} | {name} | " + " | ".join(cells) + f" | {speed} |", flush=True)


if __name__ == "__main__":
    main()
