"""How solvers do on footage: the tables of docs/kitti.md, mean Δx / Δt in m of each dataset, solver and protocol.

``python -m benchmarks.footage_table DATASET... [--relative]`` solves and scores datasets that are
there, whatever real camera they are of. ``map-causal, by height`` and ``map-batch, by height`` are the joint solvers
without the cue of the feet: distances follow from the heights of boxes alone.
"""

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

from vbbench.files.dataset import Dataset
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal


@dataclass(kw_only=True)
class CausalByHeight(MapCausal):
    """``map-causal`` without the cue of the feet."""

    feet: bool = False


@dataclass(kw_only=True)
class BatchByHeight(MapBatch):
    """``map-batch`` without the cue of the feet."""

    feet: bool = False


SOLVERS = {
    "cv": "cv",
    "vb-cv": "vb-cv",
    "vb-sf": "vb-sf",
    "map-causal": "map-causal",
    "map-causal, by height": f"{__name__}:CausalByHeight",
    "map-batch, by height": f"{__name__}:BatchByHeight",
}
PROTOCOLS = ("one-step", "sequential", "rollout")


def cell(dataset: Dataset, solver: str, protocol: str, metrics: tuple[str, str]) -> str:
    """Two figures of a solver under a protocol; empty if it does not answer that."""
    if "batch" in solver.lower() and protocol == "one-step":
        return ""
    with tempfile.TemporaryDirectory() as folder:
        answer = solve(dataset, solver, protocol, Path(folder) / "answer")
        summaries = score(answer, dataset.folder).summaries
    return " / ".join(f"{summaries[metric].mean:.3f}" for metric in metrics)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("datasets", type=Path, nargs="+")
    parser.add_argument("--relative", action="store_true", help="Δx̃ instead of Δx")
    options = parser.parse_args()
    metrics = ("dx_rel" if options.relative else "dx", "dt")
    print("| | solver | " + " | ".join(PROTOCOLS) + " |\n" + "|---" * (len(PROTOCOLS) + 2) + "|")
    for folder in options.datasets:
        dataset = Dataset(folder)
        for name, solver in SOLVERS.items():
            cells = (cell(dataset, solver, protocol, metrics) for protocol in PROTOCOLS)
            print(f"| {folder.name} | {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
