"""Message passing: exact on trees, close on full graphs."""

from typing import Any

import numpy as np
import pytest

from vbbench.geometry import FloatArray, IntArray
from vbbench_baselines._core import pass_messages, tabulate
from vbbench_baselines.cascade import CrowdGraph

FULL = [(i, j) for i in range(5) for j in range(i)]
CHAIN = [(i, i + 1) for i in range(4)]
STAR = [(0, i) for i in range(1, 5)]


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
