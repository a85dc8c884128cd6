"""Turns scenes into what each of their people sees: positions reprojected into a camera carried along."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Look
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.scene import Scene
from vbbench.sequence import SequenceData
from vbbench_generators.corruption import Corruption
from vbbench_generators.eligibility import Rules, Span, find_spans, observed_crowd
from vbbench_generators.heading import causal_headings
from vbbench_generators.viewing import view

HEIGHT_STREAM = 1
"""Spawn key of the generator of heights, apart from the one of every sequence."""


def draw_heights(scene: Scene, number: int, info: DatasetInfo) -> Scene:
    """The scene with heights N(μ_h, σ_h²) in m, by person, from the seed."""
    rng = np.random.default_rng(np.random.SeedSequence([info.known_seed, number], spawn_key=(HEIGHT_STREAM,)))
    return scene.with_heights(info.height_mean + info.height_std * rng.standard_normal(len(scene.people)))


@dataclass(frozen=True)
class Reprojection:
    """The plan of a dataset made by reprojection; see `vbbench.generation.generator.Plan`."""

    info: DatasetInfo
    scenes: tuple[Scene, ...]
    rules: Rules
    look: Look
    corruption: Corruption
    limit: int | None = None

    def __len__(self) -> int:
        return len(self.spans)

    @cached_property
    def spans(self) -> list[Span]:
        """Every sequence's frames, by scene and person id."""
        spans = [span for n, scene in enumerate(self.scenes) for span in find_spans(scene, n, self.rules)]
        return spans[: self.limit]

    @cached_property
    def expected_rows(self) -> IntArray:
        """[N] people present in each sequence, summed over frames: its observations, where nobody is hidden."""
        people = [crowd.sum(axis=1) for crowd in self._crowds]
        return np.array([_frames_of(people[span.scene], span)[span.counted].sum() for span in self.spans])

    def build(self, index: int) -> SequenceData:
        """One sequence; its random numbers follow from the seed and its index alone."""
        span = self.spans[index]
        rng = np.random.default_rng(np.random.SeedSequence([self.info.known_seed, index]))
        return view(
            self.scenes[span.scene],
            span,
            _frames_of(self._crowds[span.scene], span),
            _frames_of(self._headings[span.scene], span)[:, span.column],
            info=self.info,
            look=self.look,
            corruption=self.corruption,
            index=index,
            rng=rng,
        )

    @cached_property
    def _crowds(self) -> list[BoolArray]:
        return [observed_crowd(scene, self.rules) for scene in self.scenes]

    @cached_property
    def _headings(self) -> list[FloatArray]:
        return [causal_headings(scene.positions, scene.dt) for scene in self.scenes]


def _frames_of(values: NDArray[Any], span: Span) -> NDArray[Any]:
    """Those rows of ``values`` [T, …], one a frame of the scene, that are the span's."""
    return values[span.first : span.first + len(span.counted)]
