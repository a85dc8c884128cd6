"""How people walk around an observer, frame by frame, and what goes with it at equal numbers of people.

The observer counts as one of the walkers. With the directions α of everybody who moves, the **spread of directions** is
1 − |mean of exp(iα)|: 0 where all go one way, near 1 where as many come as go. The **spread of lines** is
1 − |mean of exp(2iα)|: 0 also where people walk along one line in opposite ways, greater where paths cross. The
**spread of bearings** is 1 − |mean of exp(iβ)| of the bearings β under which people are seen: 0 where all are on one
side, near 1 where they are all around.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import START_FRAMES
from vbbench.reproduction.agreement import LEVEL, SEED, Errors, Estimate
from vbbench.scoring.block_bootstrap import Timeline

STANDING = 0.3
"""In m/s; a slower person has no direction."""
WINDOW = 10
"""Frames of an example."""
FEW, MORE = 3, (5, 12)
"""People seen in the paper's sparse example, and in the crowded one; with more no picture shows them apart."""
RESAMPLES = 400
FEWEST_EQUAL = 20
"""Numbers of people with fewer frames than this are not informative at equal number."""

Columns = Mapping[str, Any]
"""Arrays [F] by name, of the same frames."""


def walking_of(dataset: Dataset) -> dict[str, Any]:
    """How people truly walk in the frames [F] of all sequences, from the third on.

    Columns are sequence and frame, the people seen, and the spreads of directions, of lines and of bearings, NaN where
    they are of nobody.
    """
    found = []
    for sequence in dataset.sequences():
        truth, observed = dataset.truth(sequence), sequence.observed
        people = np.where(observed[..., None], truth.positions, np.nan)
        places = truth.poses[:, None, :2]
        velocity = np.diff(np.concatenate([people, places], axis=1), axis=0)[START_FRAMES - 1 :] / dataset.info.dt
        off = (people - places)[START_FRAMES:]
        bearings = directional_spread(np.arctan2(off[..., 1], off[..., 0]))
        spread, lines = spreads(velocity)
        frames = np.arange(START_FRAMES, sequence.frames)
        numbers = np.full(len(frames), sequence.index), frames, observed[START_FRAMES:].sum(axis=1)
        found.append((*numbers, spread, lines, bearings))
    names = ("sequence", "frame", "people", "spread", "lines", "bearings")
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
    """Frames [F] of sequences [N] on a timeline: the sequence of each, ascending, and how many people are seen."""

    sequence: IntArray
    people: IntArray
    timeline: Timeline

    def estimate(self, statistic: Callable[..., float], *columns: FloatArray) -> Estimate:
        """A statistic of columns [F] and the number of people, with its interval; frames with a NaN are removed.

        Intervals are quantiles over a bootstrap of blocks of time as long as the first column stays equal, in which
        sequences are drawn with all of their frames.
        """
        there, size = ~np.isnan(columns[0]), len(self.timeline.middle)
        number = np.bincount(self.sequence[there], minlength=size)
        mean = np.bincount(self.sequence[there], columns[0][there], size) / np.maximum(number, 1)
        filled = np.where(number > 0, mean, mean[number > 0].mean())
        times = Errors(values=filled[None], timeline=self.timeline).counts(RESAMPLES, SEED).astype(np.int64)
        known = ~np.isnan(np.stack(columns)).any(axis=0)
        values = [*(column[known] for column in columns), self.people[known]]
        drawn = np.array([statistic(*(np.repeat(v, row) for v in values)) for row in times[:, self.sequence[known]]])
        drawn = drawn[~np.isnan(drawn)]
        low, high = np.quantile(drawn, LEVEL).tolist() if len(drawn) else (np.nan, np.nan)
        return Estimate(statistic(*values), low, high)


def rank_correlation(one: FloatArray, other: FloatArray, _people: IntArray) -> float:
    """Spearman's ρ of columns [F]."""
    from scipy.stats import rankdata

    return correlation(rankdata(one), rankdata(other))


def rank_correlation_at_equal_number(one: FloatArray, other: FloatArray, people: IntArray) -> float:
    """Spearman's ρ among frames with the same number of people: of ranks within each number, over its frames."""
    return correlation(ranks_within(one, people), ranks_within(other, people))


def correlation(one: FloatArray, other: FloatArray) -> float:
    """Pearson's; NaN where either does not vary."""
    one, other = one - one.mean(), other - other.mean()
    scale = float(np.sqrt((one @ one) * (other @ other)))
    return float(one @ other) / scale if scale > 0.0 else float("nan")


def less_the_mean(values: FloatArray, groups: IntArray) -> FloatArray:
    """Values [F] less the mean of their group; 0 in groups with fewer than `FEWEST_EQUAL`."""
    number = np.bincount(groups)
    mean = np.bincount(groups, values) / np.maximum(number, 1)
    return np.where(number[groups] >= FEWEST_EQUAL, values - mean[groups], 0.0)


def ranks_within(values: FloatArray, groups: IntArray) -> FloatArray:
    """Ranks [F] within each group, equals sharing theirs, as a share of the group's size less the mean."""
    from scipy.stats import rankdata

    among_all = rankdata(values)
    within = rankdata(groups * (2.0 * len(values)) + among_all)
    return less_the_mean(within, groups) / np.bincount(groups)[groups]
