"""How lively the people of a sequence walk: their common σ, learned from the walks that a window has solved.

A recording's people may change their ways twice as much as those a prior was fitted on, and a σ that is too small makes
maps worse and surer at once. An innovation e that is believed to have the variance σ_k² is told by boxes with a
noise of its own; what is found of it is its share r of what they say, r = 1 − v/σ_k² with v the variance that is left
(`optimiser.innovations`). So r²σ² is what its square has beside what noise leaves, r(1 − r)σ_k², and

    σ² = (n_0 σ_fitted² + Σ (e² − r(1 − r)σ_k²)) / (n_0 + Σ r²),

over both coordinates of all innovations that leave the window; innovations that boxes hardly tell hardly count. Squares
are those of normal ones that touch the Student-t law (`motion.walks`).
"""

import math

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_baselines.joint_map.motion.walks import UNKNOWN, Walk

BELIEVED = 20.0
"""n_0, the number of known innovation components as which the fitted σ² counts."""

MOST = 3.0
"""Times the fitted σ. It is never smaller: who hardly strays does so slowly, one innovation like the one before, and a
smaller σ would take that for impossible (`map-batch` on Sim was 1.45 times as far off as it said)."""

ASKED = 10
"""Among more people not all frames are asked: as many in the mean."""


def asks(frame: int, people: int) -> bool:
    """Whether the innovations that leave at a ``frame`` are asked, of so many ``people`` who can tell."""
    return frame % max(-(-people // ASKED), 1) == 0


class Crowd:
    """What the walks of a sequence have told so far of their common σ."""

    def __init__(self) -> None:
        self._told = np.zeros(2)
        self._scale = 1.0

    def walk(self, fitted: Walk) -> Walk:
        """The prior ``fitted`` with what was learned."""
        own = fitted.own if fitted.own == UNKNOWN else fitted.own * self._scale
        return fitted._replace(sigma=fitted.sigma * self._scale, own=own)

    def learn(self, told: FloatArray, fitted: Walk) -> None:
        """Take in `innovations_tell` [2] of those that leave a window."""
        self._told += told
        variance = (BELIEVED + self._told[0] / fitted.sigma**2) / (BELIEVED + self._told[1])
        self._scale = min(math.sqrt(max(variance, 1.0)), MOST)
