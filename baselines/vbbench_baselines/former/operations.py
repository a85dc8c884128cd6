"""Array operations of the network, on tensors while it is trained, and on NumPy's arrays in tests.

Points and directions on the ground are complex numbers: forward + i·left of a camera.
"""

from typing import Any, Protocol

Array = Any
"""A tensor while the network is trained."""


class Operations(Protocol):
    """Operations on arrays [..., N]; those that join or reduce work along the last axis."""

    def where(self, condition: Array, yes: Array, no: Array) -> Array:
        """``yes`` where the condition holds, else ``no``."""

    def exp(self, x: Array) -> Array:
        """E to the x."""

    def log(self, x: Array) -> Array:
        """The natural logarithm."""

    def sqrt(self, x: Array) -> Array:
        """The square root."""

    def asinh(self, x: Array) -> Array:
        """The inverse hyperbolic sine: linear near 0, logarithmic far from it."""

    def tanh(self, x: Array) -> Array:
        """The hyperbolic tangent."""

    def sigmoid(self, x: Array) -> Array:
        """1/(1 + exp(−x))."""

    def silu(self, x: Array) -> Array:
        """x·sigmoid(x)."""

    def clip(self, x: Array, low: float, high: float) -> Array:
        """X within bounds."""

    def direction(self, angle: Array) -> Array:
        """exp(i·angle)."""

    def angle(self, x: Array) -> Array:
        """The angle of complex x, within ±π."""

    def point(self, forward: Array, left: Array) -> Array:
        """Forward + i·left."""

    def pairs(self, points: Array) -> Array:
        """Real and imaginary parts [..., 2] of points [...]."""

    def totals(self, parts: list[Array]) -> list[Array]:
        """The sum [...] of each of the arrays [..., K]."""

    def stack(self, parts: list[Array]) -> Array:
        """N arrays [...] stacked along a new last axis, [..., N]."""

    def join(self, parts: list[Array]) -> Array:
        """Arrays [..., n] concatenated along the last axis."""

    def append_row(self, rows: Array, row: Array) -> Array:
        """Rows [..., K + 1, N]: ``rows`` [..., K, N], then ``row`` [..., N]."""

    def linear(self, x: Array, weights: Array, bias: Array) -> Array:
        """X [..., n] times the weights [m, n] transposed, and the bias [m]."""

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        """Layer normalisation along the last axis, times ``gain`` plus ``bias``."""

    def softmax(self, x: Array) -> Array:
        """Softmax along the last axis."""

    def detach(self, x: Array) -> Array:
        """The same values without gradient."""
