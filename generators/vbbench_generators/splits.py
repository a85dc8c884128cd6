"""The objects that the entry points ``vbbench.generators`` name, one a split."""

from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from vbbench.generation.generator import Card, Options
from vbbench_generators.crowds.sim import DemoSplit, SimSplit, StreetSplit
from vbbench_generators.recordings.loading import load_scenes, scale_to_field
from vbbench_generators.recordings.recipe import Recipe, get_recipe, read_recipe
from vbbench_generators.views import Reprojection, plan_reprojection

FIXED = {
    "box": "mean",
    "level": False,
    "closing": "motion",
    "vertical_vanishing_point": None,
    "walking_speed": 1.3,
    "apply_walking_speed": False,
}
"""Settings of lifting that recipes could choose before; ids of datasets include them."""


@dataclass(frozen=True)
class RecipeSplit:
    """A split defined by a recipe, whose file is read when first needed.

    Parameters
    ----------
    name : name of the split.
    file : the recipe; ``None`` for the one of this name that comes with vbbench.
    half_width : half the side in m of the square to which recordings are scaled; ``None``: no scaling.
    """

    name: str
    file: Path | None = None
    half_width: float | None = None

    @cached_property
    def recipe(self) -> Recipe:
        """The recipe."""
        return get_recipe(self.name) if self.file is None else read_recipe(self.file)

    @property
    def card(self) -> Card:
        """The card of the recipe's source."""
        return self._card(self.recipe.caution.text if self.recipe.caution else None)

    def scaled(self, half_width: float) -> "RecipeSplit":
        """The same split with its recordings scaled to ±``half_width`` m."""
        return replace(self, half_width=half_width)

    def plan(self, options: Options) -> Reprojection:
        """Read the source files and lay out the sequences."""
        recipe = self.recipe
        loaded = load_scenes(recipe, options)
        definition: dict[str, Any] = {
            "format": recipe.format,
            "dt": recipe.dt,
            "frame_step": recipe.frame_step,
            "resampling": recipe.resampling and asdict(recipe.resampling),
            "grid": recipe.grid,
            "files": [list(file) for file in loaded.files],
        }
        if recipe.lifting is not None:
            definition |= {"recording": recipe.recording, "lifting": {**asdict(recipe.lifting), **FIXED}}
        scenes, rules = loaded.scenes, recipe.sequences
        if self.half_width is not None:
            scenes, rules = scale_to_field(scenes, rules, self.half_width)
            definition |= {"half_width": self.half_width}
        return plan_reprojection(
            self._card(None if loaded.is_surveyed else recipe.caution_for(options.tier)),
            rules,
            scenes,
            options,
            definition,
            precision=recipe.precision,
            calibration=loaded.calibration,
        )

    def _card(self, caution: str | None) -> Card:
        recipe = self.recipe
        return Card(
            name=recipe.name,
            title=recipe.title,
            licence=recipe.licence,
            citation=recipe.citation,
            sources=recipe.sources,
            caution=caution,
            own_files=not recipe.sources,
        )


hotel = RecipeSplit("hotel")
eth = RecipeSplit("eth")
eth_15fps = RecipeSplit("eth-15fps")
students = RecipeSplit("students")
students_resampled = RecipeSplit("students-resampled")
zara01 = RecipeSplit("zara01")
zara02 = RecipeSplit("zara02")
shibuya01 = RecipeSplit("shibuya01")
shibuya02 = RecipeSplit("shibuya02")
custom = RecipeSplit("custom")
demo = DemoSplit()
sim = SimSplit()
street = StreetSplit()
