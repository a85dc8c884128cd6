"""Batches of windows as tensors: measurements, what each protocol gives, and the truth.

A batch follows from its number. Other processes, if any, draw batches ahead of the training.

Windows of a few people and frames, cut out of sequences and augmented at random.

Augmentation alters the truth: speeds and smoothness of people and observer, yaw, and who is present when. Boxes keep
their errors in direction and in the logarithm of the distance.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import DataLoader

from vbbench.errors import VbbenchError
from vbbench.protocol import PROTOCOLS, START_FRAMES
from vbbench_baselines.former.scene import HIGHEST, LOWEST, UNKNOWN_STD, Sights
from vbbench_baselines.former.training.crowds import Crowds, Watched
from vbbench_baselines.former.training.recipe import Phase, Recipe, Size

LONGEST_STEP = 0.85
"""In s: frames are removed as long as one then takes no longer."""
LONGEST_FRAME = 0.9
"""In s: how long a frame is at most when all walk more slowly than they did."""
NEAREST = 0.4
"""In m: whoever comes nearer is not seen."""
STOP_TIME = 0.8
"""In s, in which a person comes to a stop or sets off."""


@dataclass(frozen=True)
class Window:
    """A window of L frames and K people.

    Parameters
    ----------
    positions : [L, K] true x + i·y in m; the place by the box where no person is (a false detection).
    place, yaw : [L] of the camera, in m (complex) and rad, without jumps of 2π.
    true : [L, K] whether a person is there.
    seen : [L, K] whether there is a box.
    error : [L, K] error of the box's direction, as a unit complex number.
    height_error, foot_error : [L, K] errors of the box's two logarithms of the distance.
    sights : measurements of boxes before augmentation.
    dt, spread : see `vbbench_baselines.former.training.crowds.Watched`.
    """

    positions: NDArray[np.complex128]
    place: NDArray[np.complex128]
    yaw: NDArray[np.float64]
    true: NDArray[np.bool_]
    seen: NDArray[np.bool_]
    error: NDArray[np.complex128]
    height_error: NDArray[np.float64]
    foot_error: NDArray[np.float64]
    sights: Sights
    dt: float
    spread: float

    @property
    def relative(self) -> NDArray[np.complex128]:
        """[L, K] people relative to the camera, forward + i·left in m."""
        return _from_camera(self.positions, self.place, self.yaw)

    def shown(self) -> Sights:
        """Measurements of boxes after augmentation: true values with the boxes' errors."""
        relative = self.relative
        distance = np.maximum(np.abs(relative), 1e-6)
        range_of = np.log(distance)
        ray = np.where(self.seen, relative / distance * self.error, 1.0)

        def bounded(values: NDArray[np.float64]) -> NDArray[np.float32]:
            return np.where(self.seen, np.clip(values, LOWEST, HIGHEST), 0.0).astype(np.float32)

        return self.sights._replace(
            seen=self.seen.astype(np.float32),
            ray=ray.astype(np.complex64),
            by_height=bounded(range_of + self.height_error),
            by_feet=bounded(range_of + self.foot_error),
            has_feet=self.sights.has_feet * self.seen,
            cut=self.sights.cut * self.seen[..., None],
        )


