"""A row's figures one after the other: a line the height of a word, with a dot for each and a bar for its interval."""

from collections.abc import Sequence

from vbbench_leaderboards.charts.svg import Axis, Series, figure, line, number

_WIDTH, _HEIGHT = 150, 44
_EDGE = 7
_LEAST = 1e-6
"""The least that the height stands for: figures that are all the same have one, too."""


def trend(name: str, series: Series, says: str, points: Sequence[tuple[float, float | None, float | None]]) -> str:
    """The chart of figures with the ends of their intervals, the oldest left; ``name`` is unique on the page.

    Its height is that of the intervals: what can be seen is more than they explain.
    """
    values = [value for point in points for value in point if value is not None]
    y = Axis(low=min(values), high=max(*values, min(values) + _LEAST), start=_HEIGHT - _EDGE, end=_EDGE, log=False)
    step = (_WIDTH - 2 * _EDGE) / max(len(points) - 1, 1)
    across = [_EDGE + n * step for n in range(len(points))]
    bars = [
        line(x, y.place(low), x, y.place(high), "bar")
        for x, (_, low, high) in zip(across, points, strict=True)
        if low is not None and high is not None
    ]
    places = [f"{number(x)} {number(y.place(point[0]))}" for x, point in zip(across, points, strict=True)]
    dots = [
        f'<circle cx="{place.split()[0]}" cy="{place.split()[1]}" r="{4 if n + 1 == len(places) else 3}"/>'
        for n, place in enumerate(places)
    ]
    path = f'<path class="course" d="M{"L".join(places)}"/>'
    body = f'<g class="mark c{series.colour}">{"".join(bars)}{path}{"".join(dots)}</g>'
    return figure(name, f"{series.solver} over time", says, (_WIDTH, _HEIGHT), [body])
