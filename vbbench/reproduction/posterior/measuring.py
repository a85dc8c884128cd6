"""The posteriors of a solver, frame by frame: of the observer on a grid, of people along their viewing rays."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.estimate import FrameEstimate
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import START_FRAMES, get_protocol
from vbbench.registry import make_solver
from vbbench.reproduction.posterior.density import (
    Energy,
    GridDensity,
    discrete_entropy,
    find_density,
    gaussian_entropy,
    tails_of,
)
from vbbench.sequence import Sequence
from vbbench.solver import FrameSolver, PosePosterior
from vbbench.solving.runner import frames_of, reveal

PROTOCOL = "one-step"
SAMPLES, SPACING = 41, 0.01
"""Places along a viewing ray, and how far apart they are in m of a person's height."""


@dataclass(frozen=True, kw_only=True)
class Instant:
    """One frame's posteriors.

    Parameters
    ----------
    frame : its number.
    estimate : the solver's answer.
    density, place : of the observer's pose (x, y, yaw), and of its place, on a finer grid.
    places, probabilities : [M, S, 2] in m and [M, S] of the people seen, along their rays.
    share : probability of the places that are more probable than the true one.
    error : in m, how far the estimate is from the true place.
    """

    frame: int
    estimate: FrameEstimate
    density: GridDensity
    place: GridDensity
    places: FloatArray
    probabilities: FloatArray
    share: float
    error: float


@dataclass(frozen=True, kw_only=True)
class PosteriorTable:
    """The figures of frames [F], entropies in nats of m and rad.

    Parameters
    ----------
    sequence, frame : which.
    pose, gaussian : entropy of the pose, and of a normal density with the same covariance.
    place : entropy of its marginal.
    yaw : standard deviation in rad.
    beyond, kurtosis : of the place's marginal, see `vbbench.reproduction.posterior.density.Tails`.
    people : mean entropy of the people along their rays, NaN where nobody's place is open.
    share, error : see `Instant`.
    """

    sequence: IntArray
    frame: IntArray
    pose: FloatArray
    gaussian: FloatArray
    place: FloatArray
    yaw: FloatArray
    beyond: FloatArray
    kurtosis: FloatArray
    people: FloatArray
    share: FloatArray
    error: FloatArray

    @staticmethod
    def of_rows(rows: list[tuple[float, ...]]) -> "PosteriorTable":
        """A table of rows in the order of its columns."""
        names = [field.name for field in fields(PosteriorTable)]
        columns = np.array(rows, dtype=np.float64).reshape(-1, len(names)).T
        sequence, frame = columns[:2].astype(np.int64)
        return PosteriorTable(sequence=sequence, frame=frame, **dict(zip(names[2:], columns[2:], strict=True)))


def posterior_rows(dataset: Dataset, solver: str, first: int, last: int) -> list[tuple[float, ...]]:
    """The rows of a `PosteriorTable` of the sequences first ≤ index < last."""
    return [
        _row(sequence.index, instant)
        for sequence in dataset.sequences(first, last)
        for instant in instants(dataset, sequence, solver)
    ]


def reported_rows(dataset: Dataset, solver: str, first: int, last: int) -> list[tuple[float, ...]]:
    """Sequence, frame and entropy of the pose's reported covariance, of the sequences first ≤ index < last."""
    return [
        (sequence.index, frame, float(gaussian_entropy(answer.pose_covariance)))
        for sequence in dataset.sequences(first, last)
        for frame, answer in _answers(dataset, sequence, _made(solver))
        if answer.pose_covariance is not None and not answer.fallback
    ]


def instants(dataset: Dataset, sequence: Sequence, solver: str, only: range | None = None) -> Iterator[Instant]:
    """The posteriors in the frames of a sequence, or in some ``only``; frames that nobody helps in are left out.

    Raises
    ------
    VbbenchError
        If the solver reports none.
    """
    source = _made(solver)
    if not isinstance(source, PosePosterior):
        raise VbbenchError(f"solver '{solver}' has no pose_energy and so no posterior; try vb-sf")
    poses = dataset.truth(sequence).poses
    for frame, answer in _answers(dataset, sequence, source):
        if answer.fallback or answer.pose_covariance is None or (only is not None and frame not in only):
            continue
        density = find_density(one_turn(source.pose_energy, answer.pose[2]), answer.pose, answer.pose_covariance)
        place = density.marginal().finer()
        places, probabilities = source.ray_posterior(SAMPLES, SPACING)
        yield Instant(
            frame=frame,
            estimate=answer,
            density=density,
            place=place,
            places=places,
            probabilities=probabilities,
            share=place.share_above(poses[frame, :2]),
            error=float(np.hypot(*(answer.pose - poses[frame])[:2])),
        )


def one_turn(energy: Energy, yaw: float) -> Energy:
    """The energy of poses [N, 3] within half a turn of ``yaw``, inf beyond, so that no pose counts twice."""
    return lambda poses: np.where(np.abs(poses[:, 2] - yaw) <= np.pi, energy(poses), np.inf)


def _made(solver: str) -> FrameSolver:
    made = make_solver(solver)
    if not isinstance(made, FrameSolver):
        raise VbbenchError(f"solver '{solver}' answers for whole sequences; a posterior of each frame needs vb-sf")
    return made


def _answers(dataset: Dataset, sequence: Sequence, solver: FrameSolver) -> Iterator[tuple[int, FrameEstimate]]:
    """The solver's answers from the third frame on."""
    given = get_protocol(PROTOCOL).select_given(sequence.given)
    known = reveal(given, sequence.observed, dataset.truth(sequence))
    solver.start(dataset.problem(sequence, covariances=True))
    for shown in frames_of(sequence, given, known):
        answer = solver.step(shown)
        if shown.index >= START_FRAMES:
            yield shown.index, answer


def _row(sequence: int, instant: Instant) -> tuple[float, ...]:
    density = instant.density
    _, covariance = density.moments()
    tails = tails_of(instant.place)
    return (
        sequence,
        instant.frame,
        density.entropy,
        float(gaussian_entropy(covariance)),
        instant.place.entropy,
        float(np.sqrt(covariance[-1, -1])),
        tails.beyond,
        tails.kurtosis,
        ray_entropy(instant.places, instant.probabilities),
        instant.share,
        instant.error,
    )


def ray_entropy(places: FloatArray, probabilities: FloatArray) -> float:
    """Mean differential entropy in nats of people's places [M, S, 2] along their rays; NaN where all are certain."""
    undecided = probabilities.max(axis=1, initial=0.0) < 1.0
    if not undecided.any():
        return float("nan")
    middle = places.shape[1] // 2
    apart = np.hypot(*(places[undecided, middle + 1] - places[undecided, middle]).T)
    return float(np.mean(list(map(discrete_entropy, probabilities[undecided])) + np.log(apart)))
