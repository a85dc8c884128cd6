"""Error against time: which solver buys how much accuracy for how long a wait."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from vbbench_leaderboards.charts.svg import Axis, Series, axis_over, clip, figure, label, line, mark, short

_WIDTH, _HEIGHT = 460, 330
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 18, 30, 46
_LINE_HEIGHT = 15
_NAME = 22
_LETTER, _GAP, _SPACE = 7.5, 11, 4
"""About how wide a letter is, how far a name stands from its point, and how far at least from all else."""
_RADIUS, _DROP = 5.5, 4
"""Of a point, and how far below its middle a name's line is."""


Place = tuple[float, float, float]
"""Where something stands: from left to right, and the height of a name there."""


@dataclass(frozen=True, kw_only=True)
class Point:
    """A solver's capped mean error with its interval, ``None`` where it has none, and its microseconds per frame."""

    series: Series
    error: float
    ci95: tuple[float, float] | None
    micros: float


def scatter(name: str, metric: str, unit: str, points: Sequence[Point]) -> str:
    """The chart of one metric; ``name`` is unique on the page."""
    x = axis_over([point.micros for point in points], _LEFT, _WIDTH - _RIGHT - 60, log=True)
    y = axis_over([value for point in points for value in (point.error, *(point.ci95 or ()))], _HEIGHT - _BOTTOM, _TOP)
    title = f"{metric} against time per frame"
    description = "Lower is more accurate, further left is faster. Bars are 95 % intervals."
    parts = [*_grid(x, y, f"capped mean {metric}, {unit}"), *_marks(x, y, metric, unit, points)]
    return figure(name, title, description, (_WIDTH, _HEIGHT), parts)


def _grid(x: Axis, y: Axis, name: str) -> Iterator[str]:
    yield label(0, 14, name + (" (log scale)" if y.log else ""), "axis-name")
    for value in y.ticks():
        yield line(_LEFT, y.place(value), _WIDTH - _RIGHT, y.place(value), "grid")
        yield label(_LEFT - 8, y.place(value) + 4, short(value), "tick", "end")
    for value in x.ticks():
        yield line(x.place(value), _HEIGHT - _BOTTOM, x.place(value), _HEIGHT - _BOTTOM + 4, "grid")
        yield label(x.place(value), _HEIGHT - _BOTTOM + 19, short(value), "tick", "middle")
    yield label(_WIDTH - _RIGHT, _HEIGHT - 6, "µs per frame (log scale)", "axis-name", "end")


def _marks(x: Axis, y: Axis, metric: str, unit: str, points: Sequence[Point]) -> Iterator[str]:
    taken = [_around(x.place(point.micros), y.place(point.error) + _DROP) for point in points]
    for point in sorted(points, key=lambda point: point.error):
        across, up = x.place(point.micros), y.place(point.error)
        low, high = point.ci95 or (point.error, point.error)
        name = clip(point.series.solver, _NAME)
        start, _, height = place = _free(across, up + _DROP, len(name) * _LETTER, taken)
        taken.append(place)
        says = (
            f"{point.series.solver}: {metric} {point.error:.4f} {unit}, "
            f"{f'95 % interval {low:.4f} to {high:.4f}' if point.ci95 else 'too few sequences for an interval'}; "
            f"{point.micros:.0f} µs per frame"
        )
        left = start < across
        drawn = [
            line(across, y.place(low), across, y.place(high), "bar"),
            f'<circle cx="{across:.1f}" cy="{up:.1f}" r="{_RADIUS}"/>',
            label(across + (-_GAP if left else _GAP), height, name, "name", "end" if left else ""),
        ]
        yield mark(point.series, says, drawn)


def _around(across: float, height: float) -> Place:
    return across - _RADIUS, across + _RADIUS, height


def _free(across: float, height: float, width: float, taken: Sequence[Place]) -> Place:
    """Where a name fits: right of its point, left of it, or else to the right and as little higher as may be."""
    right, left = across + _GAP, across - _GAP - width
    for start in (right, left):
        if start >= _LEFT and _is_free((start, start + width, height), taken):
            return start, start + width, height
    while not _is_free((right, right + width, height), taken):
        height -= 1.0
    return right, right + width, height


def _is_free(place: Place, taken: Sequence[Place]) -> bool:
    start, end, height = place
    return not any(
        start < other_end + _SPACE and other < end + _SPACE and abs(height - y) < _LINE_HEIGHT
        for other, other_end, y in taken
    )
