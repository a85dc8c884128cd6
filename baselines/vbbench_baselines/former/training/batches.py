"""Batches of windows as tensors: measurements, what each protocol gives, and the truth.

A batch follows from its number. Other processes, if any, draw batches ahead of the training.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import DataLoader

from vbbench.errors import VbbenchError
from vbbench.protocol import PROTOCOLS, START_FRAMES
from vbbench_baselines.former.scene import UNKNOWN_STD, Sights
from vbbench_baselines.former.training.crowds import Crowds
from vbbench_baselines.former.training.recipe import Phase, Recipe, Size
from vbbench_baselines.former.training.windows import Window, alter, cut

TRIES = 10_000
"""Windows that are tried for a batch before giving up: some sequences are too short."""
ONE_STEP, ROLLOUT, COLD_START = (PROTOCOLS.index(name) for name in ("one-step", "rollout", "cold-start"))


@dataclass(frozen=True, kw_only=True)
class Batch:
    """B windows of L frames and K people. The world begins at the first pose.

    Parameters
    ----------
    sights : measurements of boxes, tensors [B, L, K].
    positions : [B, L, K] true x + i·y in m.
    place, yaw : [B, L] true x + i·y in m, and yaw in rad, of the camera.
    true, given, scored : [B, L, K] 1 where truth exists, where it is given in that frame, where it is scored.
    protocol : [B] number of the protocol in `vbbench.protocol.PROTOCOLS`.
    dt, spread : [B], see `vbbench_baselines.former.training.crowds.Watched`.
    """

    sights: Sights
    positions: torch.Tensor
    place: torch.Tensor
    yaw: torch.Tensor
    true: torch.Tensor
    given: torch.Tensor
    scored: torch.Tensor
    protocol: torch.Tensor
    dt: torch.Tensor
    spread: torch.Tensor

    def to(self, device: str) -> "Batch":
        """The same on another device."""
        others = {name: values.to(device) for name, values in vars(self).items() if name != "sights"}
        return Batch(sights=Sights(*(values.to(device) for values in self.sights)), **others)

    def take_over(self, other: "Batch") -> None:
        """Replace all numbers by those of another batch of the same shape."""
        for mine, values in zip(self._tensors, other._tensors, strict=True):
            mine.copy_(values)

    @property
    def _tensors(self) -> list[torch.Tensor]:
        return [*self.sights, *(values for name, values in vars(self).items() if name != "sights")]


def draw_size(rng: np.random.Generator, recipe: Recipe) -> Size:
    """The size of a batch, which is drawn before its windows."""
    shares = np.array([size.share for size in recipe.size])
    return recipe.size[rng.choice(len(recipe.size), p=shares / shares.sum())]


def batch_of(
    rng: np.random.Generator, crowds: Crowds, recipe: Recipe, phase: Phase, size: Size, *, filled: bool = False
) -> Batch:
    """A batch of windows of one size.

    Parameters
    ----------
    filled : whether arrays are padded to the greatest number of people of the size, so that all batches of a size have
        the same shape.

    Raises
    ------
    VbbenchError
        If no stream has sequences that long.
    """
    windows: list[Window] = []
    for _ in range(TRIES):
        stream = crowds.streams[rng.choice(len(crowds.streams), p=crowds.shares)]
        window = cut(rng, stream[rng.integers(len(stream))], phase, size)
        if window is not None:
            window = alter(rng, window)
            if window.seen.any():
                windows.append(window)
        if len(windows) == size.windows:
            people = size.most if filled else max(window.seen.shape[1] for window in windows)
            return _stacked(rng, windows, recipe, people)
    raise VbbenchError(
        f"hardly any sequence of the recipe has {phase.frames} frames; ask for shorter ones in [[phase]]"
    )


def _stacked(rng: np.random.Generator, windows: list[Window], recipe: Recipe, people: int) -> Batch:
    shares = np.array([recipe.protocols[name] for name in PROTOCOLS])
    protocol = rng.choice(len(PROTOCOLS), len(windows), p=shares / shares.sum())
    shown = [window.shown() for window in windows]
    empty = {"ray": 1.0, "noise": UNKNOWN_STD}
    sights = Sights(
        *(
            torch.from_numpy(_filled([getattr(one, name) for one in shown], people, empty.get(name, 0.0)))
            for name in Sights._fields
        )
    )
    place = np.stack([window.place for window in windows])
    yaw = np.stack([window.yaw for window in windows])
    origin, turned = place[:, :1], np.exp(-1j * yaw[:, :1])
    positions = _filled([window.positions for window in windows], people, 0.0)
    seen = _filled([window.seen for window in windows], people, False)
    true = _filled([window.true for window in windows], people, False) & seen
    early = np.cumsum(seen, axis=1) <= START_FRAMES
    kind, late = protocol[:, None, None], np.arange(seen.shape[1])[:, None] >= START_FRAMES
    given = early & true & (kind != COLD_START) & ~(late & ((kind == ROLLOUT) | (kind == ONE_STEP)))
    never = early & (kind != ROLLOUT) & (kind != COLD_START)
    return Batch(
        sights=sights,
        positions=_tensor((positions - origin[..., None]) * turned[..., None]),
        place=_tensor((place - origin) * turned),
        yaw=_tensor(yaw - yaw[:, :1]),
        true=_tensor(true),
        given=_tensor(given),
        scored=_tensor(true & late & ~never),
        protocol=torch.from_numpy(protocol),
        dt=_tensor(np.array([window.dt for window in windows])),
        spread=_tensor(np.array([window.spread for window in windows])),
    )


def _filled(values: list[NDArray[Any]], people: int, empty: float | bool) -> NDArray[Any]:
    """Values [L, k, ...] of each window in one array [B, L, K, ...], padded with ``empty``."""
    first = values[0]
    made = np.full((len(values), len(first), people, *first.shape[2:]), empty, first.dtype)
    for row, one in zip(made, values, strict=True):
        row[:, : one.shape[1]] = one
    return made


def _tensor(values: NDArray[Any]) -> torch.Tensor:
    return torch.from_numpy(values.astype(np.complex64 if np.iscomplexobj(values) else np.float32))


class Feed:
    """All batches of a training: each follows from seed and number alone, whoever draws it.

    Parameters
    ----------
    recipe, crowds, seed : see `vbbench_baselines.former.training.loop.Training`.
    filled : see `batch_of`.
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
        """The batches from number ``first`` on, drawn by ``jobs`` − 1 processes; the training itself takes one."""
        return iter(DataLoader(self, batch_size=None, sampler=range(first, len(self)), num_workers=jobs - 1))

    def _phase_by_phase(self) -> Iterator[Phase]:
        windows = number = 0
        while windows < self._recipe.windows:
            yield self._recipe.phase_at(windows / self._recipe.windows)
            windows += draw_size(self._rng(number), self._recipe).windows
            number += 1

    def _rng(self, number: int) -> np.random.Generator:
        return np.random.default_rng([self._recipe.seed, self._seed, number])
