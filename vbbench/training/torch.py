"""Samples as PyTorch datasets: random access, and batches in an order that no number of workers changes."""

from collections.abc import Iterator
from collections.abc import Sequence as Several
from itertools import count, islice
from multiprocessing import get_start_method
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import VbbenchError, needs_extra
from vbbench.training import samples
from vbbench.training.samples import Sample
from vbbench.training.sources import Source

with needs_extra("torch", "vbbench.training.torch"):
    import torch
    from torch.utils.data import DataLoader, Dataset

Tensors = Sample[torch.Tensor]
"""A sample, or a batch, of tensors: see `Sample`."""


def to_tensors(sample: Sample[NDArray[Any]]) -> Tensors:
    """The same as tensors, which share the memory of arrays that can be written to."""
    return sample.map(lambda values: torch.from_numpy(np.require(values, requirements="W")))


def collate(several: Several[Tensors]) -> Tensors:
    """A batch [B, …] of samples; frames and people are padded to the longest and fullest of them."""
    return to_tensors(samples.collate([sample.map(lambda values: values.numpy()) for sample in several]))


class SampleDataset(Dataset[Tensors]):
    """Samples of a source by number, for any sampler: give it to a `DataLoader` with ``collate_fn=collate``.

    Parameters
    ----------
    source : samples with a known number of them.
    """

    def __init__(self, source: Source) -> None:
        self.source = source

    def __len__(self) -> int:
        if self.source.size is None:
            raise VbbenchError("these samples have no end: give a 'stop', or read them by a Feed")
        return self.source.size

    def __getitem__(self, number: int) -> Tensors:
        if self.source.size is not None and not -self.source.size <= number < self.source.size:
            raise IndexError(number)  # ends a for loop
        return self.__getitems__([number % self.source.size if self.source.size else number])[0]

    def __getitems__(self, numbers: list[int]) -> list[Tensors]:
        """Samples of a batch, which are read together; `DataLoader` asks for them so."""
        return [to_tensors(sample) for sample in self.source.read(numbers)]


class Feed:
    """Batches of samples for training, in an order that follows from the seed alone, and that can be continued.

    A loop over a feed is an epoch: it ends with the last sample, or never if the source has no end. A loop that was
    left goes on where it stopped, in this process or with `state_dict` in another one, with any number of workers.

    Parameters
    ----------
    source : the samples.
    batch_size : samples of a batch; the last one of an epoch may have fewer.
    seed : shuffles a source that ends, every epoch again; ``None`` for their own order.
    workers : processes that make samples while the network trains; 0 makes them in this one.
    start : how workers are started; ``None`` for Python's own way.
    pin_memory : whether batches are put where a GPU fetches them faster.
    rank, world_size : this process among those of distributed training.
    """

    def __init__(
        self,
        source: Source,
        batch_size: int,
        *,
        seed: int | None = 0,
        workers: int = 0,
        start: Literal["fork", "spawn", "forkserver"] | None = None,
        pin_memory: bool = False,
        rank: int = 0,
        world_size: int = 1,
    ) -> None:
        self._order = Order(source.size, batch_size, seed, rank, world_size)
        self._loader = DataLoader(
            SampleDataset(source),
            batch_sampler=self._order,
            num_workers=workers,
            multiprocessing_context=start if workers else None,
            persistent_workers=workers > 0 and (start or get_start_method()) != "fork",  # others are slow to start
            collate_fn=collate,
            pin_memory=pin_memory,
        )

    @property
    def epoch(self) -> int:
        """Epochs that have ended."""
        return self._order.epoch

    @property
    def batch(self) -> int:
        """Batches given of this epoch."""
        return self._order.batch

    def __len__(self) -> int:
        """Batches of an epoch."""
        return len(self._order)

    def __iter__(self) -> Iterator[Tensors]:
        for batch in self._loader:
            self._order.batch += 1
            yield batch
        self._order.epoch, self._order.batch = self._order.epoch + 1, 0

    def state_dict(self) -> dict[str, Any]:
        """Where the feed is: epoch, batches given of it, and what decides their order."""
        return {"epoch": self._order.epoch, "batch": self._order.batch, "order": self._order.facts}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Go on where another feed was.

        Raises VbbenchError if that had another order: number of samples, size of batches, seed, or number of ranks.
        """
        if state["order"] != self._order.facts:
            raise VbbenchError(f"this feed is in the order {self._order.facts}, and cannot go on with {state['order']}")
        self._order.epoch, self._order.batch = state["epoch"], state["batch"]


class Order:
    """In which order samples come, and how far a feed is: batch b of rank r is the (b · ranks + r)-th of all.

    Every rank gets as many batches, so that none waits for another: where there are several ranks, the batches that are
    too few to go round are skipped. The last of all may be smaller.
    """

    def __init__(self, size: int | None, batch_size: int, seed: int | None, rank: int, world_size: int) -> None:
        if batch_size < 1 or not 0 <= rank < world_size:
            raise VbbenchError(f"batches of {batch_size}, rank {rank} of {world_size}: ranks are numbered from 0")
        facts = {"size": size, "batch_size": batch_size, "seed": seed, "world_size": world_size}
        self.facts: dict[str, int | None] = facts
        self.epoch, self.batch = 0, 0
        self._size, self._batch_size, self._seed, self._rank, self._ranks = size, batch_size, seed, rank, world_size
        self._rounds = None if size is None else -(-size // batch_size) // world_size
        if world_size > 1 and self._rounds == 0:
            raise VbbenchError(f"{size} samples are too few for {world_size} ranks with batches of {batch_size}")

    def __len__(self) -> int:
        """Batches of an epoch."""
        if self._rounds is None:
            raise TypeError("a feed of a source without an end has no length")
        return self._rounds

    def __iter__(self) -> Iterator[list[int]]:
        """Numbers of the samples of each batch that is left of the epoch; the loader asks in this process."""
        size = self._batch_size
        starts = ((at * self._ranks + self._rank) * size for at in count(self.batch))
        if self._size is None or self._rounds is None:
            return ([*range(at, at + size)] for at in starts)
        order = np.arange(self._size)
        if self._seed is not None:
            order = np.random.default_rng(np.random.SeedSequence([self._seed, self.epoch])).permutation(self._size)
        return (order[at : at + size].tolist() for at in islice(starts, max(0, self._rounds - self.batch)))
