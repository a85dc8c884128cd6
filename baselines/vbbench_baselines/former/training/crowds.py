"""Simulated sequences as measurements and truth: generated once, in parallel, and kept in files of arrays."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError
from vbbench.files.dataset import problem_of
from vbbench.folders.replacing import replacing
from vbbench.generation.generator import Options
from vbbench.generation.planning import build_sequence, planned
from vbbench.parallel.parts import in_parallel, progress_bar
from vbbench_baselines.former.scene import Sights, sights_of
from vbbench_baselines.former.training.recipe import Recipe

SHORTEST = 8
"""Frames of the shortest sequence that is kept."""
EDITION = 1
"""Of what `watch` makes of a dataset's sequence: files of another edition are not read."""
AT_ONCE = 100
"""Sequences of a file at most."""


class Watched(NamedTuple):
    """One sequence: what the network sees, and the truth.

    Attributes
    ----------
    positions : [T, K] true places in m, x + i·y; NaN where nobody is.
    poses : [T, 3] true poses of the camera.
    sights : measurements of boxes, arrays [T, K].
    dt : duration of a frame in s.
    spread : standard deviation of heights, as a share of their mean.
    """

    positions: NDArray[np.complex64]
    poses: NDArray[np.float32]
    sights: Sights
    dt: float
    spread: float


class Chunk(NamedTuple):
    """Sequences ``first`` to ``last`` of a split with these options."""

    split: str
    options: Options
    first: int
    last: int


@dataclass(frozen=True)
class Crowds:
    """All sequences of a recipe.

    Parameters
    ----------
    streams : the sequences of each stream in each scenario.
    shares : the share of the training's windows that each supplies.
    """

    streams: tuple[tuple[Watched, ...], ...]
    shares: NDArray[np.float64]

    def __len__(self) -> int:
        return sum(map(len, self.streams))


def make_crowds(recipe: Recipe, folder: Path, seed: int, *, part: float = 1.0, jobs: int = 1) -> Crowds:
    """The sequences of a recipe with a seed; those in the folder are read instead of generated.

    A file's name identifies the parameters of its sequences, so that trainings can share a folder. ``part`` is the
    share of the recipe's sequences.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts: list[tuple[float, list[tuple[Chunk, Path]]]] = []
    for stream in recipe.stream:
        count = max(1, round(part * stream.sequences))
        for scenario in stream.scenarios:
            options = stream.options(scenario, tuple(recipe.people[scenario]), seed)
            name = f"{stream.name}-{scenario}-{planned(stream.split, options).info.id}-{EDITION}"
            bounds = [(first, min(first + AT_ONCE, count)) for first in range(0, count, AT_ONCE)]
            chunks = [(Chunk(stream.split, options, *at), folder / f"{name}-{at[0]}-{at[1]}.npz") for at in bounds]
            parts.append((stream.share / len(stream.scenarios), chunks))
    everything = [one for _, chunks in parts for one in chunks]
    missing = [(chunk, file) for chunk, file in everything if not file.exists()]
    done = len(everything) - len(missing)
    with progress_bar(len(everything), f"crowds of seed {seed}", done=done, unit="part") as bar:
        for _ in in_parallel(_write, missing, jobs):
            bar.update()
    read = [(share, tuple(one for _, file in chunks for one in _read(file))) for share, chunks in parts]
    filled = [(share, watched) for share, watched in read if watched]
    shares = np.array([share for share, _ in filled])
    return Crowds(tuple(watched for _, watched in filled), shares / shares.sum())


def watch(chunk: Chunk) -> Iterator[Watched]:
    """Generate the sequences of a chunk."""
    plan = planned(chunk.split, chunk.options)
    for index in range(chunk.first, chunk.last):
        data = build_sequence(plan, index)
        problem = problem_of(plan.info, data.sequence)
        truth, boxes = data.truth, data.sequence.observations
        if len(truth.poses) >= SHORTEST and boxes.shape[1]:
            yield Watched(
                positions=(truth.positions[..., 0] + 1j * truth.positions[..., 1]).astype(np.complex64),
                poses=truth.poses.astype(np.float32),
                sights=sights_of(problem, boxes),
                dt=problem.dt,
                spread=problem.height_std / problem.height_mean,
            )


def _write(chunk: Chunk, file: Path) -> None:
    """Generate a chunk and write its file atomically."""
    watched = list(watch(chunk))
    arrays: dict[str, NDArray[Any]] = {
        "shapes": np.array([one.positions.shape for one in watched], np.int64).reshape(-1, 2),
        "dt": np.array([one.dt for one in watched]),
        "spread": np.array([one.spread for one in watched]),
    }
    if watched:
        arrays["positions"] = np.concatenate([one.positions.ravel() for one in watched])
        arrays["poses"] = np.concatenate([one.poses for one in watched])
        for name in Sights._fields:
            parts = [getattr(one.sights, name) for one in watched]
            arrays[name] = np.concatenate([part.reshape(-1, *part.shape[2:]) for part in parts])
    with replacing(file, ".npz") as draft:
        np.savez(draft, **arrays)  # type: ignore[arg-type]


def _read(path: Path) -> list[Watched]:
    try:
        with np.load(path) as file:
            arrays = {name: file[name] for name in file.files}
    except (OSError, ValueError, BadZipFile, zlib.error) as error:
        raise FileError(path, "is damaged; remove it, and it is regenerated") from error
    shapes = [tuple(shape) for shape in arrays["shapes"].tolist()]
    cells = [0, *accumulate(frames * people for frames, people in shapes)]
    frames = [0, *accumulate(count for count, _ in shapes)]
    return [
        Watched(
            positions=arrays["positions"][cells[i] : cells[i + 1]].reshape(shape),
            poses=arrays["poses"][frames[i] : frames[i + 1]],
            sights=Sights(
                *(
                    arrays[name][cells[i] : cells[i + 1]].reshape(*shape, *arrays[name].shape[1:])
                    for name in Sights._fields
                )
            ),
            dt=float(arrays["dt"][i]),
            spread=float(arrays["spread"][i]),
        )
        for i, shape in enumerate(shapes)
    ]
