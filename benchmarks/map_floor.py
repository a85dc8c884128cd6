"""The floor of the joint solvers: the least error that boxes and the motion prior allow (Cramér–Rao, after van Trees).

All residuals of a sequence are linearised at the truth and their expected information is summed: boxes count N⁻¹, an
innovation (ν + 2)/((ν + 4)σ_k²) an axis, the Fisher information of a Student-t distribution in the plane, a turn of the
head 1/2γ_f², that of a Cauchy distribution (1/2γ² if no head is believed to follow). Frame after frame is added
and what is older than the prior remembers is eliminated, so that one pass gives the covariance of the newest frame
given all before it. An error with the covariance Σ then has the mean √(2/π)·σ in yaw, and √(2λ_1/π)·E(1 − λ_2/λ_1) in
the plane, E the complete elliptic integral.

``python -m benchmarks.map_floor [--sequences 60] [--jobs 2]`` prints the tables of docs/map-solver.md.
"""

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from scipy.special import ellipe

from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.geometry import BoolArray, FloatArray, world_to_relative
from vbbench.protocol import PROTOCOLS, get_protocol, scored_frames, scored_positions
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Problem
from vbbench_baselines.common.sightings import measure
from vbbench_baselines.joint_map.measurement.boxes import Eye, statures_of
from vbbench_baselines.joint_map.motion.heads import Head, turn
from vbbench_baselines.joint_map.motion.walks import Walk, reweigh, walk_of
from vbbench_baselines.joint_map.prior import Prior, get_prior

