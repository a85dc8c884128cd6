"""``vb-sf``: view birdification with social force (VB-SF of arXiv 2111.05060), its variants, and the paper's own text.

``vb-sf`` departs from the paper where that helps; ``vb-sf-literal`` is the same solver without any departure.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.solver import Problem
from vbbench_baselines._core import (
    descend,
    link,
    minimise,
    pass_messages,
    pose_energies,
    ray_beliefs,
    sample_rays,
    tabulate,
)
from vbbench_baselines.cascade import CrowdGraph, nearest
from vbbench_baselines.motion_models import MotionModel, SocialForceWalk
from vbbench_baselines.view_birdification import Answer, Birdifier, Task

EXPECTED_WEIGHT = 0.5
"""Mean curvature of the norm m = ‖x − p‖/σ in the plane under its own density exp(−m): half that of m²/2."""


@dataclass(kw_only=True)
class SocialForceBirdifier(Birdifier):
    """The cascade with unsquared norms of deviations from social force, and message passing on the crowd graph.

    Parameters
    ----------
    relaxation, radius, implicit : parameters of `vbbench_baselines.motion_models.SocialForceWalk`.
    softness : ε in standard deviations; the norm is quadratic for smaller deviations.
    samples, spacing : S, odd, and δ in m of height: places along a ray that message passing chooses from.
    strength, sigma : weight λ of the pairwise potential relative to D_k, both in m/s², and its σ in m.
    reach, neighbours : people interact within this distance in m, each with this number of nearest neighbours.
    most_interacting : at most this number of people interact, the nearest; the others keep their own optimum.
    rounds, damping : greatest number of rounds of message passing, and the damping of messages in [0, 1).
    iterations, tolerance : limits of the continuous minimisations; the tolerance is in m and rad.
    """

    acceleration_std: float = 0.5
    relaxation: float = 0.5
    radius: float = 1.0
    implicit: bool = True
    softness: float = 0.3
    samples: int = 9
    spacing: float = 0.01
    strength: float = 1.0
    sigma: float = 1.0
    reach: float = 3.0
    neighbours: int = 6
    most_interacting: int = 100
    rounds: int = 20
    damping: float = 0.2
    iterations: int = 50
    tolerance: float = 1e-6

    variants: ClassVar[Mapping[str, str]] = {
        "vb-sf": "vb-sf as it is: heights learned from the given positions",
        f"{__name__}:PriorHeights": "vb-sf with heights from the prior only",
        f"{__name__}:PriorHeightsFreeObserver": "vb-sf with heights from the prior only, "
        "expecting nothing of the observer",
    }
    """What the paper's figure over the spread of heights compares, and what sets each apart."""

    readings: ClassVar[Mapping[str, tuple[str, str]]] = {
        "learned": ("vb-sf", f"{__name__}:FreeObserver"),
        "prior": (f"{__name__}:PriorHeights", f"{__name__}:PriorHeightsFreeObserver"),
    }
    """By what is known of heights: the solver that expects the observer to walk like the others, and the one that
    expects nothing of the observer. With equal heights, the prior is the height."""

    literal: ClassVar[str] = "vb-sf-literal"
    """The paper's text, word for word."""

    def model(self) -> MotionModel:
        """See `Birdifier.model`; override it for another motion model."""
        return SocialForceWalk(relaxation=self.relaxation, radius=self.radius, implicit=self.implicit)

    def _minimise(self, task: Task) -> Answer:
        factors = task.factors
        pose, alone, weights = minimise(factors, task.pose, self.softness, self.iterations, self.tolerance, task.facing)
        near, positions = nearest(task.rays, self.most_interacting), alone.copy()
        crowd = task._replace(pose=pose, factors=factors.of(near), rays=task.rays[near])
        self._crowd = crowd, alone[near], weights[near]
        positions[near] = self._interact(*self._crowd)
        wide = EXPECTED_WEIGHT**-0.5
        return Answer(pose, positions, factors._replace(std=factors.std * wide, walk_std=factors.walk_std * wide))

    def _interact(self, task: Task, alone: FloatArray, weights: FloatArray) -> FloatArray:
        """The second stage: people's places [K, 2] given the pose, starting from each person's own optimum."""
        pose, factors, rays, _ = task
        samples = self.samples, self.spacing
        places, energies = sample_rays(pose[2], alone, weights, rays, factors, self.softness, *samples)
        if self.samples == 1 or np.isinf(energies[:, 1]).all():
            return alone
        graph = self._graph(alone)
        choices, _ = pass_messages(energies, *tabulate(places, energies, graph), self.rounds, self.damping, 1e-3)
        valley = places[np.arange(len(choices)), choices]
        return descend(pose, valley, factors, self.softness, graph, self.iterations, self.tolerance)

    def _graph(self, alone: FloatArray) -> CrowdGraph:
        """The graph of interacting people, whose optima without interaction are ``alone`` [K, 2]."""
        strength = self.strength / self.acceleration_std
        return CrowdGraph(link(alone, self.reach, self.neighbours), strength, self.sigma)

    def pose_energy(self, poses: FloatArray) -> FloatArray:
        """See `vbbench.solver.PosePosterior.pose_energy`: the first energy, people's places minimised out."""
        task = self._task
        return pose_energies(np.ascontiguousarray(poses), task.factors, self.softness, task.facing)

    def ray_posterior(self, samples: int, spacing: float) -> tuple[FloatArray, FloatArray]:
        """See `vbbench.solver.PosePosterior.ray_posterior`: beliefs of the second stage, at the pose that was found."""
        (pose, factors, rays, _), alone, weights = self._crowd
        seen = ~np.isnan(alone[:, 0])
        here, terms = alone[seen], factors.of(seen)
        places, energies = sample_rays(pose[2], here, weights[seen], rays[seen], terms, self.softness, samples, spacing)
        felt, pair = tabulate(places, energies, self._graph(here))
        beliefs = ray_beliefs(energies, felt, pair, self.rounds, self.damping, 1e-3)
        nearest_first = np.arange(samples)
        along = np.argsort(np.where(nearest_first % 2, nearest_first + 1, -nearest_first), kind="stable")
        return places[:, along], beliefs[:, along]


