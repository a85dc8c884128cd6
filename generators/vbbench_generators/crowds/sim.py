"""The splits `sim` and `street`: crowds simulated by social force, each observed by one of its people.

`street` is the paper's photorealistic split, with occlusion.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from vbbench.camera import make_camera
from vbbench.errors import VbbenchError
from vbbench.files.dataset_checks import ALWAYS
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.generate_command import OWN_ENGINE
from vbbench.files.tables import ODOMETRY_TABLE
from vbbench.generation.generator import Card, Look, Observer, Options, Simulation, bundled_card, refuse_footage
from vbbench.generation.tier import Heights, Tier, chosen_heights, chosen_tier
from vbbench.geometry import FloatArray
from vbbench.scene import Scene
from vbbench.sequence import NO_OBSERVER, Odometry, SequenceData
from vbbench.streams import random_stream
from vbbench_generators.crowds import Scenario, draw_crowd, draw_scene, get_scenario, walk
from vbbench_generators.recordings.recipe import Rules, Span
from vbbench_generators.social_force import Model
from vbbench_generators.tiers.corruption import BehindOthers
from vbbench_generators.views import Reprojection, info_of, plan_reprojection, view, walked
from vbbench_generators.views.vehicle import draw_window, follow, ride

SCENES, PEOPLE, FRAMES = 3, 24, 60
HALF_SIDE = 6.0
"""Half the side of the square that is recorded, in m, about the middle of the plaza that people wander about."""


class DemoSplit:
    """Simulated crowds, each observed by all of its people in turn; needs no source."""

    card = bundled_card("vbbench_generators", "demo")

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
    positions = walk(scenario, draw_crowd(scenario, people, Model(), rng), Model())
    inside = np.abs(positions).max(axis=-1) <= HALF_SIDE
    comes = inside & ~np.concatenate([np.zeros((1, people), bool), inside[:-1]])
    visit = comes.T.ravel().cumsum().reshape(people, frames).T - 1
    visits = np.full((frames, comes.sum(), 2), np.nan)
    frame, person = np.nonzero(inside)
    visits[frame, visit[frame, person]] = positions[frame, person]
    visits = visits[:, np.isfinite(visits[..., 0]).argmax(axis=0).argsort(kind="stable")]
    ids = np.arange(visits.shape[1])
    return Scene(name=f"plaza-{index}", dt=scenario.dt, people=ids, positions=visits, heights=np.full(len(ids), np.nan))


REVISION = 2
"""Raised whenever the same options give other observations, so that dataset ids differ too."""
SIM_SCENARIO, STREET_SCENARIO = "open", "street"
"""Those of the paper's splits."""


@dataclass(frozen=True, kw_only=True)
class SimulationPlan:
    """A simulated dataset's `vbbench.generation.generator.Plan`. ``build`` takes any index, however large."""

    info: DatasetInfo
    scenario: Scenario
    heights: Heights
    look: Look
    tier: Tier
    limit: int | None = None
    observer: Observer = "walker"

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """Empty: every sequence has its own scene."""
        return ()

    @property
    def tables(self) -> tuple[str, ...]:
        """See `vbbench.generation.generator.FootagePlan.tables`: robots measure their own motion."""
        return (*ALWAYS, ODOMETRY_TABLE) if self.observer == "robot" else ALWAYS

    def __len__(self) -> int:
        return min(self.scenario.sequences, self.limit or self.scenario.sequences)

    def build(self, index: int) -> SequenceData:
        """One sequence with its scene; its random numbers follow from the seed and its index alone."""
        rng = random_stream(self.info.known_seed, index)
        people = self.scenario.people[index % len(self.scenario.people)]
        heights = self.heights.mean + self.heights.std * rng.standard_normal(people)
        scene, observer, heading = draw_scene(
            self.scenario,
            people,
            camera=self.info.camera,
            height=self.info.height_mean,
            rng=rng,
        )
        scene, span, poses, odometry = self._carried(scene.with_heights(heights), observer, heading, index, rng)
        data = view(
            scene,
            span,
            span.of(scene.present),
            poses,
            info=self.info,
            tier=self.tier,
            index=index,
            rng=rng,
        )
        given = replace(data.sequence.given, odometry=odometry)
        return replace(data, sequence=replace(data.sequence, given=given), scene=scene)

    def _carried(
        self, scene: Scene, observer: int, heading: FloatArray, index: int, rng: np.random.Generator
    ) -> tuple[Scene, Span, FloatArray, Odometry | None]:
        """The scene, the observed frames, poses [T, 3] of the camera in m and rad, and odometry of its bearer."""
        if self.observer == "robot":
            others = np.arange(len(scene.people)) != observer
            rest = replace(
                scene,
                people=scene.people[others],
                positions=scene.positions[:, others],
                heights=scene.heights[others],
            )
            span = _throughout(rest, index, NO_OBSERVER)
            return rest, span, *follow(scene.positions[:, observer], scene.dt, rng)
        if self.observer == "vehicle":
            window = draw_window(scene, index, rng)
            return scene, *ride(scene, window, window.of(scene.present), self.info.camera, rng), None
        span = _throughout(scene, index, observer)
        return scene, span, walked(scene, span, heading, self.look, (self.info.known_seed, index), rng), None