EXACT = 1e-3
"""Standard deviation in m of exact boxes and given positions, as in the solver."""
TURN = 1e-4
"""Standard deviation in rad of given yaws."""
OWN_PRIOR = {"hotel": "without-eth", "eth": "without-hotel"}
"""The prior that fits each split best: that of the split itself, because this is a floor."""


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Covariances about truth: pose [T, 3, 3] and positions [T, K, 2, 2], NaN where there is nobody."""

    poses: FloatArray
    positions: FloatArray


class Information:
    """The information matrix of a sequence, its variables in order of frames, heights last.

    Parameters
    ----------
    people : [T, K] who is followed when.
    """

    def __init__(self, people: BoolArray) -> None:
        count, sizes = people.shape[1], 3 + 2 * people.sum(axis=1)
        self.begin = np.concatenate(([0], np.cumsum(sizes)))
        self.heights = self.begin[-1] + np.arange(count)
        self.row = self.begin[:-1, None] + 1 + 2 * np.cumsum(people, axis=1)
        self.row[~people] = -1
        self.matrix = np.zeros((self.begin[-1] + count,) * 2)

    def place(self, t: int, k: int | None) -> FloatArray:
        """Indices of somebody's place; of the observer's for ``None``."""
        return np.arange(2) + (self.begin[t] if k is None else self.row[t, k])

    def add(self, indices: list[FloatArray], jacobian: FloatArray, weight: FloatArray) -> None:
        """Add a residual whose derivatives by some variables are ``jacobian``."""
        where = np.concatenate(indices).astype(int)
        self.matrix[np.ix_(where, where)] += jacobian.T @ weight @ jacobian

    def forget(self, t: int, reach: int) -> None:
        """Eliminate frame t, which is tied to the ``reach`` frames after it and the heights."""
        old = np.arange(self.begin[t], self.begin[t + 1])
        end = self.begin[min(t + 1 + reach, len(self.begin) - 1)]
        rest = np.concatenate((np.arange(self.begin[t + 1], end), self.heights))
        cross = self.matrix[np.ix_(rest, old)]
        self.matrix[np.ix_(rest, rest)] -= cross @ np.linalg.solve(self.matrix[np.ix_(old, old)], cross.T)

    def covariance(self, first: int, last: int) -> FloatArray:
        """Of the variables of frames first … last, those before being forgotten."""
        rows = np.concatenate((np.arange(self.begin[first], self.begin[last + 1]), self.heights))
        return np.linalg.inv(self.matrix[np.ix_(rows, rows)])


@dataclass(frozen=True, kw_only=True)
class Floor:
    """The least errors in a sequence.

    Parameters
    ----------
    prior : the motion prior.
    feet : whether boxes tell their distance by their bottom, else by height.
    batch : whether a frame is told by the frames after it, too.
    own_scale : whether everybody's σ_k is known from its true walk; else its expectation counts.
    """

    prior: Prior
    feet: bool = True
    batch: bool = False
    own_scale: bool = True

    def spread(self, problem: Problem, sequence: Sequence, truth: Truth, protocol: str) -> Spread:
        """The covariances of everything in a sequence under a protocol."""
        rules, walk = get_protocol(protocol), walk_of(self.prior, problem.dt)
        given = rules.select_given(sequence.given)
        followed = _between(sequence.observed) & ~np.isnan(truth.positions[..., 0])
        noise = self._noise(problem, sequence, truth)
        information = Information(followed)
        information.matrix[information.heights, information.heights] = 1.0 / problem.height_std**2
        precision = self._precisions(walk, followed, truth)
        reach, frames = len(walk.spreads) - 1, sequence.frames
        out = Spread(poses=np.full((frames, 3, 3), np.nan), positions=np.full((*followed.shape, 2, 2), np.nan))
        for t in range(frames):
            self._add_boxes(information, t, sequence, truth, noise)
            _add_head(information, t, truth.poses, walk.head)
            _add_walks(information, t, followed, precision, walk)
            _anchor(information, t, ~np.isnan(given.poses[t, 0]), ~np.isnan(given.positions[t, :, 0]))
            first = 0 if self.batch else max(t + 1 - reach, 0)
            if not self.batch or t == frames - 1:
                _read(information, information.covariance(first, t), first, t, out, whole=self.batch)
            if rules.needs_truth:
                _anchor(information, t, True, sequence.observed[t])
            if not self.batch and t + 1 >= reach:
                information.forget(t + 1 - reach, reach)
        return out

    def _noise(self, problem: Problem, sequence: Sequence, truth: Truth) -> FloatArray:
        """N [T, K, 2, 2] of boxes, without the height's part."""
        statures = statures_of(problem, self.feet)
        heights = statures.mean if self.feet else np.nan_to_num(truth.heights, nan=problem.height_mean)
        out = np.empty((*sequence.observed.shape, 2, 2))
        eye = Eye(problem, self.feet)
        for t in range(sequence.frames):
            seen = eye.sight(sequence.observations[t])
            rr, rf, ff = measure(seen, heights, np.zeros(len(heights)))[1].T
            out[t] = np.stack((np.stack((rr, rf), -1), np.stack((rf, ff), -1)), -2)
        return out + EXACT**2 * np.eye(2)

    def _precisions(self, walk: Walk, followed: BoolArray, truth: Truth) -> FloatArray:
        """[K + 1] expected information of a full innovation of everybody and the observer, in 1/m²."""
        tracks = [truth.positions[followed[:, k], k] for k in range(followed.shape[1])]
        variances = [_own_variance(np.ascontiguousarray(track), walk) for track in [*tracks, truth.poses[:, :2]]]
        scale = np.array(variances) if self.own_scale else np.full(len(variances), walk.sigma**2)
        return (walk.nu + 2.0) / ((walk.nu + 4.0) * scale)

    def _add_boxes(self, information: Information, t: int, sequence: Sequence, truth: Truth, noise: FloatArray) -> None:
        yaw = truth.poses[t, 2]
        turn = np.array(((np.sin(yaw), -np.cos(yaw)), (np.cos(yaw), np.sin(yaw))))  # Rᵀ: world to (right, forward)
        relative = world_to_relative(truth.positions[t], truth.poses[t])
        for k in np.flatnonzero(sequence.observed[t] & (information.row[t] >= 0)):
            right, forward = relative[k]
            jacobian = np.zeros((2, 6))  # of z − Rᵀ(x − c) by (c, yaw), x and the height
            jacobian[:, :2], jacobian[:, 3:5] = turn, -turn
            jacobian[:, 2] = -forward, right
            if not self.feet:
                jacobian[:, 5] = relative[k] / truth.heights[k]
            where = [information.place(t, None), [information.begin[t] + 2], information.place(t, k)]
            information.add([*where, [information.heights[k]]], jacobian, np.linalg.inv(noise[t, k]))


def _between(observed: BoolArray) -> BoolArray:
    """[T, K] from everybody's first box to the last."""
    return np.logical_or.accumulate(observed) & np.logical_or.accumulate(observed[::-1])[::-1]


def _own_variance(track: FloatArray, walk: Walk) -> float:
    """σ_k² in m² as the true walk [n, 2] has it."""
    return reweigh(track, walk, walk.sigma, np.zeros(len(track)), walk.sigma**2)[0]


def _add_walks(information: Information, t: int, followed: BoolArray, precision: FloatArray, walk: Walk) -> None:
    """The innovations of frame t."""
    for k in [*np.flatnonzero(followed[t]), None]:
        since = t if k is None else t - int(np.argmax(followed[:, k]))
        order = min(since, len(walk.spreads) - 1)
        if order == 0:
            continue
        weight = (1.0 if order == 1 else precision[-1 if k is None else k]) / walk.spreads[order] ** 2
        jacobian = np.kron(walk.filters[order, : order + 1], np.eye(2))
        information.add([information.place(t - d, k) for d in range(order + 1)], jacobian, weight * np.eye(2))


