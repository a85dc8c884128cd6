"""A split's recipe: a TOML file in ``recipes/`` as frozen dataclasses."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import UnknownNameError, suggestion
from vbbench.generation.sources import Source
from vbbench.geometry import BoolArray
from vbbench.parsing.numbers import FRAME_TIME, Checked, Within, check_ranges
from vbbench.parsing.toml_text import bundled_names, read_bundled, read_toml
from vbbench.registry import registered
from vbbench.scene import Scene
from vbbench_generators.lifting.heads import LiftingSettings
from vbbench_generators.tiers.noise import Precision


@dataclass(frozen=True, kw_only=True)
class Rules(Checked):
    """The rules of a recipe's sequences (table ``[sequences]``).

    Parameters
    ----------
    skip_first_frames : frames skipped at the start of each observer's track.
    min_others : a frame counts if at least so many other walkers are present.
    min_frames : an observer needs at least so many such frames.
    standing_displacement : people who move less than this in m from first to last frame are not observed.
    count_observer : whether the people of Table 1 include the observer.
    """

    skip_first_frames: Annotated[int, Within(0, 10**6)] = 0
    min_others: Annotated[int, Within(0, 10**6)] = 1
    min_frames: Annotated[int, Within(1, 10**6)] = 2
    standing_displacement: Annotated[float, Within(0.0, 1e5, "m")] = 0.0
    count_observer: bool = False


@dataclass(frozen=True, kw_only=True)
class Span:
    """An observer's frames: scene frames first … first + len(counted) − 1.

    ``column`` is the observer's among the people of the scene, −1 for a vehicle. ``counted`` [T] marks frames in which
    enough others are present; in the rest nobody is observed.
    """

    scene: int
    column: int
    first: int
    counted: BoolArray

    def of(self, values: NDArray[Any]) -> NDArray[Any]:
        """The rows of the span's frames, of ``values`` [T, …] of all frames of the scene."""
        return values[self.first : self.first + len(self.counted)]

    def others(self, crowd: BoolArray) -> BoolArray:
        """[T, K] mask of the ``crowd`` [T, K] in these frames without the observer, in counted frames."""
        others = crowd & self.counted[:, None]
        if self.column >= 0:
            others[:, self.column] = False
        return others


def observed_crowd(scene: Scene, rules: Rules) -> BoolArray:
    """[T, K] mask of people who are observed: all who are present, except those who stand the whole time."""
    present = scene.present
    first = present.argmax(axis=0)
    last = scene.frames - 1 - present[::-1].argmax(axis=0)
    column = np.arange(len(scene.people))
    way = scene.positions[last, column] - scene.positions[first, column]
    walks: BoolArray = np.hypot(way[:, 0], way[:, 1]) >= rules.standing_displacement
    return present & walks


def find_spans(scene: Scene, number: int, rules: Rules) -> list[Span]:
    """One span for each person that may be an observer, in order of person id."""
    present, crowd = scene.present, observed_crowd(scene, rules)
    others = crowd.sum(axis=1)
    spans = []
    for column in range(len(scene.people)):
        frames = np.flatnonzero(present[:, column])[rules.skip_first_frames :]
        enough = frames[others[frames] - crowd[frames, column] >= rules.min_others]
        if len(frames) > 1 and len(enough) >= rules.min_frames:
            counted = np.zeros(enough[-1] - enough[0] + 1, bool)
            counted[enough - enough[0]] = True
            spans.append(Span(scene=number, column=column, first=int(enough[0]), counted=counted))
    return spans


PACKAGE = "vbbench_generators"
DETECTED = "auto"
"""The format of a recipe whose file is the user's own: its first line decides."""


@dataclass(frozen=True, kw_only=True)
class Caution:
    """A caution that accompanies every figure of the split under some tiers."""

    text: str
    tiers: tuple[str, ...]

    def __post_init__(self) -> None:
        for tier in self.tiers:
            if tier not in registered("tier"):
                raise ValueError(f"[caution]: tiers has '{tier}'; {suggestion(tier, registered('tier'))}")


@dataclass(frozen=True, kw_only=True)
class Resampling(Checked):
    """Smooth interpolation between the key points of a ``.vsp``, plus jitter.

    Parameters
    ----------
    jitter : standard deviation in m of Gaussian noise on every coordinate.
    """

    jitter: Annotated[float, Within(0.0, 10.0, "m")]


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """The definition of a split by its source files.

    Parameters
    ----------
    name, title, licence, citation : facts of the recording.
    format : the name of a registered reader, or `DETECTED`.
    source : the trajectory files, one a scene.
    sequences : rules by which frames become sequences.
    dt : seconds per frame; ``None``: the user gives it.
    frame_step : difference of frame numbers from one frame to the next; ``None``: the commonest one.
    homography : file of the 3x3 homography from the sources' pixels to metres; ``None`` if they are metres.
    resampling : for ``.vsp`` only; ``None`` joins key points by straight lines.
    grid : unit in m to which places in the source are rounded; ``None``: they are not.
    caution : a caution that accompanies every figure of this split.
    recording : for ``crohd`` only: the recording's folder in the archive.
    lifting : for ``crohd`` only: settings of the lifting to the ground.
    precision : rounding of boxes, so that a large split compresses; ``None``: no rounding.
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
        """Whether the user provides the trajectories."""
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

    Raises UnknownNameError if there is none; the nearest name is suggested.
    """
    if name not in recipe_names():
        raise UnknownNameError("recipe", name, recipe_names())
    return read_bundled(PACKAGE, f"recipes/{name}.toml", Recipe, "recipe")


def read_recipe(path: Path) -> Recipe:
    """Read a recipe file; see `read_toml`."""
    return read_toml(path, Recipe, "recipe")
