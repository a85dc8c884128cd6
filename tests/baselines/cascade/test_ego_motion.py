"""The pose's energy: its least, its gradient, how it rises about the answer, and the covariances that follow."""

import itertools

import numpy as np
import pytest
from scipy.optimize import minimize as general_minimum

from tests.lib.cascade_terms import matrices, pose_energy, random_terms
from tests.lib.solver_runs import DT, walk
from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, relative_to_world, world_to_relative, wrap_angle
from vbbench.sequence import Given
from vbbench.solver import Frame, PosePosterior, Problem
from vbbench_baselines._core import (
    fit_pose,
    localise,
    minimise,
    pose_covariance,
    pose_energies,
    position_covariances,
)
from vbbench_baselines.cascade import VAGUE, Factors
from vbbench_baselines.social_force_birdifier import PriorHeightsFreeObserver, SocialForceBirdifier

SOFTNESS = 0.3


@pytest.mark.parametrize("seed", range(4))
def test_the_pose_is_the_least_that_scipy_finds(seed: int) -> None:
    terms = random_terms(seed)
    pose = fit_pose(terms)
    starts = [np.append(terms.walk[:2], yaw) for yaw in np.linspace(-np.pi, np.pi, 6)]
    best = min(
        (general_minimum(pose_energy, start, terms, options={"gtol": 1e-9}) for start in starts), key=lambda r: r.fun
    )
    assert pose_energy(pose, *terms) <= best.fun + 1e-9
    np.testing.assert_allclose(pose[:2], best.x[:2], atol=1e-5)
    assert wrap_angle(pose[2] - best.x[2]) == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("seed", range(10))
def test_the_yaw_is_the_least_of_the_circle(seed: int) -> None:
    """Of an observer whose place is known, among people who contradict one another."""
    terms = random_terms(seed, people=3, depth_std=3.0)
    relative = terms.relative + np.random.default_rng(seed).normal(0.0, 3.0, (3, 2))
    terms = terms._replace(relative=relative, walk_std=1e-8)
    weights = np.linalg.inv(matrices(terms.covariance) + terms.std[:, None, None] ** 2 * np.eye(2))

    def energy(yaws: FloatArray) -> FloatArray:
        poses = np.column_stack((np.tile(terms.walk[:2], (len(yaws), 1)), yaws))
        off = relative - world_to_relative(np.tile(terms.expected, (len(yaws), 1, 1)), poses)
        return np.asarray(np.einsum("nki,kij,nkj->n", off, weights, off))

    least = energy(fit_pose(terms, 0.0)[2:])[0]
    assert least <= energy(np.linspace(-np.pi, np.pi, 20_001)).min() * (1.0 + 1e-6)


def test_a_person_stands_between_measurement_and_expectation() -> None:
    terms = random_terms(7)
    relative, covariance, expected, std, pose, _ = terms
    boxes, walk = np.linalg.inv(matrices(covariance)), np.eye(2) / std[:, None, None] ** 2
    summed = boxes @ relative[..., None] + walk @ world_to_relative(expected, pose)[..., None]
    wanted = np.linalg.solve(boxes + walk, summed)[..., 0]
    np.testing.assert_allclose(world_to_relative(localise(pose, terms), pose), wanted)


# Unsquared norms


def ego_energy(pose: FloatArray, softness: float, terms: Factors) -> float:
    """E_c with the people's places minimised out one by one, slowly."""
    relative, covariance, expected, std, path, path_std = terms
    places, last = localise(pose, terms), np.inf
    while np.max(np.abs(places - last)) > 1e-13:
        last, stray = places, np.linalg.norm(places - expected, axis=1) / std
        places = localise(pose, terms._replace(std=std * np.sqrt(np.hypot(stray, softness))))
    stray = np.linalg.norm(places - expected, axis=1) / std
    off = relative - world_to_relative(places, pose)
    boxes = 0.5 * np.einsum("ki,kij,kj->", off, np.linalg.inv(matrices(covariance)), off)
    ego = np.linalg.norm(pose[:2] - path[:2]) / path_std
    return float(np.sum(np.sqrt(np.append(stray, ego) ** 2 + softness**2)) + boxes)


@pytest.mark.parametrize("seed", range(8))
def test_the_gradient_of_the_ego_energy_vanishes(seed: int) -> None:
    terms = random_terms(seed, depth_std=0.3)
    pose, _, _ = minimise(terms, np.full(3, np.nan), 0.3, 2000, 1e-12)
    h = 1e-4
    slopes = [ego_energy(pose + d, 0.3, terms) - ego_energy(pose - d, 0.3, terms) for d in h * np.eye(3)]
    np.testing.assert_allclose(np.array(slopes) / (2 * h), 0.0, atol=2e-3)


def test_without_reweighting_the_first_round_is_the_closed_form() -> None:
    terms = random_terms(2)
    np.testing.assert_array_equal(minimise(terms, np.full(3, np.nan), 0.3, 1, 0.0)[0], fit_pose(terms))


# Covariances


def hessian(pose: FloatArray, terms: Factors, h: float = 1e-4) -> FloatArray:
    """Second differences [3, 3] of the energy at ``pose``."""
    steps = h * np.eye(3)

    def slope(at: FloatArray) -> FloatArray:
        return np.array([pose_energy(at + d, *terms) - pose_energy(at - d, *terms) for d in steps]) / (2 * h)

    return np.array([slope(pose + d) - slope(pose - d) for d in steps]) / (2 * h)


@pytest.mark.parametrize("seed", range(5))
def test_the_pose_covariance_inverts_the_hessian_where_residuals_vanish(seed: int) -> None:
    terms = random_terms(seed)
    pose = terms.walk
    terms = terms._replace(expected=relative_to_world(terms.relative, pose))
    found = pose_covariance(pose, terms)
    np.testing.assert_allclose(np.linalg.inv(found), 0.5 * hessian(pose, terms), rtol=1e-4, atol=1e-4)


def test_covariances_are_those_of_many_draws() -> None:
    relative, covariance, _, std, pose, ego_std = random_terms(3, depth_std=0.2)
    truth = relative_to_world(relative, pose)
    rng, draws = np.random.default_rng(0), 4000
    root = np.linalg.cholesky(matrices(covariance))
    poses, places = np.empty((draws, 3)), np.empty((draws, len(std), 2))
    for n in range(draws):
        seen = relative + (root @ rng.normal(size=(len(std), 2, 1)))[..., 0]
        walked = truth + std[:, None] * rng.normal(size=truth.shape)
        walk = np.append(pose[:2] + ego_std * rng.normal(size=2), pose[2])
        drawn = Factors(seen, covariance, walked, std, walk, ego_std)
        poses[n] = fit_pose(drawn)
        places[n] = localise(poses[n], drawn)
    true = Factors(relative, covariance, truth, std, pose, ego_std)
    sigma = pose_covariance(pose, true)
    scale = np.sqrt(np.diag(sigma))
    np.testing.assert_allclose(np.cov(poses.T) / np.outer(scale, scale), sigma / np.outer(scale, scale), atol=0.1)
    found = position_covariances(pose, sigma, true)
    spread = np.einsum("nki,nkj->kij", places - truth, places - truth) / draws
    size = np.trace(found, axis1=1, axis2=2)[:, None, None]
    np.testing.assert_allclose(spread / size, found / size, atol=0.1)


# How the energy rises away from its minimum


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
        total += min(general_minimum(of_place, start, method="Nelder-Mead", options=look).fun for start in starts)
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
    least = general_minimum(lambda at: float(solver.pose_energy(at[None])[0]), pose + 1e-3, method="Nelder-Mead")
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
