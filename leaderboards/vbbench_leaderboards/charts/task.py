"""The drawing at the top of the page: boxes on a panorama, and the map that a solver makes of them."""

import math
from collections.abc import Iterator

from vbbench_leaderboards.charts.svg import figure, line, number

_WIDTH, _HEIGHT = 460, 300
_STRIP, _MAP = 84, 196
"""Bottom of the strip, and the middle of the map."""
_SCALE = 21.0
_PEOPLE = (
    ((1.6, 2.4), (0.5, 0.3)),
    ((-2.2, 3.0), (0.1, -0.6)),
    ((3.9, 1.2), (-0.6, 0.1)),
    ((-4.6, 0.9), (0.5, 0.2)),
    ((5.9, 3.1), (-0.4, -0.4)),
    ((-1.0, -2.6), (0.2, 0.6)),
    ((2.7, -3.1), (-0.5, 0.3)),
    ((-6.4, -2.2), (0.6, 0.1)),
    ((7.4, -1.3), (-0.3, 0.5)),
)
"""Where people stand, and how they walk: right and forward of the camera, in metres and metres per frame."""


def task_drawing() -> str:
    """The drawing as SVG."""
    parts = [
        f'<rect class="strip" x="0.5" y="0.5" width="{_WIDTH - 1}" height="{_STRIP}" rx="6"/>',
        line(0, _STRIP / 2, _WIDTH, _STRIP / 2, "grid"),
        *_boxes(),
        *_map(),
    ]
    description = "Above: boxes of people on a panorama. Below: the same people on the ground plane around the camera."
    return figure("task", "The task", description, (_WIDTH, _HEIGHT), parts)


def _boxes() -> Iterator[str]:
    for n, ((right, forward), _) in enumerate(_PEOPLE):
        tall = 150.0 / math.hypot(right, forward)
        across = (math.atan2(right, forward) / (2 * math.pi) + 0.5) * _WIDTH
        yield (
            f'<rect class="box c{n % 4 + 1}" x="{number(across - tall / 6)}" y="{number(_STRIP / 2 - tall * 0.48)}" '
            f'width="{number(tall / 3)}" height="{number(tall)}" rx="1.5"/>'
        )


def _map() -> Iterator[str]:
    middle = _WIDTH / 2
    for radius in (2, 4, 6):
        yield f'<circle class="ring" cx="{number(middle)}" cy="{_MAP}" r="{number(radius * _SCALE * 0.8)}"/>'
    for n, ((right, forward), (step, ahead)) in enumerate(_PEOPLE):
        x, y = middle + right * _SCALE, _MAP - forward * _SCALE
        yield f'<g class="c{n % 4 + 1}">'
        yield line(middle, _MAP, x, y, "ray")
        yield line(x - step * 2 * _SCALE, y + ahead * 2 * _SCALE, x, y, "trail")
        yield f'<circle class="body" cx="{number(x)}" cy="{number(y)}" r="5"/></g>'
    yield f'<path class="camera" d="M{number(middle)} {_MAP - 9}l7 17l-7 -4l-7 4z"/>'
