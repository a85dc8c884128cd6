"""What the learned solver takes from an observer's head: the residual of its fit, when it is believed, and what for."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.lib.solver_runs import DT, run
from vbbench.geometry import FloatArray
from vbbench.sequence import Truth
from vbbench_baselines.former import heads
from vbbench_baselines.former.operations import Operations
from vbbench_baselines.former.solver import VbFormer
from vbbench_generators.views.looking import causal_headings

XP, SECONDS = Operations(), np.float64(DT)


def winding(seed: int) -> Truth:
    """Eight people about somebody who walks a winding way and looks where it leads."""
    rng, frames = np.random.default_rng(seed), 25
    start, velocity = rng.uniform(-8.0, 8.0, (8, 2)), rng.uniform(-0.8, 0.8, (8, 2))
    positions = start + velocity * (np.arange(frames) * DT)[:, None, None]
    positions += np.cumsum(rng.normal(0.0, 0.05, positions.shape), axis=0)
    way = np.cumsum(rng.normal(0.0, 0.25, frames))
    path = np.cumsum(1.2 * DT * np.column_stack((np.cos(way), np.sin(way))), axis=0)
    yaw = causal_headings(path[:, None], DT)[:, 0]
    return Truth(poses=np.column_stack((path, yaw)), positions=positions, heights=np.full(8, 1.7))


def looking(truth: Truth, seed: int) -> Truth:
    """The same walks, on which the head turns as it likes."""
    turns = np.cumsum(np.random.default_rng(seed).normal(0.0, 0.25, len(truth.poses)))
    return replace(truth, poses=truth.poses + turns[:, None] * (0.0, 0.0, 1.0))


def mean_error(truths: list[Truth], **options: Any) -> float:
    """Of camera places in m, with boxes off by 2 px."""
    found = [run(VbFormer(**options), truth, "sequential", pixel_std=2.0).poses - truth.poses for truth in truths]
    return float(np.mean([np.hypot(error[2:, 0], error[2:, 1]).mean() for error in found]))


def before(truth: Truth, frame: int) -> tuple[complex, complex, float]:
    """The mean velocity of late in m/s and the step in m from the pose before ``frame``, and the turn in rad."""
    place, yaw = truth.poses[:, 0] + 1j * truth.poses[:, 1], truth.poses[:, 2]
    steps = np.diff(place)[:frame] / DT
    smooth = steps[0]
    for step in steps[1:-1]:
        smooth = heads.smoothed(XP, smooth, step, SECONDS)
    turned = np.exp(-1j * yaw[frame - 1])
    return smooth * turned, steps[-1] * DT * turned, yaw[frame] - yaw[frame - 1]


def test_derivatives_are_those_of_the_residual() -> None:
    head = heads.head_of(XP, np.complex128(1.1 + 0.2j), np.float64(1.0), SECONDS)

    def parts(x: FloatArray) -> Any:
        return heads.head_equations(XP, head, np.complex128(x[0] + 1j * x[1]), np.float64(x[2]))

    def stray(x: FloatArray) -> float:
        return float(parts(x)[8] / parts(x)[5])

    at, small = np.array((0.5, 0.1, 0.2)), 1e-6
    slopes = np.array([(stray(at + step) - stray(at - step)) / (2 * small) for step in small * np.eye(3)])
    weight, off = parts(at)[5], stray(at)
    upper = [slopes[i] * slopes[j] for i in range(3) for j in range(i, 3)]
    np.testing.assert_allclose(parts(at), weight * np.array([*upper, *(slopes * off)]), rtol=1e-3)


def test_odds_tell_heads_that_follow_from_others() -> None:
    def odds(truth: Truth) -> float:
        told = np.float64(0.0)
        for frame in range(3, len(truth.poses)):
            smooth, step, turn = before(truth, frame)
            now = heads.smoothed(XP, smooth, step / DT, SECONDS) * np.exp(-1j * turn)
            told = heads.odds_after(XP, told, np.complex128(now), np.float64(turn / DT), SECONDS)
        return float(told)

    for seed in range(5):
        assert odds(winding(seed)) == heads.MOST_ODDS
        assert odds(looking(winding(seed), seed)) < -5.0


@pytest.mark.slow
def test_a_head_that_follows_helps_and_one_that_does_not_costs_little() -> None:
    following = [winding(seed) for seed in range(12)]
    others = [looking(truth, seed) for seed, truth in enumerate(following)]
    assert mean_error(following) < 0.85 * mean_error(following, heads=False)
    assert mean_error(others) < 1.05 * mean_error(others, heads=False)
