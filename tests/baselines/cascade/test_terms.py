"""The terms of vb-sf and their energies: gradients, descent, samples along the rays."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from tests.baselines.cascade.test_ego_motion import random_terms
from vbbench.geometry import FloatArray, relative_to_world, world_to_relative
from vbbench_baselines._core import descend, fit_pose, link, localise, minimise, pass_messages, potential, sample_rays
from vbbench_baselines.cascade import CrowdGraph, Factors, nearest, select
from vbbench_baselines.motion_models import SocialForceWalk, Walkers

FULL = [(i, j) for i in range(5) for j in range(i)]


def test_the_potential_is_the_slope_of_a_gaussian() -> None:
    for d, h in ((0.3, 1e-6), (1.0, 1e-6), (2.5, 1e-6)):
        gaussian = [np.exp(-((d + side) ** 2) / (2 * 0.8**2)) for side in (h, -h)]
        assert potential(d * d, 0.8) == pytest.approx(abs(gaussian[0] - gaussian[1]) / (2 * h), rel=1e-6)


def test_the_implicit_force_is_the_one_that_acts_at_t() -> None:
    rng, dt = np.random.default_rng(1), 0.4
    last, velocity = rng.uniform(-1, 1, (6, 2)), rng.normal(size=(6, 2))
    moved = SocialForceWalk(relaxation=0.5, radius=1.0).displace(Walkers(last, velocity, dt))
    x = last + velocity * dt + moved
    near = np.linalg.norm(last[:, None] - last[None], axis=-1) < 1.0
    mean = np.array([velocity[row].mean(axis=0) for row in near])
    force = (mean - (x - last) / dt) / 0.5
    np.testing.assert_allclose(moved / dt**2, force, atol=1e-12)


def test_links_are_the_nearest_within_reach_of_either_side() -> None:
    places = np.random.default_rng(0).uniform(-4, 4, (30, 2))
    places[3] = np.nan
    distance = np.linalg.norm(places[:, None] - places[None], axis=-1) + np.diag(np.full(30, np.inf))
    wanted = set()
    for i in range(30):
        for j in np.argsort(distance[i])[:4]:
            if distance[i, j] < 2.0:
                wanted.add((min(i, j), max(i, j)))
    found = link(places, 2.0, 4)
    assert {(int(i), int(j)) for i, j in found} == wanted
    assert len(found) == len(wanted)


@pytest.mark.parametrize("sizes", [(5.0, 1.0, 9.0, np.nan, 3.0)])
def test_large_crowds_are_cut_to_the_nearest(sizes: Any) -> None:
    boxes = np.column_stack((np.zeros((5, 2)), sizes))
    np.testing.assert_array_equal(select(boxes, 4, 1.0), np.ones(5, bool))
    np.testing.assert_array_equal(select(boxes, 2, 1.0), (True, False, True, False, False))
    np.testing.assert_array_equal(select(boxes, 3, 4.0), (True, False, True, False, False))


def test_the_nearest_are_found_by_their_rays() -> None:
    rays = np.array(((0.0, 5.0), (-1.0, 0.0), (np.nan, np.nan), (3.0, 3.0), (0.0, -2.0)))
    np.testing.assert_array_equal(nearest(rays, 4), np.ones(5, bool))
    np.testing.assert_array_equal(nearest(rays, 2), (False, True, False, False, True))
    np.testing.assert_array_equal(nearest(rays, 3), (False, True, False, True, True))


def ego_energy(pose: FloatArray, softness: float, terms: Factors) -> float:
    """E_c with the people's places minimised out one by one, slowly."""
    relative, covariance, expected, std, path, path_std = terms
    places, last = localise(pose, terms), np.inf
    while np.max(np.abs(places - last)) > 1e-13:
        last, stray = places, np.linalg.norm(places - expected, axis=1) / std
        places = localise(pose, terms._replace(std=std * np.sqrt(np.hypot(stray, softness))))
    stray = np.linalg.norm(places - expected, axis=1) / std
    residuals = relative - world_to_relative(places, pose)
    boxes = 0.0
    for r, (rr, rf, ff) in zip(residuals, covariance, strict=True):
        boxes += 0.5 * r @ np.linalg.inv(np.array(((rr, rf), (rf, ff)))) @ r
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


def test_the_sampled_optimum_converges_to_the_closed_form() -> None:
    """Under squared norms (ε so great that every deviation counts as its square), from places 2 cm of height off."""
    terms = random_terms(4)
    relative, _, expected, std, pose, _ = terms
    softness, rays = 1e4, relative / 1.7
    covariance = 0.07**2 * np.column_stack((rays[:, 0] ** 2, rays[:, 0] * rays[:, 1], rays[:, 1] ** 2))
    terms = terms._replace(covariance=covariance)
    alone = localise(pose, terms)
    outward = relative_to_world(rays, np.append(np.zeros(2), pose[2]))
    gaps = []
    for spacing in (0.04, 0.01, 0.0025):
        how = softness, 2 * int(0.4 / spacing) + 1, spacing
        weights, sharp = np.full(5, 1 / softness), terms._replace(std=std / np.sqrt(softness))
        places, _ = sample_rays(pose[2], alone + 0.0213 * outward, weights, rays, sharp, *how)
        deviation = np.sum((places - alone[:, None]) * outward[:, None], axis=2) / np.sum(outward**2, axis=1)[:, None]
        mean = np.sum((alone - pose[:2]) * outward, axis=1) / np.sum(outward**2, axis=1) - 1.7
        height = (deviation + mean[:, None]) ** 2 / (2 * 0.07**2)
        energies = np.sum((places - expected[:, None]) ** 2, axis=2) / (2 * std[:, None] ** 2) + height
        none = np.empty((0, 2), np.int64), np.empty((0, *2 * energies.shape[1:]))
        choices, _ = pass_messages(energies, *none, 1, 0.0, 1e-3)
        best = places[np.arange(5), choices]
        gaps.append(np.max(np.linalg.norm((best - alone) / outward, axis=1)))
        assert gaps[-1] <= spacing
    assert gaps[2] < 0.1 * 0.0213


def test_the_descent_ends_where_the_energy_is_flat() -> None:
    terms = random_terms(9, depth_std=0.3)
    relative, covariance, expected, std, pose, _ = terms
    found = descend(pose, localise(pose, terms), terms, 0.3, CrowdGraph(np.array(FULL), 2.0, 1.0), 500, 1e-12)
    rr, rf, ff = covariance.T
    noise = np.linalg.inv(np.stack((np.stack((rr, rf), -1), np.stack((rf, ff), -1)), -2))

    def energy(flat: FloatArray) -> float:
        x = flat.reshape(-1, 2)
        off = relative - world_to_relative(x, pose)
        own = np.sqrt(np.sum((x - expected) ** 2, axis=1) / std**2 + 0.09)
        boxes = 0.5 * np.einsum("ki,kij,kj->", off, noise, off)
        return float(np.sum(own) + boxes + 2 * sum(potential(float(np.sum((x[i] - x[j]) ** 2)), 1.0) for i, j in FULL))

    np.testing.assert_allclose(approx_fprime(found.ravel(), energy, 1e-7), 0.0, atol=1e-3)
