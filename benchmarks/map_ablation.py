"""What each term of the joint solvers is good for: one left out at a time, the rest fitted again without it.

``python -m benchmarks.map_ablation [--sequences 60] [--jobs 2]`` prints the tables of docs/map-solver.md, Δx / Δt in m.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks.map_evaluation import Case, Maker, evaluate
from vbbench.generation.generator import Options
from vbbench.registry import load
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.fit import LEAST_NU
from vbbench_baselines.joint_map.prior import Prior, get_prior
from vbbench_baselines.joint_map.priors.walks import A0_RANGE, MOST_NU, fit_walks, gather, scenes_of

OTHERS = {"hotel": ("eth",), "eth": ("hotel",)}
"""What each split's prior is fitted on."""
PROTOCOLS = (("one-step", MapCausal), ("sequential", MapCausal), ("sequential", MapBatch), ("rollout", MapBatch))


def variants(case: Case) -> Iterator[tuple[str, Prior, dict[str, Any]]]:
    """Name, prior and other settings of every solver that is compared."""
    whole = case.prior
    crowds = [gather(scenes_of(load("generator", split).plan(Options()), 0)) for split in OTHERS[case.split]]

    def without(term: str, **value: Any) -> Prior:
        return fit_walks(crowds, replace(whole, **value), LEAST_NU, held=(term,))

    yield "everything", whole, {}
    yield "prior of the split itself", get_prior(f"without-{OTHERS[case.split][0]}"), {}
    yield "prior of both", get_prior("default"), {}
    first = Prior()
    yield "the prototype's walks", replace(whole, b=first.b, sigma=first.sigma, nu=first.nu, a0=first.a0), {}
    yield "normal innovations, not Student-t", without("nu", nu=MOST_NU), {}
    yield "constant velocity, no autoregression", without("b", b=(0.0, 0.0)), {}
    yield "everybody alike, no own scale", without("a0", a0=A0_RANGE[1]), {}
    students = gather(scenes_of(load("generator", "students").plan(Options()), 0))
    yield "fitted on the interpolated Students", replace(fit_walks([students], whole, LEAST_NU), speed=whole.speed), {}
    yield "an observer who need not be a person", whole, {"ego_prior": False}
    yield "no head follows the path", replace(whole, following=(0.0, 0.0)), {}
    yield "no prior on yaw", replace(whole, following=(0.0, 0.0), yaw_scale=np.inf), {}
    yield "heads follow to a milliradian", replace(whole, follow_scale=(0.001, whole.follow_scale[1])), {}
    yield "no prior on the speed of strangers", replace(whole, speed=100.0), {}
    yield "distance by box height, not by feet", whole, {"feet": False}
    yield "nothing learned from what is revealed", whole, {"learns": False}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sequences", type=int, default=85)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    heads = [f"{'causal' if solver is MapCausal else 'batch'} {protocol}" for protocol, solver in PROTOCOLS]
    for case in [Case(split=split, tier=tier) for split in OTHERS for tier in ("ideal", "noisy")]:
        print(f"\n| {case} | " + " | ".join(heads) + " |\n" + "|---" * (len(heads) + 1) + "|")
        with case.made() as dataset:
            for name, prior, settings in variants(case):
                cells = []
                for each, solver in PROTOCOLS:
                    if settings.keys() <= solver.__dataclass_fields__.keys():
                        make: Maker = partial(solver, prior=prior, **settings)
                        cells.append(str(evaluate(dataset, make, each, options.sequences, options.jobs)))
                    else:
                        cells.append("")
                print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
