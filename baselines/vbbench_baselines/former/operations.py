"""Array operations of the network: on NumPy's arrays as it runs, overridden for tensors while it is trained.

Points and directions on the ground are complex numbers: forward + i·left of a camera.
"""

from typing import Any

import numpy as np

Array = Any
"""An array of float32 or complex64, or a tensor while the network is trained."""

_I = np.complex64(1j)


class Operations:
    """Operations on arrays [..., N]; those that join or reduce work along the last axis."""

    exp, log, sqrt = staticmethod(np.exp), staticmethod(np.log), staticmethod(np.sqrt)
    asinh, tanh = staticmethod(np.arcsinh), staticmethod(np.tanh)

    def where(self, condition: Array, x: Array, y: Array) -> Array:
        """X where the condition holds, else y."""
        if condition.ndim == 0:
            return x if condition else y
        return np.where(condition, x, y)

    def sigmoid(self, x: Array) -> Array:
        """1/(1 + exp(−x)) = (1 + tanh(x/2))/2."""
        return 0.5 + 0.5 * np.tanh(0.5 * x)

    def silu(self, x: Array) -> Array:
        """x·sigmoid(x)."""
        half = 0.5 * x
        return half + half * np.tanh(half)

    def clip(self, x: Array, low: float, high: float) -> Array:
        """X within bounds."""
        return x.clip(low, high)

    def direction(self, angle: Array) -> Array:
        """exp(i·angle)."""
        return np.exp(_I * angle)

    def angle(self, x: Array) -> Array:
        """The angle of complex x, within ±π."""
        return np.arctan2(x.imag, x.real)

    def point(self, forward: Array, left: Array) -> Array:
        """Forward + i·left."""
        return forward + _I * left

    def pairs(self, points: Array) -> Array:
        """Real and imaginary parts [..., 2] of points [...]."""
        return points[..., None].view(np.float32)

    def points(self, pairs: Array) -> Array:
        """The inverse of `pairs`."""
        return pairs.view(np.complex64)[..., 0]

    def stack(self, parts: list[Array]) -> Array:
        """N arrays [K] or [] stacked along a new last axis, [K, N] or [N]."""
        return np.array(parts).T

    def unstack(self, x: Array) -> list[Array]:
        """The inverse of `stack`."""
        return list(x.T)

    def flat(self, x: Array) -> Array:
        """[..., N, M] as [..., N·M]."""
        return x.reshape((*x.shape[:-2], x.shape[-2] * x.shape[-1]))

    def join(self, parts: list[Array]) -> Array:
        """Arrays [..., n] concatenated along the last axis."""
        return np.concatenate(parts, axis=-1)

    def append_row(self, rows: Array, row: Array) -> Array:
        """Rows [..., K + 1, N]: ``rows`` [..., K, N], then ``row`` [..., N]."""
        return np.concatenate([rows, row[..., None, :]], axis=-2)

    def transposed(self, weights: Array) -> Array:
        """Weights [m, n] as [n, m], in the layout that arrays [..., n] are multiplied by fastest."""
        return np.ascontiguousarray(weights.T)

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        """Layer normalisation along the last axis, times ``gain`` plus ``bias``."""
        off = x - np.add.reduce(x, axis=-1, keepdims=True) / x.shape[-1]
        off /= np.sqrt(np.vecdot(off, off) / x.shape[-1] + 1e-5)[..., None]
        off *= gain
        off += bias
        return off

    def softmax(self, x: Array) -> Array:
        """Softmax along the last axis but one, over which NumPy reduces faster than over the last."""
        made = np.exp(x - x.max(axis=-2, keepdims=True))
        return made / made.sum(axis=-2, keepdims=True)

    def detach(self, x: Array) -> Array:
        """The same values without gradient."""
        return x
