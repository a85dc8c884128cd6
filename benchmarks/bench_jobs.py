"""How much faster `vbbench solve --jobs 2` is than one job, by the clock and by what cannot be shared.

The clock is only right on two idle processors. Processor seconds are right on busy ones too: the command's own process
does what cannot be shared (starting, handing out, writing), its workers share the rest evenly, and so

    scaling = seconds of one job / (seconds of the command's process + half of the workers' seconds).

Each command is a process of its own, as a user starts it.
Run with ``python -m benchmarks.bench_jobs [SOLVER ...]``.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation

SEQUENCES = 1500
SOLVERS = ("cv", "vb-sf", "map-causal")
TARGET = 1.9
COMMAND = """
import sys, time
from vbbench.cli import main
status = main(sys.argv[2:])
open(sys.argv[1], "w").write(str(time.process_time()))
sys.exit(status)
"""


@dataclass(frozen=True, kw_only=True)
class Spent:
    """Seconds of one command: by the clock, of its own process, and of its workers together."""

    wall: float
    own: float
    workers: float


def spent(dataset: Path, solver: str, room: Path, jobs: int) -> Spent:
    note, out = room / "own", room / f"{solver}-{jobs}"
    words = ["solve", str(dataset), "--solver", solver, "--protocol", "sequential", "--out", str(out), "--overwrite"]
    started = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-c", COMMAND, str(note), *words, "--jobs", str(jobs)], stdout=subprocess.DEVNULL
    )
    _, status, used = os.wait4(process.pid, 0)
    wall = time.perf_counter() - started
    if status:
        raise SystemExit(f"solving with {solver} failed")
    own = float(note.read_text())
    return Spent(wall=wall, own=own, workers=used.ru_utime + used.ru_stime - own)


def made(folder: Path, sequences: int) -> Path:
    options = Options(tier="noisy", simulation=Simulation(sequences=sequences))
    return generate("sim", folder, options, jobs=2).folder


def main(solvers: Sequence[str], sequences: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        room = Path(folder)
        few, many = made(room / "few", 8), made(room / "many", sequences)
        print(f"Solving {sequences} sequences of sim, noisy, sequential; load {os.getloadavg()[0]:.1f} before")
        heads = f"{'clock':>8}{'scaling':>9}  target {TARGET}"
        print(f"{'':<12}{'one job':>16}{'two jobs':>16}{'own':>8}{'workers':>9}{heads}")
        for solver in solvers:
            spent(few, solver, room, 1)  # reads files into the cache of the system
            one, two = (spent(many, solver, room, jobs) for jobs in (1, 2))
            alone, together = one.own + one.workers, two.own + two.workers
            print(
                f"{solver:<12}{one.wall:>7.1f} s {alone:>5.1f} p{two.wall:>7.1f} s {together:>5.1f} p"
                f"{two.own:>8.2f}{two.workers:>9.1f}{one.wall / two.wall:>8.2f}"
                f"{alone / (two.own + two.workers / 2):>9.2f}",
                flush=True,
            )
        print(f"p: processor seconds; load {os.getloadavg()[0]:.1f} after")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("solvers", nargs="*", default=SOLVERS)
    parser.add_argument("--sequences", type=int, default=SEQUENCES)
    asked = parser.parse_args()
    main(asked.solvers, asked.sequences)
