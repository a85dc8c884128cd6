"""The posteriors of a frame: golden figures, finer grids, and solvers without one."""

from itertools import islice
from typing import Any

import numpy as np
import pytest

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.protocol import get_protocol
from vbbench.registry import make_solver
from vbbench.reproduction.density import find_density
from vbbench.reproduction.posterior import FIGURES, SOLVER, instants, posterior_rows, text_reading
from vbbench.solving.runner import frames_of, reveal

GOLDEN: dict[str, tuple[float, ...]] = {
    "text": (-8.1517, -3.846, 0.0172, 0.9299, 0.0213),
    SOLVER: (-9.2116, -4.8975, 0.0195, 1.3519, 0.0055),
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
        rough = column in ("pose", "place", "kurtosis")
        mean = float(np.mean(table[column]))
        assert mean == pytest.approx(wanted, abs=0.02 if rough else 0.003), column


def stepped(dataset: Dataset, solver: str, frame: int) -> Any:
    """The solver after this frame of sequence 0."""
    source: Any = make_solver(solver)
    sequence = dataset.sequence(0)
    given = get_protocol("one-step").select_given(sequence.given)
    known = reveal(given, sequence.observed, dataset.truth(sequence))
    source.start(dataset.problem(sequence))
    for shown in islice(frames_of(sequence, given, known), frame + 1):
        source.step(shown)
    return source


@pytest.mark.parametrize("name", GOLDEN)
def test_finer_grids_change_little(dataset: Dataset, name: str) -> None:
    solver = text_reading() if name == "text" else name
    for instant in instants(dataset, dataset.sequence(0), solver, range(3, 12, 4)):
        source = stepped(dataset, solver, instant.frame)
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
