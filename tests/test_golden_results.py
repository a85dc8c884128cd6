"""The committed results: a subset recomputed exactly, none missing, and drift that is found."""

import itertools
import json
from pathlib import Path

import pytest

from vbbench.dataset import Dataset
from vbbench.protocol import PROTOCOLS
from vbbench_leaderboards.drift import drift
from vbbench_leaderboards.golden import SPLITS, TIERS, bundled_solvers, compute, make_dataset, recompute
from vbbench_leaderboards.result_file import RESULTS, Cell, first_sequences, read

SEQUENCES = 40
"""Sequences of Hotel that are solved again; what comes after them does not change them."""


@pytest.fixture(scope="module")
def hotel(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return make_dataset("hotel", "ideal", tmp_path_factory.mktemp("golden"), limit=SEQUENCES)


@pytest.mark.parametrize("solver", bundled_solvers())
@pytest.mark.parametrize("protocol", ["one-step", "sequential"])
def test_hotel_scores_as_committed(
    data_folder: Path, request: pytest.FixtureRequest, tmp_path: Path, protocol: str, solver: str
) -> None:
    cell = Cell(split="hotel", tier="ideal", protocol=protocol, solver=solver)
    values = compute(cell, request.getfixturevalue("hotel"), tmp_path)
    assert len(values["per_sequence"]["sequence"]) > SEQUENCES // 2
    assert drift(first_sequences(read(cell), SEQUENCES), values["per_sequence"]) == []


def test_every_bundled_solver_has_its_results() -> None:
    cells = [
        Cell(split=split, tier=tier, protocol=protocol, solver=solver)
        for split, tier, protocol, solver in itertools.product(SPLITS, TIERS, PROTOCOLS, bundled_solvers())
    ]
    missing = [str(cell.path) for cell in cells if not (RESULTS / cell.path).is_file()]
    assert not missing, "write them with make golden-update"
    for cell in cells:
        score = read(cell)["score"]
        assert (score["split"], score["protocol"], score["solver"]) == (cell.split, cell.protocol, cell.solver)
        assert (RESULTS / cell.path).stat().st_size < 100_000


def test_drift_is_found_named_and_mended(tmp_path: Path) -> None:
    kept = Cell(split="demo", tier="ideal", protocol="one-step", solver="cv")

    def run(*, update: bool) -> dict[Cell, list[str]]:
        return dict(recompute(["demo"], ["cv"], tmp_path, update=update, limit=5))

    assert all(found == ["no result was kept"] for found in run(update=True).values())
    assert not any(run(update=False).values())
    path = tmp_path / kept.path
    values = json.loads(path.read_text())
    values["per_sequence"]["dx"][3] += 2e-6
    values["score"]["metrics"]["dt"]["mean"] += 1.0
    values["package_version"] = "0.0.1"
    path.write_text(json.dumps(values))
    found = run(update=True)
    assert [line.split(":")[0] for line in found[kept]] == ["score.metrics.dt.mean", "per_sequence.dx"]
    assert "1 of" in found[kept][1]
    assert "most row 3" in found[kept][1]
    assert sum(map(bool, found.values())) == 1
    assert not any(run(update=False).values())


@pytest.mark.parametrize(
    ("old", "new", "lines"),
    [
        ({"a": 1.0}, {"a": 1.0 + 5e-7}, 0),
        ({"a": 1.0}, {"a": 1.0 + 2e-6}, 1),
        ({"a": 1e6}, {"a": 1e6 + 0.5}, 0),
        ({"a": None}, {"a": 0.0}, 1),
        ({"a": [1.0, None]}, {"a": [1.0, None]}, 0),
        ({"a": [1.0, None]}, {"a": [1.0, 2.0]}, 1),
        ({"a": [1.0]}, {"a": [1.0, 2.0]}, 1),
        ({"a": {"b": 3}}, {"a": {}}, 1),
        ({"a": "x"}, {"a": "x", "c": 1}, 1),
        ({"solver_version": "1"}, {"solver_version": "2"}, 0),
    ],
)
def test_what_counts_as_drift(old: object, new: object, lines: int) -> None:
    assert len(drift(old, new)) == lines
