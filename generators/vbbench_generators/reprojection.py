"""Turns scenes into what each of their people sees: positions reprojected into a camera carried along."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vbbench.arrays import BoolArray, FloatArray, IntArray
from vbbench.dataset_info import DatasetInfo
from vbbench.generator import Look, SequenceData
from vbbench.geometry import world_to_relative
from vbbench.protocol import START_FRAMES
from vbbench.scene import Scene
from vbbench.sequence import Given, Sequence, Truth
from vbbench_generators.corruption import add_pixel_noise
from vbbench_generators.eligibility import Rules, Span, find_spans, observed_crowd
from vbbench_generators.heading import causal_headings, wandering_look

HEIGHT_STREAM = 1
"""Spawn key of the generator of heights, apart from the one of every sequence."""


def draw_heights(scene: Scene, number: int, info: DatasetInfo) -> Scene:
    """The scene with heights N(μ_h, σ_h²) in m, by person, from the seed."""
    rng = np.random.default_rng(np.random.SeedSequence([info.seed, number], spawn_key=(HEIGHT_STREAM,)))
    return scene.with_heights(info.height_mean + info.height_std * rng.standard_normal(len(scene.people)))


@dataclass(frozen=True)
class Reprojection:
    """The plan of a dataset made by reprojection; see `vbbench.generator.Plan`."""

    info: DatasetInfo
    scenes: tuple[Scene, ...]
    rules: Rules
    look: Look
    limit: int | None = None

    def __len__(self) -> int:
        return len(self.spans)

    @cached_property
    def spans(self) -> list[Span]:
        """Every sequence's frames, by scene and person id."""
        spans = [span for n, scene in enumerate(self.scenes) for span in find_spans(scene, n, self.rules)]
        return spans[: self.limit]

    def build(self, index: int) -> SequenceData:
        """One sequence; its random numbers follow from the seed and its index alone."""
        span = self.spans[index]
        rng = np.random.default_rng(np.random.SeedSequence([self.info.seed, index]))
        scene, frames = self.scenes[span.scene], slice(span.first, span.first + len(span.counted))
        poses = self._poses(span, frames, rng)
        seen = self._crowds[span.scene][frames] & span.counted[:, None]
        seen[:, span.column] = False
        columns = np.flatnonzero(seen.any(axis=0))
        truth = Truth(
            poses=poses, positions=scene.positions[frames].take(columns, axis=1), heights=scene.heights[columns]
        )
        boxes = self._boxes(truth, seen[:, columns], rng)
        return _without_unseen(_sequence(index, span, scene, columns, boxes, truth), truth)

    @cached_property
    def _crowds(self) -> list[BoolArray]:
        return [observed_crowd(scene, self.rules) for scene in self.scenes]

    @cached_property
    def _headings(self) -> list[FloatArray]:
        return [causal_headings(scene.positions, scene.dt) for scene in self.scenes]

    def _poses(self, span: Span, frames: slice, rng: np.random.Generator) -> FloatArray:
        scene = self.scenes[span.scene]
        yaw = self._headings[span.scene][frames, span.column]
        if self.look == "wander":
            yaw = yaw + wandering_look(len(yaw), scene.dt, rng)
        wrapped = np.arctan2(np.sin(yaw), np.cos(yaw))
        return np.concatenate([scene.positions[frames, span.column], wrapped[:, None]], axis=1)

    def _boxes(self, truth: Truth, seen: BoolArray, rng: np.random.Generator) -> FloatArray:
        """Boxes [T, K, 3] in px of whoever is to be seen ([T, K]); NaN elsewhere and outside the picture."""
        camera, who = self.info.camera, np.flatnonzero(seen)
        relative = world_to_relative(truth.positions, truth.poses).reshape(-1, 2).take(who, axis=0)
        found = camera.project(relative, truth.heights.take(who % len(truth.heights)))
        if self.info.pixel_std > 0:
            found = add_pixel_noise(found, camera, self.info.pixel_std, rng)
        boxes = np.full((seen.size, 3), np.nan)
        boxes[who] = found
        return boxes.reshape(*seen.shape, 3)


def _sequence(index: int, span: Span, scene: Scene, columns: IntArray, boxes: FloatArray, truth: Truth) -> Sequence:
    observed = ~np.isnan(boxes[..., 2])
    return Sequence(
        index=index,
        scene=span.scene,
        observer=int(scene.people[span.column]),
        first_frame=span.first,
        tracks=scene.people[columns],
        observations=boxes,
        visible=np.where(observed, 1.0, np.nan),
        given=arrivals_given(truth, observed),
    )


def _without_unseen(sequence: Sequence, truth: Truth) -> SequenceData:
    """Leave out whoever never comes into the picture."""
    kept = sequence.observed.any(axis=0)
    if not kept.all():
        given = replace(sequence.given, positions=sequence.given.positions[:, kept])
        sequence = replace(
            sequence,
            tracks=sequence.tracks[kept],
            observations=sequence.observations[:, kept],
            visible=sequence.visible[:, kept],
            given=given,
        )
        truth = replace(truth, positions=truth.positions[:, kept], heights=truth.heights[kept])
    return SequenceData(sequence=sequence, truth=truth)


def arrivals_given(truth: Truth, observed: BoolArray) -> Given:
    """What `sequential` gives: the first two poses, and each track's first two visible frames, from [T, K]."""
    first_two = observed & (np.cumsum(observed, axis=0) <= START_FRAMES)
    first_poses = np.arange(len(truth.poses))[:, None] < START_FRAMES
    positions = np.full(truth.positions.shape, np.nan)
    positions[first_two] = truth.positions[first_two]
    return Given(poses=np.where(first_poses, truth.poses, np.nan), positions=positions)
