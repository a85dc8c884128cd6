"""Label rows of KITTI a second: from a file to checked arrays, beside NumPy's and Python's ways to read the same file,
by the clock and by processor time, which other work on the machine disturbs less.

Run from the repository: ``python -m benchmarks.bench_footage [--rows 1000000] [FILE]``. The file is one of KITTI's
labels, repeated until it is long enough; without one, rows are made up. The quickest of three runs counts.
"""

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from vbbench_generators.footage.kitti.labels import read_labels

REPEATS = 3
PER_FRAME = 20
LOOPED = 200_000
"""Rows that the slow ways read; their time is in proportion."""


def made_up(rows: int, seed: int = 0) -> list[str]:
    """Rows as long as KITTI's."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0.0, 300.0, (rows, 2))
    heights, forward, others = rng.uniform(1.5, 2.0, rows), rng.uniform(5.0, 30.0, rows), rng.normal(size=(rows, 6))
    body = [heights, others[:, :4], forward, others[:, 4]]
    numbers = np.column_stack([others[:, 5], corners, corners + 50.0, *body])
    return [" ".join(["Pedestrian 0 1", *(f"{value:.6f}" for value in row)]) for row in numbers.tolist()]


def repeated(lines: list[str], rows: int) -> str:
    """So many rows, what follows frame and track again and again; a frame has 20."""
    bodies = [line if line[0].isalpha() else line.split(" ", 2)[2] for line in lines if "DontCare" not in line]
    return "".join(f"{n // PER_FRAME} {n % PER_FRAME} {bodies[n % len(bodies)]}\n" for n in range(rows))


def rates(function: Callable[[Path], Any], path: Path, rows: int) -> tuple[float, float]:
    """Rows a second by the clock, and by processor time."""
    times = []
    for _ in range(REPEATS):
        start = perf_counter(), process_time()
        function(path)
        times.append((perf_counter() - start[0], process_time() - start[1]))
    clock, processor = np.min(times, axis=0)
    return rows / clock, rows / processor


def by_numpy(path: Path) -> Any:
    return np.loadtxt(path, usecols=[0, 1, *range(3, 17)])


def by_loop(path: Path) -> Any:
    with path.open() as file:
        return [[float(cell) for cell in line.split(" ") if not cell.isalpha()] for line in file]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, nargs="?")
    parser.add_argument("--rows", type=int, default=1_000_000)
    options = parser.parse_args()
    lines = options.file.read_text().splitlines() if options.file else made_up(10_000)
    with tempfile.TemporaryDirectory() as folder:
        long, short = Path(folder) / "long.txt", Path(folder) / "short.txt"
        long.write_text(repeated(lines, options.rows))
        short.write_text(repeated(lines, min(LOOPED, options.rows)))
        print(
            f"{options.rows:,} rows, {long.stat().st_size / 1e6:.0f} MB; rows a second by the clock, by processor time"
        )
        for name, function, path in (
            ("read_labels", read_labels, long),
            ("np.loadtxt", by_numpy, short),
            ("a loop over lines", by_loop, short),
        ):
            clock, processor = rates(function, path, options.rows if path is long else min(LOOPED, options.rows))
            print(f"{name:<20}{clock:>12,.0f}{processor:>12,.0f}")


if __name__ == "__main__":
    main()