def cut(rng: np.random.Generator, watched: Watched, phase: Phase, size: Size) -> Window | None:
    """A random window of a sequence; ``None`` if that is too short, or shows nobody."""
    total, frames = len(watched.poses), phase.frames
    if total < frames:
        return None
    widest = max(1, min(round(LONGEST_STEP / watched.dt), (total - 1) // (frames - 1)))
    likely = 1.0 / np.arange(1, widest + 1)
    every = 1 + int(rng.choice(widest, p=likely / likely.sum()))
    first = int(rng.integers(total - (frames - 1) * every))
    part = slice(first, first + (frames - 1) * every + 1, every)
    boxes = watched.sights.seen[part].sum(axis=0)
    people = np.flatnonzero(boxes)
    wanted = int(rng.integers(size.least, size.most + 1))
    if not len(people):
        return None
    if wanted < len(people):
        chances = boxes[people].astype(np.float64) ** 1.5
        people = np.sort(rng.choice(people, wanted, replace=False, p=chances / chances.sum()))
    poses = watched.poses[part].astype(np.float64)
    place, yaw = poses[:, 0] + 1j * poses[:, 1], np.unwrap(poses[:, 2])
    sights = Sights(*(values[part][:, people] for values in watched.sights))
    positions = watched.positions[part][:, people].astype(np.complex128)
    true, seen = ~np.isnan(positions), sights.seen > 0.5
    by_box = place[:, None] + sights.ray * np.exp(sights.by_height + 1j * yaw[:, None])
    positions = np.where(true, positions, by_box)
    relative = _from_camera(positions, place, yaw)
    distance = np.maximum(np.abs(relative), 1e-6)
    return Window(
        positions=positions,
        place=place,
        yaw=yaw,
        true=true,
        seen=seen,
        error=sights.ray * (relative / distance).conj(),
        height_error=sights.by_height - np.log(distance),
        foot_error=sights.by_feet - np.log(distance),
        sights=sights,
        dt=watched.dt * every,
        spread=watched.spread,
    )


def _from_camera(
    positions: NDArray[np.complex128], place: NDArray[np.complex128], yaw: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """[L, K] ``positions`` relative to a camera at ``place`` [L] with this ``yaw`` [L], forward + i·left in m."""
    found: NDArray[np.complex128] = (positions - place[:, None]) * np.exp(-1j * yaw)[:, None]
    return found


def alter(rng: np.random.Generator, window: Window) -> Window:
    """The window with all augmentations."""
    if rng.random() < 0.5:
        window = replace(window, dt=min(window.dt * _between(rng, 0.6, 1.6), max(window.dt, LONGEST_FRAME)))
    for change in (_stop_and_go, _stray, _look_about, _come_and_go, _mirror):
        window = change(rng, window)
    return replace(window, seen=window.seen & (np.abs(window.relative) > NEAREST))


def _stop_and_go(rng: np.random.Generator, window: Window) -> Window:
    """Some people, and sometimes the observer, stand, stop, set off or change their pace."""
    chance, positions = rng.choice((0.0, 0.0, 0.1, 0.3)), window.positions.copy()
    for person in range(positions.shape[1]):
        if rng.random() < chance and window.true[:, person].all():
            positions[:, person] = _paced(rng, window.dt, len(positions))(positions[:, person])
    window = replace(window, positions=positions)
    if rng.random() >= 0.12:
        return window
    again = _paced(rng, window.dt, len(positions))
    return replace(window, place=again(window.place), yaw=again(window.yaw.astype(np.complex128)).real)


def _paced(
    rng: np.random.Generator, dt: float, frames: int
) -> Callable[[NDArray[np.complex128]], NDArray[np.complex128]]:
    """A function that resamples a path [L] at another pace, from a random frame on, until it, or throughout."""
    pace, turn = rng.choice((0.0, 0.0, 0.3, 0.6, 1.3)), rng.integers(frames)
    soon = np.clip((np.arange(frames) - turn) / max(1, round(STOP_TIME / dt)), 0.0, 1.0)
    paces = 1.0 + (pace - 1.0) * soon
    if rng.random() < 0.3:
        paces = paces[::-1]
    if rng.random() < 0.3:
        paces = np.full(frames, pace)
    at = np.clip(np.concatenate([[0.0], np.cumsum(paces[:-1])]), 0.0, frames - 1.0)
    before = np.minimum(at.astype(np.int64), frames - 2)
    share = at - before
    return lambda way: way[before] * (1.0 - share) + way[before + 1] * share


def _stray(rng: np.random.Generator, window: Window) -> Window:
    """Perturb all paths: velocities wander, steps are uneven, gaits swing, by amounts drawn for the window."""
    if rng.random() >= 0.8:
        return window
    frames, people = window.positions.shape
    each = np.exp(0.5 * rng.standard_normal(people + 1)) * _between(rng, 0.02, 0.35)
    if rng.random() < 0.3:
        each = each * (rng.random(people + 1) < 0.4)
    aside = np.cumsum(_wander(rng, frames, people + 1, window.dt, _between(rng, 0.25, 3.0)) * each, axis=0) * window.dt
    if rng.random() < 0.5:
        uneven = _between(rng, 0.003, 0.04) * np.exp(0.4 * rng.standard_normal(people + 1))
        aside = aside + uneven * _gaussian(rng, (frames, people + 1))
    if rng.random() < 0.3:
        ways = np.gradient(np.concatenate([window.positions, window.place[:, None]], axis=1), axis=0)
        swing, phase = rng.uniform(0.0, 0.05), rng.uniform(0.0, 2.0 * np.pi, people + 1)
        beat = 2.0 * np.pi * rng.uniform(0.7, 1.1, people + 1) * window.dt * np.arange(frames)[:, None]
        aside = aside + swing * np.sin(beat + phase) * 1j * ways / (np.abs(ways) + 0.05)
    return replace(window, positions=window.positions + aside[:, :people], place=window.place + aside[:, people])


def _look_about(rng: np.random.Generator, window: Window) -> Window:
    """Add random turns to the yaw of the camera."""
    if rng.random() >= 0.35:
        return window
    turns = _wander(rng, len(window.yaw), 1, window.dt, _between(rng, 0.4, 4.0))[:, 0].real
    return replace(window, yaw=window.yaw + rng.uniform(0.0, 0.35) * turns)


def _come_and_go(rng: np.random.Generator, window: Window) -> Window:
    """Some tracks begin later or end earlier, boxes are missed, and sometimes nobody is seen for a while."""
    seen = window.seen.copy()
    frames, people = seen.shape
    if rng.random() < 0.5:
        for person in range(people):
            if rng.random() < 0.35:
                seen[: rng.integers(frames), person] = False
            if rng.random() < 0.25:
                seen[rng.integers(1, frames) :, person] = False
    if rng.random() < 0.3:
        seen &= rng.random(seen.shape) > rng.uniform(0.0, 0.15)
    if rng.random() < 0.15:
        blind = rng.integers(1, frames)
        seen[blind : blind + rng.integers(1, frames)] = False
    return replace(window, seen=seen)


def _mirror(rng: np.random.Generator, window: Window) -> Window:
    """Mirror the window: left becomes right."""
    if rng.random() >= 0.5:
        return window
    return replace(
        window,
        positions=window.positions.conj(),
        place=window.place.conj(),
        yaw=-window.yaw,
        error=window.error.conj(),
    )


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _gaussian(rng: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.complex128]:
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


def _wander(rng: np.random.Generator, frames: int, count: int, dt: float, time: float) -> NDArray[np.complex128]:
    """[L, N] complex Ornstein–Uhlenbeck processes; each part has variance 1 and the correlation time ``time`` in s."""
    kept = np.exp(-dt / time)
    found = np.empty((frames, count), np.complex128)
    found[0] = _gaussian(rng, (count,))
    for t in range(1, frames):
        found[t] = kept * found[t - 1] + np.sqrt(1.0 - kept**2) * _gaussian(rng, (count,))
    return found


TRIES = 10_000
"""Windows that are tried for a batch before giving up: some sequences are too short."""
ONE_STEP, ROLLOUT, COLD_START = (PROTOCOLS.index(name) for name in ("one-step", "rollout", "cold-start"))


class Batch(NamedTuple):
    """B windows of L frames and K people. The world begins at the first pose.

    Attributes
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
        return Batch(Sights(*(values.to(device) for values in self.sights)), *(rows.to(device) for rows in self[1:]))

    def take_over(self, other: "Batch") -> None:
        """Replace all numbers by those of another batch of the same shape."""
        for mine, values in zip((*self.sights, *self[1:]), (*other.sights, *other[1:]), strict=True):
            mine.copy_(values)


def draw_size(rng: np.random.Generator, recipe: Recipe) -> Size:
    """The size of a batch, which is drawn before its windows."""
    shares = np.array([size.share for size in recipe.size])
    return recipe.size[rng.choice(len(recipe.size), p=shares / shares.sum())]


def batch_of(
    rng: np.random.Generator, crowds: Crowds, recipe: Recipe, phase: Phase, size: Size, *, filled: bool = False
) -> Batch:
    """A batch of windows of one size.

    Raises VbbenchError if no stream has sequences that long.

    Parameters
    ----------
    filled : whether arrays are padded to the greatest number of people of the size, so that all batches of a size have
        the same shape.
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
    padding = Sights(seen=0.0, ray=1.0, by_height=0.0, by_feet=0.0, has_feet=0.0, noise=UNKNOWN_STD, cut=0.0)
    filled = (_filled([*rows], people, empty) for rows, empty in zip(zip(*shown, strict=True), padding, strict=True))
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
        sights=Sights(*map(torch.from_numpy, filled)),
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
