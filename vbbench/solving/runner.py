"""Runs a solver on one sequence under a protocol, which determines what the solver is given.

Every array that a solver gets is a copy: neither its values nor its memory lead to truth. Its answers are copied at
once, so that later writes into them have no effect.
"""

import heapq
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import VbbenchError
from vbbench.estimate import LARGEST, Answer, copy_of, is_credible
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import START_FRAMES, Protocol, scored_frames, scored_positions
from vbbench.sequence import Given, Odometry, Sequence, Truth
from vbbench.solver import Estimate, Frame, FrameEstimate, FrameSolver, Problem, SequenceSolver

SEQUENCES_A_PART = 256
"""Sequences that are divided into groups together: more make fewer processes, and an interruption loses more."""


def separate_groups(rows: Mapping[str, NDArray[Any]], first: int, last: int) -> list[IntArray]:
    """Sequences first ≤ index < last in the fewest groups in which no two sequences share a frame of a scene.

    The order in a group is random, from no seed, so that no solver can count which sequence it solves.

    Parameters
    ----------
    rows : the columns of ``sequences.parquet``.
    """
    scene, start, frames = (rows[name][first:last].astype(np.int64) for name in ("scene", "first_frame", "frames"))
    groups: list[list[int]] = []
    free: list[tuple[int, int]] = []  # of the groups, the frame of the present scene from which on they are free
    before = None
    for row in np.lexsort([start, scene]).tolist():
        if scene[row] != before:
            before, free = scene[row], [(0, group) for group in range(len(groups))]
        if free and free[0][0] <= start[row]:
            _, group = heapq.heappop(free)
        else:
            group = len(groups)
            groups.append([])
        groups[group].append(first + row)
        heapq.heappush(free, (int(start[row] + frames[row]), group))
    random = np.random.default_rng()
    return [random.permutation(np.array(group)) for group in groups]


WINDOW = 2
"""Past frames that a solver is shown besides the current one."""


def run_sequence(
    solver: FrameSolver | SequenceSolver, problem: Problem, sequence: Sequence, protocol: Protocol, truth: Truth | None
) -> tuple[Estimate, float]:
    """The solver's estimate for a sequence, and the seconds it took.

    Raises VbbenchError if the solver has neither ``step`` nor ``solve``, or a scored answer is missing or not credible.

    Parameters
    ----------
    truth : needed if the protocol reveals past frames; only these reach the solver.
    """
    given = protocol.select_given(sequence.given)
    if protocol.needs_truth and truth is None:
        raise VbbenchError(f"'{protocol.name}' gives a solver the truth of past frames, and no truth is available")
    known = given if truth is None or not protocol.needs_truth else reveal(given, sequence.observed, truth)
    if isinstance(solver, FrameSolver):
        estimate, seconds = _run_frames(solver, problem, sequence, given, known)
    elif isinstance(solver, SequenceSolver):
        if protocol.needs_truth:
            estimate, seconds = _run_prefixes(solver, problem, sequence, given, known)
        else:
            estimate, seconds = _timed_solve(solver, problem, sequence, sequence.frames, given)
    else:
        raise VbbenchError(f"{type(solver).__name__} is not a solver: it has neither start and step nor solve")
    _check_complete(estimate, sequence, given)
    return estimate, seconds


def reveal(given: Given, observed: BoolArray, truth: Truth) -> Given:
    """The whole truth as given values: all poses, and the positions of all ``observed`` people [T, K]."""
    positions = np.where(observed[..., None], truth.positions, given.positions)
    return Given(poses=truth.poses, positions=positions, odometry=given.odometry)


def frames_of(sequence: Sequence, given: Given, known: Given) -> Iterator[Frame]:
    """The frames as a solver gets them: ``known`` values of the two before each, ``given`` ones of the frame itself."""
    for t in range(sequence.frames):
        yield Frame(index=t, observations=sequence.observations[t].copy(), given=given_at(given, t, known))


def given_at(given: Given, t: int, known: Given | None = None) -> Given:
    """Given values of frame ``t`` and the two before it: ``given`` ones of ``t``, and ``known`` ones of the past."""
    known = given if known is None else known
    poses, positions = _window(known.poses, given.poses, t), _window(known.positions, given.positions, t)
    odometry = None if given.odometry is None else window_of_odometry(given.odometry, t)
    return Given(poses=poses, positions=positions, odometry=odometry)


def _window(known: FloatArray, given: FloatArray, t: int) -> FloatArray:
    window = np.full((WINDOW + 1, *known.shape[1:]), np.nan)
    past = min(t, WINDOW)
    window[WINDOW - past : WINDOW] = known[t - past : t]
    if known is given or t < START_FRAMES:
        window[WINDOW] = given[t]
    return window


