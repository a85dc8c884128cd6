"""The figures that the paper prints, from ``paper.toml``: quoted, never measured here."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from vbbench.parsing.toml_text import read_bundled

SPLITS = {2: ("hotel", "eth", "students"), 3: ("shibuya01", "shibuya02")}
"""The recordings of Tables 2 and 3."""
COLUMNS = ("dx_rel", "dx", "dr", "dt")
"""The metrics of Tables 2 to 4, in their order."""
HEADLINE = "dx"
"""The metric that every row has."""
SIGMA_H = 0.07
"""σ_h in m of the rows that are quoted."""
BEST = "VB-SF"
"""The paper's best solver."""
PROTOCOLS = ("one-step", "sequential")
"""Those that its figures may be of: the one that they fit, and the one of its text."""


@dataclass(frozen=True, kw_only=True)
class Quoted:
    """One row of the paper's Tables 2 to 4. Which protocol they are of is open: ``vbbench reproduce readings``.

    Parameters
    ----------
    split, tier : the centre lines of Table 4 are tier `ideal`, its tracker's boxes `tracked`.
    solver : the paper's name for it.
    figures : metric → mean in m or rad; some rows have Δx alone.
    """

    table: int
    split: str
    tier: str = "ideal"
    solver: str
    figures: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class Counts:
    """A split's row of Table 1: sequences, mean frames, and people in a frame, as printed."""

    sequences: int
    frames: str
    people: str

    @property
    def bounds(self) -> tuple[float, float, float]:
        """Least, mean and most people; NaN for a mean that is not printed."""
        numbers = [float(number) for number in re.findall(r"[0-9.]+", self.people)]
        return numbers[0], numbers[1] if len(numbers) == 3 else math.nan, numbers[-1]


@dataclass(frozen=True, kw_only=True)
class Photorealistic:
    """The crowd that the paper renders with a game engine.

    Parameters
    ----------
    people, frames : how many.
    field : width and length in m.
    view : of the observer's camera, in degrees.
    """

    people: int
    frames: int
    field: tuple[float, float]
    view: float


@dataclass(frozen=True, kw_only=True)
class Keypoints:
    """What the paper says of its figure of relative poses from static points.

    Parameters
    ----------
    points, trials : points a trial, and trials at each distance.
    voxel : lengths in m of the sides of the box that the points are drawn in.
    distances : nearest and farthest, in m.
    rotation, translation : bounds of the motion between the two cameras, in rad and m.
    noise : bound of the uniform noise on projections, in px.
    good_to : distance in m up to which the result is good.
    poor_from, poor_error : from this distance on (m), the mean error of translation is at least that (m).
    """

    points: int
    trials: int
    voxel: tuple[float, float, float]
    distances: tuple[float, float]
    rotation: float
    translation: float
    noise: float
    good_to: float
    poor_from: float
    poor_error: float


@dataclass(frozen=True, kw_only=True)
class Paper:
    """All quoted figures, and their source."""

    source: str
    link: str
    table1: Mapping[str, Counts]
    photorealistic: Photorealistic
    keypoints: Keypoints
    rows: tuple[Quoted, ...]

    def select(self, split: str, tier: str = "ideal") -> tuple[Quoted, ...]:
        """The rows on a split in a tier."""
        return tuple(row for row in self.rows if (row.split, row.tier) == (split, tier))

    def figures(self, split: str, solver: str) -> Mapping[str, float]:
        """The row of a solver on a split in tier `ideal`: metric → mean in m or rad; none if it is not printed."""
        return next((row.figures for row in self.select(split) if row.solver == solver), {})


@cache
def the_paper() -> Paper:
    """Read ``paper.toml``."""
    return read_bundled("vbbench", "paper.toml", Paper, "top level")
