"""The learned solver's programs compute what NumPy computes with the same network: each operation, and whole frames."""

import copy
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.numpy_operations import NumpyOperations
from tests.solver_runs import CAMERAS, problem_of, see, walk
from vbbench_baselines.former.layers import Network, first_weights, is_pure
from vbbench_baselines.former.network import Answer, Birdifier, Told
from vbbench_baselines.former.pose_fit import Measured, Motion
from vbbench_baselines.former.programs import program
from vbbench_baselines.former.programs.cells import Cells
from vbbench_baselines.former.programs.noting import NotingOperations
from vbbench_baselines.former.programs.program import Following, Programs
from vbbench_baselines.former.programs.recorder import Recorder
from vbbench_baselines.former.programs.steps import take_steps
from vbbench_baselines.former.sights import sights_of
from vbbench_baselines.former.solver import VbFormer, bundled_programs
from vbbench_baselines.former.state import nothing_seen

RNG = np.random.default_rng(0)
ONE = np.float32(1.0)


def numbers(*shape: int) -> Any:
    return RNG.normal(size=shape).astype(np.float32)


def points(*shape: int) -> Any:
    return (numbers(*shape) + 1j * numbers(*shape)).astype(np.complex64)


CASES: dict[str, tuple[Callable[..., Any], ...]] = {
    "sums of numbers": (lambda xp, a, b: a + b, numbers(5, 3), numbers(3)),
    "sums of long rows": (lambda xp, a, b: (a + b) * (a - b) / (2.0 + a * a), numbers(3, 20), numbers(3, 20)),
    "sums with long columns": (lambda xp, a, b: a + b[..., None], numbers(20, 3), numbers(20)),
    "sums of points and numbers": (lambda xp, a, b: a + b, points(5), numbers(5)),
    "differences": (lambda xp, a, b: a - b, numbers(4, 1), points(4, 3)),
    "with plain numbers": (lambda xp, a: (1.0 - a) / 3.0 + 2.0 / a, numbers(5)),
    "products of points": (lambda xp, a, b: a * b, points(5, 4), points(5, 1)),
    "products of points and numbers": (lambda xp, a, b: a * b[..., None], points(5, 4), numbers(5)),
    "products of scalars and points": (lambda xp, a, b: a * b[..., None, None], points(5, 2, 3), points()),
    "quotients": (lambda xp, a, b: a / b, points(5), numbers(5)),
    "conjugates": (lambda xp, a: a.conj() * a, points(4)),
    "opposites": (lambda xp, a: -a, points(4)),
    "powers": (lambda xp, a: (a**2 + 1.0) ** -0.5, numbers(6)),
    "sums along the last axis": (lambda xp, a: a.sum(-1), numbers(5, 4)),
    "sums along another axis": (lambda xp, a: a.sum(-2), numbers(5, 4)),
    "sums of points along an axis": (lambda xp, a: a.sum(-1), points(3, 5)),
    "sums of nothing": (lambda xp, a: a.sum(-1), numbers(3, 0)),
    "choices": (lambda xp, a, b, c: xp.where((a > 0.1) | (c < 0.0), b, 0.5 * b), numbers(9), points(9), numbers(9)),
    "bounds": (lambda xp, a: xp.clip(a, -0.5, 0.5), numbers(50)),
    "bounds of what is no number": (lambda xp, a: xp.clip(a, -0.5, 0.5), np.array([np.nan, 1.0], np.float32)),
    "exponentials and logarithms": (lambda xp, a: xp.log(xp.exp(a) + xp.sqrt(a * a)), numbers(7)),
    "logarithms of what has none": (lambda xp, a: xp.log(a), np.array([-1.0, 0.0, 1.0], np.float32)),
    "hyperbolic functions": (lambda xp, a: xp.asinh(3.0 * a) + xp.tanh(a), numbers(7)),
    "gates": (lambda xp, a: xp.silu(a) + xp.sigmoid(a), numbers(7)),
    "gates with gaps": (lambda xp, a: xp.silu(a.swapaxes(-1, -2)) + xp.exp(a[..., 0])[..., None], 9.0 * numbers(4, 4)),
    "exponentials far off": (lambda xp, a: xp.exp(a), np.array([-87.0, -40.0, 0.0, 88.0, np.nan], np.float32)),
    "shares with gaps": (lambda xp, a: xp.softmax(a.swapaxes(-1, -2)), numbers(5, 4)),
    "shares of few": (lambda xp, a: xp.softmax(a), np.array([[0.0, -1e4, 1.0], [-1e4, 0.0, np.nan]], np.float32)),
    "directions": (lambda xp, a: xp.direction(a), numbers(5)),
    "angles": (lambda xp, a: xp.angle(a), points(50)),
    "points": (lambda xp, a, b: a + xp.point(b[..., 0], b[..., 1]) * (0.3 * a.real), points(), numbers(3)),
    "pairs": (lambda xp, a: 2.0 * xp.pairs(a), points(5, 4)),
    "totals": (lambda xp, a, b: xp.stack(xp.totals([a, b])), numbers(5), numbers(5)),
    "stacks": (lambda xp, a, b: xp.stack([a, b]), numbers(5), numbers(5)),
    "stacks of scalars": (lambda xp, a, b: xp.stack([a, b]), numbers(), numbers()),
    "joints": (lambda xp, a, b: xp.join([a, b]), points(5, 2), points(5, 1)),
    "one row more": (lambda xp, a, b: xp.append_row(a, b), numbers(5, 2), numbers(2)),
    "rows": (lambda xp, a: 1.0 * a[..., :-1, :] - a[..., -1, :], numbers(4, 3)),
    "other shapes": (lambda xp, a: (1.0 * a).reshape((5, 6)), numbers(5, 2, 3)),
    "other shapes of other axes": (lambda xp, a: a.swapaxes(-1, -2).reshape((5, 6)), numbers(5, 2, 3)),
    "four axes": (lambda xp, a: 1.0 * a.swapaxes(-1, -3), numbers(2, 3, 4, 5)),
    "linear layers": (lambda xp, a, w, b: xp.linear(a, w, b), numbers(5, 4), numbers(6, 4), numbers(6)),
    "linear layers of one": (lambda xp, a, w, b: xp.linear(a, w, b), numbers(4), numbers(6, 4), numbers(6)),
    "normal layers": (lambda xp, a, w, b: xp.normalise(a, w, b), numbers(5, 4), numbers(4), numbers(4)),
    "shares": (lambda xp, a: xp.softmax(a), numbers(3, 5, 4)),
    "products of matrices with odd sides": (lambda xp, a, b: a @ b, numbers(5, 7), numbers(7, 3)),
    "products of matrices": (lambda xp, a, b: a @ b.swapaxes(-1, -2), numbers(3, 5, 4), numbers(3, 6, 4)),
}


