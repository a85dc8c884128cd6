"""The operations of the learned solver on NumPy arrays of float32: what its network in C++ is compared with."""

import numpy as np

from vbbench_baselines.former.state import Array


class NumpyOperations:
    """See `vbbench_baselines.former.layers.Operations`."""

    where, exp, log, sqrt = staticmethod(np.where), staticmethod(np.exp), staticmethod(np.log), staticmethod(np.sqrt)
    asinh, tanh = staticmethod(np.arcsinh), staticmethod(np.tanh)

    def clip(self, x: Array, low: float, high: float) -> Array:
        return np.minimum(np.maximum(x, low), high)

    def sigmoid(self, x: Array) -> Array:
        return 1.0 / (1.0 + np.exp(-x))

    def silu(self, x: Array) -> Array:
        return x / (1.0 + np.exp(-x))

    def direction(self, angle: Array) -> Array:
        return np.exp(1j * angle)

    def angle(self, x: Array) -> Array:
        return np.arctan2(x.imag, x.real)

    def point(self, forward: Array, left: Array) -> Array:
        return forward + 1j * left

    def pairs(self, points: Array) -> Array:
        return np.ascontiguousarray(points).view(points.real.dtype).reshape((*points.shape, 2))

    def totals(self, parts: list[Array]) -> list[Array]:
        return list(np.add.reduce(np.array(parts), axis=-1))

    def stack(self, parts: list[Array]) -> Array:
        made = np.empty((*parts[0].shape, len(parts)), parts[0].dtype)
        for number, part in enumerate(parts):
            made[..., number] = part
        return made

    def join(self, parts: list[Array]) -> Array:
        return np.concatenate(parts, axis=-1)

    def append_row(self, rows: Array, row: Array) -> Array:
        return np.concatenate([rows, row[..., None, :]], axis=-2)

    def linear(self, x: Array, weights: Array, bias: Array) -> Array:
        made = x @ weights.T
        made += bias
        return made

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        size = x.shape[-1]
        off = x - np.add.reduce(x, axis=-1, keepdims=True) / size
        off /= np.sqrt(np.add.reduce(off * off, axis=-1, keepdims=True) / size + 1e-5)
        return off * gain + bias

    def softmax(self, x: Array) -> Array:
        made = np.exp(x - x.max(axis=-1, keepdims=True))
        made /= made.sum(axis=-1, keepdims=True)
        return made

    def detach(self, x: Array) -> Array:
        return x
