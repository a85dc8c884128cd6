"""What it costs the joint solvers not to know how heads turn: each law in turn is held out of their prior of heads.

``python -m benchmarks.head_laws [--sequences 85] [--jobs 2] [--splits hotel eth]`` prints the table of docs/trust.md,
section "Heads". For observers whose heads turn by one law: capped mean Δx in m (sequential, noisy) of a solver whose
prior of heads was fitted on every law; the loss of one whose prior never saw this law; and the loss of one that takes
nothing from heads. The last rows are heads under ``natural``: the shipped prior, and an attacker's, which assumes the
recipe's own law in every head.
"""

import argparse
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.map_evaluation import Case, Maker, evaluate
from vbbench.files.dataset import Dataset
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.fit import OBSERVERS
from vbbench_baselines.joint_map.prior import Prior
from vbbench_baselines.joint_map.priors.turns import LAGGING, LOOSE, WANDERING, Turns, fit_head, turns_of

OTHER = {"hotel": "eth", "eth": "hotel"}
"""Where the prior of each split is fitted."""
CAP = 2.0
"""Of a sequence's Δx in m."""


def no_head(prior: Prior) -> Prior:
    """The prior that takes nothing from heads."""
    return replace(prior, following=(0.0, 0.0), yaw_scale=np.inf)


def recipe_head(prior: Prior) -> Prior:
    """An attacker's prior: every head has the law of the recipe's ``motion``, to the letter."""
    return replace(prior, lag=(0.8, 0.1), follow_scale=(0.005, 0.07), following=(0.98, 0.0))


def priors(prior: Prior, turns: Turns, law: str) -> dict[str, Prior]:
    """By name: fitted on all laws, on all but one, and on none."""
    rest = {look: pairs for look, pairs in turns.items() if look != law}
    return {"all": fit_head([turns], prior), "but one": fit_head([rest], prior), "none": no_head(prior)}


def error(dataset: Dataset, make: Maker, options: argparse.Namespace) -> float:
    """Capped mean Δx in m."""
    found = evaluate(dataset, make, "sequential", options.sequences, options.jobs)
    return float(np.minimum(found.errors[:, 0], CAP).mean())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sequences", type=int, default=85)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--splits", nargs="*", default=list(OTHER))
    parser.add_argument("--solvers", nargs="*", default=["MapCausal", "MapBatch"])
    options = parser.parse_args()
    print("| | law | solver | Δx, all laws known | this one held out | heads not used |\n|---|---|---|---|---|---|")
    for split in options.splits:
        turns = turns_of(OTHER[split], 0, OBSERVERS, None)
        for law in (*LAGGING, *WANDERING, *LOOSE):
            case = Case(split=split, tier="noisy", look=law)
            with case.made() as dataset:
                for solver in (each for each in (MapCausal, MapBatch) if each.__name__ in options.solvers):
                    fitted = priors(case.prior, turns, law)
                    known, apart, none = (
                        error(dataset, partial(solver, prior=one), options) for one in fitted.values()
                    )
                    losses = f"{apart / known - 1.0:+.0%} | {none / known - 1.0:+.0%}"
                    print(f"| {split} | {law} | {solver.__name__} | {known:.3f} | {losses} |", flush=True)
        case = Case(split=split, tier="noisy", look="natural")
        with case.made() as dataset:
            honest, recipe, none = (
                error(dataset, partial(MapCausal, prior=one), options)
                for one in (case.prior, recipe_head(case.prior), no_head(case.prior))
            )
            print(f"| {split} | natural | as shipped | {honest:.3f} | | {none / honest - 1.0:+.0%} |")
            print(
                f"| {split} | natural | recipe's own law | {recipe:.3f} | {recipe / honest - 1.0:+.0%} | |", flush=True
            )


if __name__ == "__main__":
    main()
