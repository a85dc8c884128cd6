"""Sequences by reprojection: people of a scene projected into a camera that one of them carries."""

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from vbbench.camera import Camera, PanoramaCamera
from vbbench.errors import VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Card, Look, Observer, Options, refuse_footage
from vbbench.generation.tier import Heights, Tier, chosen_heights, chosen_tier
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.scene import Scene
from vbbench.sequence import SequenceData
from vbbench.streams import Stream, random_stream
from vbbench_generators.recordings.recipe import Rules, Span, find_spans, observed_crowd
from vbbench_generators.tiers.noise import Precision
from vbbench_generators.views.looking import causal_headings
from vbbench_generators.views.vehicle import find_windows, observer_definition, ride
from vbbench_generators.views.viewing import view, walked

REVISION = 2
"""Raised whenever the same options give other observations, so that dataset ids differ too."""


def draw_heights(scene: Scene, number: int, seed: int, heights: Heights) -> Scene:
    """The scene with heights in m drawn for each person, from the seed and the scene's number."""
    rng = random_stream(seed, number, Stream.HEIGHTS)
    return scene.with_heights(heights.mean + heights.std * rng.standard_normal(len(scene.people)))


@dataclass(frozen=True)
class Reprojection:
    """The plan of a dataset made by reprojection; see `vbbench.generation.generator.Plan`."""

    info: DatasetInfo
    scenes: tuple[Scene, ...]
    rules: Rules
    look: Look
    tier: Tier
    precision: Precision | None = None
    limit: int | None = None
    observer: Observer = "walker"

    def __len__(self) -> int:
        return len(self.spans)

    @cached_property
    def spans(self) -> list[Span]:
        """Every sequence's frames, by scene and person id."""
        spans = [span for n, scene in enumerate(self.scenes) for span in self._spans_of(scene, n)]
        return spans[: self.limit]

    def _spans_of(self, scene: Scene, number: int) -> list[Span]:
        if self.observer == "vehicle":
            return find_windows(scene, number, self._crowds[number])
        return find_spans(scene, number, self.rules)

    @cached_property
    def expected_rows(self) -> IntArray:
        """[N] number of people present in each sequence, summed over frames: its boxes without occlusion."""
        people = [crowd.sum(axis=1) for crowd in self._crowds]
        return np.array([span.of(people[span.scene])[span.counted].sum() for span in self.spans])

    def seen(self, index: int) -> BoolArray | None:
        """See `ForesightedPlan.seen`: a walker's panorama without a tier shows all people who are present."""
        if self.observer != "walker" or self.info.camera.view is not None or self.info.tier != "ideal":
            return None
        span = self.spans[index]
        return span.others(span.of(self._crowds[span.scene]))

    def build(self, index: int) -> SequenceData:
        """One sequence; its random numbers follow from the seed and its index alone."""
        span = self.spans[index]
        scene, crowd = self.scenes[span.scene], self._crowds[span.scene]
        rng = random_stream(self.info.known_seed, index)
        if self.observer == "vehicle":
            span, poses = ride(scene, span, span.of(crowd), self.info.camera, rng)
        else:
            heading = span.of(self._headings[span.scene])[:, span.column]
            poses = walked(scene, span, heading, self.look, (self.info.known_seed, index), rng)
        return view(
            scene,
            span,
            span.of(crowd),
            poses,
            info=self.info,
            tier=self.tier,
            index=index,
            rng=rng,
            precision=self.precision,
        )

    @cached_property
    def _crowds(self) -> list[BoolArray]:
        return [observed_crowd(scene, self.rules) for scene in self.scenes]

    @cached_property
    def _headings(self) -> list[FloatArray]:
        return [causal_headings(scene.positions, scene.dt) for scene in self.scenes]


def info_of(
    card: Card,
    options: Options,
    camera: Camera,
    tier: Tier,
    dt: float,
    generator: str,
    details: dict[str, Any],
    **facts: Any,
) -> DatasetInfo:
    """The facts of a dataset of crowds: what solvers are given, and its definition, which ends with ``details``."""
    heights = chosen_heights(options)
    definition = {"generator": generator, **observer_definition(options, options.look or tier.look)}
    return DatasetInfo(
        split=card.name,
        title=card.title,
        camera=camera,
        tier=tier.name,
        seed=options.seed,
        dt=dt,
        height_mean=heights.told_mean,
        height_std=heights.told_std,
        **asdict(tier.told(camera)),
        definition={**definition, "limit": options.limit, **details},
        **facts,
    )


def plan_reprojection(
    card: Card,
    rules: Rules,
    scenes: list[Scene],
    options: Options,
    definition: dict[str, Any],
    *,
    precision: Precision | None = None,
    calibration: dict[str, Any] | None = None,
) -> Reprojection:
    """Lay out every sequence of ``scenes``, its boxes rounded to ``precision``.

    ``calibration`` is the entry of `DatasetInfo` about the camera that recorded the scenes.

    Raises VbbenchError if an option is not for this split.
    """
    if options.simulation is not None:
        raise VbbenchError(
            f"`scenario`, `sequences` and `people` are for the splits sim and street; {card.name} has its own people"
        )
    refuse_footage(options, card.name)
    if options.observer == "robot":
        raise VbbenchError(f"a robot drives among simulated people: `observer` robot is not for {card.name}")
    tier, heights = chosen_tier(options), chosen_heights(options)
    camera = options.camera or tier.own_camera or PanoramaCamera()
    details = {"count_observer": rules.count_observer, "rules": asdict(rules), **tier.definition}
    details |= {**({} if precision is None else {"precision": asdict(precision)}), **definition}
    names = tuple(scene.name for scene in scenes)
    facts = {"scenes": names, "caution": card.caution, "calibration": calibration}
    info = info_of(card, options, camera, tier, scenes[0].dt, f"reprojection/{REVISION}", details, **facts)
    people = tuple(draw_heights(scene, number, options.seed, heights) for number, scene in enumerate(scenes))
    return Reprojection(
        info=info,
        scenes=people,
        rules=rules,
        look=options.look or tier.look,
        tier=tier,
        precision=precision,
        limit=options.limit,
        observer=options.observer,
    )
