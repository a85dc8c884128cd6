"""How far every solver gets from the boxes alone: the table of cold-start of docs/cold-start.md.

``python -m benchmarks.cold_start DATASET... [--sequences 1000] [--jobs 2] [--solvers vb-cv,map-causal]`` prints a table
for each dataset, as ``vbbench generate`` writes them, with their truth. A run is one sequence.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from benchmarks.map_evaluation import answer, spread_over
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol, scored_frames, scored_positions
from vbbench.registry import held_out, make_solver
from vbbench.scoring.metrics import position_error, relative_position_error, translation_error

PROTOCOL, FAR = "cold-start", 5.0
"""The default protocol, and the error in m from which a run counts as far off."""

SOLVERS = ("cv", "sf", "vb-cv", "vb-sf", "map-causal", "map-batch")


@dataclass(frozen=True, kw_only=True)
class Run:
    """Errors of a sequence in m: means of Δx, Δt and Δx̃, and the worst of its poses and positions."""

    dx: float
    dt: float
    dx_rel: float
    worst_dt: float
    worst_dx: float

    @staticmethod
    def of(dataset: Dataset, solver: Any, index: int, protocol: str) -> "Run | None":
        """The errors of a solver on one sequence; ``None`` if nothing of it is scored."""
        sequence, (estimate, _) = dataset.sequence(index), answer(dataset, solver, protocol, index)
        truth, given = dataset.truth(sequence), get_protocol(protocol).select_given(sequence.given)
        frames, rows = scored_frames(sequence.observed), scored_positions(sequence.observed, given)
        if not rows.any():
            return None
        places, true_places = estimate.positions, truth.positions
        off = position_error(places[rows], true_places[rows])
        poses, true_poses = (np.repeat(all_[:, None], rows.shape[1], axis=1)[rows] for all_ in (estimate.poses, truth.poses))
        relative = relative_position_error(places[rows], poses, true_places[rows], true_poses)
        away = translation_error(estimate.poses[frames], truth.poses[frames])
        return Run(
            dx=off.mean(), dt=away.mean(), dx_rel=relative.mean(), worst_dt=away.max(), worst_dx=np.nanmax(off)
        )


def runs(dataset: Dataset, solver: str, protocol: str, sequences: int, jobs: int) -> list[Run]:
    """The runs of a solver on about so many sequences of a dataset, by the variant that was not fitted on it."""
    name, chosen = held_out(solver, dataset.info.split), spread_over(dataset, sequences)
    parts = np.array_split(np.array(chosen), max(4 * jobs, 1))
    found = Parallel(n_jobs=jobs)(delayed(_some)(dataset, name, protocol, part) for part in parts)
    return [run for part in found for run in part]


def _some(dataset: Dataset, name: str, protocol: str, indices: FloatArray) -> list[Run]:
    solver = make_solver(name)
    found = [Run.of(dataset, solver, int(index), protocol) for index in indices]
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
    options = parser.parse_args()
    for folder in options.datasets:
        dataset = Dataset(folder)
        print(f"\n{dataset.info.split}, {dataset.info.tier}, {dataset.info.camera.kind}\n")
        print(f"| solver | mean Δx | mean Δt | mean Δx̃ | median Δt | worst Δt | worst Δx | runs over {FAR:g} m |")
        print("|---|---|---|---|---|---|---|---|")
        for solver in options.solvers.split(","):
            found = runs(dataset, solver, options.protocol, options.sequences, options.jobs)
            print(row(solver, found), flush=True)


if __name__ == "__main__":
    main()