@dataclass(kw_only=True)
class FreeObserver(SocialForceBirdifier):
    """``vb-sf`` without a prior of the observer: the pose follows only from the people in the picture."""

    ego_prior: bool = False


@dataclass(kw_only=True)
class PriorHeights(SocialForceBirdifier):
    """``vb-sf`` that learns no heights: everyone keeps the dataset's prior N(μ_h, σ_h²)."""

    calibrate: bool = False


@dataclass(kw_only=True)
class PriorHeightsFreeObserver(PriorHeights):
    """As `PriorHeights`, without a prior of the observer: the pose follows only from the people in the picture."""

    ego_prior: bool = False


@dataclass(kw_only=True)
class LiteralBirdifier(PriorHeightsFreeObserver):
    """The cascade of arXiv 2111.05060 as its text has it, with nothing added.

    Heights come from N(μ_h, σ_h²) only, the observer has no motion prior, and the energies are the printed sums,

        E = Σ_k ‖F_k − ẍ_k‖ + ½ (h_k − μ_h)²/σ_h²  (+ Σ_(i,k) V_ik in the second stage),

    of accelerations in m/s² with weight one and V = ‖∇ exp(−d²/2σ²)/√(2πσ²)‖ with σ = 1 m. The solver's own past
    counts as known, and the 100 nearest people take part. The norm is smooth below a thousandth, because a descent
    needs a gradient everywhere. `acceleration_std` and `strength` follow from the duration of a frame.
    """

    estimate_std: float = 0.0
    softness: float = 1e-3
    most_people: int = 100
    iterations: int = 500

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`.

        With the velocity at t in F = (w − ẋ)/η, ‖F − ẍ‖ is (1 + dt/η)‖x − p‖/dt².
        """
        self.acceleration_std = 1.0 / (1.0 + problem.dt / self.relaxation)
        self.strength = self.acceleration_std / np.sqrt(2.0 * np.pi * self.sigma**2)
        super().start(problem)
