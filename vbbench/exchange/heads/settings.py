"""What a user asks of a recording of heads; apart, so that the command line shows it without importing NumPy."""

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
    """Where it looks, in degrees counter-clockwise from the world's x axis."""
    box_noise: float = 0.12
    """Root mean square error of the widths and heights of boxes, as a part of them."""
    key_every: int = 5
    """Boxes are drawn by hand in every so many frames; straight lines join them."""
    round_heads: bool = False
    """Heads are balls, which a lens stretches off its axis, and not discs that face the camera."""
