"""Array operations of the network: on NumPy's arrays as it runs, overridden for tensors while it is trained.

Points and directions on the ground are complex numbers: forward + i·left of a camera.
"""

from typing import Any

import numpy as np

Array = Any
"""An array of float32 or complex64, or a tensor while the network is trained."""


class Operations:
    """Operations on arrays [..., N]; those that join or reduce work along the last axis."""

    where, exp, log, sqrt = (staticmethod(do) for do in (np.where, np.exp, np.log, np.sqrt))
    asinh, tanh = staticmethod(np.arcsinh), staticmethod(np.tanh)

    def sigmoid(self, x: Array) -> Array:
        """1/(1 + exp(−x))."""
        return 1.0 / (1.0 + np.exp(-x))

    def silu(self, x: Array) -> Array:
        """x·sigmoid(x)."""
        return x / (1.0 + np.exp(-x))

    def clip(self, x: Array, low: float, high: float) -> Array:
        """X within bounds."""
        return np.minimum(np.maximum(x, low), high)

    def direction(self, angle: Array) -> Array:
        """exp(i·angle)."""
        return np.exp(1j * angle)

    def angle(self, x: Array) -> Array:
        """The angle of complex x, within ±π."""
        return np.arctan2(x.imag, x.real)

    def point(self, forward: Array, left: Array) -> Array:
        """Forward + i·left."""
        return forward + 1j * left

    def pairs(self, points: Array) -> Array:
        """Real and imaginary parts [..., 2] of points [...]."""
        return np.ascontiguousarray(points).view(points.real.dtype).reshape((*points.shape, 2))

    def totals(self, parts: list[Array]) -> list[Array]:
        """The sum [...] of each of the arrays [..., K]."""
        return list(np.add.reduce(np.array(parts), axis=-1))

    def stack(self, parts: list[Array]) -> Array:
        """N arrays [...] stacked along a new last axis, [..., N]."""
        return np.stack(parts, axis=-1)

    def join(self, parts: list[Array]) -> Array:
        """Arrays [..., n] concatenated along the last axis."""
        return np.concatenate(parts, axis=-1)

    def append_row(self, rows: Array, row: Array) -> Array:
        """Rows [..., K + 1, N]: ``rows`` [..., K, N], then ``row`` [..., N]."""
        return np.concatenate([rows, row[..., None, :]], axis=-2)

    def linear(self, x: Array, weights: Array, bias: Array) -> Array:
        """X [..., n] times the weights [m, n] transposed, and the bias [m]."""
        return x @ weights.T + bias

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        """Layer normalisation along the last axis, times ``gain`` plus ``bias``."""
        off = x - x.mean(axis=-1, keepdims=True)
        return off / np.sqrt((off * off).mean(axis=-1, keepdims=True) + 1e-5) * gain + bias

    def softmax(self, x: Array) -> Array:
        """Softmax along the last axis."""
        made = np.exp(x - x.max(axis=-1, keepdims=True))
        return made / made.sum(axis=-1, keepdims=True)

    def detach(self, x: Array) -> Array:
        """The same values without gradient."""
        return x
