"""The layers of the network; each reads its weights by name."""

from collections.abc import Mapping

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_baselines.former.operations import Array, Operations
from vbbench_baselines.former.state import DOUBT, MEMORY, TRACES

Weights = Mapping[str, Array]
WIDTH, HEADS, HIDDEN, BLOCKS = 48, 3, 96, 2
"""Numbers of each person in attention, its heads, numbers between, and how often people attend to one another."""
WALK_FACTS, EGO_FACTS, PERSON_FACTS, OBSERVER_FACTS = 14, 9, 45, 29
"""Numbers that the network is given of a walk, of the observer's, of a person seen, and of the observer."""


class Network:
    """Named layers.

    Parameters
    ----------
    operations : array operations of NumPy or PyTorch.
    weights : arrays by name, see `shapes`.
    """

    def __init__(self, operations: Operations, weights: Weights) -> None:
        self.operations = operations
        self._layers: dict[str, tuple[Array, Array]] = {}
        for name, values in weights.items():
            layer, _, kind = name.rpartition(".")
            if kind != "bias":
                factor = operations.transposed(values) if kind == "weights" else values
                self._layers[layer] = factor, weights[f"{layer}.bias"]

    def linear(self, name: str, x: Array) -> Array:
        """A linear layer of ``x`` [..., n] with a bias."""
        weights, bias = self._layers[name]
        made = x @ weights
        made += bias
        return made

    def perceptron(self, name: str, x: Array) -> Array:
        """Two linear layers of ``x`` [..., n] with SiLU between."""
        return self.linear(f"{name}.out", self.hidden(f"{name}.in", x))

    def hidden(self, name: str, x: Array) -> Array:
        """A linear layer of ``x`` [..., n] and SiLU."""
        return self.operations.silu(self.linear(name, x))

    def normalise(self, name: str, x: Array) -> Array:
        """Layer normalisation."""
        return self.operations.normalise(x, *self._layers[name])

    def remember(self, name: str, x: Array, memory: Array) -> Array:
        """The memory [..., M] after ``x``: a gated recurrent unit (Cho et al. 2014)."""
        size = memory.shape[-1]
        new, old = self.linear(f"{name}.new", x), self.linear(f"{name}.old", memory)
        gates = self.operations.sigmoid(new[..., : 2 * size] + old[..., : 2 * size])
        change, reset = gates[..., :size], gates[..., size:]
        made = self.operations.tanh(new[..., 2 * size :] + reset * old[..., 2 * size :])
        return memory + change * (made - memory)

    def attend(self, rows: Array, hidden: Array) -> Array:
        """``rows`` [..., K + 1, `WIDTH`] after the attention blocks; ``hidden`` [..., K + 1] is −∞ for absent people.

        These are transformer blocks (Vaswani et al. 2017) with normalisation before each part (Xiong et al. 2020).
        """
        for block in range(BLOCKS):
            name = f"block{block}"
            parts = self.linear(f"{name}.ask", self.normalise(f"{name}.before_asking", rows))
            parts = parts.reshape((*rows.shape[:-1], 3 * HEADS, WIDTH // HEADS)).swapaxes(-2, -3)
            asked, keys, values = (parts[..., HEADS * i : HEADS * (i + 1), :, :] for i in range(3))
            match = keys @ asked.swapaxes(-1, -2) * (WIDTH // HEADS) ** -0.5 + hidden[..., None, :, None]
            found = (self.operations.softmax(match).swapaxes(-1, -2) @ values).swapaxes(-2, -3)
            rows = rows + self.linear(f"{name}.tell", found.reshape(rows.shape))
            rows = rows + self.perceptron(f"{name}.think", self.normalise(f"{name}.before_thinking", rows))
        return self.normalise("after", rows)


def shapes() -> dict[str, tuple[int, ...]]:
    """The shape of each array of weights."""
    found: dict[str, tuple[int, ...]] = {}

    def linear(name: str, of: int, to: int) -> None:
        found.update({f"{name}.weights": (to, of), f"{name}.bias": (to,)})

    def perceptron(name: str, of: int, between: int, to: int) -> None:
        linear(f"{name}.in", of, between)
        linear(f"{name}.out", between, to)

    def memory(name: str, of: int, size: int) -> None:
        linear(f"{name}.new", of, 3 * size)
        linear(f"{name}.old", size, 3 * size)

    def normalisation(name: str) -> None:
        found.update({f"{name}.gain": (WIDTH,), f"{name}.bias": (WIDTH,)})

    perceptron("walk", WALK_FACTS + MEMORY, WIDTH, 4 + 2 * TRACES)
    perceptron("own_walk", EGO_FACTS + MEMORY, 32, 3 + 2 * TRACES)
    perceptron("person", PERSON_FACTS + MEMORY, WIDTH, WIDTH)
    perceptron("observer", OBSERVER_FACTS + MEMORY, WIDTH, WIDTH)
    for block in range(BLOCKS):
        name = f"block{block}"
        normalisation(f"{name}.before_asking")
        normalisation(f"{name}.before_thinking")
        linear(f"{name}.ask", WIDTH, 3 * WIDTH)
        linear(f"{name}.tell", WIDTH, WIDTH)
        perceptron(f"{name}.think", WIDTH, HIDDEN, WIDTH)
    normalisation("after")
    linear("trust", WIDTH, 5)
    linear("own_trust", WIDTH, 6)
    linear("look_again", WIDTH + 8, WIDTH)
    linear("together", 2 * WIDTH, WIDTH)
    linear("trust_again", WIDTH, 6)
    memory("memory", WIDTH + 4, MEMORY)
    memory("own_memory", WIDTH + 6, MEMORY)
    linear("doubt", WIDTH + MEMORY, 32)
    memory("doubts", 32 + 4, DOUBT)
    linear("pose_spread", DOUBT, 3)
    perceptron("place_spread", WIDTH + DOUBT + 4, 24, 2)
    return found


def first_weights(rng: np.random.Generator) -> dict[str, FloatArray]:
    """Initial weights: uniform (He et al. 2015), small in output layers, whose biases make it a plain filter."""
    made: dict[str, FloatArray] = {}
    for name, shape in shapes().items():
        if name.endswith(".weights"):
            made[name] = rng.uniform(-1.0, 1.0, shape) / np.sqrt(shape[1])
        else:
            made[name] = np.ones(shape) if name.endswith(".gain") else np.zeros(shape)
    for name in ("trust", "own_trust", "trust_again", "walk.out", "own_walk.out", "pose_spread", "place_spread.out"):
        made[f"{name}.weights"] *= 0.2
    for name, gains in (("walk", 4), ("own_walk", 3)):
        made[f"{name}.out.bias"][:gains] = -0.5
        made[f"{name}.out.bias"][gains : gains + TRACES] = np.linspace(1.0, 3.0, TRACES)
    made["trust_again.bias"][4:6] = 1.0
    made["pose_spread.bias"][:] = made["place_spread.out.bias"][:] = -1.0
    return made
