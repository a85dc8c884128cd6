"""Options of a recording of heads; apart, so that the command line shows them without importing NumPy."""

from dataclasses import dataclass
from typing import Annotated

from vbbench.parsing.numbers import Within


@dataclass(frozen=True, kw_only=True)
class HeadOptions:
    """A surveillance camera, and how carefully its pictures are annotated.

    Args:
        camera_height: Height of the camera over the ground in m.
        tilt: Degrees that it looks down, from the horizon.
        roll: Degrees that it is turned about its axis; the right of the picture goes up.
        fov: Horizontal field of view in degrees.
        size: Width and height of the picture in px.
        at: x and y in m of the ground below the camera; default: the crowd is in the middle of what it sees.
        facing: Direction of view in degrees, counter-clockwise from the world's x axis.
        box_noise: Relative root mean square error of the widths and heights of boxes.
        key_every: Frames from one box drawn by hand to the next; those between are interpolated.
        round_heads: Heads are spheres, which a lens stretches off its axis, instead of discs that face the camera.
    """

    camera_height: Annotated[float, Within(0.0, 1000.0, "m")] = 13.0
    tilt: float = 30.0
    roll: float = 0.0
    fov: float = 60.0
    size: str = "1920x1080"
    at: tuple[Annotated[float, Within(-1e6, 1e6, "m")], Annotated[float, Within(-1e6, 1e6, "m")]] | None = None
    facing: Annotated[float, Within(-360.0, 360.0, "degrees")] = 90.0
    box_noise: float = 0.12
    key_every: int = 5
    round_heads: bool = False
