"""The charts of the pages, as SVG: error against time, and the spread over sequences."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from vbbench.geometry import FloatArray
from vbbench.pictures.colours import SOLVERS_ON_DARK, SOLVERS_ON_LIGHT, solver_number
from vbbench_leaderboards.site.words import Term

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_TICKS = 6  # at most
_HEAVY_TAILED = 20.0
"""Largest over smallest value from which a logarithmic axis is drawn."""

_WIDTH, _HEIGHT, _BOTTOM = 460, 330, 46
_LEFT, _RIGHT, _TOP = 52, 18, 30
_LINE_HEIGHT, _LETTER, _GAP, _SPACE = 18, 10.0, 11, 4
"""Of a name as a phone shows it: its height, the width of a letter, its distance from its point, and from all else."""
_RADIUS, _DROP = 5.5, 4
"""Of a point, and how far below its middle a name's line is."""

_ROW, _NAMES, _LONGEST = 62, 118, 12
"""Of the spread: the height of a row, the width of the names' column, and the letters that fit into it."""
_DOTS, _PITCH = 100, 4.4


@dataclass(frozen=True, kw_only=True)
class Axis:
    """From values ``low`` … ``high`` to drawing units ``start`` … ``end``; values beyond the ends lie on them."""

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    @staticmethod
    def over(values: Sequence[float], start: float, end: float, *, log: bool | None = None) -> "Axis":
        """An axis that holds all values, with a little room; logarithmic on request or where tails are heavy."""
        positive = [value for value in values if value > 0] or [1.0]
        low, high = min(positive), max(positive)
        if log or (log is None and high / low > _HEAVY_TAILED):
            return Axis(low=low / 1.25, high=high * 1.25, start=start, end=end, log=True)
        return Axis(low=0.0, high=high * 1.08, start=start, end=end)

    def place(self, value: float) -> float:
        """Where a value lies."""
        share = (self._scaled(value) - self._scaled(self.low)) / (self._scaled(self.high) - self._scaled(self.low))
        return self.start + min(1.0, max(0.0, share)) * (self.end - self.start)

    @property
    def ticks(self) -> list[float]:
        """Round values within the ends: powers of ten, with twos and fives where there is room."""
        if not self.log:
            rough = (self.high - self.low) / _TICKS
            power = 10.0 ** math.floor(math.log10(rough))
            step = next(power * factor for factor in _STEPS if power * factor >= rough * 0.999)
            return [n * step for n in range(math.ceil(self.low / step), math.floor(self.high / step) + 1)]
        powers = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
        for factors in ((1, 2, 5), (1, 3), (1,)):
            values = [factor * 10.0**power for power in powers for factor in factors]
            found = [value for value in values if self.low * 0.999 <= value <= self.high * 1.001]
            if len(found) <= _TICKS:
                return found
        return found[:: math.ceil(len(found) / _TICKS)]

    def _scaled(self, value: float) -> float:
        return math.log10(max(value, self.low)) if self.log else value


