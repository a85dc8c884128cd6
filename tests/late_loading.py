"""Prints what a solver loads or compiles while its seconds are counted; `tests.test_warming` runs it.

    python -m tests.late_loading DATASET SOLVER PROTOCOL yes|no ...

Each solver and protocol, with covariances or without, runs in a fork of a process in which no kernel was called.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

from numba.core.dispatcher import Dispatcher

from vbbench.files.dataset import Dataset
from vbbench.protocol import get_protocol
from vbbench.solving import submissions as solving

loaded: list[str] = []


def late(dataset: Dataset, solver: str, protocol: str, covariances: bool) -> list[str]:
    """Names of the kernels that the solver comes to while the clock runs."""
    found: list[str] = []

    def watched(*arguments: Any) -> Any:
        before = len(loaded)
        answer = solving_run(*arguments)
        found.extend(loaded[before:])
        return answer

    solving_run, solving.run_sequence = solving.run_sequence, watched  # type: ignore[assignment]
    solving._solve_part(
        dataset, solver, solving._opened_here, get_protocol(protocol), covariances, False, 0, len(dataset)
    )
    return found


def watch_dispatchers() -> None:
    """Note every specialisation that a dispatcher gets, compiled or from the cache."""
    add = Dispatcher.add_overload

    def noted(self: Any, compiled: Any) -> None:
        loaded.append(f"{self.py_func.__module__}.{self.py_func.__qualname__}")
        add(self, compiled)

    Dispatcher.add_overload = noted


def main(dataset: str, *cases: str) -> None:
    """Print a JSON object: late kernels, by case."""
    watch_dispatchers()
    opened, found = Dataset(Path(dataset)), {}
    for solver, protocol, covariances in zip(cases[::3], cases[1::3], cases[2::3], strict=True):
        theirs, ours = os.pipe()
        child = os.fork()
        if child == 0:
            os.write(
                ours,
                json.dumps(
                    {"late": late(opened, solver, protocol, covariances == "yes"), "loaded": len(loaded)}
                ).encode(),
            )
            os._exit(0)
        os.close(ours)
        with os.fdopen(theirs) as pipe:
            found[f"{solver} {protocol} {covariances}"] = json.load(pipe)
        os.waitpid(child, 0)
    sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
