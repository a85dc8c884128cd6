"""The cascade's energies as posteriors: against the written-out sums in general form, and least at the answer."""

import itertools

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.lib.solver_runs import DT, walk
from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.sequence import Given
from vbbench.solver import Frame, PosePosterior, Problem
from vbbench_baselines._core import pose_energies, ray_beliefs
from vbbench_baselines.cascade import VAGUE, Factors
from vbbench_baselines.social_force_birdifier import PriorHeightsFreeObserver, SocialForceBirdifier

SOFTNESS = 0.3


def made_factors(noise: float, walk_std: float, seed: int = 0) -> Factors:
    rng = np.random.default_rng(seed)
    pose, people = np.array([1.0, 2.0, 0.3]), 5
    expected, std = rng.uniform(-6, 6, (people, 2)), rng.uniform(0.05, 0.3, people)
    relative = world_to_relative(expected, pose) + rng.normal(0, 0.2, (people, 2))
    roots = noise * rng.normal(size=(people, 2, 2))
    full = roots @ np.swapaxes(roots, 1, 2)
    covariance = np.ascontiguousarray(full.reshape(people, 4)[:, [0, 1, 3]])
    relative[3], std[4] = np.nan, np.nan  # not observed; of unknown past
    return Factors(relative, covariance, expected, std, pose, walk_std)


def written_out(pose: FloatArray, factors: Factors, facing: float) -> float:
    """E_c of the docstring with each person's place found by a general minimiser."""
    axes = np.array([[np.sin(pose[2]), -np.cos(pose[2])], [np.cos(pose[2]), np.sin(pose[2])]])  # right, forward
    moved = float(np.hypot(*(pose - factors.walk)[:2]))
    total = facing * (1.0 - np.cos(pose[2] - factors.walk[2]))
    if np.isinf(factors.walk_std):
        total += 0.5 * VAGUE * moved**2
    else:
        total += np.hypot(moved / factors.walk_std, SOFTNESS)
    for k in np.flatnonzero(factors.helpful):
        rr, rf, ff = factors.covariance[k]
        weight = np.linalg.inv([[rr, rf], [rf, ff]])

        def of_place(x: FloatArray, k: int = k, weight: FloatArray = weight) -> float:
            off = factors.relative[k] - axes @ (x - pose[:2])
            away = np.hypot(*(x - factors.expected[k])) / factors.std[k]
            return float(np.hypot(away, SOFTNESS) + 0.5 * off @ weight @ off)

        starts = factors.expected[k], pose[:2] + axes.T @ factors.relative[k]
        look = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000}
        total += min(minimize(of_place, start, method="Nelder-Mead", options=look).fun for start in starts)
    return float(total)


@pytest.mark.parametrize("noise", [0.03, 0.3])
@pytest.mark.parametrize("walk_std", [0.2, np.inf])
def test_energies_are_the_written_out_sum_with_places_minimised_out(noise: float, walk_std: float) -> None:
    factors, facing = made_factors(noise, walk_std), 0.7
    poses = factors.walk + np.array([[0, 0, 0], [0.1, -0.05, 0.02], [-0.5, 0.8, 0.4], [2.0, -3.0, -1.5]])
    found = pose_energies(poses, factors, SOFTNESS, facing)
    np.testing.assert_allclose(found, [written_out(pose, factors, facing) for pose in poses], rtol=1e-6)


def test_exact_boxes_leave_the_norms() -> None:
    factors = made_factors(0.0, np.inf)
    pose = factors.walk + np.array([0.3, -0.1, 0.2])
    off = factors.relative - world_to_relative(factors.expected, pose)
    norms = np.hypot(np.hypot(*off.T) / factors.std, SOFTNESS)
    expected = np.nansum(norms) + 0.5 * VAGUE * 0.1
    assert pose_energies(pose[None], factors, SOFTNESS, 0.0)[0] == pytest.approx(expected, rel=1e-9)


