"""What the figure over σ_h is made of: the paper's values, and what a user may ask for instead."""

from collections.abc import Sequence
from dataclasses import dataclass

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.generation.generator import Generator, Options, Simulation
from vbbench.protocol import get_protocol
from vbbench.registry import load, make_solver, registered

SPLIT = "sim"
SIGMAS = (0.0, 0.01, 0.03, 0.05, 0.07)
"""σ_h in m of the paper's figure."""
PEOPLE = (10, 20, 30, 40, 50)
"""K of the paper's figure."""

_MODULE = registered("solver")["vb-sf"].module
"""Where the variants of vb-sf are; only its entry point names the package."""
SOLVERS = {
    "vb-sf": "vb-sf as it is: heights learned from the given positions",
    f"{_MODULE}:PriorHeights": "vb-sf with heights from the prior only",
    f"{_MODULE}:PriorHeightsFreeObserver": "vb-sf with heights from the prior only, expecting nothing of the observer",
}
"""The solvers of the figure, and what sets them apart."""


def title_of(solver: str) -> str:
    """What a solver is called in words."""
    return SOLVERS.get(solver, solver)


@dataclass(frozen=True, kw_only=True)
class SigmaStudy:
    """What is to be measured.

    Parameters
    ----------
    solvers : registered names or ``module:attribute``.
    protocol : what the solvers are given.
    camera : ``None`` for the split's own.
    tier : how observations are corrupted.
    sequences : at each σ_h; they take the numbers of people in turn.
    seed : of the datasets.
    sigmas : σ_h in m.
    people : numbers of people K.
    """

    solvers: Sequence[str] = tuple(SOLVERS)
    protocol: str = "one-step"
    camera: Camera | None = None
    tier: str = "ideal"
    sequences: int = 500
    seed: int = 0
    sigmas: Sequence[float] = SIGMAS
    people: Sequence[int] = PEOPLE

    def options(self, sigma_h: float) -> Options:
        """What is asked of the generator at one σ_h (m)."""
        simulation = Simulation(sequences=self.sequences, people=tuple(self.people))
        return Options(camera=self.camera, tier=self.tier, height_std=sigma_h, seed=self.seed, simulation=simulation)

    def check(self) -> None:
        """Find the mistakes that can be found before the work begins.

        Raises
        ------
        VbbenchError
            If a solver, the protocol or an option of the split cannot be.
        """
        if not self.solvers or not self.sigmas:
            raise VbbenchError("nothing to measure: name a solver and a σ_h")
        get_protocol(self.protocol)
        for solver in self.solvers:
            make_solver(solver)
        generator: Generator = load("generator", SPLIT)
        for sigma_h in self.sigmas:
            generator.plan(self.options(sigma_h))
