"""How often the 95 % interval of a mean over sequences holds the true mean, by simulation.

Run from the repository: ``python -m benchmarks.interval_coverage [--repeats 1000] [DATASET ...]``. Sequences overlap in
time and share people. Every person present adds an effect of its own to the error of each sequence that sees it, in
proportion to the time that both have in common (``people``); or the errors follow something that changes slowly, with
the given frames to a correlation of 1/e. The rest is the sequence's own. Errors are log-normal, so that the true
mean is known: exp(spread²/2). Beside it stands what intervals cover that take sequences to be independent.
Named datasets lend their real times; otherwise times are drawn, as many and as long as in the paper's splits.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.scoring.block_bootstrap import Timeline, block_means


@dataclass(frozen=True, kw_only=True)
class Times:
    """When the sequences are: scene, first frame and frames, each [N]."""

    scene: IntArray
    first: IntArray
    frames: IntArray

    @property
    def timeline(self) -> Timeline:
        """Their timeline."""
        return Timeline.of(self.scene, self.first, self.first + self.frames - 1)


@dataclass(frozen=True, kw_only=True)
class Crowd:
    """Sequences of a split: scenes, sequences in each, frames of a scene, and the frames of a sequence.

    Frames of sequences are log-normal of the median and spread given, and at most the longest; people come in groups.
    """

    scenes: int
    sequences: int
    span: int
    median: float
    spread: float
    longest: int

    def times(self, random: np.random.Generator) -> Times:
        """Times drawn anew."""
        count = self.scenes * self.sequences
        drawn = self.median * np.exp(self.spread * random.normal(size=count))
        frames = np.clip(drawn.astype(np.int64), 3, min(self.longest, self.span))
        come = np.repeat(random.random(count), random.integers(1, 4, count))[:count]
        first = (come * (self.span - frames + 1)).astype(np.int64)
        return Times(scene=np.repeat(np.arange(self.scenes), self.sequences), first=first, frames=frames)


CROWDS = {
    "hotel": Crowd(scenes=1, sequences=321, span=1807, median=14, spread=0.6, longest=99),
    "eth": Crowd(scenes=1, sequences=340, span=1154, median=15, spread=0.4, longest=114),
    "students": Crowd(scenes=2, sequences=425, span=492, median=37, spread=0.6, longest=351),
    "sim": Crowd(scenes=500, sequences=1, span=20, median=20, spread=0.0, longest=20),
}
"""As many and as long as those of these splits."""


@dataclass(frozen=True, kw_only=True)
class Errors:
    """What errors share: share of the variance of their logarithm, frames that it lasts (0: people), and spread."""

    shared: float
    lasting: float
    spread: float

    @property
    def mean(self) -> float:
        """The true mean."""
        return float(np.exp(self.spread**2 / 2))

    def mixing(self, times: Times) -> FloatArray:
        """[N, S] how much of each of S independent normal numbers the sequences share; rows of length 1."""
        begin, end, same = times.first, times.first + times.frames, times.scene[:, None] == times.scene
        if not self.lasting:
            common = np.minimum(end[:, None], end) - np.maximum(begin[:, None], begin)
            mixing = np.where(same, np.clip(common, 0, None), 0).astype(float)
        else:
            middle = (begin + end) / 2
            alike = np.exp(-np.abs(middle[:, None] - middle) / self.lasting) * same
            mixing = np.linalg.cholesky(alike + 1e-9 * np.eye(len(middle)))
        return mixing / np.linalg.norm(mixing, axis=1, keepdims=True)

    def draw(self, random: np.random.Generator, times: Times, repeats: int) -> FloatArray:
        """[N, repeats] errors of the sequences."""
        mixing = self.mixing(times)
        shared = mixing @ random.normal(size=(mixing.shape[1], repeats))
        own = random.normal(size=shared.shape)
        return np.exp(self.spread * (np.sqrt(self.shared) * shared + np.sqrt(1.0 - self.shared) * own))


KINDS = {
    "people": Errors(shared=0.7, lasting=0, spread=0.4),
    "people, skewed": Errors(shared=0.7, lasting=0, spread=0.66),
    "30 frames": Errors(shared=0.7, lasting=30, spread=0.5),
    "60 frames": Errors(shared=0.6, lasting=60, spread=0.5),
}
"""Neighbours correlate as those of the splits do (.36 to .60)."""


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """How often the intervals hold the true mean, and that of a difference of two solvers; and what goes with it."""

    mean: float
    difference: float
    independent: float
    neighbours: float
    width: float
    blocks: float


def coverage(times: Iterator[Times], kind: Errors, repeats: int, random: np.random.Generator) -> Coverage:
    """Coverage over ``repeats`` draws, each with the next times."""
    rows = [_one(next(times), kind, random) for _ in range(repeats)]
    held, difference, independent, neighbours, width, blocks, means = np.array(rows).T
    return Coverage(
        mean=float(held.mean()),
        difference=float(difference.mean()),
        independent=float(independent.mean()),
        neighbours=float(neighbours.mean()),
        width=float(width.mean() / (2 * 1.96 * means.std())),
        blocks=float(np.median(blocks)),
    )


def _one(times: Times, kind: Errors, random: np.random.Generator) -> tuple[float, ...]:
    errors, timeline = kind.draw(random, times, 2), times.timeline
    one, other = errors[:, :1], errors[:, 1:]
    found = block_means(timeline, one)
    low, high = found.positive_interval(np.full(1, np.inf))[0]
    apart_low, apart_high = block_means(timeline, one - other).interval()[0]
    alone = 1.96 * one.std() / np.sqrt(len(one))
    sorted_errors = one[np.argsort(timeline.middle), 0]
    neighbours = np.corrcoef(sorted_errors[:-1], sorted_errors[1:])[0, 1]
    mean = float(found.mean[0])
    return (
        low <= kind.mean <= high,
        apart_low <= 0 <= apart_high,
        abs(mean - kind.mean) <= alone,
        neighbours,
        high - low,
        found.blocks,
        mean,
    )


def _real(folder: Path) -> Times:
    rows = Dataset(folder).rows
    keep = rows["frames"] > 2
    return Times(scene=rows["scene"][keep], first=rows["first_frame"][keep], frames=rows["frames"][keep])


def _forever(times: Times) -> Iterator[Times]:
    while True:
        yield times


def drawn(crowd: Crowd, random: np.random.Generator) -> Iterator[Times]:
    """Times of such a crowd, without end."""
    while True:
        yield crowd.times(random)


def main(folders: list[Path], repeats: int) -> None:
    random = np.random.default_rng(17)
    sources = {folder.name: _forever(_real(folder)) for folder in folders} or {
        name: drawn(crowd, random) for name, crowd in CROWDS.items()
    }
    print("| sequences | errors share | neighbours correlate | blocks | mean held | difference held | "
          "width / ideal | held if independent |\n|---|---|---:|---:|---:|---:|---:|---:|")  # fmt: skip
    for name, times in sources.items():
        for words, kind in KINDS.items():
            c = coverage(times, kind, repeats, random)
            print(f"| {name} | {words} | {c.neighbours:.2f} | {c.blocks:.1f} | {c.mean:.1%} | {c.difference:.1%} | "
                  f"{c.width:.2f} | {c.independent:.1%} |", flush=True)  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("datasets", nargs="*", type=Path)
    parser.add_argument("--repeats", type=int, default=1000)
    asked = parser.parse_args()
    main(asked.datasets, asked.repeats)
