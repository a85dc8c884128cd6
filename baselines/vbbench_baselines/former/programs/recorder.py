"""Steps are written down, and put into a table for the kernel that takes them.

Empty arrays stand for what will be computed: views of one another show which numbers they share.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from vbbench_baselines.former.programs import steps
from vbbench_baselines.former.programs.steps import Numbers, Steps

Axis = tuple[int, list[int]]
"""How long it is, and how far apart the numbers of each array are along it."""
ALIGNED = 16
"""Arrays begin at multiples of so many numbers in the memory."""


class Operand(NamedTuple):
    """Numbers of the array ``owner`` from its ``start``-th on, ``gaps`` apart along each axis of a step."""

    owner: Numbers
    start: int
    gaps: tuple[int, ...]


class Written(NamedTuple):
    """What the kernel is given.

    Attributes
    ----------
    steps : [S, `steps.STEP_WIDTH`].
    memory : [M] before the first of them.
    inputs, outputs : where their numbers begin in the memory.
    """

    steps: Steps
    memory: Numbers
    inputs: list[int]
    outputs: list[int]


class Recorder:
    """Steps so far, and the numbers that are there before the first one."""

    def __init__(self) -> None:
        self._steps: list[tuple[int, tuple[int, ...], list[Operand]]] = []
        self._constants: list[Numbers] = []
        self._scalars: dict[float, Numbers] = {}

    def constant(self, values: Any) -> Numbers:
        """An array of values that are there from the beginning."""
        self._constants.append(np.array(values, np.float32, order="C"))
        return self._constants[-1]

    def scalar(self, value: float) -> Numbers:
        """A number that is there from the beginning."""
        if value not in self._scalars:
            self._scalars[value] = self.constant(value)
        return self._scalars[value]

    def note(self, what: int, result: Numbers, *operands: Numbers) -> None:
        """That ``result`` becomes what is done with operands, which are broadcast to its shape."""
        arrays = [result, *operands]
        self._note(what, sorted(_merged(_axes(result.shape, arrays)), key=_worth_while), arrays)

    def note_rows(self, what: int, result: Numbers, *operands: Numbers) -> None:
        """That each row of ``result`` [..., n], or [..., 1], becomes what is done with rows [..., n] of operands."""
        *outer, last = _axes(operands[0].shape, [result, *operands])
        self._note(what, [*_merged(outer), last], [result, *operands])

    def note_matrix_product(self, result: Numbers, a: Numbers, b: Numbers, added: Numbers) -> None:
        """That ``result`` [..., I, J] becomes ``added`` [J] and the product of a [..., I, K] and b [..., K, J]."""
        arrays = [result[..., :, None, :], a[..., :, :, None], b[..., None, :, :], added]
        shape = np.broadcast_shapes(*(array.shape for array in arrays))
        self._note(steps.MATRIX_PRODUCT, _axes(shape, arrays), arrays)

    def _note(self, what: int, axes: list[Axis], arrays: Sequence[Numbers]) -> None:
        """A step along the last three axes for each place along the others."""
        outer, inner = axes[: -steps.AXES], axes[-steps.AXES :]
        inner = [(1, [0] * len(arrays))] * (steps.AXES - len(inner)) + inner
        shape = tuple(length for length, _ in inner)
        for place in product(*(range(length) for length, _ in outer)):
            operands = [
                Operand(
                    owner := _owner_of(array),
                    _start(array, owner) + sum(i * gaps[n] for i, (_, gaps) in zip(place, outer, strict=True)),
                    tuple(gaps[n] for _, gaps in inner),
                )
                for n, array in enumerate(arrays)
            ]
            self._steps.append((what, shape, operands))

    def written(self, inputs: Sequence[Numbers], outputs: Sequence[Numbers]) -> Written:
        """What is written down, as a table; neither inputs nor outputs have gaps."""
        homes, size = self._homes([*self._constants, *map(_owner_of, inputs), *map(_owner_of, outputs)])
        table = np.zeros((len(self._steps), steps.STEP_WIDTH), np.int32)
        for row, (what, shape, operands) in zip(table, self._steps, strict=True):
            numbers = [what, *shape]
            for owner, start, gaps in operands:
                numbers += [homes[id(owner)] + start, *gaps]
            row[: len(numbers)] = numbers
        memory = np.zeros(size, np.float32)
        for values in self._constants:
            home = homes[id(values)]
            memory[home : home + values.size] = values.ravel()

        def place(array: Numbers) -> int:
            owner = _owner_of(array)
            return homes[id(owner)] + _start(array, owner)

        return Written(table, memory, list(map(place, inputs)), list(map(place, outputs)))

    def _homes(self, kept: Sequence[Numbers]) -> tuple[dict[int, int], int]:
        """Where each owner's numbers are, by its `id`, and how many there are in all.

        One that no later step needs makes room for the next of its size, unless it is ``kept``.
        """
        needed = {id(operand.owner): number for number, step in enumerate(self._steps) for operand in step[2]}
        homes: dict[int, int] = {}
        free: dict[int, list[int]] = {}
        size = 0
        for owner in kept:
            if id(owner) not in homes:
                homes[id(owner)], size = size, size + _room(owner)
                needed.pop(id(owner), None)
        for number, (_, _, operands) in enumerate(self._steps):
            owners = {id(operand.owner): operand.owner for operand in operands}
            for key, owner in owners.items():
                if key not in homes:
                    vacant = free.get(_room(owner))
                    homes[key] = vacant.pop() if vacant else size
                    size = max(size, homes[key] + _room(owner))
            for key, owner in owners.items():
                if needed.get(key) == number:
                    free.setdefault(_room(owner), []).append(homes[key])
        return homes, size


def _owner_of(array: Numbers) -> Numbers:
    """The array whose numbers this one shows."""
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


def _start(array: Numbers, owner: Numbers) -> int:
    """Which number of its owner is an array's first."""
    if array is owner:
        return 0
    first, begin = (one.__array_interface__["data"][0] for one in (array, owner))
    return int(first - begin) // array.itemsize


def _room(owner: Numbers) -> int:
    return -(-owner.size // ALIGNED) * ALIGNED


def _axes(shape: tuple[int, ...], arrays: Sequence[Numbers]) -> list[Axis]:
    """The length of each axis, and how far apart the numbers of each array are along it when it is broadcast."""
    gaps = [list(_gaps(array, shape)) for array in arrays]
    return [(length, [gap[axis] for gap in gaps]) for axis, length in enumerate(shape)]


def _gaps(array: Numbers, shape: tuple[int, ...]) -> Iterator[int]:
    missing = len(shape) - array.ndim
    yield from [0] * missing
    for length, stride, wanted in zip(array.shape, array.strides, shape[missing:], strict=True):
        if length not in (1, wanted):
            raise ValueError(f"an operand of the shape {array.shape} does not fit a step of the shape {shape}")
        yield 0 if length == 1 else stride // array.itemsize


def _worth_while(axis: Axis) -> tuple[bool, int]:
    """An axis after which others should come: the last one is a long one along which the result has no gaps."""
    length, gaps = axis
    return gaps[0] == 1 and length >= steps.LONG, length


def _merged(axes: list[Axis]) -> list[Axis]:
    """Axes without those of one place, and with one for neighbours that one can go along without a jump."""
    made: list[Axis] = []
    for length, gaps in axes:
        if length == 1:
            continue
        if made and made[-1][1] == [gap * length for gap in gaps]:
            made[-1] = (made[-1][0] * length, gaps)
        else:
            made.append((length, gaps))
    return made
