"""What a recipe says about lifting heads to the ground."""

from dataclasses import dataclass
from typing import Annotated, Literal

from vbbench.parsing.numbers import Within, check_ranges

BoxSize = Literal["mean", "width", "height"]
Closing = Literal["motion", "prior"]
Method = Literal["motion", "prior", "vanishing-point", "homography"]
"""What closed the focal length, or ``homography``: the user gave all of the camera."""


@dataclass(frozen=True, kw_only=True)
class LiftingSettings:
    """The table ``[lifting]`` of a recipe.

    Parameters
    ----------
    head_size : what a head's box measures, in m, in the sense of ``box``.
    head_height : height of a head's centre above the ground, in m.
    box : which size of a box counts: ``mean`` is √(width·height), whose noise is the smallest.
    level : whether the camera is known to have no roll.
    closing : what decides the focal length: how evenly people walk in all directions (and the prior), or the prior.
    vertical_vanishing_point : (u, v) in px where plumb lines meet; decides the focal length instead, if given.
    focal_median, focal_spread : log-normal prior of the focal length in picture widths: median, standard deviation.
    direction_spread : standard deviation of log speed that may truly depend on the direction, harmonic by harmonic.
    window : seconds over which a walking speed is measured.
    gap : longest gap in s that is interpolated; a track with a longer one becomes two people.
    walking_speed : median speed of walkers in m/s that the scale is checked against.
    apply_walking_speed : whether the scale is also set by it.
    resamples : how often tracks are resampled for the intervals.
    """

    head_size: Annotated[float, Within(0.01, 10.0, "m")] = 0.24
    head_height: Annotated[float, Within(0.01, 10.0, "m")] = 1.58
    box: BoxSize = "mean"
    level: bool = False
    closing: Closing = "motion"
    vertical_vanishing_point: tuple[Annotated[float, Within(-1e9, 1e9, "px")], ...] | None = None
    focal_median: Annotated[float, Within(0.01, 100.0)] = 1.0
    focal_spread: Annotated[float, Within(0.001, 10.0)] = 0.4
    direction_spread: Annotated[float, Within(1e-6, 1.0)] = 0.02
    window: Annotated[float, Within(0.01, 3600.0, "s")] = 2.0
    gap: Annotated[float, Within(0.0, 3600.0, "s")] = 4.0
    walking_speed: Annotated[float, Within(0.01, 10.0, "m/s")] = 1.3
    apply_walking_speed: bool = False
    resamples: Annotated[int, Within(20, 10_000)] = 60

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.vertical_vanishing_point is not None and len(self.vertical_vanishing_point) != 2:
            raise ValueError("vertical_vanishing_point must be two numbers, u and v in px")
