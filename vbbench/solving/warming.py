"""Warms a solver up before its seconds are counted: it answers a synthetic sequence, which is then discarded.

Otherwise what a solver compiles, imports or loads on first use would count as solving time. The synthetic sequence
exercises every path of the protocol: many people, few and none, late arrivals, people who leave and come back,
positions that are given and not; with the dataset's camera, frame rate, noise and covariances.
"""

import warnings
from contextlib import suppress
from dataclasses import replace

import numpy as np

from vbbench.geometry import BoolArray, world_to_relative
from vbbench.protocol import START_FRAMES, Protocol, arrivals_given
from vbbench.sequence import Sequence, Truth
from vbbench.solver import FrameSolver, Problem, SequenceSolver
from vbbench.solving.runner import run_sequence

FRAMES = 24
"""Most frames of the synthetic sequence: more than a solver may remember."""

PEOPLE = 8
"""People in it; the number changes from frame to frame."""

PACE = 1.3
"""Speed in m/s of the observer and of the people."""


def warm_up(solver: FrameSolver | SequenceSolver, problem: Problem, protocol: Protocol, frames: int = FRAMES) -> None:
    """Answer a synthetic sequence like those of ``problem``, of at most ``frames`` frames; failures are ignored."""
    sequence, truth = synthetic_sequence(problem, min(frames, FRAMES))
    _answer(solver, replace(problem, tracks=sequence.tracks), sequence, protocol, truth)


def begin(solver: FrameSolver | SequenceSolver, problem: Problem, sequence: Sequence, protocol: Protocol) -> None:
    """Answer the first solved frame of a real sequence, so that a new solver object loads what it needs.

    Of the frames before it, what the dataset gives is given.
    """
    frames = slice(START_FRAMES + 1)
    given = sequence.given.frames(frames)
    opening = replace(
        sequence, observations=sequence.observations[frames], visible=sequence.visible[frames], given=given
    )
    past = Truth(poses=given.poses, positions=given.positions, heights=np.full(len(sequence.tracks), np.nan))
    _answer(solver, problem, opening, protocol, past)


def _answer(
    solver: FrameSolver | SequenceSolver, problem: Problem, sequence: Sequence, protocol: Protocol, truth: Truth
) -> None:
    with warnings.catch_warnings(), suppress(Exception):
        warnings.simplefilter("ignore")
        run_sequence(solver, problem, sequence, protocol, truth)


def synthetic_sequence(problem: Problem, frames: int) -> tuple[Sequence, Truth]:
    """People who walk ahead of an observer, appear, leave and hide."""
    rng, time = np.random.default_rng(0), np.arange(frames) * problem.dt
    poses = np.column_stack((PACE * time, np.zeros(frames), 0.1 * np.sin(time)))
    ahead, aside = 2.5 + 0.7 * np.arange(PEOPLE), 0.9 * (np.arange(PEOPLE) % 4 - 1.5)
    start, velocity = np.column_stack((ahead, aside)), (PACE, 0.0) + 0.1 * rng.normal(size=(PEOPLE, 2))
    positions = start + velocity * time[:, None, None] + 0.01 * rng.normal(size=(frames, PEOPLE, 2))
    heights = problem.height_mean + problem.height_std * rng.normal(size=PEOPLE)
    boxes = problem.camera.project(world_to_relative(positions, poses), np.broadcast_to(heights, (frames, PEOPLE)))
    boxes = boxes + problem.pixel_std * rng.normal(size=boxes.shape)
    boxes[~_shown(frames)] = np.nan
    observed, truth = ~np.isnan(boxes[..., 2]), Truth(poses=poses, positions=positions, heights=heights)
    sequence = Sequence(
        index=0,
        scene=0,
        observer=PEOPLE,
        first_frame=0,
        tracks=np.arange(PEOPLE),
        observations=boxes,
        visible=np.where(observed, 1.0, np.nan),
        given=arrivals_given(truth, observed),
    )
    return sequence, truth


def _shown(frames: int) -> BoolArray:
    """[T, K] who is visible.

    Nobody in frame 3, and one person in frame 5; the nearest two arrive in frames 4 and 7, the last hides from 6 to 8.
    """
    shown, t = np.ones((frames, PEOPLE), np.bool_), np.arange(frames)
    shown[t == 3] = False
    shown[t == 5, 1:] = False
    shown[t < 4, 0] = shown[t < 7, 1] = False
    shown[(t >= 6) & (t <= 8), -1] = False
    return shown
