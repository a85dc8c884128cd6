"""How a solver's error is spread over the sequences: a dot for each hundredth of them."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_leaderboards.charts.svg import Axis, Series, axis_over, clip, figure, label, line, mark, short

_WIDTH, _ROW = 460, 62
_LEFT, _RIGHT, _TOP, _BOTTOM = 92, 12, 26, 34
_DOTS = 100
_PITCH = 4.4
"""Distance of neighbouring dots."""
_NAME = 10


@dataclass(frozen=True, kw_only=True)
class Spread:
    """A solver's figures of all its sequences [N]."""

    series: Series
    values: FloatArray


def distribution(name: str, metric: str, unit: str, spreads: Sequence[Spread]) -> str:
    """The chart of one metric; ``name`` is unique on the page."""
    shown = [spread for spread in spreads if len(spread.values)]
    dots = [_hundredths(spread.values) for spread in shown]
    ends = [float(value) for values in dots for value in np.quantile(values, [0.01, 0.99])] or [1.0]
    height = _TOP + _ROW * len(shown) + _BOTTOM
    x = axis_over(ends, _LEFT, _WIDTH - _RIGHT)
    title = f"{metric} of every sequence"
    description = "Each dot is one percent of the sequences, the line their median; further left is more accurate."
    rows = (_row(x, n, metric, unit, spread, own) for n, (spread, own) in enumerate(zip(shown, dots, strict=True)))
    return figure(name, title, description, (_WIDTH, height), [*_grid(x, height, metric, unit), *rows])


def _hundredths(values: FloatArray) -> FloatArray:
    """The middle of every hundredth of the values, in order."""
    return np.quantile(values, (np.arange(_DOTS) + 0.5) / _DOTS)


def _grid(x: Axis, height: int, metric: str, unit: str) -> Iterator[str]:
    scale = " (log scale)" if x.log else ""
    yield label(_WIDTH - _RIGHT, 14, f"{metric} of a sequence, {unit}{scale}", "axis-name", "end")
    for value in x.ticks():
        yield line(x.place(value), _TOP, x.place(value), height - _BOTTOM + 4, "grid")
        yield label(x.place(value), height - _BOTTOM + 19, short(value), "tick", "middle")


def _row(x: Axis, n: int, metric: str, unit: str, spread: Spread, dots: FloatArray) -> str:
    floor = _TOP + _ROW * (n + 1) - 7
    low, median, high = np.quantile(spread.values, [0.05, 0.5, 0.95])
    says = (
        f"{spread.series.solver}: {metric} median {median:.4f} {unit}, 5 % of sequences below {low:.4f}, "
        f"5 % above {high:.4f}; {len(spread.values)} sequences"
    )
    drawn = [
        label(0, floor - 8, clip(spread.series.solver, _NAME), "name"),
        line(_LEFT, floor + 4, _WIDTH - _RIGHT, floor + 4, "grid"),
        f'<path class="dots" d="{_piled(x, dots, floor)}"/>',
        line(x.place(float(median)), floor + 4, x.place(float(median)), floor - _ROW + 16, "median"),
    ]
    return mark(spread.series, says, drawn)


def _piled(x: Axis, dots: FloatArray, floor: float) -> str:
    """Path of the dots, piled up where they share a column."""
    columns = [round((x.place(float(value)) - _LEFT) / _PITCH) for value in dots]
    highest = max(Counter(columns).values())
    pitch = min(_PITCH, (_ROW - 16) / highest)
    pile: Counter[int] = Counter()
    places = []
    for column in columns:
        places.append(f"M{_LEFT + column * _PITCH:.0f} {floor - pile[column] * pitch:.1f}h0")
        pile[column] += 1
    return "".join(places)
