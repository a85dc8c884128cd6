"""Solves the sequences of a trial in parallel and measures how far off, and how sure of it, each answer is."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from vbbench.files.dataset import Dataset
from vbbench.geometry import BoolArray, FloatArray, world_to_relative, wrap_angle
from vbbench.protocol import get_protocol, scored_frames, scored_positions
from vbbench.registry import make_solver
from vbbench.scoring.metrics import position_error, relative_position_error, translation_error
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Estimate
from vbbench.solving.runner import run_sequence

FAR = 5.0
"""Error in m from which an answer is asked whether it said so."""

WITHIN = 6.18
"""χ² of two degrees of freedom below which 95.4 % of all errors are, as many as within 2 σ of a single figure."""

Change = Callable[[Sequence, Truth, int], Sequence]
"""Makes another sequence of one, with its truth and a seed."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """What solvers are measured on.

    Parameters
    ----------
    dataset, protocol : what is solved, and how.
    change : what is done to each sequence first, once with each of so many ``seeds``.
    chosen : the sequences, by their truth; ``None`` for all.
    covariances : whether solvers are asked for them.
    """

    dataset: Dataset
    protocol: str
    change: Change | None = None
    seeds: int = 1
    chosen: Callable[[Truth], bool] | None = None
    covariances: bool = False

    def sequences(self, every: int) -> list[int]:
        """Every ``every``-th of the sequences wanted."""
        every_one = range(len(self.dataset))
        if self.chosen is None:
            return list(every_one)[::every]
        return [n for n in every_one if self.chosen(self.dataset.truth(self.dataset.sequence(n)))][::every]


@dataclass(frozen=True, kw_only=True)
class Run:
    """One sequence solved; NaN where nothing counts, infinite where the solver failed.

    Parameters
    ----------
    dx, dt, dx_rel : means of the errors that are scored, in m.
    dx_camera : as ``dx_rel``, in the axes of the camera: an error of the yaw does not count.
    dx_arrivals : as ``dx``, with everybody's first two visible frames, which are not scored.
    drift : error of the observer's last place over the time until then, in m/s.
    farthest_pose, farthest_person : greatest errors in m, of poses in every frame and of people in every box.
    far_poses, far_people : how many of these are above `FAR`.
    unsure_poses, unsure_people : how many of them have a standard deviation of at least a third of the error.
    flagged_poses : how many far poses are unsure, fall back, or have not converged by the solver's own word.
    pose_square, people_square : squared errors by the covariances, for each degree of freedom, of the last pose and of
        the people in it; 1 is correct.
    pose_squares, people_squares : the same of all scored frames.
    pose_held, people_held : shares of scored places of the observer and of people within 2 σ, that is, `WITHIN`.
    pace : speed of the estimated camera in m/s, by its places a second apart.
    rate : frames solved in a second.
    """

    dx: float = np.inf
    dt: float = np.inf
    dx_rel: float = np.inf
    dx_camera: float = np.inf
    dx_arrivals: float = np.inf
    drift: float = np.inf
    farthest_pose: float = np.inf
    farthest_person: float = np.inf
    far_poses: float = np.nan
    far_people: float = np.nan
    unsure_poses: float = np.nan
    unsure_people: float = np.nan
    flagged_poses: float = np.nan
    pose_square: float = np.nan
    people_square: float = np.nan
    pose_squares: float = np.nan
    people_squares: float = np.nan
    pose_held: float = np.nan
    people_held: float = np.nan
    pace: float = np.nan
    rate: float = np.nan


@dataclass(frozen=True)
class Runs:
    """All runs of a solver in a trial."""

    runs: tuple[Run, ...]

    def __len__(self) -> int:
        return len(self.runs)

    def __getattr__(self, name: str) -> FloatArray:
        """[N] a figure of `Run`, by its name."""
        if name not in {field.name for field in fields(Run)}:
            raise AttributeError(name)
        return np.array([getattr(run, name) for run in self.runs], np.float64)


def measure(trial: Trial, solver: str, *, jobs: int, every: int = 1) -> Runs:
    """A solver's runs."""
    calls = [(number, seed) for number in trial.sequences(every) for seed in range(trial.seeds)]
    parts = [calls[first :: 8 * jobs] for first in range(min(8 * jobs, len(calls)))]
    found = Parallel(n_jobs=jobs)(delayed(_some)(trial, solver, part) for part in parts)
    by_call = {call: run for part in found for call, run in part}
    return Runs(tuple(run for call in calls if (run := by_call[call]) is not None))


