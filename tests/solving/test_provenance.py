"""Resumed work is all of one version of a solver: its source is part of what the work is known by."""

import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pyarrow.parquet as pq
import pytest

import vbbench.files.sequence_tables
import vbbench.parallel.parts
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.solving import solve
from vbbench.solving.provenance import source_digest

SOLVER = """
import numpy as np
from vbbench import FrameEstimate
from helper import shift

class Mine:
    def start(self, problem):
        pass
    def step(self, frame):
        if frame.index == 0 and frame.given.poses[2, 0] == {last}:  # the world of a sequence tells it from others
            raise KeyboardInterrupt
        positions = np.zeros((len(frame.observations), 2))
        return FrameEstimate(pose=np.full(3, shift()), positions=positions)
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where a user's solver lies, with a module and a package beside it."""
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "mine.py").write_text(SOLVER.format(last=-1))
    (tmp_path / "helper.py").write_text("def shift():\n    from deep import numbers\n    return numbers.SHIFT\n")
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep/__init__.py").touch()
    (tmp_path / "deep/numbers.py").write_text("SHIFT = 1.0\n")
    (tmp_path / "deep/weights.bin").write_bytes(b"1")
    (tmp_path / "unrelated.py").write_text("x = 1\n")
    yield tmp_path
    forget()


def forget() -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] in ("mine", "helper", "deep")]:
        del sys.modules[name]


def edit(path: Path, text: str) -> None:
    path.write_text(text)
    shutil.rmtree(path.parent / "__pycache__", ignore_errors=True)


@pytest.mark.parametrize("name", ["mine.py", "helper.py", "deep/__init__.py", "deep/numbers.py", "deep/weights.bin"])
def test_whatever_a_solver_is_made_of_counts(folder: Path, name: str) -> None:
    before = source_digest("mine:Mine")
    (folder / name).write_bytes((folder / name).read_bytes() + b"\n")
    assert source_digest("mine:Mine") != before


def test_nothing_else_counts(folder: Path) -> None:
    before = source_digest("mine:Mine")
    (folder / "unrelated.py").write_text("x = 2\n")
    (folder / "deep/__pycache__").mkdir()
    (folder / "deep/__pycache__/x.pyc").touch()
    (folder / "deep/.swp").touch()
    os.utime(folder / "mine.py", (1, 1))
    assert source_digest("mine:Mine") == before
    __import__("mine")
    __import__("unrelated")
    assert source_digest("mine:Mine") == before


def test_nothing_is_run_to_find_out(folder: Path) -> None:
    (folder / "mine.py").write_text("import helper\nraise SystemExit\n")
    (folder / "helper.py").write_text("this is no Python (((\nimport deep\n")
    first = source_digest("mine:Mine")
    (folder / "deep/numbers.py").write_text("SHIFT = 2.0\n")
    assert source_digest("mine:Mine") != first
    assert not {"mine", "helper", "deep"} & sys.modules.keys()


def interrupted(folder: Path, monkeypatch: pytest.MonkeyPatch, solver: str = SOLVER, **options: bool) -> Dataset:
    """A dataset of six sequences, of which a solver has solved four and left two parts."""
    monkeypatch.setattr(vbbench.parallel.parts, "PATIENCE", 0.0)  # every part is kept
    monkeypatch.setattr(vbbench.files.sequence_tables, "PART_SIZE", 2)
    dataset = Dataset(generate("sim", folder / "sim", Options(limit=6)).folder)
    edit(folder / "mine.py", solver.format(last=repr(float(dataset.sequence(4).given.poses[0, 0]))))
    with pytest.raises(VbbenchError if options else KeyboardInterrupt):
        solve(dataset, "mine:Mine", "rollout", folder / "out", **options)
    assert len(list(folder.glob("out.partial/parts/*.arrows"))) == 2
    return dataset


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"isolate": True}], ids=str)
def test_a_changed_helper_starts_the_work_anew(
    folder: Path, monkeypatch: pytest.MonkeyPatch, options: dict[str, bool]
) -> None:
    dataset = interrupted(folder, monkeypatch, **options)
    forget()
    edit(folder / "mine.py", SOLVER.format(last=-1))
    edit(folder / "deep/numbers.py", "SHIFT = 2.0\n")
    out = solve(dataset, "mine:Mine", "rollout", folder / "out", **options)
    assert set(pq.read_table(out / "poses.parquet")["x"].to_pylist()) == {2.0}


@pytest.mark.slow
def test_isolated_work_takes_no_answers_that_were_given_without(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    process, asked = 'float(__import__("os").getpid())', '__import__("os").environ.get("STOPS") and frame.index == 0'
    monkeypatch.setenv("STOPS", "here")
    solver = SOLVER.replace("shift()", process).replace("frame.index == 0", asked)
    dataset = interrupted(folder, monkeypatch, solver)
    monkeypatch.delenv("STOPS")
    out = solve(dataset, "mine:Mine", "rollout", folder / "out", isolate=True)
    assert float(os.getpid()) not in pq.read_table(out / "poses.parquet")["x"].to_pylist()
