"""The network as a program: written down once for each number of people, then run frame by frame by one kernel.

What goes into a frame and comes out of it are nested tuples of arrays, see `State`, `Answer`, `Told`.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple, Self

import numpy as np

from vbbench_baselines.former.layers import Network, is_pure
from vbbench_baselines.former.network import Answer, Birdifier, Told
from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.pose_fit import Measured, Motion
from vbbench_baselines.former.programs.cells import Cells
from vbbench_baselines.former.programs.noting import NotingOperations
from vbbench_baselines.former.programs.recorder import Recorder, Written
from vbbench_baselines.former.programs.steps import take_steps
from vbbench_baselines.former.sights import Sights
from vbbench_baselines.former.state import State, nothing_seen
from vbbench_baselines.former.weights import Weights

MOST_PROGRAMS = 32
"""Programs that are kept, for as many numbers of people; each takes about 1 MB."""


class Kind(NamedTuple):
    """What programs differ by: how many ``people`` there are, and whether what is ``measured`` is sure."""

    people: int
    measured: bool | None


class Program(NamedTuple):
    """Steps, and the `Cells` of what goes in and comes out."""

    written: Written
    inputs: Any
    outputs: Any


class Programs:
    """Programs of a network with these weights; see `vbbench_baselines.former.network.Birdifier`.

    Once written down they do not change, and serve all who follow with them.
    """

    def __init__(self, weights: Weights, *, feet: bool) -> None:
        self._weights, self._feet = weights, feet
        self._programs: OrderedDict[Kind, Program] = OrderedDict()

    def __deepcopy__(self, memo: Mapping[int, Any]) -> Self:
        return self

    def of(self, kind: Kind) -> Program:
        """The program for frames of a kind."""
        if kind not in self._programs:
            self._programs[kind] = self._program(kind)
            if len(self._programs) > MOST_PROGRAMS:
                self._programs.popitem(last=False)
        self._programs.move_to_end(kind)
        return self._programs[kind]

    def _program(self, kind: Kind) -> Program:
        recorder = Recorder()
        weights = {name: Cells(recorder, recorder.constant(values.T).T) for name, values in self._weights.items()}
        birdifier = Birdifier(Network(NotingOperations(), weights), is_pure(self._weights), self._feet)
        cells = _inputs(kind, recorder)
        made = birdifier.advance(*cells)
        return Program(recorder.written([*map(_numbers, leaves(cells))], [*map(_numbers, leaves(made))]), cells, made)


class Following:
    """Frame after frame by programs, in a memory of its own.

    Parameters
    ----------
    programs : to follow with.
    people : how many there are; if others come, their program is written down then.
    """

    def __init__(self, programs: Programs, people: int) -> None:
        self._programs = programs
        self._prepare(Kind(people, None))

    def __reduce__(self) -> tuple[Any, ...]:
        return Following, (self._programs, self._kind.people)

    def advance(self, state: State, sights: Sights, told: Told, dt: Array, spread: Array) -> tuple[State, Answer]:
        """See `vbbench_baselines.former.network.Birdifier.advance`; of one sequence, without an axis of batches."""
        kind = Kind(len(sights.seen), None if told.measured is None else told.measured.sure)
        if kind != self._kind:
            self._prepare(kind)
        for view, values in zip(self._inputs, leaves((state, sights, told, dt, spread)), strict=True):
            view[...] = values
        take_steps(self._steps, self._memory)
        made: tuple[State, Answer] = _each(self._outputs, np.ndarray.copy)
        return made

    def _prepare(self, kind: Kind) -> None:
        written, given, made = self._programs.of(kind)
        self._kind, self._steps, self._memory = kind, written.steps, written.memory.copy()
        self._inputs = list(map(self._view, leaves(given), written.inputs))
        starts = iter(written.outputs)
        self._outputs = _each(made, lambda cells: self._view(cells, next(starts)))

    def _view(self, cells: Cells, start: int) -> Array:
        """The numbers or points of cells that begin there in the memory."""
        view = self._memory[start : start + cells.numbers.size]
        return (view.view(np.complex64) if cells.points else view).reshape(cells.shape)


def _inputs(kind: Kind, recorder: Recorder) -> tuple[State, Sights, Told, Array, Array]:
    """Cells for what goes into a frame of one sequence, without an axis of batches."""
    k, numbers = kind.people, partial(_empty, recorder, False)
    points = partial(_empty, recorder, True)
    seen, ray, noise, cut = numbers(k), points(k), numbers(k, 3), numbers(k, 3)
    sights = Sights(seen, ray, by_height=numbers(k), by_feet=numbers(k), has_feet=numbers(k), noise=noise, cut=cut)
    measured = None if kind.measured is None else Measured(Motion(points(), numbers()), numbers(3), kind.measured)
    told = Told(points(k), numbers(k), Motion(points(), numbers()), numbers(), measured)
    return nothing_seen(numbers, points, k), sights, told, numbers(), numbers()


def _empty(recorder: Recorder, points: bool, *shape: int) -> Cells:
    return Cells.empty(recorder, shape, points=points)


def _numbers(cells: Cells) -> Array:
    return cells.numbers


def _each(tree: Any, do: Callable[[Any], Any]) -> Any:
    """Nested tuples with what is done with each array in its place; what is no array stays."""
    if isinstance(tree, tuple):
        made = [_each(branch, do) for branch in tree]
        return type(tree)(*made) if hasattr(tree, "_fields") else tuple(made)
    return tree if tree is None or isinstance(tree, bool) else do(tree)


def leaves(tree: Any) -> Iterator[Any]:
    """The arrays in nested tuples."""
    if isinstance(tree, tuple):
        for branch in tree:
            yield from leaves(branch)
    elif tree is not None and not isinstance(tree, bool):
        yield tree
