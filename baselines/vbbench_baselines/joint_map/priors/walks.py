"""What a motion prior is fitted on, second differences of true walks, and the prior under which they are most likely.

With innovations e_j of the autoregression, in units c_j of their scale where a walk begins, a person's likelihood is

    ∫ p(s²) Π_j t_ν(e_j; s c_j) ds²,   t_ν(e; s) = (1 + ‖e‖²/(νs²))^{−(ν/2 + 1)} / (2πs²)

(the Student-t density in the plane), s² scaled inverse χ² with a_0 degrees of freedom about σ². The integral is a sum
over a fixed grid of ln s², so that the likelihood is smooth in all parameters.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import Bounds, minimize
from scipy.special import gammaln, logsumexp

from vbbench.generation.generator import Plan
from vbbench.geometry import FloatArray, IntArray, runs_of_true
from vbbench.scene import Scene
from vbbench_baselines.joint_map.prior import Prior, stationary, unbounded

STANDING = 0.5
"""People who end nearer than this (m) to their start are left out: splits do not show them, and they do not walk."""


class Walks(NamedTuple):
    """Every second difference of a crowd, with what came before it.

    Attributes
    ----------
    differences : [N, 3, 2] in m: a_t, a_{t−1} and a_{t−2}; zero where the walk had not begun.
    order : [N] how many of the two past ones there are, 0 to 2.
    first : [P] row at which each person begins; persons stand one after the other.
    speed : mean square of a velocity component in m²/s².
    """

    differences: FloatArray
    order: IntArray
    first: IntArray
    speed: float


def scenes_of(plan: Plan, most: int) -> Sequence[Scene]:
    """A split's shared scenes, or the scenes of its first ``most`` sequences."""
    built = (plan.build(index).scene for index in range(min(most, len(plan))))
    return plan.scenes or [scene for scene in built if scene is not None]


def gather(scenes: Iterable[Scene]) -> Walks:
    """All walks in some scenes; a person who comes back begins a new walk."""
    people: list[list[FloatArray]] = []
    squares: list[FloatArray] = []
    for scene in scenes:
        for column in range(len(scene.people)):
            path, there = scene.positions[:, column], scene.present[:, column]
            runs = [path[first:last] for first, last in runs_of_true(there).tolist()]
            if np.hypot(*(runs[-1][-1] - runs[0][0])) < STANDING:
                continue
            squares += [(np.diff(run, axis=0) / scene.dt) ** 2 for run in runs]
            if any(len(run) > 2 for run in runs):
                people.append([np.diff(run, 2, axis=0) for run in runs if len(run) > 2])
    order = [np.minimum(np.arange(len(a)), 2) for person in people for a in person]
    lengths = [sum(map(len, person)) for person in people]
    return Walks(
        differences=np.concatenate([_with_past(a) for person in people for a in person]),
        order=np.concatenate(order).astype(np.int64),
        first=np.cumsum([0, *lengths[:-1]], dtype=np.int64),
        speed=float(np.concatenate(squares).mean()),
    )


def _with_past(differences: FloatArray) -> FloatArray:
    """[n, 2] → [n, 3, 2]: each beside the two before it."""
    rows = np.zeros((len(differences), 3, 2))
    for lag in range(3):
        rows[lag:, lag] = differences[: len(differences) - lag]
    return rows


GRID = np.arange(2.0 * np.log(1e-4), 2.0 * np.log(3.0), 0.2)
"""ln s² of the integral, s from 0.1 mm to 3 m."""

SIGMA_RANGE, MOST_NU, A0_RANGE = (1e-3, 1.0), 100.0, (0.5, 200.0)
"""Beyond these the distributions are indistinguishable from their limits."""


def innovations(walks: Walks, prior: Prior) -> FloatArray:
    """[N] squared innovations ‖e‖² in m², in units of c²."""
    start = prior.start
    b = np.array(((0.0, 0.0), (start.b, 0.0), prior.b))[walks.order]
    c = np.array((start.first, start.second, 1.0))[walks.order]
    e = walks.differences[:, 0] - np.einsum("nl,nlx->nx", b, walks.differences[:, 1:])
    squares: FloatArray = np.sum(e * e, axis=1) / (c * c)
    return squares


def log_likelihood(walks: Walks, prior: Prior) -> float:
    """Mean over second differences of their log density, in nats."""
    squares, counts = innovations(walks, prior)[:, None], np.bincount(walks.order, minlength=3)
    half, a = 0.5 * prior.nu + 1.0, 0.5 * prior.a0
    each = -half * np.log1p(squares / (prior.nu * np.exp(GRID))) - GRID - np.log(2.0 * np.pi)
    persons = np.add.reduceat(each, walks.first, axis=0)
    x = np.log(a * prior.sigma**2) - GRID
    spread = a * x - np.exp(x) - gammaln(a) + np.log(GRID[1] - GRID[0])  # ln of p(s²) ds²
    units = -2.0 * float(counts[0] * np.log(prior.start.first) + counts[1] * np.log(prior.start.second))  # −2 Σ ln c
    return (float(logsumexp(persons + spread, axis=1).sum()) + units) / len(walks.order)


def fit_walks(crowds: Sequence[Walks], start: Prior, least_nu: float, held: Collection[str] = ()) -> Prior:
    """The prior with the greatest mean of `log_likelihood` over crowds: each counts the same, however large.

    ν ≥ ``least_nu`` keeps interpolated recordings, most of whose second differences are zero, from being believed.
    What is ``held`` of ``b``, ``nu`` and ``a0`` stays what it is in ``start``, which measures what it is good for.
    """

    def cost(v: FloatArray) -> float:
        prior = _unpack(v, start)
        return -sum(log_likelihood(walks, prior) for walks in crowds)

    lower = np.array((-2.0, -2.0, *np.log((SIGMA_RANGE[0], least_nu, A0_RANGE[0]))))
    upper = np.array((2.0, 2.0, *np.log((SIGMA_RANGE[1], MOST_NU, A0_RANGE[1]))))
    v = np.clip(_pack(start), lower, upper)
    for i, name in enumerate(("b", "b", "sigma", "nu", "a0")):
        if name in held:
            lower[i] = upper[i] = v[i]
    best = minimize(cost, v, method="L-BFGS-B", bounds=Bounds(lower, upper), options={"ftol": 1e-11, "gtol": 1e-7})
    speed = float(np.sqrt(np.mean([walks.speed for walks in crowds])))
    return replace(_unpack(best.x, start), speed=speed)


def _pack(prior: Prior) -> FloatArray:
    """Free parameters: partial autocorrelations, which keep the autoregression stationary, and logarithms."""
    return np.append(unbounded(prior.b), np.log((prior.sigma, prior.nu, prior.a0)))


def _unpack(v: FloatArray, others: Prior) -> Prior:
    sigma, nu, a0 = np.exp(v[2:])
    return replace(others, b=stationary(v[:2]), sigma=float(sigma), nu=float(nu), a0=float(a0))
