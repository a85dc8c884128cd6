"""The operations of the network on tensors, through which weights are learned."""

from typing import Any

import torch
from torch.nn import functional

from vbbench_baselines.former.operations import Array


class TensorOperations:
    """See `vbbench_baselines.former.operations.Operations`."""

    where, exp, log, sqrt = (staticmethod(do) for do in (torch.where, torch.exp, torch.log, torch.sqrt))
    asinh, tanh, sigmoid = (staticmethod(do) for do in (torch.asinh, torch.tanh, torch.sigmoid))
    clip, point = staticmethod(torch.clip), staticmethod(torch.complex)
    silu, linear = staticmethod(functional.silu), staticmethod(functional.linear)

    def direction(self, angle: Array) -> Array:
        """See `Operations`."""
        return torch.complex(torch.cos(angle), torch.sin(angle))

    def angle(self, x: Array) -> Array:
        """See `Operations`."""
        return torch.atan2(x.imag, x.real)

    def pairs(self, points: Array) -> Array:
        """See `Operations`."""
        return torch.stack([points.real, points.imag], -1)

    def totals(self, parts: list[Array]) -> list[Array]:
        """See `Operations`."""
        return [part.sum(-1) for part in parts]

    def stack(self, parts: list[Array]) -> Array:
        """See `Operations`."""
        return torch.stack(parts, -1)

    def join(self, parts: list[Array]) -> Array:
        """See `Operations`."""
        return torch.cat(parts, -1)

    def append_row(self, rows: Array, row: Array) -> Array:
        """See `Operations`."""
        return torch.cat([rows, row[..., None, :]], -2)

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        """See `Operations`."""
        return functional.layer_norm(x, (x.shape[-1],), gain, bias)

    def softmax(self, x: Array) -> Array:
        """See `Operations`."""
        return torch.softmax(x, -1)

    def detach(self, x: Any) -> Array:
        """See `Operations`."""
        return x.detach()
