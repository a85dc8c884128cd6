"""What stands for an array while a network is written down: it has a shape, and whatever is done with it is noted.

A point is two numbers side by side, forward and left.
"""

from types import EllipsisType
from typing import Any

import numpy as np

from vbbench_baselines.former import steps
from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.recorder import Numbers, Recorder

Index = int | slice | EllipsisType | None
Value = Any
"""`Cells`, or a plain number."""


class Cells:
    """An array of numbers, or of points.

    Parameters
    ----------
    recorder : who notes what is done with it.
    numbers : its place, [...]; of points [..., 2].
    points : whether it has points.
    """

    def __init__(self, recorder: Recorder, numbers: Numbers, points: bool = False) -> None:
        self.recorder, self.numbers, self.points = recorder, numbers, points

    @classmethod
    def empty(cls, recorder: Recorder, shape: tuple[int, ...], *, points: bool = False) -> "Cells":
        """Of a shape, for numbers that are to come."""
        return cls(recorder, np.empty((*shape, 2) if points else shape, np.float32), points)

    @property
    def shape(self) -> tuple[int, ...]:
        """As of an array."""
        return self.numbers.shape[:-1] if self.points else self.numbers.shape

    @property
    def real(self) -> "Cells":
        """Forward."""
        return self._part(0)

    @property
    def imag(self) -> "Cells":
        """To the left."""
        return self._part(1)

    def _part(self, number: int) -> "Cells":
        return Cells(self.recorder, self.numbers[..., number])

    def conj(self) -> "Cells":
        """Points whose left is right."""
        return self._made(steps.MULTIPLY, self.shape, True, self.numbers, self.recorder.constant([1.0, -1.0]))

    def __getitem__(self, index: Index | tuple[Index, ...]) -> "Cells":
        index = index if isinstance(index, tuple) else (index,)
        if self.points and Ellipsis in index:
            index = (*index, slice(None))
        return Cells(self.recorder, self.numbers[index], self.points)

    def reshape(self, shape: tuple[int, ...]) -> "Cells":
        """As of an array."""
        wanted = (*shape, 2) if self.points else shape
        made = self.numbers.reshape(wanted)
        if not np.may_share_memory(made, self.numbers):
            self.recorder.note(steps.COPY, made.reshape(self.numbers.shape), self.numbers)
        return Cells(self.recorder, made, self.points)

    def swapaxes(self, one: int, other: int) -> "Cells":
        """As of an array of numbers."""
        return Cells(self.recorder, self.numbers.swapaxes(one, other))

    def sum(self, axis: int) -> "Cells":
        """As of an array."""
        along = np.moveaxis(self.numbers, axis % len(self.shape), -1)
        made = np.empty(along.shape[:-1], np.float32)
        self.recorder.note_rows(steps.SUM, made[..., None], along)
        return Cells(self.recorder, made, self.points)

    def __add__(self, other: Value) -> "Cells":
        return self._plus(steps.ADD, other)

    __radd__ = __add__

    def __sub__(self, other: Value) -> "Cells":
        return self._plus(steps.SUBTRACT, other)

    def __rsub__(self, other: Value) -> "Cells":
        return _cells(self.recorder, other) - self

    def _plus(self, what: int, other: Value) -> "Cells":
        other = _cells(self.recorder, other)
        if self.points == other.points:
            return self._made(what, _shape(self, other), self.points, self.numbers, other.numbers)
        made, zero = Cells.empty(self.recorder, _shape(self, other), points=True), _cells(self.recorder, 0.0)
        ahead, left = (
            [(getattr(cells, part) if cells.points else plain).numbers for cells, plain in ((self, one), (other, two))]
            for part, one, two in (("real", self, other), ("imag", zero, zero))
        )
        self.recorder.note(what, made.real.numbers, *ahead)
        self.recorder.note(what, made.imag.numbers, *left)
        return made

    def __mul__(self, other: Value) -> "Cells":
        other = _cells(self.recorder, other)
        if not (self.points and other.points):
            return self._times(steps.MULTIPLY, other)
        made = Cells.empty(self.recorder, _shape(self, other), points=True)
        a, b, c, d = (cells.numbers for cells in (self.real, self.imag, other.real, other.imag))
        self.recorder.note(steps.SUBTRACT_PRODUCTS, made.real.numbers, a, c, b, d)
        self.recorder.note(steps.ADD_PRODUCTS, made.imag.numbers, a, d, b, c)
        return made

    __rmul__ = __mul__

    def __truediv__(self, other: Value) -> "Cells":
        return self._times(steps.DIVIDE, _cells(self.recorder, other))

    def __rtruediv__(self, other: Value) -> "Cells":
        return _cells(self.recorder, other) / self

    def _times(self, what: int, other: "Cells") -> "Cells":
        """A product or quotient, of which one at most has points."""
        points = self.points or other.points
        both = [cells.numbers[..., None] if points and not cells.points else cells.numbers for cells in (self, other)]
        return self._made(what, _shape(self, other), points, *both)

    def __neg__(self) -> "Cells":
        return self * -1.0

    def __pow__(self, power: float) -> "Cells":
        if power == 2:
            return self * self
        return self._made(steps.POWER, self.shape, False, self.numbers, self.recorder.scalar(power))

    def __matmul__(self, other: "Cells") -> "Cells":
        return self.times_matrix(other, self.recorder.scalar(0.0))

    def times_matrix(self, other: "Cells", added: Numbers) -> "Cells":
        """The product of matrices, and ``added`` [J] in every row [J]."""
        right = other
        if right.numbers.strides[-1] != right.numbers.itemsize:
            right = right._made(steps.COPY, right.shape, False, right.numbers)
        shape = (*np.broadcast_shapes(self.shape[:-2], right.shape[:-2]), self.shape[-2], right.shape[-1])
        made = Cells.empty(self.recorder, shape)
        self.recorder.note_matrix_product(made.numbers, self.numbers, right.numbers, added)
        return made

    def __gt__(self, other: Value) -> "Cells":
        return self._compared(steps.IS_MORE, other)

    def __lt__(self, other: Value) -> "Cells":
        return self._compared(steps.IS_LESS, other)

    def __or__(self, other: "Cells") -> "Cells":
        return self._compared(steps.LARGER, other)

    def _compared(self, what: int, other: Value) -> "Cells":
        other = _cells(self.recorder, other)
        return self._made(what, _shape(self, other), False, self.numbers, other.numbers)

    def _made(self, what: int, shape: tuple[int, ...], points: bool, *operands: Numbers) -> "Cells":
        made = Cells.empty(self.recorder, shape, points=points)
        self.recorder.note(what, made.numbers, *operands)
        return made


