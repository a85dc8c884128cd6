"""People's places given the pose: the cascade's second energy, with the interactions of people.

E_p = Σ_k U_k(x_k) + λ Σ_(i,k) V(‖x_i − x_k‖) (arXiv 2111.05060, section IV-C; V in
`vbbench_baselines.cascade.crowd_graph`), a person's own energy, given the pose, being

    U_k(x) = ρ(‖x − p_k‖/σ_k) + ½‖z_k − Rᵀ(x − c)‖²_{N_k⁻¹}   (see `vbbench_baselines.cascade.reweighting`).

Message passing over samples along the viewing rays finds the valley, and a descent from there its lowest point, off the
grid of samples. In each step of the descent ρ is replaced by its weighted square and V by its tangent;
what is left is a Kalman update with p_k moved by −σ_k²/w_k·λ∇V.

The samples stand δ of height apart on the ray about the person's own optimum, as many as ±SPAN standard deviations of
the height take, at most S. Box noise across the ray moves each sample to where, at that height, U_k is least under the
weights at the optimum; without box noise all samples are on the ray. People known to less than δ/2 have one sample.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.cascade.crowd_graph import CrowdGraph, potential, pull
from vbbench_baselines.cascade.reweighting import moved, weigh
from vbbench_baselines.common.ego_motion import Factors, invert, localise

SPAN = 3.0
"""Standard deviations of the height, by the person's own terms, on either side of the optimum."""


class Samples(NamedTuple):
    """Places along the viewing rays; sample 0 is the person's own optimum.

    Attributes
    ----------
    places : [K, S, 2] in the world, in m.
    energies : [K, S] U less that at the optimum; inf = unused.
    """

    places: FloatArray
    energies: FloatArray


@kernel
def sample_rays(
    yaw: float,
    positions: FloatArray,
    weights: FloatArray,
    rays: FloatArray,
    factors: Factors,
    softness: float,
    most: int,
    spacing: float,
) -> Samples:
    """Everyone's samples; people without expectation stay where they are.

    Parameters
    ----------
    yaw : of the observer, in rad.
    positions, weights : [K, 2] optima in m and [K] weights there, as `settle` gives them.
    rays : [K, 2] place in m of a person one metre tall.
    softness : as in `settle`.
    most, spacing : S, odd, and δ in m of height.
    """
    covariance, expected, std = factors.covariance, factors.expected, factors.std
    people, sin, cos = len(std), np.sin(yaw), np.cos(yaw)
    places, energies = np.empty((people, most, 2)), np.empty((people, most))
    for k in range(people):
        x, y = positions[k, 0], positions[k, 1]
        for s in range(most):
            places[k, s, 0], places[k, s, 1], energies[k, s] = x, y, np.inf
        energies[k, 0] = 0.0
        spread = std[k] / np.sqrt(weights[k])
        variance, right, forward = _direction(rays[k], covariance[k], spread)
        if not variance >= 0.25 * spacing**2:
            continue
        step_x, step_y = (right * sin + forward * cos) * spacing, (forward * sin - right * cos) * spacing
        # Away from the optimum x the box term grows by its slope there, −∇ρ = −(w/σ²)(x − p), and its own curvature.
        off_x, off_y = x - expected[k, 0], y - expected[k, 1]
        start = np.sqrt((off_x * off_x + off_y * off_y) / std[k] ** 2 + softness**2)
        slope = weights[k] / std[k] ** 2 * (off_x * step_x + off_y * step_y)
        squared = step_x * step_x + step_y * step_y
        curvature = max(spacing**2 / variance - squared / spread**2, 0.0)  # N⁻¹ = P⁻¹ − 1/spread²
        half = min(most // 2, int(np.ceil(SPAN * np.sqrt(variance) / spacing)))
        for s in range(1, 2 * half + 1):
            n = float((s + 1) // 2 if s % 2 else -(s // 2))
            moved_x, moved_y = off_x + n * step_x, off_y + n * step_y
            walk = np.sqrt((moved_x * moved_x + moved_y * moved_y) / std[k] ** 2 + softness**2) - start
            places[k, s, 0], places[k, s, 1] = x + n * step_x, y + n * step_y
            energies[k, s] = walk - n * slope + 0.5 * n * n * curvature
    return Samples(places, energies)


@kernel
def _direction(ray: FloatArray, covariance: FloatArray, spread: float) -> tuple[float, float, float]:
    """Variance in m² of the height given all of a person's own terms, and dz/dh (right, forward) where they move it.

    Both from the covariance P = (1/spread² + N⁻¹)⁻¹ of z: var h = uᵀPu with u = ρ/‖ρ‖², dz/dh = P u/(uᵀPu).
    """
    v, squared = spread**2, ray[0] * ray[0] + ray[1] * ray[1]
    u_r, u_f = ray[0] / squared, ray[1] / squared
    rr, rf, ff = invert(covariance[0] + v, covariance[1], covariance[2] + v)
    # P = v − v (N + v)⁻¹ v
    right, forward = v * (u_r - v * (rr * u_r + rf * u_f)), v * (u_f - v * (rf * u_r + ff * u_f))
    variance = u_r * right + u_f * forward
    return variance, right / variance, forward / variance


@kernel
def tabulate(samples: Samples, graph: CrowdGraph) -> tuple[IntArray, FloatArray]:
    """The edges [E', 2] along which a choice makes a difference, and λV there, [E', S, S]."""
    places, energies = samples
    edges, strength, sigma = graph
    most = energies.shape[1]
    kept, pair = edges.copy(), np.empty((len(edges), most, most))
    count = 0
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
        if most == 1 or (np.isinf(energies[i, 1]) and np.isinf(energies[j, 1])):
            continue
        for s in range(most):
            for r in range(most):
                pair[count, s, r] = 0.0
                if not (np.isinf(energies[i, s]) or np.isinf(energies[j, r])):
                    dx, dy = places[i, s, 0] - places[j, r, 0], places[i, s, 1] - places[j, r, 1]
                    pair[count, s, r] = strength * potential(dx * dx + dy * dy, sigma)
        kept[count, 0], kept[count, 1] = i, j
        count += 1
    return kept[:count], pair[:count]


@kernel
def descend(
    pose: FloatArray,
    positions: FloatArray,
    factors: Factors,
    softness: float,
    graph: CrowdGraph,
    rounds: int,
    tolerance: float,
) -> FloatArray:
    """Positions [K, 2] of least E_p near ``positions``; the rest as in `settle`."""
    relative, covariance, expected, std, walk, walk_std = factors
    weights = weigh(positions, factors, softness)
    for _ in range(rounds):
        spread = std / np.sqrt(weights)
        pulled = expected - (spread**2).reshape((-1, 1)) * pull(positions, graph)
        last = positions
        positions = localise(pose, Factors(relative, covariance, pulled, spread, walk, walk_std))
        if not moved(last, positions, tolerance):
            break
        weights = weigh(positions, factors, softness)
    return positions
