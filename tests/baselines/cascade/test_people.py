"""People's places given the pose: interactions, messages along rays, and the descent."""

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from tests.lib.cascade_terms import matrices, random_terms
from vbbench.geometry import FloatArray, IntArray, relative_to_world, world_to_relative
from vbbench_baselines._core import (
    descend,
    link,
    localise,
    pass_messages,
    potential,
    ray_beliefs,
    sample_rays,
    tabulate,
)
from vbbench_baselines.cascade import CrowdGraph, nearest, select

FULL = [(i, j) for i in range(5) for j in range(i)]
CHAIN = [(i, i + 1) for i in range(4)]
STAR = [(0, i) for i in range(1, 5)]


def test_the_potential_is_the_gradient_of_a_gaussian() -> None:
    for d, h in ((0.3, 1e-6), (1.0, 1e-6), (2.5, 1e-6)):
        gaussian = [np.exp(-((d + side) ** 2) / (2 * 0.8**2)) for side in (h, -h)]
        assert potential(d * d, 0.8) == pytest.approx(abs(gaussian[0] - gaussian[1]) / (2 * h), rel=1e-6)


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


def test_large_crowds_are_cut_to_the_nearest() -> None:
    boxes = np.column_stack((np.zeros((5, 2)), (5.0, 1.0, 9.0, np.nan, 3.0)))
    np.testing.assert_array_equal(select(boxes, 4, 1.0), np.ones(5, bool))
    np.testing.assert_array_equal(select(boxes, 2, 1.0), (True, False, True, False, False))
    np.testing.assert_array_equal(select(boxes, 3, 4.0), (True, False, True, False, False))
    rays = np.array(((0.0, 5.0), (-1.0, 0.0), (np.nan, np.nan), (3.0, 3.0), (0.0, -2.0)))
    np.testing.assert_array_equal(nearest(rays, 4), np.ones(5, bool))
    np.testing.assert_array_equal(nearest(rays, 2), (False, True, False, False, True))
    np.testing.assert_array_equal(nearest(rays, 3), (False, True, False, True, True))


def total(choices: Any, unary: FloatArray, edges: Any, pair: FloatArray) -> float:
    energy = sum(unary[k, s] for k, s in enumerate(choices))
    return float(energy + sum(v[choices[i], choices[j]] for (i, j), v in zip(edges, pair, strict=True)))


def brute_force(unary: FloatArray, edges: Any, pair: FloatArray) -> float:
    """The least energy of all choices: every term broadcast over the grid [S, S, …] of everybody's choices."""
    energy = np.zeros((unary.shape[1],) * len(unary))
    axes = np.ogrid[tuple(slice(0, n) for n in energy.shape)]
    for k, own in enumerate(unary):
        energy += own[axes[k]]
    for (i, j), v in zip(edges, pair, strict=True):
        energy += v[axes[i], axes[j]]
    return float(energy.min())


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("damping", [0.0, 0.2])
@pytest.mark.parametrize("tree", [CHAIN, STAR, CHAIN[:2], [(3, 1)]], ids=str)
def test_messages_are_exact_on_trees(tree: Any, damping: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    unary, pair = rng.normal(size=(5, 7)), rng.normal(size=(len(tree), 7, 7))
    choices, _ = pass_messages(unary, np.array(tree), pair, 100, damping, 1e-12)
    assert total(choices, unary, tree, pair) == pytest.approx(brute_force(unary, tree, pair), abs=1e-9)


def test_unused_samples_are_never_chosen() -> None:
    unary = np.full((5, 7), np.inf)
    unary[:, :2] = np.random.default_rng(1).normal(size=(5, 2))
    choices, _ = pass_messages(unary, np.array(FULL), np.random.default_rng(2).normal(size=(10, 7, 7)), 50, 0.2, 1e-9)
    assert np.all(choices < 2)


def crowded(seed: int, people: int = 5, samples: int = 7) -> tuple[FloatArray, IntArray, FloatArray]:
    """A full graph of people at most 2 m apart, with the solver's own terms at its own strength."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-1, 1, (people, 1, 2)) + np.linspace(-0.3, 0.3, samples)[:, None] * rng.normal(
        size=(people, 1, 2)
    )
    energies = (np.arange(samples) - rng.uniform(0, samples, (people, 1))) ** 2 / rng.uniform(1, 10, (people, 1))
    edges, pair = tabulate(places, energies, CrowdGraph(np.array(FULL), 1.0 / 0.5, 1.0))
    return energies, edges, pair


def test_messages_come_close_on_full_graphs() -> None:
    gaps = []
    for seed in range(40):
        unary, edges, pair = crowded(seed)
        choices, _ = pass_messages(unary, edges, pair, 20, 0.2, 1e-3)
        gaps.append(total(choices, unary, edges, pair) - brute_force(unary, edges, pair))
    assert np.mean(np.array(gaps) < 1e-9) >= 0.9
    assert max(gaps) < 0.1


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
    noise = np.linalg.inv(matrices(covariance))

    def energy(flat: FloatArray) -> float:
        x = flat.reshape(-1, 2)
        off = relative - world_to_relative(x, pose)
        own = np.sqrt(np.sum((x - expected) ** 2, axis=1) / std**2 + 0.09)
        boxes = 0.5 * np.einsum("ki,kij,kj->", off, noise, off)
        return float(np.sum(own) + boxes + 2 * sum(potential(float(np.sum((x[i] - x[j]) ** 2)), 1.0) for i, j in FULL))

    np.testing.assert_allclose(approx_fprime(found.ravel(), energy, 1e-7), 0.0, atol=1e-3)
