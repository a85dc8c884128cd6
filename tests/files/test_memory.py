"""Nothing holds a split in memory: whoever makes, solves, scores or checks one has some sequences in hand at a time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import SequenceTable
from vbbench.files.verification import verify
from vbbench.generation import datasets as generation
from vbbench.generation import write_dataset
from vbbench.generation.generator import Card, Options
from vbbench.parallel.parts import Part
from vbbench.scene import Scene
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench.solving import submissions as solving
from vbbench_generators.recordings.recipe import Rules
from vbbench_generators.views import Reprojection, plan_reprojection

PEOPLE, FRAMES, BUDGET = 40, 50, 5_000
"""A sequence has 1,900 rows, all of them 78,000."""


def crowd() -> Reprojection:
    rng = np.random.default_rng(0)
    pace = np.arange(FRAMES)[:, None, None] * rng.normal(0.0, 0.05, (PEOPLE, 2))
    positions = rng.uniform(-9.0, 9.0, (PEOPLE, 2)) + pace
    unknown = np.full(PEOPLE, np.nan)
    scene = Scene(name="dense", dt=0.04, people=np.arange(PEOPLE), positions=positions, heights=unknown)
    card = Card(name="dense", title="Dense", licence="", citation="", sources=())
    return plan_reprojection(card, Rules(), [scene], Options(), {})


@pytest.fixture(autouse=True)
def _small_budgets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vbbench.files.sequence_tables.ROWS_A_PART", BUDGET)
    monkeypatch.setattr("vbbench.scoring.scored_rows.CELLS_AT_ONCE", BUDGET)


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """How many rows each reading of a table has brought."""
    rows: list[int] = []
    before = SequenceTable.read

    def counted(table: SequenceTable, *arguments: Any) -> dict[str, Any]:
        found = before(table, *arguments)
        rows.append(len(next(iter(found.values()))))
        return found

    monkeypatch.setattr(SequenceTable, "read", counted)
    return rows


@pytest.mark.slow
def test_parts_are_cut_by_rows(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    parts: list[Part] = []
    for module, name in ((generation, "_build_part"), (solving, "_solve_part")):
        monkeypatch.setattr(module, name, _kept(getattr(module, name), parts))
    dataset = write_dataset(crowd(), tmp_path / "data")
    solve(dataset, "cv", "sequential", tmp_path / "answer")
    rows = [
        sum(len(group) for group in part.groups.get(name, ()))
        for part in parts
        for name in ("observations", "positions")
    ]
    assert BUDGET // 2 < max(rows) <= BUDGET
    assert dataset.info.counts["observations"] > 15 * BUDGET


@pytest.mark.slow
def test_tables_are_read_some_sequences_at_a_time(tmp_path: Path, read: list[int]) -> None:
    dataset = write_dataset(crowd(), tmp_path / "data")
    for _ in dataset.sequences():
        pass
    solve(dataset, "cv", "sequential", tmp_path / "answer")
    score(tmp_path / "answer", tmp_path / "data")
    verify(tmp_path / "data")
    assert BUDGET // 2 < max(read) <= BUDGET


def test_scenes_at_hand_are_few(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("vbbench.files.dataset.SCENES_KEPT", 2)
    made = generation.generate("sim", tmp_path / "sim", Options(limit=5))
    dataset = Dataset(made.folder)
    for sequence in dataset.sequences():
        assert np.isfinite(dataset.truth(sequence).positions).all()
        assert len(dataset._scenes) <= 2


def _kept(work: Any, parts: list[Part]) -> Any:
    def kept(*arguments: Any) -> Part:
        parts.append(work(*arguments))
        return parts[-1]

    return kept
