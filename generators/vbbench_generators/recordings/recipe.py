"""A split's recipe: a file in ``recipes/`` that a person can read, and the frozen dataclasses made of it."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated

from vbbench.errors import UnknownNameError, suggestion
from vbbench.generation.sources import Source
from vbbench.parsing.numbers import FRAME_TIME, Within, check_ranges
from vbbench.parsing.toml_text import bundled_names, read_bundled, read_toml
from vbbench.registry import registered
from vbbench_generators.lifting.settings import LiftingSettings
from vbbench_generators.recordings.eligibility import Rules
from vbbench_generators.tiers.noise import Precision

PACKAGE = "vbbench_generators"
DETECTED = "auto"
"""The format of a recipe whose file is the user's own: its first line decides."""


@dataclass(frozen=True, kw_only=True)
class Caution:
    """What must stand with every figure of the split, under the tiers concerned."""

    text: str
    tiers: tuple[str, ...]

    def __post_init__(self) -> None:
        for tier in self.tiers:
            if tier not in registered("tier"):
                raise ValueError(f"[caution]: tiers has '{tier}'; {suggestion(tier, registered('tier'))}")


@dataclass(frozen=True, kw_only=True)
class Resampling:
    """Key points of a ``.vsp`` joined by a smooth curve, with jitter on top.

    Parameters
    ----------
    jitter : standard deviation in m of Gaussian noise on every coordinate, from the seed.
    """

    jitter: Annotated[float, Within(0.0, 10.0, "m")]

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """How a split is made from its source files.

    Parameters
    ----------
    name, title, licence, citation : what it is, and whose.
    format : how to read the sources: the name of a registered reader, or `DETECTED`.
    source : the trajectory files, one a scene.
    sequences : which frames of which people become sequences.
    dt : seconds per frame; ``None``: the user says it.
    frame_step : frame numbers of the source a frame; ``None``: the commonest.
    homography : file of the 3x3 homography from the sources' pixels to metres; ``None`` if they are metres.
    resampling : for ``.vsp`` only; ``None`` joins key points by straight lines.
    grid : in m, where places in the source are rounded to multiples of it; ``None``: they are not.
    caution : what everybody who sees a figure of this split has to know.
    recording : for ``crohd`` only: the folder of the archive that holds it.
    lifting : for ``crohd`` only: how heads are put on the ground.
    precision : what boxes are rounded to, so that a large split compresses; ``None`` = not at all.
    """

    name: str
    title: str
    licence: str
    citation: str
    format: str
    source: tuple[Source, ...] = ()
    sequences: Rules
    dt: Annotated[float, FRAME_TIME] | None = None
    frame_step: Annotated[int, Within(1, 10**6)] | None = None
    homography: Source | None = None
    resampling: Resampling | None = None
    grid: Annotated[float, Within(0.0, 1.0, "m")] | None = None
    caution: Caution | None = None
    recording: str | None = None
    lifting: LiftingSettings | None = None
    precision: Precision | None = None

    def __post_init__(self) -> None:
        check_ranges(self)
        formats = [*registered("reader"), DETECTED]
        if self.format not in formats:
            hint = suggestion(self.format, formats)
            raise ValueError(f"recipe: no reader is registered for format = '{self.format}'; {hint}")

    @property
    def sources(self) -> tuple[Source, ...]:
        """Every file the split is made from: one a scene, then the homography if there is one."""
        return self.source if self.homography is None else (*self.source, self.homography)

    @property
    def reads_own_file(self) -> bool:
        """Whether the user brings the trajectories."""
        return not self.source

    def caution_for(self, tier: str) -> str | None:
        """The caution that holds under ``tier``."""
        return self.caution.text if self.caution is not None and tier in self.caution.tiers else None


def recipe_names() -> list[str]:
    """The recipes of this package, in alphabetical order."""
    return bundled_names(PACKAGE, "recipes")


@cache
def get_recipe(name: str) -> Recipe:
    """The recipe of the split ``name``.

    Raises
    ------
    UnknownNameError
        If there is none; the nearest name is suggested.
    """
    if name not in recipe_names():
        raise UnknownNameError("recipe", name, recipe_names())
    return read_bundled(PACKAGE, f"recipes/{name}.toml", Recipe, "recipe")


def read_recipe(path: Path) -> Recipe:
    """Read a recipe file; see `read_toml`."""
    return read_toml(path, Recipe, "recipe")
