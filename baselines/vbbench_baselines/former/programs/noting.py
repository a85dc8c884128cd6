"""What the network computes with while it is written down: the operations on cells, each a step or a few."""

from functools import partial

import numpy as np

from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.programs import steps
from vbbench_baselines.former.programs.cells import Cells, cells_of, common_shape
from vbbench_baselines.former.programs.steps import Numbers


def _function(what: int, x: Cells, *others: Numbers) -> Cells:
    """Of numbers one by one."""
    made = Cells.empty(x.recorder, x.shape)
    x.recorder.note(what, made.numbers, x.plain, *others)
    return made


class NotingOperations:
    """See `vbbench_baselines.former.operations.Operations`; on `vbbench_baselines.former.programs.cells.Cells`."""

    exp, log, sqrt = (staticmethod(partial(_function, what)) for what in (steps.EXP, steps.LOG, steps.SQRT))
    asinh, tanh = (staticmethod(partial(_function, what)) for what in (steps.ASINH, steps.TANH))
    sigmoid, silu = (staticmethod(partial(_function, what)) for what in (steps.SIGMOID, steps.SILU))

    def where(self, condition: Array, yes: Array, no: Array) -> Array:
        """See `Operations`."""
        yes, no = (cells_of(condition.recorder, cells) for cells in (yes, no))
        made = Cells.empty(condition.recorder, common_shape(condition, yes, no), points=yes.points)
        chosen = condition.plain[..., None] if yes.points else condition.plain
        condition.recorder.note(steps.CHOOSE, made.numbers, chosen, *_alike([yes, no]))
        return made

    def clip(self, x: Array, low: float, high: float) -> Array:
        """See `Operations`."""
        raised = _function(steps.LARGER, x, x.recorder.scalar(low))
        return _function(steps.SMALLER, raised, x.recorder.scalar(high))

    def direction(self, angle: Array) -> Array:
        """See `Operations`."""
        made = Cells.empty(angle.recorder, angle.shape, points=True)
        angle.recorder.note(steps.COSINE, made.real.numbers, angle.plain)
        angle.recorder.note(steps.SINE, made.imag.numbers, angle.plain)
        return made

    def angle(self, x: Array) -> Array:
        """See `Operations`."""
        return _function(steps.ANGLE, x.imag, x.real.numbers)

    def point(self, forward: Array, left: Array) -> Array:
        """See `Operations`."""
        made = Cells.empty(forward.recorder, common_shape(forward, left), points=True)
        forward.recorder.note(steps.COPY, made.real.numbers, forward.plain)
        forward.recorder.note(steps.COPY, made.imag.numbers, left.plain)
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
        for part, numbers in zip(parts, _alike(parts), strict=True):
            room = made[..., at : at + part.shape[-1]]
            made.recorder.note(steps.COPY, room.numbers, numbers)
            at += part.shape[-1]
        return made

    def append_row(self, rows: Array, row: Array) -> Array:
        """See `Operations`."""
        made = Cells.empty(rows.recorder, (*rows.shape[:-2], rows.shape[-2] + 1, rows.shape[-1]))
        rows.recorder.note(steps.COPY, made[..., :-1, :].numbers, rows.plain)
        rows.recorder.note(steps.COPY, made[..., -1, :].numbers, row.plain)
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


def _rows(what: int, x: Cells, *others: Cells) -> Cells:
    """Of rows, each as long as before."""
    made = Cells.empty(x.recorder, x.shape)
    x.recorder.note_rows(what, made.numbers, x.without_gaps().plain, *(other.plain for other in others))
    return made


def _alike(parts: list[Cells]) -> list[Numbers]:
    """Of parts their numbers; TypeError if some are points and others are not."""
    points = all(part.points for part in parts)
    return [part.numbers if points else part.plain for part in parts]
