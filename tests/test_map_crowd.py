"""How lively a crowd walks is learned from its walks, however lively those were that the prior was fitted on."""

import numpy as np
import pytest

from tests.solver_runs import CAMERAS, DT, problem_of, see
from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.sequence import Truth
from vbbench.solving.runner import run_sequence
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.crowd import MOST, Crowd, asks
from vbbench_baselines.joint_map.motion.walks import UNKNOWN, walk_of
from vbbench_baselines.joint_map.prior import Prior

PRIOR = Prior(nu=1e9, a0=1e9, yaw_scale=0.05)
FRAMES, PEOPLE = 60, 6


def lively(scale: float, seed: int) -> Truth:
    """Walks as the prior has them, but with innovations ``scale`` times as large."""
    rng = np.random.default_rng(seed)
    second: FloatArray = np.zeros((FRAMES, PEOPLE + 1, 2))
    for t in range(2, FRAMES):
        told = PRIOR.b[0] * second[t - 1] + PRIOR.b[1] * second[t - 2]
        second[t] = told + rng.normal(0.0, scale * PRIOR.sigma, second[t].shape)
    walks = np.cumsum(rng.normal(0.0, 0.2 * DT, second.shape[1:]) + np.cumsum(second, axis=0), axis=0)
    yaw = np.cumsum(0.02 * rng.normal(size=FRAMES))
    heights = np.clip(rng.normal(1.7, 0.07, PEOPLE), 1.4, 2.0)
    places = walks[:, :-1] + rng.uniform(-8.0, 8.0, (PEOPLE, 2))
    return Truth(poses=np.column_stack((walks[:, -1], yaw)), positions=places, heights=heights)


def learned(scale: float, seed: int) -> float:
    """How many times the prior's σ the solver believes in the end."""
    truth, solver = lively(scale, seed), MapCausal(prior=PRIOR)
    sequence = see(truth, CAMERAS[0], 1.0, seed)
    run_sequence(solver, problem_of(sequence, CAMERAS[0], 1.0), sequence, get_protocol("sequential"), None)
    return solver.crowd.walk(walk_of(PRIOR, DT)).sigma / PRIOR.sigma


@pytest.mark.parametrize(("scale", "low", "high"), [(1.0, 0.9, 1.1), (2.0, 1.7, 2.3), (0.3, 1.0, 1.0)])
def test_a_crowd_is_found_as_lively_as_it_is_and_never_less_than_the_prior(
    scale: float, low: float, high: float
) -> None:
    assert low <= np.mean([learned(scale, seed) for seed in range(4)]) <= high


def test_nothing_told_changes_nothing() -> None:
    crowd, fitted = Crowd(), walk_of(PRIOR, DT)
    crowd.learn(np.zeros(2), fitted)
    assert crowd.walk(fitted) == fitted


def test_an_observer_who_need_not_be_a_person_is_not_learned_of() -> None:
    crowd, fitted = Crowd(), walk_of(PRIOR, DT, ego_prior=False)
    crowd.learn(np.array((1e5 * fitted.sigma**2, 1e3)), fitted)
    assert crowd.walk(fitted).own == UNKNOWN
    assert crowd.walk(fitted).sigma == pytest.approx(MOST * fitted.sigma)


def test_many_people_are_asked_in_a_share_of_the_frames() -> None:
    assert all(asks(frame, 10) for frame in range(10))
    assert sum(asks(frame, 40) for frame in range(100)) == 25


def test_columns_of_nobody_change_nothing() -> None:
    truth, scales = lively(2.0, 0), []
    for more in (0, 30):
        nobody = np.full((FRAMES, more, 2), np.nan)
        places = np.concatenate([truth.positions, nobody], axis=1)
        wider = Truth(poses=truth.poses, positions=places, heights=np.append(truth.heights, np.full(more, 1.7)))
        sequence, solver = see(wider, CAMERAS[0]), MapCausal(prior=PRIOR, window=8)
        run_sequence(solver, problem_of(sequence, CAMERAS[0]), sequence, get_protocol("sequential"), None)
        scales.append(solver.crowd.walk(walk_of(PRIOR, DT)).sigma)
    assert scales[0] == pytest.approx(scales[1], rel=1e-9)
