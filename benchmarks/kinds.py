"""Errors on a dataset of footage by kind of sequence: how the camera moves, how dense and quick people are, how near.

``python -m benchmarks.kinds DATASET SUBMISSION...``, such as those in the work folder of `vbbench leaderboard rerun`,
prints a table: for each kind, and for each submission, capped means of Δx / Δt / Δx̃ in m, and of how many sequences.
"""

import argparse
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import get_protocol
from vbbench.scoring import score
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import capped_figures

SHOWN = ("dx", "dt", "dx_rel")
STANDS = 1.0
"""A camera that is driven less than so many m in a sequence stands."""
EDGES = {
    "camera driven, m": (0.0, STANDS, np.inf),
    "people a frame": (0.0, 5.0, 10.0, np.inf),
    "speed of people, m/s": (0.0, 0.5, 1.0, np.inf),
    "box height, px": (0.0, 40.0, 80.0, np.inf),
}
"""Where the kinds of a feature of sequences begin and end."""


def features(dataset: Dataset) -> dict[str, FloatArray]:
    """Feature → [N] of every sequence; medians where it has many values."""
    rows = []
    for sequence in dataset.sequences():
        relative = dataset.info.truth == "relative"
        truth = None if relative else dataset.truth(sequence)
        second = max(round(1.0 / dataset.info.dt), 1)
        driven, speed = np.nan, np.nan
        if truth is not None:
            driven = float(np.hypot(*np.diff(truth.poses[:, :2], axis=0).T).sum())
            moved = truth.positions[second:] - truth.positions[:-second]
            speeds = np.hypot(moved[..., 0], moved[..., 1]) / (second * dataset.info.dt)
            speed = float(np.nanmedian(speeds)) if np.isfinite(speeds).any() else np.nan
        heights = sequence.observations[..., 2][sequence.observed]
        rows.append((driven, sequence.observed.sum(axis=1).mean(), speed, np.median(heights)))
    return dict(zip(EDGES, np.array(rows).reshape(-1, len(EDGES)).T, strict=True))


def kinds(found: dict[str, FloatArray]) -> Iterator[tuple[str, IntArray]]:
    """Name of every kind, and the numbers of its sequences."""
    yield "all", np.arange(len(next(iter(found.values()))))
    for name, values in found.items():
        edges = EDGES[name]
        for low, high in pairwise(edges):
            end = f"{low:g} or more" if high == np.inf else f"{low:g} to {high:g}"
            yield f"{name}: {end}", np.flatnonzero((values >= low) & (values < high))


def errors(submission: Path, dataset: Path) -> FloatArray:
    """[sequences, metrics] capped means of the `SHOWN` metrics; NaN where a sequence is not scored."""
    result = score(submission, dataset)
    own, caps = result.per_sequence, get_protocol(result.protocol.name).caps
    capped = capped_figures(caps, {name: own.figures[name] for name in METRICS})
    table = np.full((result.total_sequences, len(SHOWN)), np.nan)
    table[own.sequence] = capped[:, [list(METRICS).index(name) for name in SHOWN]]
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("dataset", type=Path)
    parser.add_argument("submissions", type=Path, nargs="+", metavar="SUBMISSION")
    options = parser.parse_args()
    tables = {folder: errors(folder, options.dataset) for folder in options.submissions}
    print(f"| | sequences | {' | '.join(folder.name for folder in tables)} |\n|{'---|' * (len(tables) + 2)}")
    for name, numbers in kinds(features(Dataset(options.dataset))):
        if not len(numbers):
            continue
        cells = [" / ".join(_mean(column) for column in table[numbers].T) for table in tables.values()]
        print(f"| {name} | {len(numbers)} | {' | '.join(cells)} |")


def _mean(values: FloatArray) -> str:
    known = values[np.isfinite(values)]
    return f"{known.mean():.2f}" if len(known) else "–"


if __name__ == "__main__":
    main()
