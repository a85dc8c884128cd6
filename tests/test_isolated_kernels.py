"""What numba compiles for an isolated solver: read where it is, kept for the next, written nowhere else."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from vbbench.camera import PanoramaCamera
from vbbench.sequence import Given
from vbbench.solver import Frame, Problem
from vbbench.solving.isolation import kernel_cache
from vbbench.solving.isolation.kernel_cache import keep_files, user_caches
from vbbench.solving.isolation.solver_process import IsolatedSolver

NUMERICAL = """
import numpy as np
from numba import njit
from vbbench import FrameEstimate

@njit(cache=True)
def double(x):
    return 2.0 * x

class Compiled:
    def start(self, problem):
        double(1.0)
    def step(self, frame):
        hits, misses = (sum(count.values()) for count in (double.stats.cache_hits, double.stats.cache_misses))
        return FrameEstimate(pose=np.array([hits, misses, double(1)]), positions=np.zeros((0, 2)))
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where the solver lies."""
    (tmp_path / "user").mkdir()
    (tmp_path / "user/numerical.py").write_text(NUMERICAL)
    monkeypatch.syspath_prepend(tmp_path / "user")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "user"


def hits_and_misses(compiled: Path | None = None) -> list[float]:
    """Kernels that were loaded and that were compiled until the first answer; then what is compiled is kept."""
    nothing = Given(poses=np.full((3, 3), np.nan), positions=np.zeros((3, 0, 2)))
    camera = PanoramaCamera()
    problem = Problem(camera=camera, dt=0.4, tracks=np.arange(0), height_mean=1.7, height_std=0.1, pixel_std=0.0)
    with IsolatedSolver("numerical:Compiled", compiled=compiled) as solver:
        solver.start(problem)  # type: ignore[union-attr]
        solver.keep_compiled()
        answer = solver.step(Frame(index=0, observations=np.zeros((0, 3)), given=nothing))  # type: ignore[union-attr]
    return list(answer.pose[:2])


@pytest.mark.slow
def test_what_one_process_compiles_the_next_one_loads(folder: Path, tmp_path: Path) -> None:
    compiled = tmp_path / "compiled"
    assert hits_and_misses(compiled) == [0, 1]
    assert hits_and_misses(compiled) == [1, 0]
    assert not list(folder.rglob("*.nb?"))
    assert not (tmp_path / "cache").exists()


@pytest.mark.slow
def test_what_was_compiled_before_is_loaded_and_stays_as_it_was(folder: Path) -> None:
    subprocess.run([sys.executable, "-c", "import numerical; numerical.double(1.0)"], cwd=folder, check=True)
    before = {path: path.read_bytes() for path in folder.rglob("*.nb?")}
    assert len(before) == 2
    assert hits_and_misses() == [1, 0]
    assert {path: path.read_bytes() for path in folder.rglob("*.nb?")} == before


@pytest.mark.slow
def test_caches_elsewhere_are_read(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "chosen"))
    subprocess.run([sys.executable, "-c", "import numerical; numerical.double(1.0)"], cwd=folder, check=True)
    assert user_caches() == [str(tmp_path / "chosen")]
    assert hits_and_misses() == [1, 0]


def test_what_a_solver_leaves_is_not_trusted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source, secret = tmp_path / "private/mine_1", tmp_path / "secret.nbc"
    source.mkdir(parents=True)
    secret.write_text("secret")
    (source / "a.nbi").write_text("index")
    (source / "b.nbc").symlink_to(secret)
    (source / "c.txt").touch()
    (source / "d.nbc").mkdir()
    (source / "e.nbc").write_text("x" * 100)
    (tmp_path / "private/linked").symlink_to(tmp_path)
    monkeypatch.setattr(kernel_cache, "MOST_BYTES", 90)
    keep_files(tmp_path / "private", tmp_path / "kept")
    assert [str(path.relative_to(tmp_path / "kept")) for path in tmp_path.glob("kept/*/*")] == ["mine_1/a.nbi"]
    keep_files(tmp_path / "private", tmp_path / "kept")  # somebody was faster
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kept", "private", "secret.nbc"]