def scatter(
    name: str, metric: Term, points: Sequence[tuple[str, int, float, tuple[float, float] | None, float]]
) -> Markup:
    """Capped error against time per frame; empty without points.

    Parameters
    ----------
    name : unique on the page.
    points : solver, number of its colour, error, 95 % interval or ``None``, and microseconds per frame.
    """
    if not points:
        return Markup()
    x = Axis.over([micros for *_, micros in points], _LEFT, _WIDTH - _RIGHT - 60, log=True)
    y = Axis.over([v for _, _, error, ends, _ in points for v in (error, *(ends or ()))], _HEIGHT - _BOTTOM, _TOP)
    parts = [_label(0, 14, f"capped mean {metric.name}, {metric.unit}{_scale(y)}", "axis-name")]
    for value in y.ticks:
        parts.append(_line(_LEFT, y.place(value), _WIDTH - _RIGHT, y.place(value), "grid"))
        parts.append(_label(_LEFT - 8, y.place(value) + 4, _short(value), "tick", "end"))
    for value in x.ticks:
        parts.append(_line(x.place(value), _HEIGHT - _BOTTOM, x.place(value), _HEIGHT - _BOTTOM + 4, "grid"))
        parts.append(_label(x.place(value), _HEIGHT - _BOTTOM + 19, _short(value), "tick", "middle"))
    parts.append(_label(_WIDTH - _RIGHT, _HEIGHT - 6, "µs per frame (log scale)", "axis-name", "end"))
    taken = [_around(x.place(micros), y.place(error) + _DROP) for _, _, error, _, micros in points]
    for solver, colour, error, ends, micros in sorted(points, key=lambda point: point[2]):
        across, up = x.place(micros), y.place(error)
        low, high = ends or (error, error)
        start, end, height = _free(across, up + _DROP, len(_clip(solver, 22)) * _LETTER, taken)
        taken.append((start, end, height))
        interval = f"95 % interval {low:.4f} to {high:.4f}" if ends else "too few sequences for an interval"
        words = f"{solver}: {metric.name} {error:.4f} {metric.unit}, {interval}; {micros:.0f} µs per frame"
        at, anchor = (start, "start") if start > across else (end, "end")
        drawn = [
            _line(across, y.place(low), across, y.place(high), "bar"),
            _circle(across, up, _RADIUS),
            _label(at, height, _clip(solver, 22), "name", anchor),
        ]
        parts.append(_mark(solver, colour, words, drawn))
    description = "Lower is more accurate, further left is faster. Bars are 95 % intervals."
    return _frame(name, f"{metric.name} against time per frame", description, (_WIDTH, _HEIGHT), parts)


def _around(across: float, height: float) -> tuple[float, float, float]:
    return across - _RADIUS, across + _RADIUS, height


def _free(
    across: float, height: float, width: float, taken: Sequence[tuple[float, float, float]]
) -> tuple[float, float, float]:
    """Where a name fits: right of its point, left of it, or else to the right and as little higher as may be."""
    right, left = across + _GAP, across - _GAP - width
    for start in (right, left):
        if _LEFT <= start <= _WIDTH - width and _is_free((start, start + width, height), taken):
            return start, start + width, height
    right = min(right, _WIDTH - width)
    while not _is_free((right, right + width, height), taken):
        height -= 1.0
    return right, right + width, height


def _is_free(place: tuple[float, float, float], taken: Sequence[tuple[float, float, float]]) -> bool:
    start, end, height = place
    return not any(
        start < other_end + _SPACE and other < end + _SPACE and abs(height - y) < _LINE_HEIGHT
        for other, other_end, y in taken
    )


def distribution(name: str, metric: Term, spreads: Sequence[tuple[str, int, FloatArray]]) -> Markup:
    """The spread over sequences, a dot for each hundredth of them.

    Parameters
    ----------
    name : unique on the page.
    spreads : solver, number of its colour, and its figures of all sequences [N].
    """
    shown = [(solver, colour, values) for solver, colour, values in spreads if len(values)]
    dots = [np.quantile(values, (np.arange(_DOTS) + 0.5) / _DOTS) for *_, values in shown]
    ends = [float(value) for values in dots for value in np.quantile(values, [0.01, 0.99])] or [1.0]
    height = 26 + _ROW * len(shown) + 34
    x = Axis.over(ends, _NAMES, _WIDTH - 12)
    parts = [_label(_WIDTH - 12, 14, f"{metric.name} of a sequence, {metric.unit}{_scale(x)}", "axis-name", "end")]
    for value in x.ticks:
        parts.append(_line(x.place(value), 26, x.place(value), height - 30, "grid"))
        parts.append(_label(x.place(value), height - 15, _short(value), "tick", "middle"))
    for n, ((solver, colour, values), own) in enumerate(zip(shown, dots, strict=True)):
        floor = 26 + _ROW * (n + 1) - 7
        low, median, high = np.quantile(values, [0.05, 0.5, 0.95])
        words = (
            f"{solver}: {metric.name} median {median:.4f} {metric.unit}, 5 % of sequences below {low:.4f}, "
            f"5 % above {high:.4f}; {len(values)} sequences"
        )
        middle = x.place(float(median))
        drawn = [
            _label(0, floor - 8, _clip(solver, _LONGEST), "name"),
            _line(_NAMES, floor + 4, _WIDTH - 12, floor + 4, "grid"),
            _path("dots", _piled(x, own, floor)),
            _line(middle, floor + 4, middle, floor - _ROW + 16, "median"),
        ]
        parts.append(_mark(solver, colour, words, drawn))
    description = "Each dot is one percent of the sequences, the line their median; further left is more accurate."
    return _frame(name, f"{metric.name} of every sequence", description, (_WIDTH, height), parts)


