"""Views of a scene by reprojection: its people as the camera sees them that one of them, or a vehicle, carries."""

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np

from vbbench.camera import Camera, PanoramaCamera
from vbbench.errors import VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Card, Look, Observer, Options, refuse_footage
from vbbench.generation.tier import Heights, Sight, Tier, chosen_heights, chosen_tier
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import NO_OBSERVER, Sequence, SequenceData, Truth, held_persons
from vbbench.streams import Stream, random_stream
from vbbench_generators.recordings.recipe import Rules, Span, find_spans, observed_crowd
from vbbench_generators.tiers.noise import Precision, wandering
from vbbench_generators.views.looking import (
    LONGEST_LEAD,
    WANDER_STD,
    WANDER_TIME,
    Law,
    Way,
    causal_headings,
    natural_look,
    natural_yaws,
    wrapped,
)
from vbbench_generators.views.vehicle import find_windows, observer_definition, ride

REVISION = 2
"""Raised whenever the same options give other observations, so that dataset ids differ too."""


def truth_of_tracks(truth: Truth, people: IntArray, persons: IntArray) -> Truth:
    """Truth of tracks [T, K] of ``persons`` [T, K], from that of ``people`` [P]; NaN for false alarms."""
    positions, heights = np.full((*persons.shape, 2), np.nan), np.full(persons.shape[1], np.nan)
    frame, track = np.nonzero(persons >= 0)
    column = np.searchsorted(people, persons[frame, track])
    positions[frame, track] = truth.positions[frame, column]
    heights[track[::-1]] = truth.heights[column[::-1]]  # the first person's, where there are several
    return Truth(poses=truth.poses, positions=positions, heights=heights)


def view(
    scene: Scene,
    span: Span,
    crowd: BoolArray,
    poses: FloatArray,
    *,
    info: DatasetInfo,
    tier: Tier,
    index: int,
    rng: np.random.Generator,
    precision: Precision | None = None,
) -> SequenceData:
    """The sequence of one observer.

    Parameters
    ----------
    scene, span : the observer's frames of the scene.
    crowd : [T, K] mask of the people to be seen in these frames; others may still hide them.
    poses : [T, 3] (x, y, yaw) of the camera in m and rad.
    info : facts of the dataset, its camera among them.
    tier : corruption of exact boxes.
    index : number of the sequence.
    rng : the sequence's random numbers.
    precision : rounding of boxes at the end; ``None``: no rounding.
    """
    seen = span.others(crowd)
    places = span.of(scene.positions)
    columns = np.flatnonzero((~np.isnan(places[..., 0]) if tier.hides else seen).any(axis=0))
    columns = columns[columns != span.column]
    positions, people = places.take(columns, axis=1), scene.people[columns]
    truth = Truth(poses=poses, positions=positions, heights=scene.heights[columns])
    sight = Sight(
        truth=truth,
        people=people,
        seen=seen[:, columns],
        watched=span.counted,
        camera=info.camera,
        dt=info.dt,
        observer="vehicle" if span.column == NO_OBSERVER else "walker",
    )
    made = tier.observe(sight, rng)
    boxes, visible, persons = made.boxes, made.visible, made.persons
    if persons is None:
        tracks = people
        kept = np.flatnonzero(~np.isnan(boxes[..., 2]).all(axis=0))
        if len(kept) < len(people):  # whoever never comes into the picture is left out
            boxes, visible, tracks = boxes.take(kept, axis=1), visible.take(kept, axis=1), people[kept]
            truth = Truth(poses=poses, positions=positions.take(kept, axis=1), heights=truth.heights[kept])
    else:
        tracks, persons = np.arange(boxes.shape[1]), held_persons(persons, ~np.isnan(boxes[..., 2]))
        truth = truth_of_tracks(truth, people, persons)
    if precision is not None:
        boxes = precision.rounded(boxes, info.camera)
    sequence = Sequence(
        index=index,
        scene=span.scene,
        observer=NO_OBSERVER if span.column == NO_OBSERVER else int(scene.people[span.column]),
        first_frame=span.first,
        tracks=tracks,
        observations=boxes,
        visible=visible,
        given=arrivals_given(truth, ~np.isnan(boxes[..., 2] + truth.positions[..., 0])),
    )
    return SequenceData(sequence=sequence, truth=truth, persons=persons)


def walked(
    scene: Scene, span: Span, heading: FloatArray, look: Look, seed: tuple[int, int], rng: np.random.Generator
) -> FloatArray:
    """[T, 3] poses of a camera that one of the people carries.

    Parameters
    ----------
    scene, span : the bearer's frames of the scene.
    heading : [T] direction of the bearer's walking, in rad.
    look : model of the camera's yaw: along ``heading``, wandering about it, or that of people's heads.
    seed : the dataset's seed, and the number of the sequence.
    rng : the sequence's random numbers.
    """
    if look == "wander":
        heading = heading + WANDER_STD * wandering((len(heading),), WANDER_TIME, scene.dt, rng)
    elif look != "motion":
        heading = _natural_heading(scene, span, look, random_stream(*seed, Stream.LOOK))
    return np.concatenate([span.of(scene.positions)[:, span.column], wrapped(heading)[:, None]], axis=1)


def _natural_heading(scene: Scene, span: Span, look: Look, rng: np.random.Generator) -> FloatArray:
    """Yaw [T] in rad of the observer's head in the frames of the span, drawn from its own random stream."""
    reach, end = int(np.ceil(2.0 * LONGEST_LEAD / scene.dt)), span.first + len(span.counted)
    first = max(span.first - reach, 0)
    path = scene.positions[first : end + reach, span.column]
    known = np.flatnonzero(~np.isnan(path[:, 0]))
    way = Way(
        path=path[known],
        times=scene.dt * (known + first - span.first).astype(np.float64),
        around=scene.positions[span.first : end],
        dt=scene.dt,
    )
    law: Law | None = None if look == "natural" else cast(Law, look)
    return natural_yaws(way, natural_look(), rng, law)


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
