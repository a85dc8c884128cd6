"""The split `demo`: simulated people passing through a square, for a first look without a recording."""

from dataclasses import replace

import numpy as np

from vbbench.generation.generator import Card, Options
from vbbench.scene import Scene
from vbbench.streams import random_stream
from vbbench_generators.crowds.scenario import get_scenario
from vbbench_generators.crowds.scenes import draw_crowd, walk
from vbbench_generators.crowds.social_force.model import Model
from vbbench_generators.recordings.eligibility import Rules
from vbbench_generators.views.reprojection import Reprojection, plan_reprojection

SCENES, PEOPLE, FRAMES = 3, 24, 60
HALF_SIDE = 6.0
"""Half the side of the square that is recorded, in m, about the middle of the plaza that people wander about."""


class DemoSplit:
    """Simulated crowds, each seen by all of its people; needs no source."""

    card = Card(
        name="demo",
        title="Synthetic crowds passing through a square (no recording)",
        licence="Apache-2.0, like vbbench",
        citation="none; made by vbbench",
        sources=(),
        caution="synthetic crowds, not people: for trying things out, not for comparing solvers",
        people="simulated",
    )

    def plan(self, options: Options) -> Reprojection:
        """Simulate the crowds and lay out their sequences."""
        scenes = [record_plaza(options.seed, index, PEOPLE, FRAMES) for index in range(SCENES)]
        rules = Rules(min_others=3, min_frames=5)
        return plan_reprojection(self.card, rules, scenes, options, {"crowd": [SCENES, PEOPLE, FRAMES, HALF_SIDE]})


def record_plaza(seed: int, index: int, people: int, frames: int) -> Scene:
    """The scenario `plaza`, of which only a square is recorded: people come and go; those who come back are new.

    Parameters
    ----------
    seed, index : the scene follows from ``SeedSequence([seed, index])`` alone.
    people : number of people K on the plaza.
    frames : number of frames T.
    """
    scenario = replace(get_scenario("plaza"), people=(people,), frames=frames)
    rng = random_stream(seed, index)
    positions = walk(scenario, draw_crowd(scenario, people, Model(), rng), Model(), "vbbench")
    inside = np.abs(positions).max(axis=-1) <= HALF_SIDE
    comes = inside & ~np.concatenate([np.zeros((1, people), bool), inside[:-1]])
    visit = comes.T.ravel().cumsum().reshape(people, frames).T - 1
    visits = np.full((frames, comes.sum(), 2), np.nan)
    frame, person = np.nonzero(inside)
    visits[frame, visit[frame, person]] = positions[frame, person]
    visits = visits[:, np.isfinite(visits[..., 0]).argmax(axis=0).argsort(kind="stable")]
    ids = np.arange(visits.shape[1])
    return Scene(name=f"plaza-{index}", dt=scenario.dt, people=ids, positions=visits, heights=np.full(len(ids), np.nan))
