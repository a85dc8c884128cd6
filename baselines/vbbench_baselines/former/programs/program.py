"""The network as a program: written down once for each number of people, then run frame by frame by one kernel.

What goes into a frame and comes out of it are nested tuples of arrays, see `State`, `Answer`, `Told`.
"""

from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from threading import Lock
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

MOST_PROGRAMS = 64
"""Programs that are kept, for as many numbers of people; of 20 people one takes .6 MB."""

NOTHING = Measured(Motion(np.complex64(0.0), np.float32(0.0)), np.zeros(3, np.float32), np.float32(0.0))
"""What odometry says where there is none."""


class Kind(NamedTuple):
    """Of an array its shape, and whether it has points."""

    shape: tuple[int, ...]
    points: bool


class Program(NamedTuple):
    """Steps, and the `Kind` of each array that goes in and comes out, in nested tuples."""

    written: Written
    inputs: Any
    outputs: Any


class Programs:
    """Programs of a network with these weights; see `vbbench_baselines.former.network.Birdifier`.

    Once written down they do not change, and serve all who follow with them, in any thread.
    """

    def __init__(self, weights: Weights, feet: bool, heads: bool = True) -> None:
        self.weights, self.feet, self.heads = weights, feet, heads
        self._programs: OrderedDict[int, Program] = OrderedDict()
        self._writing = Lock()

    def __deepcopy__(self, memo: Mapping[int, Any]) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return Programs, (self.weights, self.feet, self.heads)

    def of(self, people: int) -> Program:
        """The program for so many people."""
        with self._writing:
            if people not in self._programs:
                self._programs[people] = self._written_down(people)
                if len(self._programs) > MOST_PROGRAMS:
                    self._programs.popitem(last=False)
            self._programs.move_to_end(people)
            return self._programs[people]

    def _written_down(self, people: int) -> Program:
        """The program, whose weights lie in memory as rows that are added up, and not as `layers.shapes` has them."""
        recorder = Recorder()
        weights = {name: Cells(recorder, recorder.constant(values.T).T) for name, values in self.weights.items()}
        network = Network(NotingOperations(), weights)
        birdifier = Birdifier(network, pure=is_pure(self.weights), feet=self.feet, heads=self.heads)
        inputs = _inputs(people, recorder)
        outputs = _each(birdifier.advance(*inputs), Cells.without_gaps)
        written = recorder.written(*([cells.numbers for cells in leaves(some)] for some in (inputs, outputs)))
        return Program(written, _each(inputs, _kind), _each(outputs, _kind))


class Following:
    """Frame after frame by a program, in a memory of its own.

    Parameters
    ----------
    programs : to follow with.
    people : how many there are.
    """

    def __init__(self, programs: Programs, people: int) -> None:
        self._programs, self._people = programs, people
        program = programs.of(people)
        self._steps, self._memory = program.written.steps, program.written.memory.copy()
        starts, inputs = iter(program.written.outputs), leaves(program.inputs, Kind)
        self._inputs = list(map(self._view, inputs, program.written.inputs))
        self._outputs = _each(program.outputs, lambda kind: self._view(kind, next(starts)), Kind)

    def __reduce__(self) -> tuple[Any, ...]:
        return Following, (self._programs, self._people)

    def advance(self, state: State, sights: Sights, told: Told, dt: Array, spread: Array) -> tuple[State, Answer]:
        """See `vbbench_baselines.former.network.Birdifier.advance`; of one sequence, without an axis of batches."""
        told = told._replace(measured=told.measured or NOTHING)
        for view, values in zip(self._inputs, leaves((state, sights, told, dt, spread)), strict=True):
            view[...] = values
        take_steps(self._steps, self._memory)
        made: tuple[State, Answer] = _each(self._outputs, np.ndarray.copy)
        return made

    def _view(self, kind: Kind, start: int) -> Array:
        """The array that begins there in the memory."""
        view = self._memory[start : start + int(np.prod(kind.shape)) * (1 + kind.points)]
        return (view.view(np.complex64) if kind.points else view).reshape(kind.shape)


def _inputs(people: int, recorder: Recorder) -> tuple[State, Sights, Told, Array, Array]:
    """Cells for what goes into a frame of one sequence, without an axis of batches."""
    k, numbers, points = people, partial(_empty, recorder, False), partial(_empty, recorder, True)
    seen, ray, noise, cut = numbers(k), points(k), numbers(k, 3), numbers(k, 3)
    sights = Sights(seen, ray, by_height=numbers(k), by_feet=numbers(k), has_feet=numbers(k), noise=noise, cut=cut)
    measured = Measured(Motion(points(), numbers()), numbers(3), numbers())
    told = Told(points(k), numbers(k), Motion(points(), numbers()), numbers(), measured)
    return nothing_seen(numbers, points, k), sights, told, numbers(), numbers()


def _empty(recorder: Recorder, points: bool, *shape: int) -> Cells:
    return Cells.empty(recorder, shape, points=points)


def _kind(cells: Cells) -> Kind:
    return Kind(cells.shape, cells.points)


def _each(tree: Any, do: Callable[[Any], Any], leaf: type = np.ndarray) -> Any:
    """Nested tuples with what is done with each leaf in its place; a ``leaf`` may itself be a tuple."""
    if isinstance(tree, tuple) and not isinstance(tree, leaf):
        made = [_each(branch, do, leaf) for branch in tree]
        return type(tree)(*made) if hasattr(tree, "_fields") else tuple(made)
    return do(tree)


def leaves(tree: Any, leaf: type = np.ndarray) -> Iterator[Any]:
    """Those of nested tuples; a ``leaf`` may itself be a tuple."""
    if isinstance(tree, tuple) and not isinstance(tree, leaf):
        for branch in tree:
            yield from leaves(branch, leaf)
    else:
        yield tree
