"""Ablated solvers, which a study needs that compares the rankings of two datasets.

`vbbench reproduce transfer` ranks them. Each is named on the command line as ``vbbench_baselines.variants:NAME``, such
as ``vbbench_baselines.variants:map-causal-window-6``. No constant is changed, only what a solver is given or may use:

- ``free``: the observer's motion has no prior (``ego_prior`` off).
- ``prior-heights``: heights are not learned from given positions (``calibrate`` off).
- ``no-force``: no alignment with the velocity of people around (`SocialForceBirdifier.relaxation`).
- ``alone``: no pairwise potential (`SocialForceBirdifier.samples`).
- ``noise-2``, ``noise-4``: the stated noise of the boxes is twice or four times the true one (the joint solvers learn
  it where the calibration is uncertain, as in this study).
- ``window-6``: the window has six frames.
- ``person``: a person carries the camera.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from vbbench.reproduction.variants import Variant
from vbbench.solver import Frame, FrameEstimate, FrameSolver, Problem
from vbbench_baselines.ground_plane import GroundPlane
from vbbench_baselines.joint_map import MapCausal
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

NO_FORCE = 1e9
"""In s; whoever adapts that slowly keeps going straight on."""


@dataclass(frozen=True)
class Misinformed:
    """A solver whose problem states ``times`` the true noise of the boxes."""

    solver: FrameSolver
    times: float

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        self.solver.start(replace(problem, pixel_std=self.times * problem.pixel_std))

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        return self.solver.step(frame)


Make = Callable[[], Any]


def _misinformed(make: Callable[[], FrameSolver], times: float) -> Make:
    return lambda: Misinformed(make(), times)


_CV, _SF = ConstantVelocityBirdifier, SocialForceBirdifier

FACTORIES: Mapping[str, Make] = {
    "vb-cv-free": partial(_CV, ego_prior=False),
    "vb-cv-prior-heights": partial(_CV, calibrate=False),
    "ground-plane-noise-4": _misinformed(GroundPlane, 4.0),
    "vb-cv-noise-2": _misinformed(_CV, 2.0),
    "vb-cv-noise-4": _misinformed(_CV, 4.0),
    "vb-sf-free": partial(_SF, ego_prior=False),
    "vb-sf-prior-heights": partial(_SF, calibrate=False),
    "vb-sf-no-force": partial(_SF, relaxation=NO_FORCE),
    "vb-sf-alone": partial(_SF, samples=1),
    "vb-sf-noise-2": _misinformed(_SF, 2.0),
    "vb-sf-noise-4": _misinformed(_SF, 4.0),
    "map-causal-window-6": partial(MapCausal, size=6),
    "map-causal-person": partial(MapCausal, carried_by="person"),
}
"""What makes each variant."""

_SOLVERS = (
    "cv",
    "sf",
    "ground-plane",
    "vb-cv",
    "vb-sf",
    "vb-sf-literal",
    "map-causal",
    "map-batch",
    "vb-former",
)


def _uses_feet(name: str) -> bool:
    return name.startswith(("map-", "vb-former"))


VARIANTS = {name: Variant(solver=name, feet=_uses_feet(name)) for name in _SOLVERS} | {
    name: Variant(solver=f"{__name__}:{name}", feet=_uses_feet(name)) for name in FACTORIES
}
"""What `vbbench.reproduction.transfer` ranks: the solvers as they are, and their variants."""


def __getattr__(name: str) -> Make:
    """The variant called ``name``, as an attribute of the module."""
    try:
        return FACTORIES[name]
    except KeyError:
        raise AttributeError(f"no variant is called {name}") from None
