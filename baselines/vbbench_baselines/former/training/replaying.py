"""Learning from batches on a GPU, recorded once for each shape.

A frame through the network and back is thousands of small operations; starting them from Python takes longer than doing
them.
"""

from collections.abc import Callable
from typing import NamedTuple

import torch

from vbbench_baselines.former.training.batches import Batch
from vbbench_baselines.former.training.following import Errors

WARM_UP = 2
"""Batches before one is recorded, in which libraries make their own arrays."""

Learn = Callable[[Batch], Errors]
"""What is learned from a batch goes to the gradients of the weights, in place; its errors."""


class _Recording(NamedTuple):
    graph: torch.cuda.CUDAGraph
    batch: Batch
    errors: Errors


class Replaying:
    """``learn``, recorded for each shape of batches and played again; errors are overwritten by the next batch."""

    def __init__(self, learn: Learn) -> None:
        self._learn, self._recordings, self._memory = learn, dict[torch.Size, _Recording](), None
        self._stream = torch.cuda.Stream()

    def __call__(self, batch: Batch) -> Errors:
        """Learn from a batch on the GPU, or on its way there."""
        shape = batch.true.shape
        if shape not in self._recordings:
            self._recordings[shape] = self._record(batch)
        recording = self._recordings[shape]
        recording.batch.take_over(batch)
        recording.graph.replay()
        return recording.errors

    def _record(self, batch: Batch) -> _Recording:
        own, graph = batch.to("cuda"), torch.cuda.CUDAGraph()
        self._stream.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(self._stream):
            for _ in range(WARM_UP):
                self._learn(own)
        torch.cuda.current_stream().wait_stream(self._stream)
        with torch.cuda.graph(graph, pool=self._memory, stream=self._stream):
            errors = Errors(*(values.detach() for values in self._learn(own)))
        self._memory = graph.pool()
        return _Recording(graph, own, errors)