def _add_head(information: Information, t: int, poses: FloatArray, head: Head) -> None:
    """The yaw increment up to frame t, of a head that follows the path by the first law if any is believed to."""
    if t == 0:
        return
    follows, frames = np.isfinite(head.odds[0]), (t - 1, t)
    slopes = turn(poses[t - 1], poses[t], head, 0)[2] if follows else np.array((0.0, 0.0, -1.0, 0.0, 0.0, 1.0))
    where = [indices for i in frames for indices in (information.place(i, None), [information.begin[i] + 2])]
    scale = head.following[0] if follows else head.wandering
    information.add(where, slopes[None], np.array(((0.5 / scale**2,),)))


def _anchor(information: Information, t: int, pose: bool, people: BoolArray) -> None:
    """Hold what is given of frame t; everything else vaguely, so that it is somewhere."""
    diagonal = np.full(information.begin[t + 1] - information.begin[t], 1e-6)
    if pose:
        diagonal[:3] = EXACT**-2, EXACT**-2, TURN**-2
    rows = information.row[t, people & (information.row[t] >= 0)] - information.begin[t]
    diagonal[rows] = diagonal[rows + 1] = EXACT**-2
    where = np.arange(information.begin[t], information.begin[t + 1])
    information.matrix[where, where] += diagonal


def _read(information: Information, covariance: FloatArray, first: int, t: int, out: Spread, *, whole: bool) -> None:
    """Write the covariances of frame t, or of all frames first … t, to ``out``."""
    for frame in range(first if whole else t, t + 1):
        at = information.begin[frame] - information.begin[first]
        out.poses[frame] = covariance[at : at + 3, at : at + 3]
        for k in np.flatnonzero(information.row[frame] >= 0):
            row = information.row[frame, k] - information.begin[first]
            out.positions[frame, k] = covariance[row : row + 2, row : row + 2]


def mean_distance(covariance: FloatArray) -> FloatArray:
    """Mean length of normal errors with covariances [..., 2, 2]."""
    low, high = np.moveaxis(np.linalg.eigvalsh(covariance), -1, 0)
    return np.sqrt(2.0 * high / np.pi) * ellipe(1.0 - np.maximum(low, 0.0) / high)


def least_errors(spread: Spread, sequence: Sequence, protocol: str) -> FloatArray:
    """Mean (Δx, Δt, Δr) of a sequence, over what is scored."""
    given = get_protocol(protocol).select_given(sequence.given)
    frames, rows = scored_frames(sequence.observed), scored_positions(sequence.observed, given)
    rows &= ~np.isnan(spread.positions[..., 0, 0])
    if not frames.any() or not rows.any():
        return np.full(3, np.nan)
    turn = np.sqrt(2.0 / np.pi * spread.poses[frames, 2, 2])
    place = mean_distance(spread.poses[frames, :2, :2])
    return np.array((mean_distance(spread.positions[rows]).mean(), place.mean(), turn.mean()))


def floor_of(dataset: Dataset, floor: Floor, protocol: str, sequences: int, jobs: int = 1) -> FloatArray:
    """[N, 3] (Δx, Δt, Δr) of about so many sequences spread over a dataset; NaN where nothing is scored."""
    chosen = range(0, len(dataset), max(len(dataset) // sequences, 1))
    rows = Parallel(n_jobs=jobs)(delayed(_one)(dataset, floor, protocol, index) for index in chosen)
    return np.array(rows)


def _one(dataset: Dataset, floor: Floor, protocol: str, index: int) -> FloatArray:
    sequence = dataset.sequence(index)
    truth = dataset.truth(sequence)
    return least_errors(floor.spread(dataset.problem(sequence), sequence, truth, protocol), sequence, protocol)


def _cell(rows: FloatArray) -> str:
    dx, dt, dr = np.nanmean(rows, axis=0)
    return f"{dx:.3f} / {dt:.3f} / {dr:.4f} ({np.nanmedian(rows[:, 1]):.3f})"


def cases() -> Iterator[tuple[str, str]]:
    """Split and tier of each table."""
    for tier in ("ideal", "noisy"):
        for split in OWN_PRIOR:
            yield split, tier


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sequences", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    heads = ["Δx / Δt / Δr (median Δt)", "distance by", *PROTOCOLS, "batch, sequential"]
    print("| " + " | ".join(heads) + " |")
    print("|---" * len(heads) + "|")
    for split, tier in cases():
        with tempfile.TemporaryDirectory() as folder:
            dataset = generate(split, Path(folder) / "data", Options(tier=tier), jobs=options.jobs)
            for feet in (True, False):
                floor = {batch: Floor(prior=get_prior(OWN_PRIOR[split]), feet=feet, batch=batch) for batch in (0, 1)}
                asked = [(floor[0], protocol) for protocol in PROTOCOLS] + [(floor[1], "sequential")]
                cells = [floor_of(dataset, *each, options.sequences, options.jobs) for each in asked]
                text = [_cell(rows) for rows in cells]
                print(f"| {split}, {tier} | {'feet' if feet else 'height'} | " + " | ".join(text) + " |", flush=True)


if __name__ == "__main__":
    main()
