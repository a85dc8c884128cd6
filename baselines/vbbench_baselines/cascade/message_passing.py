"""Min-sum (max-product) message passing on a graph of discrete choices: O(E S² T).

Minimises Σ_k U_k(s_k) + Σ_(i,j) V_ij(s_i, s_j). Exact on trees; on graphs with loops a good minimum, not a certain one.
"""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel


@kernel
def pass_messages(
    unary: FloatArray, edges: IntArray, pair: FloatArray, rounds: int, damping: float, tolerance: float
) -> tuple[IntArray, int]:
    """The choice of each node, by its min-marginal.

    Parameters
    ----------
    unary : [K, S] energies U, inf = no such choice.
    edges, pair : [E, 2] nodes (i, j) and [E, S, S] energies V_ij(s_i, s_j), finite.
    rounds, tolerance : stop after this number of rounds, or when no message changed by more; all are passed at once.
    damping : share of the last round's message that is kept, in [0, 1).

    Returns
    -------
    [K] choices, and the number of rounds.
    """
    belief, done = pass_beliefs(unary, edges, pair, rounds, damping, tolerance)
    choices = np.empty(len(belief), np.int64)
    for k in range(len(belief)):
        choices[k] = np.argmin(belief[k])
    return choices, done


@kernel
def pass_beliefs(
    unary: FloatArray, edges: IntArray, pair: FloatArray, rounds: int, damping: float, tolerance: float
) -> tuple[FloatArray, int]:
    """The min-marginals [K, S] themselves, up to a constant for each node, and the number of rounds."""
    count, samples = len(edges), unary.shape[1]
    messages = np.zeros((count, 2, samples))  # 0: to i from j, 1: to j from i
    belief = unary.copy()
    done = 0
    while done < rounds:
        change, last = 0.0, messages.copy()
        for e in range(count):
            i, j = belief[edges[e, 0]], belief[edges[e, 1]]
            change = max(change, _send(j, last[e, 1], pair[e], True, messages[e, 0], damping))
            change = max(change, _send(i, last[e, 0], pair[e], False, messages[e, 1], damping))
        done += 1
        if change <= tolerance:
            break
        belief = unary.copy()
        for e in range(count):
            for end in range(2):
                for s in range(samples):
                    belief[edges[e, end], s] += messages[e, end, s]
    return belief, done


@kernel
def _send(
    belief: FloatArray, received: FloatArray, pair: FloatArray, to_first: bool, message: FloatArray, damping: float
) -> float:
    """Update ``message`` [S] from a node with ``belief``, which had ``received`` [S]; return the greatest change.

    ``pair`` [S, S] holds the energies by the choices of the edge's two nodes; ``to_first``: the first receives.
    """
    samples = len(message)
    fresh = np.full(samples, np.inf)
    for s in range(samples):
        for r in range(samples):
            fresh[s] = min(fresh[s], belief[r] - received[r] + (pair[s, r] if to_first else pair[r, s]))
    fresh -= np.min(fresh)
    change = 0.0
    for s in range(samples):
        value = fresh[s] + damping * (message[s] - fresh[s])
        change = max(change, abs(value - message[s]))
        message[s] = value
    return change
