"""Errors as neighbouring fields report them: localisation by distance, odometry drift, HOTA and IDF1.

``python -m benchmarks.literature DATASET... [--solvers vb-sf,map-causal] [--jobs 2]`` prints three tables for datasets
with their truth.

* Localisation: |estimated − true distance| of people from the camera, by 5 m of true distance, from a cold start: as
  monocular localisation reports it (MonoLoco, Bertoni et al., ICCV 2019).
* Drift: for every segment of the path of 5, 10 and 20 m the error of its end in the axes of its start, per length,
  under the protocol sequential: as KITTI's odometry benchmark does with 100 to 800 m.
* HOTA (Luiten et al., IJCV 2021) and IDF1 (Ristani et al., 2016) of people on the map, under sequential: a person and a
  track d m apart have a similarity of 1 − d / 2 m. People within 40 m in the picture count, hidden ones, too.
"""

import argparse
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray, motion_between, world_to_relative, wrap_angle
from vbbench.protocol import get_protocol, scored_frames, scored_positions
from vbbench.registry import make_solver
from vbbench.solving.runner import run_sequence

BIN, FARTHEST = 5.0, 40.0
SEGMENTS = (5.0, 10.0, 20.0)
"""Lengths in m; runs are 20 m long where KITTI's odometry has kilometres."""
APART = 2.0
"""In m, at which a person and a track have nothing in common."""
ALPHAS = np.arange(0.05, 0.99, 0.05)
"""Least similarities of a match, over which HOTA is the mean."""
SAME = 0.5
"""The least similarity of a match for IDF1."""


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Ids and places [P] of people and [K] of tracks in a frame, in m."""

    people: IntArray
    places: FloatArray
    tracks: IntArray
    found: FloatArray


def distance_errors(dataset: Dataset, solver: Any, index: int) -> FloatArray:
    """[N, 2] true distance in m of scored people from the camera, and the error of the estimated one."""
    sequence, rules = dataset.sequence(index), get_protocol("cold-start")
    truth = dataset.truth(sequence)
    estimate, _ = run_sequence(solver, dataset.problem(sequence), sequence, rules, None)
    rows = scored_positions(sequence.observed, rules.select_given(sequence.given))
    true, found = (
        np.linalg.norm(world_to_relative(one.positions, one.poses)[rows], axis=-1) for one in (truth, estimate)
    )
    known = np.isfinite(true)
    return np.stack([true[known], np.abs(found - true)[known]], axis=-1)


def segment_errors(true: FloatArray, found: FloatArray) -> Iterator[tuple[float, float, float]]:
    """Length in m, error of the end in m and in rad, of every segment of a path [T, 3] of one of the `SEGMENTS`."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(true[:, :2], axis=0).T))])
    for length in SEGMENTS:
        for start in range(len(true)):
            end = int(np.searchsorted(way, way[start] + length))
            if end == len(true):
                break
            moved, guess = (motion_between(one[start][None], one[end][None])[0] for one in (true, found))
            off = float(np.hypot(*(guess - moved)[:2]))
            yield length, off, abs(float(wrap_angle(guess[2] - moved[2])))


def mapped(dataset: Dataset, solver: Any, index: int) -> tuple[list[tuple[float, float, float]], list[Frame]]:
    """Segments of the camera's path, and people and tracks of every scored frame."""
    sequence, rules = dataset.sequence(index), get_protocol("sequential")
    truth, problem = dataset.truth(sequence), dataset.problem(sequence)
    estimate, _ = run_sequence(solver, problem, sequence, rules, truth if rules.needs_truth else None)
    scored = np.flatnonzero(scored_frames(sequence.observed))
    segments = list(segment_errors(truth.poses[scored], estimate.poses[scored]))
    people, places, heights = dataset.surroundings(sequence)
    relative = world_to_relative(places, truth.poses)
    shown = problem.camera.project(relative, np.where(np.isnan(heights), problem.height_mean, heights))
    near = np.isfinite(shown[..., 2]) & (np.linalg.norm(relative, axis=-1) < FARTHEST)
    frames = [
        Frame(
            people=people[near[frame]],
            places=places[frame, near[frame]],
            tracks=sequence.tracks[sequence.observed[frame]],
            found=estimate.positions[frame, sequence.observed[frame]],
        )
        for frame in scored.tolist()
    ]
    return segments, frames


