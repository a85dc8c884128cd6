"""People's places given the pose: the cascade's second energy, with everybody's influence on everybody.

E_p = Σ_k U_k(x_k) + λ Σ_(i,k) V(‖x_i − x_k‖) (arXiv 2111.05060, section IV-C; U in `vbbench_baselines.rays`, V in
`vbbench_baselines.pair_potential`): message passing over the samples along the rays finds the valley, and a descent
from there its lowest point, so that answers do not stand on a grid. In each step of the descent ρ is replaced by its
weighted square and V by its tangent; what is left is a Kalman update with p_k moved by −σ_k²/w_k·λ∇V.
"""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_baselines.localisation import localise
from vbbench_baselines.message_passing import pass_messages
from vbbench_baselines.pair_potential import potential, pull
from vbbench_baselines.reweighting import moved, weigh


@kernel
def tabulate(
    places: FloatArray, energies: FloatArray, edges: IntArray, strength: float, sigma: float
) -> tuple[IntArray, FloatArray]:
    """The edges [E', 2] along which a choice makes a difference, and λV there, [E', S, S].

    Places [K, S, 2] in m and energies [K, S] of the samples, inf = unused; edges [E, 2].
    """
    samples = energies.shape[1]
    kept, pair = edges.copy(), np.empty((len(edges), samples, samples))
    count = 0
    for e in range(len(edges)):
        i, j = edges[e, 0], edges[e, 1]
        if samples == 1 or (np.isinf(energies[i, 1]) and np.isinf(energies[j, 1])):
            continue
        for s in range(samples):
            for r in range(samples):
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
    relative: FloatArray,
    covariance: FloatArray,
    expected: FloatArray,
    std: FloatArray,
    softness: float,
    edges: IntArray,
    strength: float,
    sigma: float,
    rounds: int,
    tolerance: float,
) -> FloatArray:
    """Positions [K, 2] of least E_p near ``positions``; arguments as in `settle` and above."""
    weights, spread, pulled = weigh(positions, expected, std, softness), std.copy(), expected.copy()
    for _ in range(rounds):
        force = pull(positions, edges, strength, sigma)
        for k in range(len(std)):
            spread[k] = std[k] / np.sqrt(weights[k])
            pulled[k, 0] = expected[k, 0] - spread[k] ** 2 * force[k, 0]
            pulled[k, 1] = expected[k, 1] - spread[k] ** 2 * force[k, 1]
        last = positions
        positions = localise(pose, relative, covariance, pulled, spread)
        if not moved(last, positions, tolerance):
            break
        weights = weigh(positions, expected, std, softness)
    return positions


@kernel
def choose(
    places: FloatArray, energies: FloatArray, edges: IntArray, pair: FloatArray, rounds: int, damping: float
) -> FloatArray:
    """The places [K, 2] that message passing chooses among the samples; arguments as above."""
    choices, _ = pass_messages(energies, edges, pair, rounds, damping, 1e-3)
    chosen = np.empty((len(choices), 2))
    for k in range(len(choices)):
        chosen[k, 0], chosen[k, 1] = places[k, choices[k], 0], places[k, choices[k], 1]
    return chosen