def window_of_odometry(odometry: Odometry, t: int) -> Odometry:
    """The odometry of the frames t−2, t−1 and t."""
    shown = odometry.frames(slice(max(0, t - WINDOW), t + 1))
    return Odometry.unmeasured(WINDOW).followed_by(shown).frames(slice(-WINDOW - 1, None))


def _run_frames(
    solver: FrameSolver, problem: Problem, sequence: Sequence, given: Given, known: Given
) -> tuple[Estimate, float]:
    answers: list[FrameEstimate] = []
    seconds = 0.0
    with _staying(sequence):
        solver.start(problem)
        for frame in frames_of(sequence, given, known):
            started = perf_counter()
            answer = solver.step(frame)
            seconds += perf_counter() - started
            answers.append(copy_of(_checked_kind(answer, FrameEstimate, sequence)))
            where = f"sequence {sequence.index}, frame {frame.index}"
            _check_shape(answer.positions, (len(sequence.tracks), 2), where)
    return Estimate.of_frames(answers), seconds


@contextmanager
def _staying(sequence: Sequence) -> Iterator[None]:
    """Convert SystemExit of a solver to an error about the solver: other answers would be lost silently."""
    try:
        yield
    except SystemExit as error:
        raise VbbenchError(
            f"sequence {sequence.index}: the solver ended the program (exit status {error.code}); it must not"
        ) from error


def _run_prefixes(
    solver: SequenceSolver, problem: Problem, sequence: Sequence, given: Given, known: Given
) -> tuple[Estimate, float]:
    """Call the solver once per frame, on the sequence up to it, with the truth of all frames before it."""
    start = Estimate(poses=given.poses, positions=given.positions)
    answers, seconds = [start.frame(t) for t in range(min(START_FRAMES, sequence.frames))], 0.0
    for t in range(START_FRAMES, sequence.frames):
        past = np.arange(t + 1) < t
        shown = known.frames(slice(t + 1)).keeping(past, np.broadcast_to(past[:, None], (t + 1, len(sequence.tracks))))
        estimate, spent = _timed_solve(solver, problem, sequence, t + 1, shown)
        answers.append(estimate.frame(t))
        seconds += spent
    return Estimate.of_frames(answers), seconds


def _timed_solve(
    solver: SequenceSolver, problem: Problem, sequence: Sequence, frames: int, given: Given
) -> tuple[Estimate, float]:
    measured = given.odometry
    odometry = None
    if measured is not None:
        odometry = Odometry(motions=measured.motions.copy(), covariances=measured.covariances.copy())
    shown = Given(poses=given.poses.copy(), positions=given.positions.copy(), odometry=odometry)
    observations = sequence.observations[:frames].copy()
    with _staying(sequence):
        started = perf_counter()
        estimate = solver.solve(problem, observations, shown)
        seconds = perf_counter() - started
    positions = _checked_kind(estimate, Estimate, sequence).positions
    _check_shape(positions, shown.positions.shape, f"sequence {sequence.index}")
    return copy_of(estimate), seconds


def _checked_kind(answer: Answer, kind: type[Answer], sequence: Sequence) -> Answer:
    if not isinstance(answer, kind):
        raise VbbenchError(
            f"sequence {sequence.index}: the solver returned a {type(answer).__name__}, not a {kind.__name__}"
        )
    return answer


def _check_shape(positions: FloatArray, wanted: tuple[int, ...], where: str) -> None:
    if positions.shape != wanted:
        raise VbbenchError(f"{where}: the solver's positions have shape {list(positions.shape)}, not {list(wanted)}")


def _check_complete(estimate: Estimate, sequence: Sequence, given: Given) -> None:
    """Check that every scored answer exists and is credible."""
    _check_shape(estimate.positions, given.positions.shape, f"sequence {sequence.index}")
    wanted = {
        "pose": scored_frames(sequence.observed)[:, None] & ~is_credible(estimate.poses),
        "position": scored_positions(sequence.observed, given)[..., None] & ~is_credible(estimate.positions),
    }
    for what, bad in wanted.items():
        if bad.any():
            place = tuple(np.argwhere(bad)[0])
            value = {"pose": estimate.poses, "position": estimate.positions}[what][place]
            fault = f"{value:g}, beyond ±{LARGEST:.0f} m or rad" if np.isfinite(value) else "not finite"
            whose = f" of track {sequence.tracks[place[1]]}" if what == "position" else ""
            raise VbbenchError(f"sequence {sequence.index}, frame {place[0]}: the solver's {what}{whose} is {fault}")
