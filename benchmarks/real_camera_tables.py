"""Writes the tables of docs/real-cameras.md anew.

    python -m benchmarks.real_camera_tables --kitti ~/kitti [--cache DIR] [--only KITTI] [--write]

The cells are those of `benchmarks.real_camera`; ``--only`` takes how titles of tables begin. A table is found by its
first line, and with ``--write`` it is replaced there; otherwise it is printed.
"""

import argparse
import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.real_camera.__main__ import chosen
from benchmarks.real_camera.cells import Cell
from benchmarks.real_camera.measuring import Runs, measure
from benchmarks.real_camera.scenes import Scenes
from benchmarks.real_camera.targets import joined
from vbbench.folders.replacing import write_text_atomically

PAGE = Path("docs/real-cameras.md")

CAUSAL = ("cv", "vb-sf", "map-causal")
"""Solvers of every table; `map-batch` is beside them where later frames have anything to tell."""

SEQUENCES_ONLY = "map-batch"

FRAME_TIMES = {"4": ".4 s", "1": ".1 s"}


@dataclass(frozen=True, kw_only=True)
class Table:
    """Cells that stand in one table.

    Parameters
    ----------
    title : of its first column, by which it is found.
    cells : how their names begin.
    shown : the figures of a row; the second in brackets.
    """

    title: str
    cells: tuple[str, ...]
    shown: tuple[str, ...]

    @property
    def header(self) -> str:
        """Its first line."""
        return f"| {self.title} | " + " | ".join(f"`{solver}`" for solver in (*CAUSAL, SEQUENCES_ONLY)) + " |"


ERRORS = ("mean", "worst run")

TABLES = (
    Table(title="KITTI every 4th frame", cells=("kitti-4-one", "kitti-4-seq", "kitti-4-roll"), shown=ERRORS),
    Table(title="KITTI every frame", cells=("kitti-1-one", "kitti-1-seq", "kitti-1-roll"), shown=ERRORS),
    Table(title="KITTI cold start", cells=("kitti-4-cold", "kitti-1-cold"), shown=("mean", "Δx̃; drift, m/s")),
    Table(title="tier `field`", cells=("boards-field",), shown=("capped", "failed")),
    Table(title="normalised squared errors", cells=("calibration",), shown=("mean", "median")),
)


def lines(table: Table, scenes: Scenes, every: int) -> Iterator[str]:
    """The lines of a table; progress is told meanwhile."""
    yield table.header
    yield "|---" * (len(CAUSAL) + 2) + "|"
    for cell in chosen(",".join(table.cells)):
        for name, make in cell.trials.items():
            trial, runs = make(scenes), dict[str, Runs]()
            solvers = CAUSAL if trial.protocol == "one-step" else (*CAUSAL, SEQUENCES_ONLY)
            for solver in solvers:
                print(f"{cell.name}, {name}, {solver}", file=sys.stderr, flush=True)
                runs[solver] = measure(trial, solver, jobs=scenes.jobs, every=every)
            texts = [_text(cell, runs[solver], runs["cv"], table.shown) if solver in runs else "" for solver in runs]
            texts += [""] * (len(CAUSAL) + 1 - len(texts))
            yield f"| {_label(cell, name)} ({len(runs['cv'])}) | " + " | ".join(texts) + " |"


def _text(cell: Cell, runs: Runs, cv: Runs, shown: tuple[str, ...]) -> str:
    figures = cell.figures(runs, cv)
    first, second = (joined(figures[name]) for name in shown)
    return first if len(runs) == 1 and shown == ERRORS else f"{first} ({second})"


def _label(cell: Cell, trial: str) -> str:
    """What a row is about."""
    origin, *rest = cell.name.split("-")
    if origin != "kitti":
        return trial
    protocol = "-".join(rest[1:])
    return f"{trial}, {FRAME_TIMES[rest[0]]}" if protocol == "cold-start" else f"{trial}, {protocol}"


def replaced(page: str, table: list[str]) -> str:
    """The page with the table that begins with the same line, if it has it."""
    rows = page.split("\n")
    if table[0] not in rows:
        return page
    first = last = rows.index(table[0])
    while last < len(rows) and rows[last].startswith("|"):
        last += 1
    return "\n".join([*rows[:first], *table, *rows[last:]])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kitti", type=Path, required=True, help="KITTI's folder")
    parser.add_argument("--cache", type=Path, default=Path("out/real-camera"), help="where datasets are kept")
    parser.add_argument("--only", default="", metavar="TITLE,...", help="how the tables' titles begin")
    parser.add_argument("--every", type=int, default=1, help="of tier field and calibration, every so many-th sequence")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="replace the tables of the page")
    asked = parser.parse_args()
    scenes = Scenes(kitti=asked.kitti, cache=asked.cache, jobs=asked.jobs)
    only = tuple(asked.only.split(","))  # every title begins with nothing
    warnings.filterwarnings("ignore", "A worker stopped", UserWarning)
    for table in (table for table in TABLES if table.title.startswith(only)):
        sparse = table.title in ("tier `field`", "normalised squared errors")
        rows = list(lines(table, scenes, asked.every if sparse else 1))
        print("\n".join(rows), "\n", flush=True)
        if asked.write:
            write_text_atomically(PAGE, replaced(PAGE.read_text("utf-8"), rows))


if __name__ == "__main__":
    main()
