"""``natural.toml`` as frozen dataclasses: how heads turn under ``look = natural``."""

from dataclasses import dataclass
from functools import cache
from typing import Annotated

from vbbench.parsing.numbers import Share, Within, check_ranges
from vbbench.parsing.toml_text import read_bundled

Seconds = Annotated[float, Within(0.0, 60.0, "s")]
Span = Annotated[float, Within(0.05, 60.0, "s")]
Angle = Annotated[float, Within(0.0, 3.1416, "rad")]
Rate = Annotated[float, Within(0.0, 100.0)]


@dataclass(frozen=True, kw_only=True)
class Walking:
    """What every law takes for the direction of walking.

    Parameters
    ----------
    stride : s over which it is measured, half before and half after.
    standing_speed : m/s below which a person stands.
    turn_rate : rad/s by which a head turns at most.
    offset_std : rad by which a person's head points away from the law all the time.
    unsteady_std, memory : rad by which it strays from that, correlated over so many s.
    """

    stride: Span
    standing_speed: Rate
    turn_rate: Annotated[float, Within(0.1, 100.0)]
    offset_std: Angle
    unsteady_std: Angle
    memory: Span


@dataclass(frozen=True, kw_only=True)
class Follow:
    """The direction of walking a moment later; ``lead`` in s, drawn a person, unsteady with a ``memory`` in s."""

    share: Share
    lead: Seconds
    lead_std: Seconds
    unsteady_std: Seconds
    memory: Span


@dataclass(frozen=True, kw_only=True)
class Ahead:
    """Where the person will be after a time in s, drawn a person between ``nearest`` and ``farthest``."""

    share: Share
    nearest: Span
    farthest: Span


@dataclass(frozen=True, kw_only=True)
class Glance:
    """Along the path, but for glances at neighbours.

    Parameters
    ----------
    time_share : of the time that a person is glanced at, where there is one.
    duration : mean in s of a glance.
    distance, widest : in m, and in rad to either side of the path: who is within both may be glanced at.
    head_share : how much of the way to the other the head turns.
    """

    share: Share
    time_share: Annotated[float, Within(0.001, 0.9)]
    duration: Span
    distance: Annotated[float, Within(0.1, 1000.0)]
    head_share: Share
    widest: Angle


@dataclass(frozen=True, kw_only=True)
class Sway:
    """Along the path, and to and fro at half the ``step_rate`` in 1/s with an ``amplitude`` in rad, drawn a person."""

    share: Share
    step_rate: Rate
    step_rate_std: Rate
    amplitude: Angle
    amplitude_std: Angle


@dataclass(frozen=True, kw_only=True)
class Standing:
    """Who stands looks somewhere for ``held_for`` s on average, ``spread`` rad about the direction of the way there."""

    held_for: Span
    spread: Angle


@dataclass(frozen=True, kw_only=True)
class NaturalLook:
    """The laws of ``look = natural``; a law's ``share`` is that of the sequences in which it holds."""

    walking: Walking
    follow: Follow
    ahead: Ahead
    glance: Glance
    sway: Sway
    standing: Standing

    def __post_init__(self) -> None:
        for table in (self.walking, self.follow, self.ahead, self.glance, self.sway, self.standing):
            check_ranges(table)
        if abs(sum(self.shares) - 1.0) > 1e-9:
            raise ValueError(f"the shares of the laws add up to {sum(self.shares):g}, not 1")

    @property
    def shares(self) -> tuple[float, float, float, float]:
        """Of `vbbench_generators.views.looking.laws.LAWS`, in their order."""
        return self.follow.share, self.ahead.share, self.glance.share, self.sway.share


@cache
def natural_look() -> NaturalLook:
    """The settings that come with this package."""
    return read_bundled("vbbench_generators", "views/looking/natural.toml", NaturalLook, "top level")