def hota_and_idf1(frames: Sequence[Frame]) -> tuple[float, float]:
    """HOTA and IDF1 of tracks, from 0 to 1."""
    people, tracks = (
        np.unique(np.concatenate([getattr(one, name) for one in frames])) for name in ("people", "tracks")
    )
    shape = len(people), len(tracks)
    possible, likely = np.zeros(shape), np.zeros(shape)
    persons, boxes = np.zeros((shape[0], 1)), np.zeros((1, shape[1]))
    at, similar = [], []
    for one in frames:
        place = np.ix_(np.searchsorted(people, one.people), np.searchsorted(tracks, one.tracks))
        alike = np.clip(1.0 - cdist(one.places, one.found) / APART, 0.0, None)
        total = alike.sum(axis=0, keepdims=True) + alike.sum(axis=1, keepdims=True) - alike
        possible[place] += np.divide(alike, total, out=np.zeros_like(alike), where=total > 0.0)
        likely[place] += alike >= SAME
        persons[place[0]] += 1.0
        boxes[0, place[1]] += 1.0
        at.append(place)
        similar.append(alike)
    aligned = possible / np.maximum(persons + boxes - possible, 1e-12)
    matches = np.zeros((len(ALPHAS), *shape))
    for place, alike in zip(at, similar, strict=True):
        rows, columns = linear_sum_assignment(-(aligned[place] * alike))
        for n, alpha in enumerate(ALPHAS):
            hit = alike[rows, columns] >= alpha - np.finfo(float).eps
            matches[n, place[0].ravel()[rows[hit]], place[1].ravel()[columns[hit]]] += 1.0
    hits = matches.sum(axis=(1, 2))
    detected = hits / np.maximum(persons.sum() + boxes.sum() - hits, 1.0)
    associated = (matches * matches / np.maximum(persons + boxes - matches, 1.0)).sum(axis=(1, 2)) / np.maximum(
        hits, 1.0
    )
    pairs = likely[linear_sum_assignment(-likely)].sum()
    return float(np.sqrt(detected * associated).mean()), float(2.0 * pairs / (persons.sum() + boxes.sum()))


@dataclass(frozen=True, kw_only=True)
class Figures:
    """What was measured of a solver on a dataset: `distance_errors`, segments of paths, HOTA and IDF1."""

    distances: FloatArray
    segments: FloatArray
    hota: float
    idf1: float

    @staticmethod
    def of(dataset: Dataset, name: str, indices: Iterable[int]) -> "Figures":
        """The figures of a solver on some sequences; ids of people and tracks are of a sequence."""
        solver = make_solver(name)
        distances, segments, frames = [], [], []
        for index in indices:
            distances.append(distance_errors(dataset, solver, index))
            ways, seen = mapped(dataset, solver, index)
            segments += ways
            base = index << 32
            frames += [
                Frame(people=one.people + base, places=one.places, tracks=one.tracks + base, found=one.found)
                for one in seen
            ]
        hota, idf1 = hota_and_idf1(frames)
        return Figures(
            distances=np.concatenate(distances), segments=np.array(segments).reshape(-1, 3), hota=hota, idf1=idf1
        )

    def by_distance(self) -> list[str]:
        """Mean errors in m, a bin each, and of all."""
        bins = np.floor(self.distances[:, 0] / BIN)
        found = [self.distances[bins == n, 1] for n in range(round(FARTHEST / BIN))]
        means = [f"{one.mean():.2f}" if len(one) else "" for one in found]
        return [*means, f"{self.distances[:, 1].mean():.2f}"]

    def drift(self) -> list[str]:
        """Per cent and degrees a 100 m, a length each."""
        cells = []
        for length in SEGMENTS:
            one = self.segments[self.segments[:, 0] == length]
            turned = np.degrees(one[:, 2]).mean() / length * 100.0 if len(one) else 0.0
            cells.append(f"{100.0 * one[:, 1].mean() / length:.1f} % / {turned:.0f}°" if len(one) else "")
        return cells


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("datasets", nargs="+", type=Path, metavar="DATASET")
    parser.add_argument("--solvers", default="vb-sf,map-causal")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    pairs = [(folder, solver) for folder in options.datasets for solver in options.solvers.split(",")]
    opened = {folder: Dataset(folder) for folder in options.datasets}
    found = Parallel(n_jobs=options.jobs)(
        delayed(Figures.of)(opened[folder], solver, range(len(opened[folder]))) for folder, solver in pairs
    )
    edges = [f"{BIN * n:.0f} to {BIN * (n + 1):.0f} m" for n in range(round(FARTHEST / BIN))]
    scores = [[f"{one.hota:.2f}", f"{one.idf1:.2f}"] for one in found]
    for head, rows in (
        ([*edges, "all"], [one.by_distance() for one in found]),
        ([f"{length:.0f} m" for length in SEGMENTS], [one.drift() for one in found]),
        (["HOTA", "IDF1"], scores),
    ):
        print(f"\n| | {' | '.join(head)} |\n|{'---|' * (len(head) + 1)}")
        for (folder, solver), row in zip(pairs, rows, strict=True):
            print(f"| {folder.name}, `{solver}` | {' | '.join(row)} |")


if __name__ == "__main__":
    main()
