"""How people walk around an observer, frame by frame, and what goes with it.

The observer counts as one of the walkers. With the directions α of everybody who moves, the **spread of directions** is
1 − |mean of exp(iα)|: 0 where all go one way, near 1 where as many come as go. The **spread of lines** is
1 − |mean of exp(2iα)|: 0 also where people walk along one line in opposite ways, greater where paths cross.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import START_FRAMES
from vbbench.reproduction.agreement import LEVEL, SEED, Errors, Estimate, spearman
from vbbench.scoring.block_bootstrap import Timeline

STANDING = 0.3
"""In m/s; a slower person has no direction."""
WINDOW = 10
"""Frames of an example."""
FEW, MORE = 3, (5, 12)
"""People seen in the paper's sparse example, and in the crowded one; with more no picture shows them apart."""
RESAMPLES = 400

Columns = Mapping[str, Any]
"""Arrays [F] by name, of the same frames."""


def walking_of(dataset: Dataset) -> dict[str, Any]:
    """How people truly walk in the frames [F] of all sequences, from the third on.

    Columns are sequence and frame, the people seen, and the spreads of directions and of lines, NaN where they are of
    nobody.
    """
    found = []
    for sequence in dataset.sequences():
        truth, observed = dataset.truth(sequence), sequence.observed
        people = np.where(observed[..., None], truth.positions, np.nan)
        places = truth.poses[:, None, :2]
        velocity = np.diff(np.concatenate([people, places], axis=1), axis=0)[START_FRAMES - 1 :] / dataset.info.dt
        spread, lines = spreads(velocity)
        frames = np.arange(START_FRAMES, sequence.frames)
        numbers = np.full(len(frames), sequence.index), frames, observed[START_FRAMES:].sum(axis=1)
        found.append((*numbers, spread, lines))
    names = ("sequence", "frame", "people", "spread", "lines")
    return {name: np.concatenate(parts) for name, parts in zip(names, zip(*found, strict=True), strict=True)}


def spreads(velocity: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Spreads of directions and of lines, [F] each, of velocities [F, K, 2] in m/s, NaN = not known."""
    speed, angle = np.hypot(velocity[..., 0], velocity[..., 1]), np.arctan2(velocity[..., 1], velocity[..., 0])
    angle = np.where(speed >= STANDING, angle, np.nan)
    return directional_spread(angle), directional_spread(2.0 * angle)


def directional_spread(angle: FloatArray) -> FloatArray:
    """1 − |mean of exp(iα)| [F] of angles α [F, K] in rad, NaN = none."""
    known = ~np.isnan(angle)
    count = known.sum(axis=-1)
    total = np.abs(np.where(known, np.exp(1j * angle), 0.0).sum(axis=-1))
    return np.where(count > 0, 1.0 - total / np.maximum(count, 1), np.nan)


class Example(NamedTuple):
    """Ten frames of a sequence, what they are an example of, and means over them."""

    title: str
    sequence: int
    first: int
    people: float
    spread: float
    lines: float

    @property
    def frames(self) -> range:
        """The frames' numbers."""
        return range(self.first, self.first + WINDOW)


def pick_examples(walk: Columns) -> list[Example]:
    """Few and more people, each parallel and crossing, of all stretches of `WINDOW` frames; none where there is none.

    Few: at least `FEW` people in every frame, and never more than the sparsest such stretch has at most. More: as many
    as `MORE` says in every frame. Parallel: the least spread of directions. Crossing: the greatest product of the
    spreads of directions and of lines. Of equals, the first.
    """
    sequence, people, spread = walk["sequence"], walk["people"], walk["spread"]
    stretches = [
        slice(begin, begin + WINDOW)
        for begin in range(len(sequence) - WINDOW + 1)
        if sequence[begin] == sequence[begin + WINDOW - 1] and not np.isnan(spread[begin : begin + WINDOW]).any()
    ]
    most = {one.start: int(people[one].max()) for one in stretches}
    sparse = min((most[one.start] for one in stretches if people[one].min() >= FEW), default=FEW)
    kinds = {
        f"{FEW if sparse == FEW else f'{FEW} to {sparse}'} people": (FEW, sparse),
        f"{MORE[0]} to {MORE[1]} people": MORE,
    }
    orders: dict[str, Callable[[slice], float]] = {
        "parallel": lambda one: round(float(np.mean(spread[one])), 9),
        "crossing": lambda one: -round(float(np.mean(spread[one])) * float(np.mean(walk["lines"][one])), 9),
    }
    found = []
    for title, (low, high) in kinds.items():
        fitting = [one for one in stretches if people[one].min() >= low and most[one.start] <= high]
        for how, order in orders.items() if fitting else ():
            best = min(fitting, key=order)
            means = (float(np.mean(walk[name][best])) for name in ("people", "spread", "lines"))
            found.append(Example(f"{title}, {how}", int(sequence[best.start]), int(walk["frame"][best.start]), *means))
    return found


class FrameSample(NamedTuple):
    """Frames [F] of sequences [N] on a timeline: the sequence of each, ascending."""

    sequence: IntArray
    timeline: Timeline

    def rank_correlation(self, one: FloatArray, other: FloatArray) -> Estimate:
        """Spearman's ρ of columns [F] with its interval; frames with a NaN are removed.

        Intervals are quantiles over a bootstrap of blocks of time as long as the first column stays equal, in which
        sequences are drawn with all of their frames.
        """
        there, size = ~np.isnan(one), len(self.timeline.middle)
        number = np.bincount(self.sequence[there], minlength=size)
        mean = np.bincount(self.sequence[there], one[there], size) / np.maximum(number, 1)
        filled = np.where(number > 0, mean, mean[number > 0].mean())
        times = Errors(values=filled[None], timeline=self.timeline).counts(RESAMPLES, SEED).astype(np.int64)
        known = there & ~np.isnan(other)
        pair = np.stack([one[known], other[known]])
        drawn = np.array([correlation(*np.repeat(pair, row, axis=1)) for row in times[:, self.sequence[known]]])
        drawn = drawn[~np.isnan(drawn)]
        low, high = np.quantile(drawn, LEVEL).tolist() if len(drawn) else (np.nan, np.nan)
        return Estimate(correlation(*pair), low, high)


def correlation(one: FloatArray, other: FloatArray) -> float:
    """Spearman's ρ of columns [F]; NaN where either does not vary."""
    return float(spearman(one[None], other[None])[0])
