"""What stands for an array while a network is written down: it has a shape, and whatever is done with it is noted.

A point is two numbers side by side, forward and left.
"""

from types import EllipsisType
from typing import Any

import numpy as np

from vbbench_baselines.former.programs import steps
from vbbench_baselines.former.programs.recorder import Recorder
from vbbench_baselines.former.programs.steps import Numbers

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
    def plain(self) -> Numbers:
        """The place of numbers.

        Raises
        ------
        TypeError
            If they are points.
        """
        if self.points:
            raise TypeError("this is done with numbers, not with points")
        return self.numbers

    @property
    def shape(self) -> tuple[int, ...]:
        """As of an array."""
        return self.numbers.shape[:-1] if self.points else self.numbers.shape

    @property
    def real(self) -> "Cells":
        """Forward; of numbers they themselves."""
        return self._part(0) if self.points else self

    @property
    def imag(self) -> "Cells":
        """To the left; of numbers nothing."""
        return self._part(1) if self.points else cells_of(self.recorder, 0.0)

    def _part(self, number: int) -> "Cells":
        return Cells(self.recorder, self.numbers[..., number])

    def conj(self) -> "Cells":
        """Points whose left is right; of numbers they themselves."""
        if not self.points:
            return self
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
        return Cells(self.recorder, self.plain.swapaxes(one, other))

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
        return cells_of(self.recorder, other) - self

    def _plus(self, what: int, other: Value) -> "Cells":
        other = cells_of(self.recorder, other)
        if self.points == other.points:
            return self._made(what, common_shape(self, other), self.points, self.numbers, other.numbers)
        made = Cells.empty(self.recorder, common_shape(self, other), points=True)
        self.recorder.note(what, made.real.numbers, self.real.numbers, other.real.numbers)
        self.recorder.note(what, made.imag.numbers, self.imag.numbers, other.imag.numbers)
        return made

    def __mul__(self, other: Value) -> "Cells":
        other = cells_of(self.recorder, other)
        if not (self.points and other.points):
            return self._times(steps.MULTIPLY, other)
        made = Cells.empty(self.recorder, common_shape(self, other), points=True)
        a, b, c, d = (cells.numbers for cells in (self.real, self.imag, other.real, other.imag))
        self.recorder.note(steps.SUBTRACT_PRODUCTS, made.real.numbers, a, c, b, d)
        self.recorder.note(steps.ADD_PRODUCTS, made.imag.numbers, a, d, b, c)
        return made

    __rmul__ = __mul__

    def __truediv__(self, other: Value) -> "Cells":
        other = cells_of(self.recorder, other)
        if other.points:
            raise TypeError("no step divides by points; multiply by their conjugate, over its square")
        return self._times(steps.DIVIDE, other)

    def __rtruediv__(self, other: Value) -> "Cells":
        return cells_of(self.recorder, other) / self

    def _times(self, what: int, other: "Cells") -> "Cells":
        """A product or quotient, of which one at most has points."""
        points = self.points or other.points
        both = [cells.numbers[..., None] if points and not cells.points else cells.numbers for cells in (self, other)]
        return self._made(what, common_shape(self, other), points, *both)

    def __neg__(self) -> "Cells":
        return self * -1.0

    def __pow__(self, power: float) -> "Cells":
        if power == 2:
            return self * self
        return self._made(steps.POWER, self.shape, False, self.plain, self.recorder.scalar(power))

    def __matmul__(self, other: "Cells") -> "Cells":
        return self.times_matrix(other, self.recorder.scalar(0.0))

    def times_matrix(self, other: "Cells", added: Numbers) -> "Cells":
        """The product of matrices, and ``added`` [J] in every row [J]."""
        right = other.without_gaps()
        shape = (*np.broadcast_shapes(self.shape[:-2], right.shape[:-2]), self.shape[-2], right.shape[-1])
        made = Cells.empty(self.recorder, shape)
        self.recorder.note_matrix_product(made.numbers, self.plain, right.numbers, added)
        return made

    def __gt__(self, other: Value) -> "Cells":
        return self._compared(steps.IS_MORE, other)

    def __lt__(self, other: Value) -> "Cells":
        return self._compared(steps.IS_LESS, other)

    def __or__(self, other: "Cells") -> "Cells":
        return self._compared(steps.LARGER, other)

    def _compared(self, what: int, other: Value) -> "Cells":
        other = cells_of(self.recorder, other)
        return self._made(what, common_shape(self, other), False, self.plain, other.plain)

    def without_gaps(self) -> "Cells":
        """The same, or if its numbers are not side by side a copy."""
        if self.numbers.flags.c_contiguous:
            return self
        return self._made(steps.COPY, self.shape, self.points, self.numbers)

    def _made(self, what: int, shape: tuple[int, ...], points: bool, *operands: Numbers) -> "Cells":
        made = Cells.empty(self.recorder, shape, points=points)
        self.recorder.note(what, made.numbers, *operands)
        return made


def cells_of(recorder: Recorder, value: Value) -> Cells:
    """Cells, or one of a plain number."""
    return value if isinstance(value, Cells) else Cells(recorder, recorder.scalar(value))


def common_shape(*cells: Cells) -> tuple[int, ...]:
    """To which they are broadcast."""
    return np.broadcast_shapes(*(one.shape for one in cells))
