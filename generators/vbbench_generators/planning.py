"""From scenes and the user's options to the plan of a reprojected dataset."""

from dataclasses import asdict
from typing import Any

from vbbench.dataset_info import DatasetInfo
from vbbench.errors import VbbenchError
from vbbench.generator import Card, Options
from vbbench.scene import Scene
from vbbench_generators.corruption import PIXEL_STD
from vbbench_generators.eligibility import Rules
from vbbench_generators.reprojection import Reprojection, draw_heights

HEIGHT_MEAN = 1.70
"""μ_h in m, as in the paper."""
REVISION = 1
"""Raised whenever the same options give other observations, so that dataset ids differ too."""


def plan_reprojection(
    card: Card, rules: Rules, scenes: list[Scene], options: Options, definition: dict[str, Any]
) -> Reprojection:
    """Lay out every sequence of ``scenes``.

    Raises
    ------
    VbbenchError
        If an option cannot be.
    """
    _check(card.name, options)
    info = DatasetInfo(
        split=card.name,
        title=card.title,
        camera=options.camera,
        tier=options.tier,
        seed=options.seed,
        dt=scenes[0].dt,
        height_mean=HEIGHT_MEAN,
        height_std=options.height_std,
        pixel_std=PIXEL_STD[options.tier],
        scenes=tuple(scene.name for scene in scenes),
        definition={
            "generator": f"reprojection/{REVISION}",
            "look": options.look,
            "limit": options.limit,
            "count_observer": rules.count_observer,
            "rules": asdict(rules),
            **definition,
        },
        caution=card.caution,
    )
    people = tuple(draw_heights(scene, number, info) for number, scene in enumerate(scenes))
    return Reprojection(info=info, scenes=people, rules=rules, look=options.look, limit=options.limit)


def _check(split: str, options: Options) -> None:
    if options.tier not in PIXEL_STD:
        raise VbbenchError(f"split '{split}' offers the tiers {', '.join(PIXEL_STD)}, not '{options.tier}'")
    if not 0.0 <= options.height_std <= 0.3:
        raise VbbenchError(f"--sigma-h is the spread of people's heights in m, 0 to 0.3, not {options.height_std}")
    if options.limit is not None and options.limit < 1:
        raise VbbenchError(f"--limit must be at least 1, not {options.limit}")
    if options.seed < 0:
        raise VbbenchError(f"--seed must be 0 or more, not {options.seed}")
