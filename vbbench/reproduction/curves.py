"""Figures of a scored dataset over the number K of people in its scenes."""

from dataclasses import dataclass

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import SequenceTable
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.scoring.scorecard import Score
from vbbench.scoring.statistics import bootstrap_means, known

PANELS = ("dr", "dt", "dx_rel", "dx")
"""The metrics of the paper's figure, in its order."""


@dataclass(frozen=True, kw_only=True)
class Statistic:
    """One metric over some sequences.

    Parameters
    ----------
    mean, median : of the sequences' figures.
    low, high : ends of the 95 % bootstrap interval of the mean over sequences.
    """

    mean: float
    low: float
    high: float
    median: float


@dataclass(frozen=True, kw_only=True)
class Point:
    """The figure's metrics over the sequences with the same number of people.

    Parameters
    ----------
    people : K, people of the scene, the observer included.
    sequences : scored sequences.
    seen : mean over sequences of the people whose place is scored in a frame.
    coverage : share of scored rows that were submitted: of poses or of positions, whichever is smaller.
    statistics : by metric.
    """

    people: int
    sequences: int
    seen: float
    coverage: float
    statistics: dict[str, Statistic]


def points_by_people(score: Score, dataset: Dataset) -> tuple[Point, ...]:
    """A point for every number of people K, in ascending order.

    Raises
    ------
    FileError
        If the truth is withheld: it alone tells K.
    """
    people = scene_people(dataset)[score.per_sequence.sequence]
    return tuple(_point(score, int(count), people == count) for count in np.unique(people))


def scene_people(dataset: Dataset) -> IntArray:
    """[N] number of people in the scene of each sequence, the observer included, seen or not."""
    scenes = dataset.rows["scene"]
    table = SequenceTable(dataset.table_path("truth/people"), "truth/people", "scene")
    rows = table.read(0, int(scenes.max()) + 1, ["scene"])
    return np.asarray(np.bincount(rows["scene"])[scenes])


def _point(score: Score, people: int, chosen: BoolArray) -> Point:
    own = score.per_sequence
    figures = np.stack([own.figures[name][chosen] for name in PANELS], axis=1)
    low, high = np.quantile(bootstrap_means(figures), [0.025, 0.975], axis=0)
    columns = zip(PANELS, figures.T, low.tolist(), high.tolist(), strict=True)
    return Point(
        people=people,
        sequences=len(figures),
        seen=float(np.mean(own.positions[chosen] / own.frames[chosen])),
        coverage=min(_share(own.posed[chosen], own.frames[chosen]), _share(own.placed[chosen], own.positions[chosen])),
        statistics={name: _statistic(known(values), *interval) for name, values, *interval in columns},
    )


def _statistic(values: FloatArray, low: float, high: float) -> Statistic:
    mean, median = (np.mean(values), np.median(values)) if len(values) else (np.nan, np.nan)
    return Statistic(mean=float(mean), low=low, high=high, median=float(median))


def _share(part: IntArray, whole: IntArray) -> float:
    return float(part.sum() / whole.sum()) if whole.any() else 1.0
