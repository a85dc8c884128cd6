"""Fits the motion prior to true walks: ``python -m vbbench_baselines.joint_map.fit SPLIT... [--leave-out SPLIT]``.

All priors of the package are made again by the lines that stand at the head of their TOML files.
"""

import argparse
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from vbbench.errors import VbbenchError
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation.generator import Look, Options, Plan
from vbbench.registry import load
from vbbench_baselines.joint_map.prior import Prior
from vbbench_baselines.joint_map.priors.lessons import Fold, fit_lessons, halves
from vbbench_baselines.joint_map.priors.turns import HELD_OUT, Turns, fit_head, turns_of
from vbbench_baselines.joint_map.priors.walks import Walks, fit_walks, gather, log_likelihood, scenes_of

RECORDINGS = ("hotel", "eth")
"""Splits fitted on unless others are named: recordings annotated frame by frame."""
LEAST_NU = 3.0
SIMULATED, OBSERVERS = 60, 60
"""Sequences of a simulated split that are walked through, and observers whose yaw is followed."""


def fit(
    splits: Iterable[str], *, seed: int = 0, least_nu: float = LEAST_NU, held_out: Look = HELD_OUT
) -> tuple[Prior, list[dict[str, Any]]]:
    """The motion prior of greatest likelihood on some splits, and what it was fitted on.

    Parameters
    ----------
    splits : names of splits; each counts the same, however many people it has.
    seed : of simulated splits, so that they can be others than those tested.
    least_nu : ν is kept at or above it.
    held_out : the way of looking that the heads are not fitted on.

    Raises
    ------
    VbbenchError
        If there is no split, their frame rates differ, or a source is missing.
    """
    plans: dict[str, Plan] = {split: load("generator", split).plan(Options(seed=seed)) for split in splits}
    rates = {plan.info.dt for plan in plans.values()}
    if not plans:
        raise VbbenchError("no split is left to fit a prior on; name one that is not left out")
    if len(rates) > 1:
        raise VbbenchError(f"a prior is fitted on splits of one frame rate, not {sorted(rates)} seconds per frame")
    crowds = {split: gather(scenes_of(plan, SIMULATED)) for split, plan in plans.items()}
    turns = {split: turns_of(split, seed, OBSERVERS, held_out) for split in plans}
    prior = fit_walks(list(crowds.values()), Prior(dt=rates.pop()), least_nu)
    prior = fit_lessons(_folds(plans, crowds, prior, least_nu), prior)
    prior = fit_head(list(turns.values()), prior)
    facts = [_facts(plans[split], crowds[split], turns[split], prior) for split in plans]
    return prior, facts


def _folds(plans: dict[str, Plan], crowds: dict[str, Walks], start: Prior, least_nu: float) -> list[Fold]:
    """Every split, or either half of the only one, with the prior of the others."""
    if len(plans) > 1:
        others = {split: [crowds[other] for other in plans if other != split] for split in plans}
        return [Fold(fit_walks(others[split], start, least_nu), scenes_of(plans[split], SIMULATED)) for split in plans]
    first, second = halves(scenes_of(next(iter(plans.values())), SIMULATED))
    pairs = ((first, second), (second, first))
    return [Fold(fit_walks([gather(known)], start, least_nu), unknown) for known, unknown in pairs]


def _facts(plan: Plan, walks: Walks, turns: Turns, prior: Prior) -> dict[str, Any]:
    return {
        "split": plan.info.split,
        "files": [list(file) for file in plan.info.definition.get("files", [])],
        "seed": plan.info.seed,
        "people": len(walks.first),
        "second_differences": len(walks.order),
        "heads": sorted(turns),
        "yaw_increments": sum(map(len, turns.values())),
        "nats_per_second_difference": round(log_likelihood(walks, prior), 4),
    }


def to_toml(prior: Prior, facts: list[dict[str, Any]], command: str) -> str:
    """A prior and what it was fitted on as TOML text; the same values give the same text."""
    lines = [f"# Written by: {command}"]
    values = {name: _rounded(value) for name, value in asdict(prior).items()}
    for head, table in (("[prior]", values), *(("[[fitted_on]]", split) for split in facts)):
        lines += ["", head, *(f"{name} = {json.dumps(value)}" for name, value in table.items())]
    return "\n".join(lines) + "\n"


def _rounded(value: Any) -> Any:
    """Three significant digits: far fewer than anything is sensitive to, and the same on every processor."""
    if isinstance(value, tuple):
        return [_rounded(part) for part in value]
    return float(f"{value:.3g}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit, and print the TOML or write it to a file."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    parser = argparse.ArgumentParser(prog="python -m vbbench_baselines.joint_map.fit", description=fit.__doc__)
    parser.add_argument("splits", nargs="*", default=RECORDINGS, help=f"default: {' '.join(RECORDINGS)}")
    parser.add_argument("--leave-out", nargs="*", default=[], metavar="SPLIT", help="splits not to fit on")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--least-nu", type=float, default=LEAST_NU)
    parser.add_argument("--out", type=Path, help="file to write; default: standard output")
    asked = parser.parse_args(arguments)
    splits = [split for split in asked.splits if split not in asked.leave_out]
    try:
        prior, facts = fit(splits, seed=asked.seed, least_nu=asked.least_nu)
    except VbbenchError as error:
        parser.exit(2, f"{error}\n")
    if asked.out:
        arguments = [*arguments[: arguments.index("--out")], *arguments[arguments.index("--out") + 2 :]]
    text = to_toml(prior, facts, " ".join((parser.prog, *arguments)))
    if asked.out:
        write_text_atomically(asked.out, text)
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
