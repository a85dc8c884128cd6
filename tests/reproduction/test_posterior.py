"""The posteriors of a frame: golden figures, finer grids, and solvers without one."""

from itertools import islice
from typing import Any

import numpy as np
import pandas as pd
import pytest

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.registry import make_solver
from vbbench.reproduction.density import find_density
from vbbench.reproduction.posterior import (
    FIGURES,
    SOLVER,
    WINDOW,
    FrameSample,
    instants,
    pick_examples,
    posterior_rows,
    spreads,
    text_reading,
)
from vbbench.scoring.block_bootstrap import Timeline
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
    ("solver", "message"), [("vb-cv", "no pose_energy"), ("map-batch", "no pose_energy"), ("vb-fs", "mean 'vb-sf'")]
)
def test_a_solver_without_posterior_is_refused(dataset: Dataset, solver: str, message: str) -> None:
    with pytest.raises(VbbenchError, match=message):
        posterior_rows(dataset, solver, 0, 1)


def heading(*degrees: float) -> FloatArray:
    """Velocities [1, K, 2] of 1 m/s."""
    angle = np.radians(degrees)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[None]


@pytest.mark.parametrize(
    ("velocity", "directions", "lines"),
    [
        (heading(30, 30, 30), 0.0, 0.0),
        (heading(30, 210), 1.0, 0.0),
        (heading(0, 90), 1.0 - np.sqrt(0.5), 1.0),
        (heading(0, 90, 180, 270), 1.0, 1.0),
        (np.concatenate([heading(30, 30), 0.1 * heading(120, 0), heading(90) * np.nan], axis=1), 0.0, 0.0),
        (np.zeros((1, 3, 2)), np.nan, np.nan),
    ],
)
def test_spreads_of_directions_and_of_lines(velocity: FloatArray, directions: float, lines: float) -> None:
    spread, of_lines = spreads(velocity)
    assert (spread[0], of_lines[0]) == pytest.approx((directions, lines), abs=1e-12, nan_ok=True)


def walking(sequence: int, velocity: FloatArray, frames: int = WINDOW + 3) -> dict[str, Any]:
    """A sequence in which an observer and the people of ``velocity`` [1, K, 2] walk on."""
    spread, lines = (np.repeat(values, frames) for values in spreads(velocity))
    people = np.full(frames, velocity.shape[1] - 1)
    numbers = {"sequence": np.full(frames, sequence), "frame": np.arange(2, frames + 2), "people": people}
    return {**numbers, "spread": spread, "lines": lines}


def joined(walks: list[dict[str, Any]]) -> dict[str, Any]:
    return {name: np.concatenate([walk[name] for walk in walks]) for name in walks[0]}


def test_the_rule_finds_parallel_and_crossing_walks_with_few_and_with_more_people() -> None:
    walks = [
        walking(0, heading(0, 20, 50, 70)),
        walking(1, heading(0, 1, 2, 3)),  # few, parallel
        walking(2, heading(0, 90, 180, 265)),  # few, crossing
        walking(3, heading(0, 180, 0, 180)),  # opposite ways of one line do not cross
        walking(4, heading(0, 0, 1, 2, 3, 4, 5)),  # more, parallel
        walking(5, heading(0, 60, 120, 180, 240, 300, 90)),  # more, crossing
        walking(6, heading(*range(0, 360, 20))),  # too many for a picture
        walking(7, heading(0, 0, 0, 0), frames=WINDOW - 1),  # too short
    ]
    found = pick_examples(joined(walks))
    assert [(one.title, one.sequence) for one in found] == [
        ("3 people, parallel", 1),
        ("3 people, crossing", 2),
        ("5 to 12 people, parallel", 4),
        ("5 to 12 people, crossing", 5),
    ]
    assert found[0].frames == range(2, 2 + WINDOW)
    assert pick_examples(walks[7]) == []


def test_where_no_stretch_has_three_people_throughout_the_sparsest_counts() -> None:
    mixed = walking(0, heading(0, 10, 20, 30))
    people = np.where(np.arange(len(mixed["people"])) % 2, 3, 4)
    found = pick_examples({**mixed, "people": people})
    assert [one.title for one in found] == ["3 to 4 people, parallel", "3 to 4 people, crossing"]


def sample(sequences: int = 60, frames: int = 20) -> FrameSample:
    first = 5 * np.arange(sequences)
    timeline = Timeline.of(np.zeros(sequences, np.int64), first, first + frames - 1)
    sequence = np.repeat(np.arange(sequences), frames)
    return FrameSample(sequence=sequence, timeline=timeline)


def test_ranks_are_correlated_with_an_interval() -> None:
    rng = np.random.default_rng(0)
    frames = sample()
    people = rng.integers(3, 9, len(frames.sequence)).astype(np.float64)
    entropy = -2.0 * people + rng.normal(0.0, 1.0, len(people))
    found = frames.rank_correlation(people, entropy)
    assert found.value == pytest.approx(pd.Series(people).corr(pd.Series(entropy), method="spearman"))
    assert found.low < found.value < found.high < -0.7


def test_what_never_varies_has_no_correlation_and_no_interval() -> None:
    frames = sample(sequences=3, frames=2)
    found = frames.rank_correlation(np.arange(6.0), np.ones(6))
    assert np.isnan([found.value, found.low, found.high]).all()
