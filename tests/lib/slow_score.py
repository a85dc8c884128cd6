"""Scores as one would first write it: pandas tables and a Python loop over rows. Shares no code with vbbench.

The tests check the library against it, and ``benchmarks/bench_scoring.py`` its speed.
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

Figures = dict[str, list[float]]


def score_rows(
    dataset: Path, submission: Path, given: str = "arrivals", sequences: int | None = None, each: str = "iterrows"
) -> dict[int, dict[str, float]]:
    """Figures of each sequence (of the first few) by metric; ``each`` is how pandas hands out its rows."""
    tables = {
        name: pd.read_parquet(folder / f"{name}.parquet")
        for folder, names in ((dataset, _DATASET), (submission, ("poses", "positions")))
        for name in names
    }
    truth = {(r.scene, r.frame, r.person): (r.x, r.y) for r in tables["truth/scenes"].itertuples()}
    by_sequence = {name: dict(list(tables[name].groupby("sequence"))) for name in _BY_SEQUENCE}
    limit = sequences or len(tables["sequences"])
    results = {}
    for row in tables["sequences"].head(limit).itertuples():
        parts = {name: groups.get(row.sequence, tables[name].head(0)) for name, groups in by_sequence.items()}
        figures = _sequence(row, parts, truth, given, each)
        if figures["dt"]:
            results[row.sequence] = {name: sum(values) / len(values) for name, values in figures.items() if values}
    return results


def bootstrap(figures: list[float], resamples: int = 4000, seed: int = 0) -> tuple[float, float]:
    """Interval of the mean, one resample after the other."""
    random = np.random.default_rng(seed)
    means = [float(np.mean(random.choice(figures, len(figures)))) for _ in range(resamples)]
    return float(np.quantile(means, 0.025)), float(np.quantile(means, 0.975))


def _sequence(row: Any, parts: dict[str, pd.DataFrame], truth: dict[Any, Any], given: str, each: str) -> Figures:
    known = {(r.frame, r.track) for r in _rows(parts["given"], each) if given == "arrivals" or r.frame < 2}
    pose = {r.frame: (r.x, r.y, r.yaw) for r in _rows(parts["poses"], each)}
    true_pose = {r.frame: (r.x, r.y, r.yaw) for r in _rows(parts["truth/poses"], each)}
    place = {(r.frame, r.track): (r.x, r.y) for r in _rows(parts["positions"], each)}
    (world,) = parts["truth/frames"].itertuples()
    tracks = list(parts["truth/tracks"].itertuples())
    figures: Figures = defaultdict(list)
    frames = set()
    for seen in _rows(parts["observations"], each):
        if seen.frame < 2:
            continue
        frames.add(seen.frame)
        if (seen.frame, seen.track) in known:
            continue
        x, y = place[seen.frame, seen.track]
        tx, ty = _in_world(world, truth[row.scene, row.first_frame + seen.frame, _person(tracks, seen)])
        ox, oy, _ = pose[seen.frame]
        rx, ry, _ = true_pose[seen.frame]
        figures["dx"].append(math.sqrt((x - tx) ** 2 + (y - ty) ** 2))
        figures["dx_rel"].append(math.sqrt(((x - ox) - (tx - rx)) ** 2 + ((y - oy) - (ty - ry)) ** 2))
    for frame in frames:
        x, y, yaw = pose[frame]
        tx, ty, true_yaw = true_pose[frame]
        figures["dt"].append(math.sqrt((x - tx) ** 2 + (y - ty) ** 2))
        figures["dr"].append(math.acos(max(-1.0, min(1.0, math.cos(yaw - true_yaw)))))
    return figures


def _person(tracks: list[Any], seen: Any) -> int:
    """Whoever the track last began to stand for."""
    return [row.person for row in tracks if row.track == seen.track and row.frame <= seen.frame][-1]


def _in_world(world: Any, place: tuple[float, float]) -> tuple[float, float]:
    turned = complex(*place) * complex(math.cos(world.yaw), math.sin(world.yaw))
    return turned.real + world.x, turned.imag + world.y


def _rows(table: pd.DataFrame, each: str) -> Iterator[Any]:
    return (row for _, row in table.iterrows()) if each == "iterrows" else table.itertuples()


_DATASET = ("sequences", "observations", "given", "truth/scenes", "truth/poses", "truth/frames", "truth/tracks")
_BY_SEQUENCE = ("observations", "given", "truth/poses", "truth/frames", "truth/tracks", "poses", "positions")