def stepped(solver: SocialForceBirdifier, bend: FloatArray | float = 0.0, noise: float = 0.0) -> SocialForceBirdifier:
    """The solver after one frame, in which the people's past positions (t−1, t−2) are off by (bend, 2 bend)."""
    truth = walk(7, wobble=0.05)
    camera = PanoramaCamera()
    boxes = camera.project(world_to_relative(truth.positions[2], truth.poses[2]), truth.heights)
    boxes += noise * np.random.default_rng(1).normal(size=boxes.shape)
    people = len(truth.heights)
    problem = Problem(
        camera=camera,
        dt=DT,
        tracks=np.arange(people),
        height_mean=1.7,
        height_std=0.07,
        pixel_std=noise,
        covariances=True,
    )
    poses, positions = np.full((3, 3), np.nan), np.full((3, people, 2), np.nan)
    poses[:2], positions[:2] = truth.poses[:2], truth.positions[:2]
    positions[0] += 2.0 * np.asarray(bend)
    positions[1] += bend
    solver.start(problem)
    solver.step(Frame(index=2, observations=boxes, given=Given(poses=poses, positions=positions)))
    return solver


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize("kind", [SocialForceBirdifier, PriorHeightsFreeObserver])
def test_the_energy_is_least_at_the_answer(kind: type[SocialForceBirdifier], noise: float) -> None:
    solver = stepped(kind(), noise=noise)
    assert isinstance(solver, PosePosterior)
    pose = solver._history.poses[2]
    steps = np.array(list(itertools.product((-1e-2, -1e-4, 0.0, 1e-4, 1e-2), repeat=3)))
    energies = solver.pose_energy(pose + steps)
    assert energies.min() > solver.pose_energy(pose[None])[0] - 1e-7
    least = minimize(lambda at: float(solver.pose_energy(at[None])[0]), pose + 1e-3, method="Nelder-Mead")
    np.testing.assert_allclose(least.x, pose, atol=2e-3)


def test_where_people_come_from_counts_only_through_where_they_are_expected() -> None:
    """Other directions of walking, with the same places expected, leave the posterior as it is."""
    rng = np.random.default_rng(3)
    calm = {"relaxation": 1e9, "strength": 0.0}
    straight = stepped(PriorHeightsFreeObserver(**calm))
    people = straight._history.positions.shape[1]
    turned = stepped(PriorHeightsFreeObserver(**calm), bend=rng.normal(0.0, 0.4, (people, 2)))
    poses = straight._history.poses[2] + rng.normal(0.0, 0.1, (50, 3))
    np.testing.assert_allclose(straight.pose_energy(poses), turned.pose_energy(poses), rtol=1e-7)


def test_beliefs_along_rays_are_ordered_and_of_sum_one() -> None:
    solver = stepped(PriorHeightsFreeObserver(strength=0.0))
    places, probability = solver.ray_posterior(41, 0.01)
    pose = solver._history.poses[2]
    assert places.shape == (len(probability), 41, 2)
    np.testing.assert_allclose(probability.sum(axis=1), 1.0)
    assert (np.abs(np.diff(probability > 0, axis=1)).sum(axis=1) <= 2).all()  # used samples are in one piece
    for own, p in zip(places, probability, strict=True):
        off = own[p > 0] - pose[:2]
        bearing = np.unwrap(np.arctan2(off[:, 1], off[:, 0]))
        np.testing.assert_allclose(bearing, bearing[0], atol=1e-9)  # exact boxes: on the ray
        assert (np.diff(np.hypot(*off.T)) > 0).all()


def test_beliefs_on_a_tree_are_the_least_energies_of_all_others() -> None:
    rng = np.random.default_rng(5)
    unary, edges = rng.uniform(0, 3, (4, 3)), np.array([[0, 1], [1, 2], [1, 3]])
    pair = rng.uniform(0, 3, (3, 3, 3))
    totals = {
        choice: sum(unary[k, s] for k, s in enumerate(choice))
        + sum(pair[e, choice[i], choice[j]] for e, (i, j) in enumerate(edges))
        for choice in itertools.product(range(3), repeat=4)
    }
    least = np.array([[min(t for c, t in totals.items() if c[k] == s) for s in range(3)] for k in range(4)])
    probability = ray_beliefs(unary, edges, pair, 50, 0.0, 1e-12)
    expected = np.exp(-least)
    np.testing.assert_allclose(probability, expected / expected.sum(axis=1, keepdims=True), rtol=1e-7)
