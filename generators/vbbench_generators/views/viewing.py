"""The sequence of one observer of a scene: camera poses, people's boxes, visible fractions, and what is given."""

from dataclasses import asdict
from typing import Any, cast

import numpy as np

from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Look
from vbbench.generation.tier import Sight, Tier
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import arrivals_given
from vbbench.scene import Scene
from vbbench.sequence import NO_OBSERVER, Sequence, SequenceData, Truth, held_persons
from vbbench.streams import Stream, random_stream
from vbbench_generators.recordings.recipe import Span
from vbbench_generators.tiers.noise import Precision, wandering
from vbbench_generators.views.looking import (
    LONGEST_LEAD,
    WANDER_STD,
    WANDER_TIME,
    Law,
    Way,
    natural_look,
    natural_yaws,
    wrapped,
)


def look_definition(look: Look) -> dict[str, Any]:
    """The parameters of yaws, as JSON: part of a dataset's definition and id."""
    return {"look": look, **({} if look in ("motion", "wander") else {"natural": asdict(natural_look())})}


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
