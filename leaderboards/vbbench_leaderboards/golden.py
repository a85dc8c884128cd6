"""Golden results: what the bundled solvers score, committed, and recomputed to find any drift.

    python -m vbbench_leaderboards.golden [--split hotel eth] [--solver vb-cv] [--update] [--jobs 2]

For the panorama, σ_h = 0.07 m and seed 0. Exit status 1 tells that something drifted and was not updated.
"""

import itertools
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Literal, get_args

from vbbench.camera import CAMERAS
from vbbench.dataset import Dataset
from vbbench.generation import generate
from vbbench.generator import Options, Tier
from vbbench.protocol import PROTOCOLS
from vbbench.registry import registered
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_leaderboards.drift import drift
from vbbench_leaderboards.result_file import RESULTS, Cell, read, to_values, write

SplitName = Literal["hotel", "eth", "eth-15fps", "students", "students-resampled"]
SPLITS: tuple[SplitName, ...] = get_args(SplitName)
TIERS: tuple[Tier, ...] = ("ideal", "noisy")


def bundled_solvers() -> list[str]:
    """Names of the solvers that come with vbbench, strangers' left out."""
    return sorted(name for name, point in registered("solver").items() if point.dist and point.dist.name == "vbbench")


def make_dataset(split: str, tier: Tier, work: Path, *, limit: int | None = None, jobs: int = 1) -> Dataset:
    """The dataset of a split's results, in a folder of its own in ``work``."""
    options = Options(camera=CAMERAS["panorama"](), tier=tier, limit=limit)
    return generate(split, work / f"{split}-{tier}", options, jobs=jobs)


def compute(cell: Cell, dataset: Dataset, work: Path, *, jobs: int = 1) -> dict[str, Any]:
    """Solve and score one cell: the content of its file."""
    out = solve(dataset, cell.solver, cell.protocol, work / "answers", jobs=jobs, overwrite=True)
    return to_values(score(out, dataset.folder))


def recompute(
    splits: Sequence[str],
    solvers: Sequence[str],
    results: Path,
    *,
    update: bool,
    limit: int | None = None,
    jobs: int = 1,
) -> Iterator[tuple[Cell, list[str]]]:
    """Every cell with what drifted from its file; with ``update`` the file is then written anew."""
    with tempfile.TemporaryDirectory() as scratch:
        for split, tier in itertools.product(splits, TIERS):
            dataset = make_dataset(split, tier, Path(scratch), limit=limit, jobs=jobs)
            for protocol, solver in itertools.product(PROTOCOLS, solvers):
                cell = Cell(split=split, tier=tier, protocol=protocol, solver=solver)
                values = compute(cell, dataset, Path(scratch), jobs=jobs)
                found = _compare(cell, values, results)
                if found and update:
                    write(cell, values, results)
                yield cell, found


def _compare(cell: Cell, values: dict[str, Any], results: Path) -> list[str]:
    if not (results / cell.path).is_file():
        return ["no result was kept"]
    return drift(read(cell, results), values)


def recompute_command(
    split: tuple[SplitName, ...] = SPLITS,
    solver: tuple[str, ...] | None = None,
    results: Path = RESULTS,
    update: bool = False,
    jobs: int = 1,
) -> int:
    """Solve and score again, compare with the result files, and say what drifted; the number of cells that did.

    Args:
        split: Splits to recompute.
        solver: Solvers to recompute; default: all that come with vbbench.
        results: Folder with the result files.
        update: Write what drifted, and what is new.
        jobs: Processes.
    """
    drifted = 0
    for cell, found in recompute(split, solver or bundled_solvers(), results, update=update, jobs=jobs):
        drifted += bool(found) and not update
        state = "as committed" if not found else "written anew" if update else "drifted"
        _say(f"{cell.path}: {state}", *(f"  {line}" for line in found))
    return drifted


def _say(*lines: str) -> None:
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    sys.stdout.flush()


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status."""
    import tyro

    flags = (tyro.conf.FlagCreatePairsOff,)
    drifted = tyro.cli(recompute_command, prog="python -m vbbench_leaderboards.golden", args=argv, config=flags)
    return int(drifted > 0)


if __name__ == "__main__":
    sys.exit(main())
