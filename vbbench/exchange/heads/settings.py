"""Options of a recording of heads; apart, so that the command line shows them without importing NumPy."""

from dataclasses import dataclass
from typing import Annotated

from vbbench.parsing.numbers import Within


@dataclass(frozen=True, kw_only=True)
class HeadOptions:
    """A surveillance camera, and how carefully its pictures are annotated."""

    camera_height: Annotated[float, Within(0.0, 1000.0, "m")] = 13.0
    """Height of the camera over the ground in m."""
    tilt: float = 30.0
    """Degrees that it looks down, from the horizon."""
    roll: float = 0.0
    """Degrees that it is turned about its axis; the right of the picture goes up."""
    fov: float = 60.0
    """Horizontal field of view in degrees."""
    size: str = "1920x1080"
    """Width and height of the picture in px."""
    at: tuple[Annotated[float, Within(-1e6, 1e6, "m")], Annotated[float, Within(-1e6, 1e6, "m")]] | None = None
    """x and y in m of the ground below the camera; default: the crowd is in the middle of what it sees."""
    facing: Annotated[float, Within(-360.0, 360.0, "degrees")] = 90.0
    """Direction of view in degrees, counter-clockwise from the world's x axis."""
    box_noise: float = 0.12
    """Relative root mean square error of the widths and heights of boxes."""
    key_every: int = 5
    """Frames from one box drawn by hand to the next; those between are interpolated."""
    round_heads: bool = False
    """Heads are spheres, which a lens stretches off its axis, instead of discs that face the camera."""
