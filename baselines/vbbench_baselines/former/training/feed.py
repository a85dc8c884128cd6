"""The batches of a training by their numbers, drawn ahead of it by other processes if there are any."""

from collections.abc import Iterator

import numpy as np
from torch.utils.data import DataLoader

from vbbench_baselines.former.training.batches import Batch, batch_of, draw_size
from vbbench_baselines.former.training.crowds import Crowds
from vbbench_baselines.former.training.recipe import Phase, Recipe


class Feed:
    """All batches of a training: each follows from seed and number alone, whoever draws it.

    Parameters
    ----------
    recipe, crowds, seed : see `vbbench_baselines.former.training.loop.Training`.
    filled : see `vbbench_baselines.former.training.batches.batch_of`.
    """

    def __init__(self, recipe: Recipe, crowds: Crowds, seed: int, *, filled: bool = False) -> None:
        self._recipe, self._crowds, self._seed, self._filled = recipe, crowds, seed, filled
        self._phases = list(self._phase_by_phase())

    def __len__(self) -> int:
        return len(self._phases)

    def __getitem__(self, number: int) -> Batch:
        rng = self._rng(number)
        size = draw_size(rng, self._recipe)
        return batch_of(rng, self._crowds, self._recipe, self._phases[number], size, filled=self._filled)

    def drawn(self, first: int, jobs: int) -> Iterator[Batch]:
        """The batches from number ``first`` on; of ``jobs`` processes one is left to whoever learns from them."""
        return iter(DataLoader(self, batch_size=None, sampler=range(first, len(self)), num_workers=jobs - 1))

    def _phase_by_phase(self) -> Iterator[Phase]:
        number = 0
        for stage in self._recipe.stage:
            windows = 0
            while windows < stage.windows:
                yield stage.phase_at(windows / stage.windows)
                windows += draw_size(self._rng(number), self._recipe).windows
                number += 1

    def _rng(self, number: int) -> np.random.Generator:
        return np.random.default_rng([self._recipe.seed, self._seed, number])
