"""Turns scenes into what each of their people sees: positions reprojected into a camera carried along."""

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import PanoramaCamera
from vbbench.errors import VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Card, Look, Options, refuse_footage
from vbbench.generation.tier import Tier, get_tier
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.scene import Scene
from vbbench.sequence import SequenceData
from vbbench_generators.recordings.eligibility import Rules, Span, find_spans, observed_crowd
from vbbench_generators.tiers.noise import Precision
from vbbench_generators.views.heading import causal_headings
from vbbench_generators.views.viewing import view

HEIGHT_MEAN = 1.70
"""μ_h in m, as in the paper."""
REVISION = 2
"""Raised whenever the same options give other observations, so that dataset ids differ too."""
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
    tier: Tier
    precision: Precision | None = None
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


def _frames_of(values: NDArray[Any], span: Span) -> NDArray[Any]:
    """Those rows of ``values`` [T, …], one a frame of the scene, that are the span's."""
    return values[span.first : span.first + len(span.counted)]


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

    ``calibration`` is what `DatasetInfo` says of the camera that recorded the scenes.

    Raises
    ------
    VbbenchError
        If an option cannot be.
    """
    if options.simulation is not None:
        raise VbbenchError(
            "--scenario, --sequences, --people and --engine are for the splits sim and street; "
            f"{card.name} has its own people"
        )
    refuse_footage(options, card.name)
    tier, camera = get_tier(options.tier), options.camera or PanoramaCamera()
    info = DatasetInfo(
        split=card.name,
        title=card.title,
        camera=camera,
        tier=tier.name,
        seed=options.seed,
        dt=scenes[0].dt,
        height_mean=HEIGHT_MEAN,
        height_std=options.height_std,
        pixel_std=tier.pixel_std(camera),
        scenes=tuple(scene.name for scene in scenes),
        definition={
            "generator": f"reprojection/{REVISION}",
            "look": options.look,
            "limit": options.limit,
            "count_observer": rules.count_observer,
            "rules": asdict(rules),
            **tier.definition,
            **({} if precision is None else {"precision": asdict(precision)}),
            **definition,
        },
        caution=card.caution,
        calibration=calibration,
    )
    people = tuple(draw_heights(scene, number, info) for number, scene in enumerate(scenes))
    return Reprojection(
        info=info,
        scenes=people,
        rules=rules,
        look=options.look,
        tier=tier,
        precision=precision,
        limit=options.limit,
    )