def _some(trial: Trial, solver: str, calls: list[tuple[int, int]]) -> list[tuple[tuple[int, int], Run | None]]:
    made = make_solver(solver)
    return [(call, _run(trial, made, *call)) for call in calls]


def _run(trial: Trial, solver: Any, number: int, seed: int) -> Run | None:
    """One sequence solved and measured; ``None`` if nothing of it is scored."""
    dataset, rules = trial.dataset, get_protocol(trial.protocol)
    sequence = dataset.sequence(number)
    truth, relative = _truth(dataset, sequence)
    if trial.change is not None:
        sequence = trial.change(sequence, truth, seed)
    if not scored_frames(sequence.observed).any():
        return None
    problem = dataset.problem(sequence, covariances=trial.covariances)
    try:
        with np.errstate(all="ignore"):
            estimate, seconds = run_sequence(solver, problem, sequence, rules, truth if rules.needs_truth else None)
    except Exception as error:
        print(f"sequence {number}: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
        return Run()
    shown = replace(sequence, given=rules.select_given(sequence.given))
    return Run(
        **_errors(estimate, shown, truth, problem.dt),
        dx_camera=_beside(estimate, shown, relative),
        **_sureness(estimate, shown, truth),
        pace=_pace(estimate, problem.dt),
        rate=sequence.frames / max(seconds, 1e-9),
    )


def _truth(dataset: Dataset, sequence: Sequence) -> tuple[Truth, FloatArray]:
    """What is true of a sequence, NaN where nothing was measured, and places [T, K, 2] relative to the camera in m."""
    unknown = np.full((*sequence.observed.shape, 2), np.nan)
    if dataset.info.truth in ("whole", "poses"):
        truth = dataset.truth(sequence)
        return truth, world_to_relative(truth.positions, truth.poses)
    poses, heights = np.full((sequence.frames, 3), np.nan), np.full(len(sequence.tracks), np.nan)
    known = dataset.info.truth == "relative"
    return Truth(poses=poses, positions=unknown, heights=heights), (
        dataset.relative_truth(sequence) if known else unknown
    )


def _beside(estimate: Estimate, sequence: Sequence, relative: FloatArray) -> float:
    """Mean error of scored places in the axes of the camera."""
    off = world_to_relative(estimate.positions, estimate.poses) - relative
    return _mean(np.hypot(off[..., 0], off[..., 1])[scored_positions(sequence.observed, sequence.given)])


def _errors(estimate: Estimate, sequence: Sequence, truth: Truth, dt: float) -> dict[str, float]:
    frames, rows = scored_frames(sequence.observed), scored_positions(sequence.observed, sequence.given)
    away = translation_error(estimate.poses, truth.poses)
    off = position_error(estimate.positions, truth.positions)
    beside = relative_position_error(estimate.positions, estimate.poses[:, None], truth.positions, truth.poses[:, None])
    last = int(np.flatnonzero(frames)[-1])
    return {
        "dx": _mean(off[rows]),
        "dt": _mean(away[frames]),
        "dx_rel": _mean(beside[rows]),
        "dx_arrivals": _mean(off[sequence.observed & frames[:, None]]),
        "drift": float(away[last] / (last * dt)),
        "farthest_pose": float(np.nanmax(away, initial=0.0)),
        "farthest_person": float(np.nanmax(off[sequence.observed], initial=0.0)),
    }


def _sureness(estimate: Estimate, sequence: Sequence, truth: Truth) -> dict[str, float]:
    away = translation_error(estimate.poses, truth.poses)
    off = position_error(estimate.positions, truth.positions)
    far_poses, far_people = away > FAR, (off > FAR) & sequence.observed
    unsure_poses = far_poses & (_spread(estimate.pose_covariances, away.shape) >= away / 3)
    unsure_people = far_people & (_spread(estimate.position_covariances, off.shape) >= off / 3)
    flagged = unsure_poses.copy()
    if estimate.fallback is not None:
        flagged |= far_poses & estimate.fallback
    if estimate.converged is not None:
        flagged |= far_poses & ~estimate.converged
    return {
        "far_poses": float(far_poses.sum()),
        "far_people": float(far_people.sum()),
        "unsure_poses": float(unsure_poses.sum()),
        "unsure_people": float(unsure_people.sum()),
        "flagged_poses": float(flagged.sum()),
        **_squares(estimate, sequence, truth),
    }


def _squares(estimate: Estimate, sequence: Sequence, truth: Truth) -> dict[str, float]:
    """Squared errors by the covariances, for each degree of freedom, and shares of places within 2 σ."""
    last = int(np.flatnonzero(scored_frames(sequence.observed))[-1])
    rows = scored_positions(sequence.observed, sequence.given)[last] & np.isfinite(truth.positions[last, :, 0])
    error = estimate.poses[last] - truth.poses[last]
    error[2] = wrap_angle(error[2])
    found = {}
    if estimate.pose_covariances is not None:
        found["pose_square"] = _square(error[None], estimate.pose_covariances[last][None])
    if estimate.position_covariances is not None and rows.any():
        off = estimate.positions[last] - truth.positions[last]
        found["people_square"] = _square(off[rows], estimate.position_covariances[last][rows])
    return found | _all_squares(estimate, sequence, truth)


def _all_squares(estimate: Estimate, sequence: Sequence, truth: Truth) -> dict[str, float]:
    """`_squares` of all scored frames."""
    frames = scored_frames(sequence.observed) & np.isfinite(truth.poses[:, 0])
    rows = scored_positions(sequence.observed, sequence.given) & frames[:, None]
    rows &= np.isfinite(truth.positions[..., 0])
    away, off = estimate.poses - truth.poses, (estimate.positions - truth.positions)[rows]
    away[:, 2] = wrap_angle(away[:, 2])
    found = {}
    if estimate.pose_covariances is not None and frames.any():
        spread = estimate.pose_covariances[frames]
        found["pose_squares"] = _square(away[frames], spread)
        found["pose_held"] = _held(away[frames, :2], spread[:, :2, :2])
    if estimate.position_covariances is not None and rows.any():
        found["people_squares"] = _square(off, estimate.position_covariances[rows])
        found["people_held"] = _held(off, estimate.position_covariances[rows])
    return found


def _held(errors: FloatArray, covariances: FloatArray) -> float:
    """Share of places whose errors [N, 2] are within 2 σ; of those that have a covariance."""
    known = np.isfinite(covariances).all(axis=(1, 2)) & (np.linalg.det(covariances) > 0.0)
    weighed = np.linalg.solve(covariances[known], errors[known, :, None])[..., 0]
    return _mean(((errors[known] * weighed).sum(axis=1) <= WITHIN).astype(np.float64))


def _pace(estimate: Estimate, dt: float) -> float:
    """Speed in m/s by places a second apart."""
    every = max(1, round(1.0 / dt))
    steps = np.diff(estimate.poses[::every, :2], axis=0)
    return _mean(np.hypot(steps[:, 0], steps[:, 1])) / (every * dt)


def _square(errors: FloatArray, covariances: FloatArray) -> float:
    """Mean over errors [N, D] of eᵀ C⁻¹ e / D; NaN if a covariance is missing or singular."""
    try:
        weighed = np.linalg.solve(covariances, errors[..., None])[..., 0]
    except np.linalg.LinAlgError:
        return np.nan
    return float(np.mean(np.sum(errors * weighed, axis=-1)) / errors.shape[-1])


def _spread(covariances: FloatArray | None, shape: tuple[int, ...]) -> FloatArray:
    """Standard deviation in m of the distance, by covariances [..., D, D]; none where there are none."""
    if covariances is None:
        return np.full(shape, np.nan)
    return np.sqrt(covariances[..., 0, 0] + covariances[..., 1, 1])


def _mean(values: FloatArray) -> float:
    known: BoolArray = ~np.isnan(values)
    return float(values[known].mean()) if known.any() else np.nan
