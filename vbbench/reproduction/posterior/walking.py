"""How people walk around an observer, frame by frame, and stretches of a recording picked for it.

The observer counts as one of the walkers. With the directions α of everybody who moves, the **spread of directions** is
1 − |mean of exp(iα)|: 0 where all go one way, near 1 where as many come as go. The **spread of lines** is
1 − |mean of exp(2iα)|: 0 also where people walk along one line in opposite ways, greater where paths cross. The
**spread of bearings** is 1 − |mean of exp(iβ)| of the bearings β under which people are seen: 0 where all are on one
side, near 1 where they are all around.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import START_FRAMES

STANDING = 0.3
"""In m/s; whoever is slower has no direction."""
WINDOW = 10
"""Frames of an example."""
FEW = 3
"""People seen in the paper's sparse example; also the least number that counts as few."""
MORE = (5, 12)
"""People seen in the crowded one; where there are more than this, no picture shows them apart."""


@dataclass(frozen=True, kw_only=True)
class Walking:
    """The frames of one sequence, from the third on: [F] each.

    Parameters
    ----------
    sequence : its number.
    frame : numbers of the frames.
    people : how many people are seen.
    spread, lines : of directions and of lines, NaN where nobody moves.
    bearings : their spread, NaN where nobody is seen.
    standing : share of the walkers who stand.
    arrivals : how many are seen for the first time.
    """

    sequence: int
    frame: IntArray
    people: IntArray
    spread: FloatArray
    lines: FloatArray
    bearings: FloatArray
    standing: FloatArray
    arrivals: IntArray


def walking_of(dataset: Dataset) -> list[Walking]:
    """How people truly walk in each sequence."""
    found = []
    for sequence in dataset.sequences():
        truth, observed = dataset.truth(sequence), sequence.observed
        people = np.where(observed[..., None], truth.positions, np.nan)
        places = truth.poses[:, None, :2]
        velocity = np.diff(np.concatenate([people, places], axis=1), axis=0)[START_FRAMES - 1 :] / dataset.info.dt
        spread, lines, standing = spreads(velocity)
        off = (people - places)[START_FRAMES:]
        frames = np.arange(START_FRAMES, sequence.frames)
        found.append(
            Walking(
                sequence=sequence.index,
                frame=frames,
                people=observed[START_FRAMES:].sum(axis=1),
                spread=spread,
                lines=lines,
                bearings=directional_spread(np.arctan2(off[..., 1], off[..., 0])),
                standing=standing,
                arrivals=np.bincount(observed.argmax(axis=0), minlength=sequence.frames)[START_FRAMES:],
            )
        )
    return found


def spreads(velocity: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Spread of directions, spread of lines and share of those who stand, [F] each.

    Parameters
    ----------
    velocity : [F, K, 2] in m/s, NaN = not known.
    """
    speed, angle = np.hypot(velocity[..., 0], velocity[..., 1]), np.arctan2(velocity[..., 1], velocity[..., 0])
    moving: BoolArray = speed >= STANDING
    count, known = moving.sum(axis=-1), (~np.isnan(speed)).sum(axis=-1)
    angle = np.where(moving, angle, np.nan)
    return directional_spread(angle), directional_spread(2.0 * angle), (known - count) / np.maximum(known, 1)


def directional_spread(angle: FloatArray) -> FloatArray:
    """1 − |mean of exp(iα)| [F] of angles α [F, K] in rad, NaN = none."""
    known = ~np.isnan(angle)
    count = known.sum(axis=-1)
    total = np.abs(np.where(known, np.exp(1j * angle), 0.0).sum(axis=-1))
    return np.where(count > 0, 1.0 - total / np.maximum(count, 1), np.nan)


def along_walk(path: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """What turns places [..., 2] in m into those along, and to the left of, the way from a path's first place [T, 2].

    The way leads to its last place. Each sequence has a world of its own, turned at random; in these axes pictures of
    several can be compared.
    """
    known = path[~np.isnan(path[:, 0])]
    way = known[-1] - known[0]
    angle = np.arctan2(way[1], way[0])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return lambda places: (places - known[0]) @ turn


@dataclass(frozen=True, kw_only=True)
class Example:
    """Ten frames of a sequence, and what they are an example of.

    Parameters
    ----------
    title : in words.
    sequence, first : its number, and the first of the frames.
    people, spread, lines : means over the frames.
    """

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


def pick_examples(walks: Sequence[Walking]) -> list[Example]:
    """Few and more people, each parallel and crossing, of all stretches of `WINDOW` frames; none where there is none.

    Few: at least `FEW` people in every frame, and never more than the sparsest such stretch has at most. More: as many
    as `MORE` says in every frame. Parallel: the least spread of directions. Crossing: the greatest product of the
    spreads of directions and of lines. Of equals, the first.
    """
    stretches = [one for walk in walks for one in _stretches(walk)]
    sparse = min((one.most for one in stretches if one.least >= FEW), default=FEW)
    kinds = {
        f"{FEW if sparse == FEW else f'{FEW} to {sparse}'} people": (FEW, sparse),
        f"{MORE[0]} to {MORE[1]} people": MORE,
    }
    found = []
    for people, (least, most) in kinds.items():
        fitting = [one for one in stretches if one.least >= least and one.most <= most]
        for how, key in _ORDERS.items():
            if fitting:
                best = min(fitting, key=key)
                found.append(
                    Example(
                        title=f"{people}, {how}",
                        sequence=best.walk.sequence,
                        first=int(best.walk.frame[best.begin]),
                        people=best.mean(best.walk.people),
                        spread=best.mean(best.walk.spread),
                        lines=best.mean(best.walk.lines),
                    )
                )
    return found


@dataclass(frozen=True, kw_only=True)
class _Stretch:
    walk: Walking
    begin: int

    def mean(self, values: FloatArray | IntArray) -> float:
        return float(np.mean(values[self.begin : self.begin + WINDOW]))

    @property
    def least(self) -> int:
        return int(self.walk.people[self.begin : self.begin + WINDOW].min())

    @property
    def most(self) -> int:
        return int(self.walk.people[self.begin : self.begin + WINDOW].max())


def _stretches(walk: Walking) -> Iterable[_Stretch]:
    """Those in which somebody moves in every frame."""
    for begin in range(len(walk.frame) - WINDOW + 1):
        if not np.isnan(walk.spread[begin : begin + WINDOW]).any():
            yield _Stretch(walk=walk, begin=begin)


_ORDERS: dict[str, Callable[[_Stretch], float]] = {
    "parallel": lambda one: round(one.mean(one.walk.spread), 9),
    "crossing": lambda one: -round(one.mean(one.walk.spread) * one.mean(one.walk.lines), 9),
}
