"""The posteriors of a frame: golden figures, finer grids, and solvers without one."""

from typing import Any

import numpy as np
import pytest

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.reproduction.density import find_density
from vbbench.reproduction.posterior import FIGURES, SOLVER, instants, posterior_rows, text_reading
from vbbench.solving.posterior import find_posterior

GOLDEN: dict[str, tuple[float, ...]] = {
    "text": (-8.1517, -8.1258, -3.846, 0.0059, 0.0172, 0.9299, -1.1961, 0.2134, 0.0213),
    SOLVER: (-9.2116, -9.1877, -4.8975, 0.0045, 0.0195, 1.3519, np.nan, 0.0583, 0.0055),
}
"""Means over the frames of the first sequence: entropies and kurtosis to .02, the rest to .003."""


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("demo", tmp_path_factory.mktemp("posterior") / "demo", Options(limit=2))


@pytest.mark.slow
@pytest.mark.parametrize("name", GOLDEN)
def test_figures_are_those_of_the_record(dataset: Dataset, name: str) -> None:
    rows = np.array(posterior_rows(dataset, text_reading() if name == "text" else name, 0, 1))
    table = dict(zip(FIGURES, rows.T[2:], strict=True))
    assert rows[:, 1].tolist() == list(range(2, dataset.sequence(0).frames))
    for column, wanted in zip(FIGURES, GOLDEN[name], strict=True):
        rough = column in ("pose", "gaussian", "place", "kurtosis", "people")
        mean = float(np.mean(table[column]))
        assert mean == pytest.approx(wanted, abs=0.02 if rough else 0.003, nan_ok=True), column
    assert (table["pose"] <= table["gaussian"] + 1e-3).all()  # a normal density has the most entropy


@pytest.mark.parametrize("name", GOLDEN)
def test_finer_grids_change_little(dataset: Dataset, name: str) -> None:
    solver = text_reading() if name == "text" else name
    for instant in instants(dataset, dataset.sequence(0), solver, range(3, 12, 4)):
        source: Any = find_posterior(dataset, 0, instant.frame, solver=solver, protocol="one-step").source
        fine = find_density(source.pose_energy, *instant.density.moments(), points=41)
        assert instant.density.entropy == pytest.approx(fine.entropy, abs=0.01)
        (beyond, kurtosis), wanted = instant.place.tails(), fine.marginal().finer().tails()
        assert kurtosis == pytest.approx(wanted[1], abs=0.03)
        assert beyond == pytest.approx(wanted[0], abs=1e-3)


@pytest.mark.parametrize(
    ("solver", "message"), [("vb-cv", "no pose_energy"), ("map-batch", "whole sequences"), ("vb-fs", "mean 'vb-sf'")]
)
def test_a_solver_without_posterior_is_refused(dataset: Dataset, solver: str, message: str) -> None:
    with pytest.raises(VbbenchError, match=message):
        posterior_rows(dataset, solver, 0, 1)
