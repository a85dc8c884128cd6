"""The pieces that charts share: the frame with its title, axes, texts, and series that keyboards reach."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_HEAVY_TAILED = 20.0
"""Largest over smallest value from which a logarithmic axis is drawn."""


@dataclass(frozen=True, kw_only=True)
class Series:
    """Whose a mark is: a solver, with the number of its colour."""

    solver: str
    colour: int


def figure(name: str, title: str, description: str, size: tuple[int, int], parts: Iterable[str]) -> str:
    """An SVG with title and description; ``name`` is unique on the page."""
    width, height = size
    return (
        f'<svg class="chart" viewBox="0 0 {width} {height}" role="group" aria-labelledby="{name}-title {name}-desc">'
        f'<title id="{name}-title">{escape(title)}</title><desc id="{name}-desc">{escape(description)}</desc>'
        f"{''.join(parts)}</svg>"
    )


def mark(series: Series, says: str, parts: Iterable[str]) -> str:
    """A series that is reached by keyboard and says its figures."""
    text = escape(says)
    return (
        f'<g class="mark c{series.colour}" data-solver="{escape(series.solver)}" data-tip="{text}" tabindex="0" '
        f'role="img" aria-label="{text}"><title></title>{"".join(parts)}</g>'
    )


def label(x: float, y: float, text: str, kind: str = "", anchor: str = "") -> str:
    """A text; ``anchor`` is middle or end."""
    ends = f' text-anchor="{anchor}"' if anchor else ""
    classes = f' class="{kind}"' if kind else ""
    return f'<text x="{number(x)}" y="{number(y)}"{classes}{ends}>{escape(text)}</text>'


def line(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    """A straight line."""
    return f'<path class="{kind}" d="M{number(x1)} {number(y1)}L{number(x2)} {number(y2)}"/>'


def number(value: float) -> str:
    """A coordinate to a tenth."""
    return f"{value:.1f}".removesuffix(".0")


def clip(text: str, most: int) -> str:
    """A name that is too long, cut with an ellipsis."""
    return text if len(text) <= most else text[: most - 1] + "…"


@dataclass(frozen=True, kw_only=True)
class Axis:
    """From values ``low`` … ``high`` to drawing units ``start`` … ``end``; values beyond the ends lie on them."""

    low: float
    high: float
    start: float
    end: float
    log: bool

    def place(self, value: float) -> float:
        """Where a value lies."""
        share = (self._scaled(value) - self._scaled(self.low)) / (self._scaled(self.high) - self._scaled(self.low))
        return self.start + min(1.0, max(0.0, share)) * (self.end - self.start)

    def ticks(self, most: int = 6) -> list[float]:
        """Round values within the ends: powers of ten, with twos and fives where there is room."""
        if not self.log:
            return _linear_ticks(self.low, self.high, most)
        powers = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
        for factors in ((1, 2, 5), (1, 3), (1,)):
            values = [factor * 10.0**power for power in powers for factor in factors]
            found = [value for value in values if self.low * 0.999 <= value <= self.high * 1.001]
            if len(found) <= most:
                return found
        return found[:: math.ceil(len(found) / most)]

    def _scaled(self, value: float) -> float:
        return math.log10(max(value, self.low)) if self.log else value


def axis_over(values: Sequence[float], start: float, end: float, *, log: bool | None = None) -> Axis:
    """An axis that holds all values, with a little room; logarithmic if asked for or if they are heavy-tailed."""
    positive = [value for value in values if value > 0] or [1.0]
    low, high = min(positive), max(positive)
    if log is None:
        log = high / low > _HEAVY_TAILED
    if log:
        return Axis(low=low / 1.25, high=high * 1.25, start=start, end=end, log=True)
    return Axis(low=0.0, high=high * 1.08, start=start, end=end, log=False)


def short(value: float) -> str:
    """A tick's value without needless digits: 0.05, 2, 3000."""
    return f"{value:.10f}".rstrip("0").rstrip(".") if value < 1e6 else f"{value:g}"


def _linear_ticks(low: float, high: float, most: int) -> list[float]:
    rough = (high - low) / most
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * factor for factor in _STEPS if power * factor >= rough * 0.999)
    return [n * step for n in range(math.ceil(low / step), math.floor(high / step) + 1)]
