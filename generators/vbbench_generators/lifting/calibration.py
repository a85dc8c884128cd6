"""What is known of the camera after lifting, and how well."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

Method = Literal["motion", "prior", "vanishing-point", "homography"]


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A figure and the ends of its 95 % interval; all three agree where the figure was given."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """A camera that stands still above a crowd, found from the heads in its picture.

    Parameters
    ----------
    method : what closed the focal length, or ``homography``: the user gave all of it.
    pseudo_metric : whether scale and stretch rest on the sizes of heads and on how people walk.
    focal : focal length in px.
    tilt, roll : in rad; down from level, and by which the picture has to be turned clockwise to be level.
    camera_height : above the ground, in m.
    horizon : row in px, from the picture's top, where the horizon crosses the middle column.
    stretch : g = f / cos θ in px: depths are proportional to it.
    head_size, head_height : what was taken for a head, in m; the size after any correction by the walking speed.
    head_scatter : robust standard deviation of head sizes about their plane, relative to the size; ``None`` if unasked.
    roundness : how much of a ball's lengthening off the axis was taken off the sizes, 0 to 1.
    size_plane : (a, b, c) of head sizes, in px, px a row and px a column; ``None`` if unasked.
    size_plane_covariance : [3, 3] of these three, from resampled tracks; ``None`` if unasked.
    walkers : people whose motion was asked for the stretch.
    walking_speed : median speed of walkers in m/s before any correction by it; ``None`` if nobody walks.
    scale_applied : factor by which all lengths were multiplied to reach the recipe's walking speed; 1 if not asked.
    smoothing_residual_m, smoothing_residual_px : root mean square of what the smoother took off the tracks.
    boxes, tracks : how many were lifted; boxes on the horizon or above it are not, and gaps can divide a track.
    """

    method: Method
    pseudo_metric: bool
    focal: Estimate
    tilt: Estimate
    roll: Estimate
    camera_height: Estimate
    horizon: Estimate
    stretch: Estimate
    head_size: float
    head_height: float
    head_scatter: float | None
    roundness: float
    size_plane: tuple[float, float, float] | None
    size_plane_covariance: tuple[tuple[float, ...], ...] | None
    walkers: int
    walking_speed: float | None
    scale_applied: float
    smoothing_residual_m: float
    smoothing_residual_px: float
    boxes: int
    tracks: int

    def to_dict(self) -> dict[str, Any]:
        """All of it as JSON wants it."""
        return asdict(self)
