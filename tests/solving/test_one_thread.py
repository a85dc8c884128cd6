"""Solvers compute on one thread, so that rounding does not depend on how many processors or jobs there are."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
import scipy.linalg  # noqa: F401 - the library whose threads are counted
from threadpoolctl import threadpool_info, threadpool_limits

from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.registry import registered
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench.solving import solve


class ThreadCounter:
    """Answers the largest number of threads that a library may use, for want of a pose."""

    def start(self, problem: Problem) -> None:
        self._people = len(problem.tracks)

    def step(self, frame: Frame) -> FrameEstimate:
        threads = max(library["num_threads"] for library in threadpool_info())
        return FrameEstimate(pose=np.full(3, float(threads)), positions=np.zeros((self._people, 2)))


@pytest.mark.slow
@pytest.mark.parametrize("how", [{}, {"isolate": True}, {"jobs": 2}], ids=str)
def test_a_solver_has_one_thread(tmp_path: Path, how: dict[str, Any]) -> None:
    folder = generate("sim", tmp_path / "sim", Options(limit=2), jobs=1).folder
    name = f"{ThreadCounter.__module__}:{ThreadCounter.__name__}"
    with threadpool_limits(3):
        out = solve(Dataset(folder), name, "sequential", tmp_path / "out", **how)
        assert max(library["num_threads"] for library in threadpool_info()) == 3
    answers = pq.read_table(out / "poses.parquet").to_pandas()
    assert set(answers["x"]) == {1.0}


LATE = """
import sys
from pathlib import Path
from vbbench.files.dataset import Dataset
from vbbench.solving import runner, solve

def clock():
    loaded.append(set(sys.modules))
    return float(len(loaded))

runner.perf_counter, loaded = clock, []
solve(Dataset(Path(sys.argv[1])), sys.argv[2], "sequential", Path(sys.argv[3]))
assert loaded
print(*sorted(set().union(*(after - before for before, after in zip(loaded[::2], loaded[1::2])))))
"""


@pytest.mark.slow
def test_a_bundled_solver_imports_nothing_while_its_seconds_are_counted(tmp_path: Path) -> None:
    """In a new process each: no library comes after the threads were limited."""
    folder = generate("demo", tmp_path / "demo", Options(limit=1), jobs=1).folder
    late = {}
    for solver in registered("solver"):
        command = [sys.executable, "-c", LATE, str(folder), solver, str(tmp_path / solver)]
        late[solver] = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert len(late) >= 9
    assert {solver: modules for solver, modules in late.items() if modules} == {}