class RecordingOperations:
    """See `vbbench_baselines.former.operations.Operations`; on `Cells`."""

    def where(self, condition: Array, yes: Array, no: Array) -> Array:
        """See `Operations`."""
        yes, no = (_cells(condition.recorder, cells) for cells in (yes, no))
        made = Cells.empty(condition.recorder, _shape(condition, yes, no), points=yes.points)
        chosen = condition.numbers[..., None] if yes.points else condition.numbers
        condition.recorder.note(steps.CHOOSE, made.numbers, chosen, yes.numbers, no.numbers)
        return made

    def exp(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.EXP, x)

    def log(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.LOG, x)

    def sqrt(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.SQRT, x)

    def asinh(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.ASINH, x)

    def tanh(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.TANH, x)

    def sigmoid(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.SIGMOID, x)

    def silu(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.SILU, x)

    def clip(self, x: Array, low: float, high: float) -> Array:
        """See `Operations`."""
        raised = _function(steps.LARGER, x, x.recorder.scalar(low))
        return _function(steps.SMALLER, raised, x.recorder.scalar(high))

    def direction(self, angle: Array) -> Array:
        """See `Operations`."""
        made = Cells.empty(angle.recorder, angle.shape, points=True)
        angle.recorder.note(steps.COSINE, made.real.numbers, angle.numbers)
        angle.recorder.note(steps.SINE, made.imag.numbers, angle.numbers)
        return made

    def angle(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.ANGLE, x.imag, x.real.numbers)

    def point(self, forward: Array, left: Array) -> Array:
        """See `Operations`."""
        made = Cells.empty(forward.recorder, _shape(forward, left), points=True)
        forward.recorder.note(steps.COPY, made.real.numbers, forward.numbers)
        forward.recorder.note(steps.COPY, made.imag.numbers, left.numbers)
        return made

    def pairs(self, points: Array) -> Array:
        """See `Operations`."""
        return Cells(points.recorder, points.numbers)

    def totals(self, parts: list[Array]) -> list[Array]:
        """See `Operations`."""
        return [part.sum(-1) for part in parts]

    def stack(self, parts: list[Array]) -> Array:
        """See `Operations`."""
        return self.join([part[..., None] for part in parts])

    def join(self, parts: list[Array]) -> Array:
        """See `Operations`."""
        leading = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
        made = Cells.empty(parts[0].recorder, (*leading, sum(part.shape[-1] for part in parts)), points=parts[0].points)
        at = 0
        for part in parts:
            room = made[..., at : at + part.shape[-1]]
            made.recorder.note(steps.COPY, room.numbers, part.numbers)
            at += part.shape[-1]
        return made

    def append_row(self, rows: Array, row: Array) -> Array:
        """See `Operations`."""
        made = Cells.empty(rows.recorder, (*rows.shape[:-2], rows.shape[-2] + 1, rows.shape[-1]))
        rows.recorder.note(steps.COPY, made[..., :-1, :].numbers, rows.numbers)
        rows.recorder.note(steps.COPY, made[..., -1, :].numbers, row.numbers)
        return made

    def linear(self, x: Array, weights: Array, bias: Array) -> Array:
        """See `Operations`."""
        made = (x if len(x.shape) > 1 else x[None]).times_matrix(weights.swapaxes(-1, -2), bias.numbers)
        return made if len(x.shape) > 1 else made[0]

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        """See `Operations`."""
        return _rows(steps.NORMAL, x, gain, bias)

    def softmax(self, x: Array) -> Array:
        """See `Operations`."""
        return _rows(steps.SHARES, x)

    def detach(self, x: Array) -> Array:
        """See `Operations`."""
        return x


def _cells(recorder: Recorder, value: Value) -> Cells:
    return value if isinstance(value, Cells) else Cells(recorder, recorder.scalar(value))


def _shape(*cells: Cells) -> tuple[int, ...]:
    return np.broadcast_shapes(*(one.shape for one in cells))


def _function(what: int, x: Cells, *others: Numbers) -> Cells:
    """Of numbers one by one."""
    made = Cells.empty(x.recorder, x.shape)
    x.recorder.note(what, made.numbers, x.numbers, *others)
    return made


def _rows(what: int, x: Cells, *others: Cells) -> Cells:
    """Of rows, each as long as before."""
    made = Cells.empty(x.recorder, x.shape)
    x.recorder.note_rows(what, made.numbers, x.numbers, *(other.numbers for other in others))
    return made