def view(memory: Any, start: int, cells: Cells) -> Any:
    made = memory[start : start + cells.numbers.size]
    return (made.view(np.complex64) if cells.points else made).reshape(cells.shape)


@pytest.mark.parametrize("case", CASES)
def test_each_operation_is_numpys(case: str) -> None:
    do, *arrays = CASES[case]
    recorder = Recorder()
    cells = [Cells.empty(recorder, array.shape, points=np.iscomplexobj(array)) for array in arrays]
    made = do(NotingOperations(), *cells)
    written = recorder.written([one.numbers for one in cells], [made.numbers])
    for start, one, array in zip(written.inputs, cells, arrays, strict=True):
        view(written.memory, start, one)[...] = array
    take_steps(written.steps, written.memory)
    with np.errstate(all="ignore"):
        wanted = do(NumpyOperations(), *arrays)
    np.testing.assert_allclose(view(written.memory, written.outputs[0], made), wanted, rtol=2e-5, atol=1e-6)


MISTAKES: dict[str, tuple[type[Exception], Callable[..., Any]]] = {
    "lengths that do not fit": (ValueError, lambda xp, a, b, p: xp.clip(a, -1.0, 1.0) + b),
    "points among numbers": (TypeError, lambda xp, a, b, p: xp.join([a, p])),
    "a choice of either": (TypeError, lambda xp, a, b, p: xp.where(a > 0.0, p, a)),
    "a function of points": (TypeError, lambda xp, a, b, p: xp.exp(p)),
    "a power of points": (TypeError, lambda xp, a, b, p: p**-0.5),
    "a division by points": (TypeError, lambda xp, a, b, p: a / p),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_what_no_step_does_is_refused(case: str) -> None:
    error, do = MISTAKES[case]
    recorder = Recorder()
    cells = Cells.empty(recorder, (5,)), Cells.empty(recorder, (2,)), Cells.empty(recorder, (5,), points=True)
    with pytest.raises(error):
        do(NotingOperations(), *cells)


def some_weights(*, pure: bool) -> dict[str, Any]:
    return {name: values.astype(np.float32) for name, values in first_weights(np.random.default_rng(1), pure).items()}


def measured(sure: bool) -> Measured:
    motion, information = Motion(np.complex64(0.1 + 0.01j), np.float32(0.02)), np.array([9.0, 16.0, 25.0], np.float32)
    return Measured(motion, information, np.float32(sure))


def follow(network: Any, people: int, said: Measured | None = None) -> list[Answer]:
    """What a network answers on a walk; nothing is given but the first pose, and some places in the third frame."""
    sequence = see(walk(0, people=people), CAMERAS[0], 1.0)
    problem, still, answers = problem_of(sequence, CAMERAS[0], 1.0), Motion(np.complex64(0.0), np.float32(0.0)), []
    state = nothing_seen(lambda *n: np.zeros(n, np.float32), lambda *n: np.zeros(n, np.complex64), people)
    for t, boxes in enumerate(sequence.observations):
        placed = ((np.arange(people) % 3 == 0) & (t == 2)).astype(np.float32)
        told = Told(np.full(people, 3.0 + 1.0j, np.complex64), placed, still, ONE * (t == 0), said)
        with np.errstate(all="ignore"):
            state, answer = network.advance(state, sights_of(problem, boxes), told, np.float32(0.4), np.float32(0.04))
        answers.append(answer)
    return answers


@pytest.mark.parametrize("pure", [False, True])
@pytest.mark.parametrize("feet", [False, True])
@pytest.mark.parametrize("people", [0, 1, 2, 9])
@pytest.mark.parametrize("said", [None, measured(False), measured(True)], ids=["alone", "measured", "sure"])
def test_frames_are_numpys(pure: bool, feet: bool, people: int, said: Measured | None) -> None:
    weights = some_weights(pure=pure)
    plain = Birdifier(Network(NumpyOperations(), weights), is_pure(weights), feet)
    wanted = follow(plain, people, said)
    for found, answer in zip(
        follow(Following(Programs(weights, feet=feet), people), people, said), wanted, strict=True
    ):
        for one, other in zip(program.leaves(found), program.leaves(answer), strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-3, atol=2e-4)


def test_who_follows_with_the_same_programs_is_not_disturbed() -> None:
    programs = Programs(some_weights(pure=False), feet=True)
    alone = follow(Following(programs, 5), 5)

    class InTurn:
        """Another, who follows elsewhere, has a frame between any two."""

        def __init__(self) -> None:
            self.one, self.other = Following(programs, 5), Following(programs, 5)

        def advance(self, *inputs: Any) -> Any:
            made = self.one.advance(*inputs)
            self.other.advance(*inputs[:3], np.float32(0.7), np.float32(0.2))
            return made

    for found, answer in zip(follow(InTurn(), 5), alone, strict=True):
        np.testing.assert_array_equal(found.places, answer.places)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy])
