"""Solvers on a real camera and beside it: a table for each cell, with what is wanted.

    python -m benchmarks.real_camera map-causal vb-sf cv --kitti ~/kitti [--only kitti-4-sequential,boards-field]

A solver is a registered name or ``module:attribute``. ``--kitti`` is KITTI's folder with ``training``, ``poses`` and
``detections`` in it. ``--only`` takes names of cells, or how they begin; ``--list`` tells them. Datasets are kept in
``--cache``. Figures are means over runs without any cap, unless a cell says so; those that miss what is wanted have a
``!``. The other splits are searched for where ``vbbench generate`` does.
"""

import argparse
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

from benchmarks.real_camera.cells import Cell, cells
from benchmarks.real_camera.measuring import Runs, Trial, measure
from benchmarks.real_camera.scenes import Scenes
from benchmarks.real_camera.targets import joined, read_targets, target_of
from vbbench.errors import VbbenchError
from vbbench.registry import make_solver
from vbbench.solver import FrameSolver


def chosen(only: str) -> list[Cell]:
    """The cells whose names begin with one of those asked for.

    Raises
    ------
    VbbenchError
        If none begins with one of them.
    """
    names = [name.strip() for name in only.split(",") if name.strip()]
    for name in names:
        if not any(cell.name.startswith(name) for cell in cells()):
            raise VbbenchError(f"no cell begins with '{name}'; there are {', '.join(cell.name for cell in cells())}")
    return [cell for cell in cells() if not names or any(cell.name.startswith(name) for name in names)]


def table(cell: Cell, solvers: list[str], scenes: Scenes, every: int) -> Iterator[str]:
    """The lines of a cell's table; progress is told meanwhile."""
    whole = {name: not isinstance(make_solver(name), FrameSolver) for name in solvers}
    targets = read_targets().get(cell.name, {})
    yield f"\n{cell.name}: {cell.unit}\n"
    yield "| | " + " | ".join([*solvers, "prototype", "wanted"]) + " |"
    yield "|---" * (len(solvers) + 3) + "|"
    for name, make in cell.trials.items():
        runs, trial = dict[str, Runs](), make(scenes)
        for solver in dict.fromkeys([*(["cv"] if cell.beside_cv else []), *solvers]):
            if not (whole.get(solver) and trial.protocol == "one-step"):
                runs[solver] = _measured(f"{cell.name}, {name}", trial, solver, scenes.jobs, every)
        found = {solver: cell.figures(runs[solver], runs.get("cv")) for solver in solvers if solver in runs}
        count = max(map(len, runs.values()), default=0)
        for figure in next(iter(found.values()), ()):
            target = target_of(targets, name, figure)
            texts = []
            for solver in solvers:
                values = found[solver][figure] if solver in found else ()
                texts.append(joined(values) + " !" * (bool(values) and target.missed(values, whole[solver])))
            yield f"| {name} ({count}), {figure} | " + " | ".join([*texts, *target.texts]) + " |"


def _measured(what: str, trial: Trial, solver: str, jobs: int, every: int) -> Runs:
    started = perf_counter()
    found = measure(trial, solver, jobs=jobs, every=every)
    seconds = perf_counter() - started
    print(f"{what}, {solver}: {len(found)} runs, {seconds:.1f} s", file=sys.stderr, flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("solvers", nargs="*", metavar="SOLVER")
    parser.add_argument("--kitti", type=Path, help="KITTI's folder")
    parser.add_argument("--detections", type=Path, help="a detector's boxes on it (default: detections in it)")
    parser.add_argument("--only", default="", metavar="CELL,...", help="cells, or how their names begin")
    parser.add_argument("--cache", type=Path, default=Path("out/real-camera"), help="where datasets are kept")
    parser.add_argument("--every", type=int, default=1, help="of each dataset, only every so many-th sequence")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--list", action="store_true", help="tell the names of the cells")
    asked = parser.parse_args()
    if asked.list:
        print("\n".join(f"{cell.name}: {cell.unit}" for cell in cells()))
        return
    if not asked.solvers or asked.kitti is None:
        parser.error("name a solver, and KITTI's folder with --kitti")
    scenes = Scenes(kitti=asked.kitti, cache=asked.cache, detections=asked.detections, jobs=asked.jobs)
    warnings.filterwarnings("ignore", "A worker stopped", UserWarning)
    try:
        for cell in chosen(asked.only):
            for line in table(cell, asked.solvers, scenes, asked.every):
                print(line, flush=True)
    except VbbenchError as error:
        sys.exit(f"real_camera: {error}")


if __name__ == "__main__":
    main()
