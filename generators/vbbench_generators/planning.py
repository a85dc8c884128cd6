"""From scenes and the user's options to the plan of a reprojected dataset."""

from dataclasses import asdict, replace
from typing import Any

from vbbench.camera import PanoramaCamera
from vbbench.errors import VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Card, Options
from vbbench.scene import Scene
from vbbench_generators.corruption import corruption_of
from vbbench_generators.eligibility import Rules
from vbbench_generators.option_checks import check_options
from vbbench_generators.precision import Precision
from vbbench_generators.reprojection import Reprojection, draw_heights

HEIGHT_MEAN = 1.70
"""μ_h in m, as in the paper."""
REVISION = 1
"""Raised whenever the same options give other observations, so that dataset ids differ too."""


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
    check_options(card.name, options)
    if options.simulation is not None:
        raise VbbenchError(
            "--scenario, --sequences, --people and --engine are for the splits sim and street; "
            f"{card.name} has its own people"
        )
    corruption = replace(corruption_of(options.tier), precision=precision)
    camera = options.camera or PanoramaCamera()
    info = DatasetInfo(
        split=card.name,
        title=card.title,
        camera=camera,
        tier=options.tier,
        seed=options.seed,
        dt=scenes[0].dt,
        height_mean=HEIGHT_MEAN,
        height_std=options.height_std,
        pixel_std=corruption.told_std(camera),
        scenes=tuple(scene.name for scene in scenes),
        definition={
            "generator": f"reprojection/{REVISION}",
            "look": options.look,
            "limit": options.limit,
            "count_observer": rules.count_observer,
            "rules": asdict(rules),
            **corruption.definition,
            **definition,
        },
        caution=card.caution,
        calibration=calibration,
    )
    people = tuple(draw_heights(scene, number, info) for number, scene in enumerate(scenes))
    return Reprojection(
        info=info, scenes=people, rules=rules, look=options.look, corruption=corruption, limit=options.limit
    )