def _throughout(scene: Scene, index: int, observer: int) -> Span:
    """All frames of the scene of sequence ``index``."""
    return Span(scene=index, column=observer, first=0, counted=np.ones(scene.frames, bool))


class SimSplit:
    """Simulated crowds, one a sequence; needs no source."""

    card = bundled_card("vbbench_generators", "sim")

    def plan(self, options: Options) -> SimulationPlan:
        """Lay out the sequences; nothing is simulated yet."""
        return plan_simulation(self.card, options, SIM_SCENARIO, chosen_tier(options))


def plan_simulation(
    card: Card,
    options: Options,
    default_scenario: str,
    tier: Tier,
    **definition: str | float,
) -> SimulationPlan:
    """The plan of a split whose crowds are simulated.

    Raises VbbenchError if an option is not for this split, or out of the scenario's range.

    Parameters
    ----------
    card : card of the split.
    default_scenario : the scenario, unless the options name one.
    tier : the corruption of exact boxes.
    definition : further entries of the dataset's definition.
    """
    if options.source is not None or options.dt is not None or options.homography is not None:
        raise VbbenchError(f"{card.name} has no source: remove `source`, `dt` and `homography`")
    refuse_footage(options, card.name)
    asked = options.simulation or Simulation()
    scenario = get_scenario(asked.scenario or default_scenario)
    numbers: dict[str, Any] = {"sequences": asked.sequences, "people": asked.people}
    try:
        scenario = replace(scenario, **{name: value for name, value in numbers.items() if value is not None})
    except ValueError as error:
        raise VbbenchError(f"scenario '{scenario.name}': {error}") from error
    camera = options.camera or tier.own_camera or make_camera(scenario.camera)
    details = {"engine": OWN_ENGINE, "scenario": asdict(scenario), **tier.definition, **definition}
    titled = replace(card, title=f"{card.title}; {scenario.title}")
    return SimulationPlan(
        info=info_of(titled, options, camera, tier, scenario.dt, f"simulation/{REVISION}", details, scenes=()),
        scenario=scenario,
        heights=chosen_heights(options),
        look=options.look or tier.look,
        tier=tier,
        limit=options.limit,
        observer=options.observer,
    )


class StreetSplit:
    """The scenario `street`; needs no source.

    Its tier `ideal` is the paper's input from centre lines: a person with a sufficient visible fraction has a whole,
    exact box, others have none. Tiers without occlusion, such as `noisy`, are applied to these boxes; tiers with
    occlusion, such as `occluded` and `tracked`, work as in other splits.
    """

    card = replace(SimSplit.card, name="street", title="Street: a simulated crowd in which people hide one another")

    def plan(self, options: Options) -> SimulationPlan:
        """Lay out the sequences; nothing is simulated yet."""
        asked = options.simulation
        if asked is not None and asked.scenario is not None:
            raise VbbenchError(f"street is the scenario '{STREET_SCENARIO}'; `scenario` is for the split 'sim'")
        tier = chosen_tier(options)
        if tier.hides:
            return plan_simulation(self.card, options, STREET_SCENARIO, tier, input=tier.name)
        hidden = BehindOthers(name=tier.name, summary=tier.summary, tier=tier)
        return plan_simulation(self.card, options, STREET_SCENARIO, hidden, input="cline")
