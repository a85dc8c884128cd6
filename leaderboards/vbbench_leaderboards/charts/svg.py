"""The pieces that charts share: the frame with its title, texts, and series that keyboards reach."""

from collections.abc import Iterable
from dataclasses import dataclass
from html import escape


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