def _piled(x: Axis, dots: FloatArray, floor: float) -> str:
    """Path of the dots, piled up where they share a column."""
    columns = [round((x.place(float(value)) - _NAMES) / _PITCH) for value in dots]
    pitch = min(_PITCH, (_ROW - 16) / max(Counter(columns).values()))
    pile: Counter[int] = Counter()
    places = []
    for column in columns:
        places.append(f"M{_NAMES + column * _PITCH:.0f} {floor - pile[column] * pitch:.1f}h0")
        pile[column] += 1
    return "".join(places)


def _frame(name: str, title: str, description: str, size: tuple[int, int], parts: Iterable[Markup]) -> Markup:
    """An SVG with title and description; ``name`` is unique on the page."""
    return Markup(
        '<svg class="chart" viewBox="0 0 {width} {height}" role="group" aria-labelledby="{name}-title {name}-desc">'
        '<title id="{name}-title">{title}</title><desc id="{name}-desc">{description}</desc>{parts}</svg>'
    ).format(width=size[0], height=size[1], name=name, title=title, description=description, parts=Markup().join(parts))


def _mark(solver: str, colour: int, words: str, parts: Iterable[Markup]) -> Markup:
    """A solver's series, which the keyboard reaches and whose figures are read out."""
    return Markup(
        '<g class="mark c{colour}" data-solver="{solver}" tabindex="0" role="img" '
        'aria-label="{words}"><title>{words}</title>{parts}</g>'
    ).format(colour=colour, solver=solver, words=words, parts=Markup().join(parts))


def _label(x: float, y: float, text: str, kind: str, anchor: str = "start") -> Markup:
    """A text; ``anchor`` is start, middle or end."""
    return Markup('<text x="{}" y="{}" class="{}" text-anchor="{}">{}</text>').format(
        _number(x), _number(y), kind, anchor, text
    )


def _line(x1: float, y1: float, x2: float, y2: float, kind: str) -> Markup:
    return _path(kind, f"M{_number(x1)} {_number(y1)}L{_number(x2)} {_number(y2)}")


def _path(kind: str, course: str) -> Markup:
    return Markup('<path class="{}" d="{}"/>').format(kind, course)


def _circle(x: float, y: float, radius: float) -> Markup:
    return Markup('<circle cx="{}" cy="{}" r="{}"/>').format(_number(x), _number(y), radius)


def _number(value: float) -> str:
    """A coordinate to a tenth."""
    return f"{value:.1f}".removesuffix(".0")


def _clip(text: str, most: int) -> str:
    """A name that is too long, cut with an ellipsis."""
    return text if len(text) <= most else text[: most - 1] + "…"


def _scale(axis: Axis) -> str:
    return " (log scale)" if axis.log else ""


def _short(value: float) -> str:
    """A tick's value without needless digits: 0.05, 2, 3000."""
    return f"{value:.10f}".rstrip("0").rstrip(".") if value < 1e6 else f"{value:g}"


def colour_number(solver: str) -> int:
    """The number of a solver's colour, from 1 on: of ``--solver-N`` and of the class ``cN``."""
    return solver_number(solver) + 1


def colours_css() -> str:
    """The style sheet of all solvers' colours, on white and on dark paper."""
    pairs = zip(SOLVERS_ON_LIGHT, SOLVERS_ON_DARK, strict=True)
    colours = "".join(f"  --solver-{n}: light-dark({light}, {dark});\n" for n, (light, dark) in enumerate(pairs, 1))
    classes = "".join(f".c{n} {{ --c: var(--solver-{n}); }}\n" for n in range(1, len(SOLVERS_ON_LIGHT) + 1))
    return f"/* Written by site/charts.py. */\n:root {{\n{colours}}}\n{classes}"
