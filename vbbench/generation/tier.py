"""What becomes of exact boxes before a solver sees them: a tier is one object, registered under ``vbbench.tiers``.

Whoever makes datasets, lists tiers or explains them asks this registry. Whoever reads a dataset does not: all that
reading needs stands in its files, so that a dataset of a tier that is not installed here is read like any other.
"""

from dataclasses import dataclass
from functools import cached_property
from textwrap import fill
from typing import Any, ClassVar

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError, quoted
from vbbench.generation.generator import Look, Observer, Options
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.registry import load_all, load_registered
from vbbench.sequence import Truth

HEIGHT_MEAN, HEIGHT_STD = 1.70, 0.07
"""μ_h in m, as in the paper, and σ_h unless a person asks for another one."""


@dataclass(frozen=True, kw_only=True)
class Heights:
    """People's heights in m: N(``mean``, ``std``²) as they are, N(``told_mean``, ``told_std``²) as solvers get them."""

    mean: float
    std: float
    told_mean: float
    told_std: float


@dataclass(frozen=True, kw_only=True)
class Told:
    """What solvers are given of the errors of boxes and camera; its fields are those of `vbbench.solver.Problem`."""

    pixel_std: float
    box_std: float = 0.0
    tilt_std: float = 0.0
    mount_height_std: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Sight:
    """What is around an observer throughout a sequence, for a tier to make boxes of.

    Parameters
    ----------
    truth : the camera's poses; positions and heights of everybody who is to be seen and, for a tier that `hides`, of
        whoever else is there and may stand in the way.
    people : [K] their ids.
    seen : [T, K] who is to be seen.
    watched : [T] frames in which anything may be seen.
    camera : what it is seen with.
    dt : seconds per frame.
    observer : who carries it.
    """

    truth: Truth
    people: IntArray
    seen: BoolArray
    watched: BoolArray
    camera: Camera
    dt: float
    observer: Observer = "walker"

    @cached_property
    def boxes(self) -> FloatArray:
        """Exact boxes [T, K, 3] in px of whoever is to be seen; NaN elsewhere and outside the picture."""
        truth, who = self.truth, np.flatnonzero(self.seen)
        relative = world_to_relative(truth.positions, truth.poses).reshape(-1, 2).take(who, axis=0)
        boxes = np.full((self.seen.size, 3), np.nan)
        boxes[who] = self.camera.project(relative, truth.heights.take(who % max(len(truth.heights), 1)))
        return boxes.reshape(*self.seen.shape, 3)


@dataclass(frozen=True, kw_only=True)
class Observations:
    """What a tier makes of a sight.

    Parameters
    ----------
    boxes : [T, K, 3] (u, v, l) in px; NaN = not seen.
    visible : [T, K] how much shows of whoever is seen, 0 to 1, or a detector's score; NaN = not seen.
    persons : of a tier that tracks, [T, K] the id of the person behind each box, −1 = nobody; its columns are tracks.
        ``None`` where the columns are the people of the sight, in their order.
    """

    boxes: FloatArray
    visible: FloatArray
    persons: IntArray | None = None


@dataclass(frozen=True, kw_only=True)
class Tier:
    """What is done to exact boxes: a subclass says what it observes, and whatever is not as here.

    Parameters
    ----------
    name : what it is called: in ``--tier``, in ``dataset.json`` and where it is registered.
    summary : what it does to boxes, in one sentence.
    """

    name: str
    summary: str

    hides: ClassVar[bool] = False
    """Whether people may stand in the way of others; a sight then holds everybody who is there."""
    look: ClassVar[Look] = "motion"
    """How the camera turns where the user does not say."""

    @property
    def definition(self) -> dict[str, Any]:
        """What boxes follow from besides the name and `pixel_std`, as JSON: part of a dataset's definition and id."""
        return {}

    def pixel_std(self, camera: Camera) -> float:  # noqa: ARG002
        """What solvers are given: the standard deviation in px of a box's column, top and bottom."""
        return 0.0

    def told(self, camera: Camera) -> Told:
        """All that solvers are given of the errors of boxes and camera."""
        return Told(pixel_std=self.pixel_std(camera))

    @property
    def own_camera(self) -> Camera | None:
        """What people are seen with where the user names no camera; ``None`` leaves it to the split."""
        return None

    @property
    def own_heights(self) -> Heights | None:
        """How tall people are; ``None`` leaves it to split and user."""
        return None

    def annotated(self) -> "Tier":
        """The same with boxes as people draw them, in place of a detector's.

        Raises VbbenchError if the tier has no detector that can be turned off.
        """
        raise VbbenchError(f"tier '{self.name}' has no detector that can be turned off; remove `detector`")

    def noised(self, std: float) -> "Tier":  # noqa: ARG002
        """The same with noise of ``std`` px.

        Raises VbbenchError if the tier has no noise whose size can be chosen.
        """
        raise VbbenchError(f"tier '{self.name}' has no noise whose size can be chosen; remove `noise`")

    def lasting(self, frames: int) -> "Tier":  # noqa: ARG002
        """The same without tracks of fewer than so many frames.

        Raises VbbenchError if the tier has no tracks.
        """
        raise VbbenchError(f"tier '{self.name}' has no tracks that could be too short; remove `least_track`")

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """Make the boxes; ``rng`` holds the sequence's random numbers."""
        raise NotImplementedError


def get_tier(name: str) -> Tier:
    """The tier that is registered as ``name``.

    Raises UnknownNameError if no tier is called so; the nearest name is suggested; VbbenchError if it is broken, not a
    `Tier`, or registered under a name that is not its own.
    """
    found = load_registered("tier", name)
    if not isinstance(found, Tier):
        raise VbbenchError(f"tier '{name}' is {quoted(found)}; register an object of a subclass of Tier")
    if found.name != name:
        raise VbbenchError(f"tier '{name}' calls itself '{found.name}': register it under that name")
    return found


def chosen_tier(options: Options) -> Tier:
    """The tier that is asked for, changed as the options say; raises VbbenchError if there is none such."""
    tier = get_tier(options.tier)
    tier = tier if options.detector else tier.annotated()
    tier = tier if options.noise is None else tier.noised(options.noise)
    return tier if options.least_track is None else tier.lasting(options.least_track)


def chosen_heights(options: Options) -> Heights:
    """How tall people are, and what solvers are given; raises VbbenchError if the tier leaves no choice."""
    own = get_tier(options.tier).own_heights
    if own is None:
        std = HEIGHT_STD if options.height_std is None else options.height_std
        return Heights(mean=HEIGHT_MEAN, std=std, told_mean=HEIGHT_MEAN, told_std=std)
    if options.height_std is not None:
        raise VbbenchError(f"people of tier '{options.tier}' have heights of its recipe; remove `height_std`")
    return own


def all_tiers() -> list[Tier]:
    """Every tier, those of vbbench first; a broken one is skipped with a warning."""
    return [tier for tier in load_all("tier").values() if isinstance(tier, Tier)]


def describe_tiers() -> str:
    """All tiers as text."""
    return "\n".join(fill(f"{tier.name}: {tier.summary}", 110, subsequent_indent="    ") for tier in all_tiers())
