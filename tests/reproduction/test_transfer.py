"""The study of transfer: people between frames, variants of solvers, and errors that count as the cap."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, problem_of, see, walk
from vbbench.errors import VbbenchError
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.protocol import get_protocol
from vbbench.registry import load, make_solver
from vbbench.reproduction.grid import Making
from vbbench.reproduction.transfer import errors_of, people_as_text
from vbbench.reproduction.variants import registered_variants
from vbbench.scene import Scene
from vbbench.solver import FrameSolver, Problem
from vbbench.solving.runner import run_sequence
from vbbench_baselines.variants import FACTORIES, Misinformed


def test_people_between_frames_are_on_a_smooth_curve_and_nobody_is_extrapolated() -> None:
    time = 0.4 * np.arange(8)
    walk = np.column_stack([1.2 * time, 0.3 * time**2])
    places = np.full((8, 2, 2), np.nan)
    places[:, 0], places[[1, 2, 5], 1] = walk, walk[[1, 2, 5]] + 3.0
    scene = Scene(name="two", dt=0.4, people=np.array([4, 7]), positions=places, heights=np.full(2, 1.7))
    rows = np.array([line.split() for line in people_as_text(scene, 0.1).splitlines()], float)
    assert rows[rows[:, 1] == 4][:, 0].tolist() == list(range(29))
    assert rows[rows[:, 1] == 7][:, 0].tolist() == [4, 5, 6, 7, 8]
    first = rows[rows[:, 1] == 4]
    np.testing.assert_allclose(first[:, 2:], np.column_stack([0.12 * first[:, 0], 0.003 * first[:, 0] ** 2]), atol=1e-4)


def test_there_are_enough_variants_and_all_of_them_start() -> None:
    variants = registered_variants()
    assert len(variants) >= 20
    assert sum(variant.feet for variant in variants.values()) >= 5
    assert sum(not variant.feet for variant in variants.values()) >= 15
    for variant in variants.values():
        assert hasattr(make_solver(variant.solver), "step") or hasattr(make_solver(variant.solver), "solve")


def test_no_two_variants_are_the_same() -> None:
    made = [str(vars(factory())) + type(factory()).__name__ for factory in FACTORIES.values()]
    assert len(set(made)) == len(made)


def test_answers_of_variants_with_feet_alone_follow_their_rows() -> None:
    """Rows say nothing to the others: boxes 20 px lower have the same answers."""
    sequence = see(walk(0), CAMERAS[0], 1.0)
    lower = replace(sequence, observations=sequence.observations + np.array([0.0, 20.0, 0.0]))
    problem, protocol = problem_of(sequence, CAMERAS[0], 1.0), get_protocol("sequential")
    for name, variant in registered_variants().items():
        answers = [run_sequence(make_solver(variant.solver), problem, s, protocol, None)[0] for s in (sequence, lower)]
        same = np.allclose(answers[0].positions, answers[1].positions, rtol=0.0, atol=1e-6, equal_nan=True)
        assert same != variant.feet, name


def test_an_unknown_variant_is_named() -> None:
    with pytest.raises(VbbenchError, match="no variant is called map-casual"):
        load("solver", "vbbench_baselines.variants:map-casual")


def test_an_error_above_the_cap_and_none_count_as_the_cap(tmp_path: Path) -> None:
    dataset = generate("demo", tmp_path / "demo" / "dataset", Options(limit=3))
    cell = Making().cell(dataset, "cv", "sequential")
    figures = cell.score.per_sequence.figures["dx"]
    far = {**cell.score.per_sequence.figures, "dx": np.where(np.arange(3) == 0, 1e5, np.nan)}
    other = replace(cell.score, per_sequence=replace(cell.score.per_sequence, figures=far))
    errors = errors_of([cell, replace(cell, score=other)], "dx")
    cap = cell.score.protocol.caps["dx"]
    assert (errors.values[1] == cap).all()
    np.testing.assert_array_equal(errors.values[0], np.minimum(figures, cap))


class Listening:
    """Keeps the noise that it was given."""

    given = 0.0

    def start(self, problem: Problem) -> None:
        self.given = problem.pixel_std

    step = None


def test_a_misinformed_solver_gets_another_noise() -> None:
    problem, listening = problem_of(see(walk(0), CAMERAS[0], 1.0), CAMERAS[0], 1.0), Listening()
    solver: Any = listening
    Misinformed(solver, 4.0).start(problem)
    assert listening.given == 4.0 * problem.pixel_std == 4.0
    assert isinstance(Misinformed(solver, 4.0), FrameSolver)
