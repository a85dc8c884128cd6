"""Error against time: which solver buys how much accuracy for how long a wait."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from vbbench_leaderboards.charts.axis import Axis, axis_over, short
from vbbench_leaderboards.charts.svg import Series, clip, figure, label, line, mark

_WIDTH, _HEIGHT = 460, 330
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 18, 30, 46
_LINE_HEIGHT = 15
_NAME = 22
_LETTER, _GAP = 7.5, 11
"""About how wide a letter is, and how far a name stands from its point."""


@dataclass(frozen=True, kw_only=True)
class Point:
    """A solver's mean error with its interval, and its microseconds a frame."""

    series: Series
    error: float
    ci95: tuple[float, float]
    micros: float


def scatter(name: str, metric: str, unit: str, points: Sequence[Point]) -> str:
    """The chart of one metric; ``name`` is unique on the page."""
    x = axis_over([point.micros for point in points], _LEFT, _WIDTH - _RIGHT - 60, log=True)
    y = axis_over([value for point in points for value in (point.error, *point.ci95)], _HEIGHT - _BOTTOM, _TOP)
    title = f"{metric} against time a frame"
    description = "Lower is more accurate, further left is faster. Bars are 95 % intervals of the mean."
    parts = [*_grid(x, y, f"mean {metric}, {unit}"), *_marks(x, y, metric, unit, points)]
    return figure(name, title, description, (_WIDTH, _HEIGHT), parts)


def _grid(x: Axis, y: Axis, name: str) -> Iterator[str]:
    yield label(0, 14, name + (" (log scale)" if y.log else ""), "axis-name")
    for value in y.ticks():
        yield line(_LEFT, y.place(value), _WIDTH - _RIGHT, y.place(value), "grid")
        yield label(_LEFT - 8, y.place(value) + 4, short(value), "tick", "end")
    for value in x.ticks():
        yield line(x.place(value), _HEIGHT - _BOTTOM, x.place(value), _HEIGHT - _BOTTOM + 4, "grid")
        yield label(x.place(value), _HEIGHT - _BOTTOM + 19, short(value), "tick", "middle")
    yield label(_WIDTH - _RIGHT, _HEIGHT - 6, "µs a frame (log scale)", "axis-name", "end")


def _marks(x: Axis, y: Axis, metric: str, unit: str, points: Sequence[Point]) -> Iterator[str]:
    taken: list[tuple[float, float, float]] = []
    for point in sorted(points, key=lambda point: point.error):
        across, up = x.place(point.micros), y.place(point.error)
        low, high = point.ci95
        height = _free(across, up + 4, len(clip(point.series.solver, _NAME)) * _LETTER, taken)
        says = (
            f"{point.series.solver}: {metric} {point.error:.4f} {unit}, 95 % interval {low:.4f} to {high:.4f}; "
            f"{point.micros:.0f} µs a frame"
        )
        drawn = [
            line(across, y.place(low), across, y.place(high), "bar"),
            f'<circle cx="{across:.1f}" cy="{up:.1f}" r="5.5"/>',
            label(across + _GAP, height, clip(point.series.solver, _NAME), "name"),
        ]
        yield mark(point.series, says, drawn)


def _free(start: float, height: float, width: float, taken: list[tuple[float, float, float]]) -> float:
    """The nearest height, upwards, at which no other name stands; ``taken`` has starts, ends and heights."""
    end = start + width + 2 * _GAP
    while any(start < other_end and other < end and abs(height - y) < _LINE_HEIGHT for other, other_end, y in taken):
        height -= 1.0
    taken.append((start, end, height))
    return height
