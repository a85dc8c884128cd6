"""Boxes rounded to binary fractions: exact multiples, told in the definition, harmless to solvers, small on disk."""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from vbbench.camera import PanoramaCamera
from vbbench.files.dataset import Dataset
from vbbench.generation import write_dataset
from vbbench.generation.generator import Options
from vbbench.registry import load
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_generators.tiers.noise import Precision

FINE = Precision(u_bits=10, v_bits=10, l_bits=12)


def made(folder: Path, precision: Precision | None) -> Dataset:
    plan = load("generator", "demo").plan(Options(limit=30))
    definition = {**plan.info.definition, **({} if precision is None else {"precision": asdict(precision)})}
    info = replace(plan.info, definition=definition)
    return write_dataset(replace(plan, info=info, precision=precision), folder)


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Dataset, Dataset]:
    folder = tmp_path_factory.mktemp("precision")
    return made(folder / "exact", None), made(folder / "rounded", FINE)


def test_boxes_are_multiples_within_half_a_step_and_truth_is_untouched(pair: tuple[Dataset, Dataset]) -> None:
    exact, rounded = pair
    for a, b in zip(exact.sequences(), rounded.sequences(), strict=True):
        seen, steps = a.observed, np.array(FINE.steps)
        np.testing.assert_array_equal(seen, b.observed)
        boxes = b.observations[seen]
        np.testing.assert_array_equal(boxes / steps, np.rint(boxes / steps))
        gap = boxes - a.observations[seen]
        gap[:, 0] = (gap[:, 0] + 720.0) % 1440.0 - 720.0
        assert (np.abs(gap) <= 0.5 * steps).all()
        np.testing.assert_array_equal(a.given.positions, b.given.positions)
        np.testing.assert_array_equal(exact.truth(a).positions, rounded.truth(b).positions)


def test_a_column_that_rounds_up_to_the_width_is_column_nought_and_no_box_vanishes() -> None:
    boxes = np.array([[1439.9999, 240.0, 10.0], [0.0, 0.0, 1e-9], [np.nan, np.nan, np.nan]])
    near = FINE.rounded(boxes, PanoramaCamera())
    np.testing.assert_array_equal(near[:2], [[0.0, 240.0, 10.0], [0.0, 0.0, 2.0**-12]])
    assert np.isnan(near[2]).all()


def test_the_definition_tells_and_the_id_differs_where_there_is_one(pair: tuple[Dataset, Dataset]) -> None:
    exact, rounded = pair
    assert rounded.info.definition["precision"] == {"u_bits": 10, "v_bits": 10, "l_bits": 12}
    assert "precision" not in exact.info.definition
    assert exact.info.id != rounded.info.id


@pytest.mark.slow
def test_solvers_do_not_feel_it(pair: tuple[Dataset, Dataset], tmp_path: Path) -> None:
    figures = []
    for name, dataset in zip(("a", "b"), pair, strict=True):
        solve(dataset, "vb-cv", "one-step", tmp_path / name)
        figures.append(score(tmp_path / name, dataset.folder).summaries)
    for metric in ("dt", "dx", "dx_rel"):
        assert abs(figures[0][metric].mean - figures[1][metric].mean) < 2e-4
