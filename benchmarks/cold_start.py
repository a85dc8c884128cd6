"""How far every solver gets from the boxes alone: the table of cold-start of docs/cold-start.md.

``python -m benchmarks.cold_start DATASET... [--sequences 1000] [--jobs 2] [--solvers vb-cv,map-causal] [--odometry]``
prints a table for each dataset, as ``vbbench generate`` writes them, with their truth. A run is one sequence. It counts
as far off if one of its poses is. ``--odometry``: solvers also get simulated odometry, see `wheels`.
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, motion_between
from vbbench.protocol import get_protocol, scored_frames, scored_positions
from vbbench.registry import make_solver
from vbbench.scoring.metrics import position_error, relative_position_error, translation_error
from vbbench.sequence import Odometry
from vbbench.solving.runner import run_sequence

PROTOCOL, FAR = "cold-start", 5.0
"""The default protocol, and the error in m from which a run counts as far off."""

SOLVERS = ("cv", "sf", "vb-cv", "vb-sf", "map-causal", "map-batch")


SLIP, LEAST, TURN = 0.02, 0.01, 0.005
"""Of the simulated odometry: standard deviations of a motion, as a share of it and in m, which add up, and in rad."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """What solvers are given: the protocol, and whether odometry."""

    protocol: str
    odometry: bool


@dataclass(frozen=True, kw_only=True)
class Run:
    """Errors of a sequence in m: means of Δx, Δt and Δx̃, and the worst of its poses and positions."""

    dx: float
    dt: float
    dx_rel: float
    worst_dt: float
    worst_dx: float

    @staticmethod
    def of(dataset: Dataset, solver: Any, index: int, case: Case) -> "Run | None":
        """The errors of a solver on one sequence; ``None`` if nothing of it is scored."""
        sequence, rules = dataset.sequence(index), get_protocol(case.protocol)
        truth = dataset.truth(sequence)
        if case.odometry:
            sequence = replace(sequence, given=replace(sequence.given, odometry=wheels(truth.poses, index)))
        shown = truth if rules.needs_truth else None
        estimate, _ = run_sequence(solver, dataset.problem(sequence), sequence, rules, shown)
        given = rules.select_given(sequence.given)
        frames, rows = scored_frames(sequence.observed), scored_positions(sequence.observed, given)
        rows &= np.isfinite(truth.positions[..., 0])  # boxes of a detector may show nobody
        if not rows.any():
            return None
        places, true_places = estimate.positions, truth.positions
        off = position_error(places[rows], true_places[rows])
        frame = np.nonzero(rows)[0]
        relative = relative_position_error(places[rows], estimate.poses[frame], true_places[rows], truth.poses[frame])
        away = translation_error(estimate.poses[frames], truth.poses[frames])
        return Run(dx=off.mean(), dt=away.mean(), dx_rel=relative.mean(), worst_dt=away.max(), worst_dx=np.nanmax(off))


def wheels(poses: FloatArray, seed: int) -> Odometry:
    """Odometry of true poses [T, 3], with noise."""
    moved = motion_between(poses[:-1], poses[1:])
    std = np.full(moved.shape, TURN)
    std[:, :2] = LEAST + SLIP * np.hypot(moved[:, 0], moved[:, 1])[:, None]
    noisy = moved + std * np.random.default_rng(seed).normal(size=moved.shape)
    motions, covariances = np.full(poses.shape, np.nan), np.full((len(poses), 3, 3), np.nan)
    motions[1:], covariances[1:] = noisy, std[:, :, None] ** 2 * np.eye(3)
    return Odometry(motions=motions, covariances=covariances)


def runs(dataset: Dataset, solver: str, case: Case, sequences: int, jobs: int) -> list[Run]:
    """The runs of a solver on about so many sequences of a dataset."""
    chosen = range(0, len(dataset), max(round(len(dataset) / sequences), 1))
    parts = np.array_split(np.array(chosen), max(4 * jobs, 1))
    found = Parallel(n_jobs=jobs)(delayed(_some)(dataset, solver, case, part) for part in parts)
    return [run for part in found for run in part]


def _some(dataset: Dataset, name: str, case: Case, indices: FloatArray) -> list[Run]:
    solver = make_solver(name)
    found = [Run.of(dataset, solver, int(index), case) for index in indices]
    return [run for run in found if run is not None]


def row(name: str, found: list[Run]) -> str:
    """A row of the table."""
    dx, dt, rel, worst_dt, worst_dx = (
        np.array([getattr(run, field) for run in found]) for field in Run.__dataclass_fields__
    )
    means = " | ".join(f"{np.mean(values):.2f}" for values in (dx, dt, rel))
    worst = f"{np.max(worst_dt):.1f} | {np.max(worst_dx):.1f}"
    return f"| {name} | {means} | {np.median(dt):.2f} | {worst} | {100 * np.mean(worst_dt > FAR):.0f} % |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("datasets", nargs="+", type=Path, metavar="DATASET")
    parser.add_argument("--sequences", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--solvers", default=",".join(SOLVERS))
    parser.add_argument("--protocol", default=PROTOCOL)
    parser.add_argument("--odometry", action="store_true")
    options = parser.parse_args()
    case = Case(protocol=options.protocol, odometry=options.odometry)
    for folder in options.datasets:
        dataset = Dataset(folder)
        print(f"\n{dataset.info.split}, {dataset.info.tier}, {dataset.info.camera.kind}\n")
        print(f"| solver | mean Δx | mean Δt | mean Δx̃ | median Δt | worst Δt | worst Δx | runs over {FAR:g} m |")
        print("|---|---|---|---|---|---|---|---|")
        for solver in options.solvers.split(","):
            found = runs(dataset, solver, case, options.sequences, options.jobs)
            print(row(solver, found), flush=True)


if __name__ == "__main__":
    main()
