"""Every benchmark that needs no recordings runs, at its smallest size."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SMALLEST = {
    "bench_birdify": "--frames 40 --people 3 --runs 1",
    "bench_cars": "--rows 2000",
    "bench_estimator": "--people 3 --frames 8 --runs 1",
    "bench_former": "--people 3 --runs 1",
    "bench_jobs": "cv --sequences 8",
    "bench_scoring": "--quick",
    "bench_session": "--frames 40 --people 8 --uncertain",
    "bench_solver": "",
    "bench_startup": "--runs 1",
    "bench_streaming": "--frames 20 --people 4 --columns 8",
    "bench_vb_sf": "--people 5 --compared 5",
    "session_coverage": "--runs 1 --seconds 2 --people 5",
    "turning_camera": "--runs 1 --solver map-causal --dt .4",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SMALLEST)
def test_a_benchmark_runs_at_its_smallest_size(name: str) -> None:
    command = [sys.executable, "-m", f"benchmarks.{name}", *SMALLEST[name].split()]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("\n") > 1