def test_copies_answer_alike(copied: Callable[[Following], Following]) -> None:
    following = Following(Programs(some_weights(pure=False), feet=True), 3)
    wanted = follow(following, 3)
    for found, answer in zip(follow(copied(following), 3), wanted, strict=True):
        np.testing.assert_array_equal(found.places, answer.places)


def test_no_more_programs_are_kept_than_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(program, "MOST_PROGRAMS", 2)
    written = []
    monkeypatch.setattr(Recorder, "written", lambda *given, do=Recorder.written: written.append(1) or do(*given))
    programs = Programs(some_weights(pure=False), feet=True)
    first = [follow(Following(programs, people), people)[-1].places for people in (2, 3, 2, 4, 3)]
    assert len(written) == 4, "2, 3 and 4, and 3 again once 4 has taken its place"
    np.testing.assert_array_equal(first[0], first[2])
    np.testing.assert_array_equal(first[1], first[4])


def test_a_solver_takes_other_weights_at_its_next_start() -> None:
    solver, problem = (
        VbFormer(weights=some_weights(pure=False)),
        problem_of(see(walk(0, people=2), CAMERAS[0], 1.0), CAMERAS[0], 1.0),
    )
    used = []
    for changes in ({}, {}, {"feet": False}, {"weights": some_weights(pure=True)}, {"weights": None}):
        for name, value in changes.items():
            setattr(solver, name, value)
        solver.start(problem)
        used.append(solver._following._programs)
    assert used[0] is used[1]
    assert len({id(programs) for programs in used}) == 4
    assert used[-1] is bundled_programs("vb-former", False, True)
