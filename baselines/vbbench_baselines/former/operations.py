"""What the network computes with: the same few operations on NumPy arrays, and while it is trained on tensors.

Points and directions on the ground are complex numbers: forward + i·left of a camera.
"""

from typing import Any, Protocol

import numpy as np

Array = Any
"""A NumPy array, or a tensor while the network is trained."""


class Operations(Protocol):
    """Operations on arrays [..., N]; those that join or reduce work along the last axis."""

    def where(self, condition: Array, yes: Array, no: Array) -> Array:
        """``yes`` where the condition holds, else ``no``."""

    def exp(self, x: Array) -> Array:
        """E to the x."""

    def log(self, x: Array) -> Array:
        """The natural logarithm."""

    def sqrt(self, x: Array) -> Array:
        """The square root."""

    def asinh(self, x: Array) -> Array:
        """As x near 0, as a logarithm far off: large errors do not drown small ones."""

    def tanh(self, x: Array) -> Array:
        """The hyperbolic tangent."""

    def sigmoid(self, x: Array) -> Array:
        """1/(1 + exp(−x))."""

    def silu(self, x: Array) -> Array:
        """x·sigmoid(x)."""

    def clip(self, x: Array, low: float, high: float) -> Array:
        """X within bounds."""

    def direction(self, angle: Array) -> Array:
        """exp(i·angle)."""

    def angle(self, x: Array) -> Array:
        """The angle of complex x, within ±π."""

    def point(self, forward: Array, left: Array) -> Array:
        """Forward + i·left."""

    def pairs(self, points: Array) -> Array:
        """Forward and left of points [...] side by side, [..., 2]."""

    def totals(self, parts: list[Array]) -> list[Array]:
        """The sum [...] of each of the arrays [..., K]."""

    def stack(self, parts: list[Array]) -> Array:
        """Arrays [...] side by side, [..., N]."""

    def join(self, parts: list[Array]) -> Array:
        """Arrays [..., n] one after the other."""

    def append_row(self, rows: Array, row: Array) -> Array:
        """Rows [..., K, N] and one more [..., N]."""

    def linear(self, x: Array, weights: Array, bias: Array) -> Array:
        """X [..., n] times the weights [m, n] transposed, and the bias [m]."""

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        """X less its mean, over its standard deviation, times gain plus bias (layer normalisation)."""

    def softmax(self, x: Array) -> Array:
        """Shares that sum to 1."""

    def detach(self, x: Array) -> Array:
        """x, through which nothing is learned."""


class NumpyOperations:
    """The operations on NumPy arrays of float32."""

    where, exp, log, sqrt = staticmethod(np.where), staticmethod(np.exp), staticmethod(np.log), staticmethod(np.sqrt)
    asinh, tanh = staticmethod(np.arcsinh), staticmethod(np.tanh)

    def clip(self, x: Array, low: float, high: float) -> Array:
        """See `Operations`."""
        return np.minimum(np.maximum(x, low), high)  # in half the time of np.clip

    def sigmoid(self, x: Array) -> Array:
        """See `Operations`."""
        return 1.0 / (1.0 + np.exp(-x))

    def silu(self, x: Array) -> Array:
        """See `Operations`."""
        return x / (1.0 + np.exp(-x))

    def direction(self, angle: Array) -> Array:
        """See `Operations`."""
        return np.exp(1j * angle)

    def angle(self, x: Array) -> Array:
        """See `Operations`."""
        return np.arctan2(x.imag, x.real)

    def point(self, forward: Array, left: Array) -> Array:
        """See `Operations`."""
        return forward + 1j * left

    def pairs(self, points: Array) -> Array:
        """See `Operations`."""
        return np.ascontiguousarray(points).view(points.real.dtype).reshape((*points.shape, 2))

    def totals(self, parts: list[Array]) -> list[Array]:
        """See `Operations`."""
        return list(np.add.reduce(np.array(parts), axis=-1))

    def stack(self, parts: list[Array]) -> Array:
        """See `Operations`."""
        made = np.empty((*parts[0].shape, len(parts)), parts[0].dtype)
        for number, part in enumerate(parts):
            made[..., number] = part
        return made

    def join(self, parts: list[Array]) -> Array:
        """See `Operations`."""
        return np.concatenate(parts, axis=-1)

    def append_row(self, rows: Array, row: Array) -> Array:
        """See `Operations`."""
        return np.concatenate([rows, row[..., None, :]], axis=-2)

    def linear(self, x: Array, weights: Array, bias: Array) -> Array:
        """See `Operations`."""
        made = x @ weights.T
        made += bias
        return made

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        """See `Operations`."""
        size = x.shape[-1]
        off = x - np.add.reduce(x, axis=-1, keepdims=True) / size
        off /= np.sqrt(np.add.reduce(off * off, axis=-1, keepdims=True) / size + 1e-5)
        return off * gain + bias

    def softmax(self, x: Array) -> Array:
        """See `Operations`."""
        made = np.exp(x - x.max(axis=-1, keepdims=True))
        made /= made.sum(axis=-1, keepdims=True)
        return made

    def detach(self, x: Array) -> Array:
        """See `Operations`."""
        return x
