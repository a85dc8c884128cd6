"""The words and numbers of the pages: terms and their meanings, figures in one format, addresses that are safe."""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal
from urllib.parse import urlsplit

from markupsafe import Markup

from vbbench.generation.footage import FOOTAGE
from vbbench.generation.tier import all_tiers
from vbbench.parsing.toml_text import bundled_table
from vbbench.scoring.metrics import section


@dataclass(frozen=True, kw_only=True)
class Term:
    """A word of the page: its short name, its name in full, its unit, and its meaning."""

    name: str
    full: str
    unit: str = ""
    meaning: str


def error_terms() -> dict[str, Term]:
    """The metrics that boards show first, in the order of the paper's tables."""
    return _metric_terms("metrics")


def drift_terms() -> dict[str, Term]:
    """The metrics of motion over a second."""
    return _metric_terms("drift")


def _metric_terms(part: Literal["metrics", "drift"]) -> dict[str, Term]:
    found = section(part).items()
    return {key: Term(name=one.symbol, full=one.name, unit=one.unit, meaning=one.meaning) for key, one in found}


COLUMNS, SUMMARIES, PROTOCOLS = (
    {key: Term(**facts) for key, facts in terms.items()} for terms in bundled_table(__package__, "words.toml").values()
)
"""The terms of columns, of summaries over sequences, and of protocols, by key."""


@cache
def tiers() -> dict[str, Term]:
    """Every tier that is installed here, in the registry's order, by name, and footage."""
    found = {tier.name: tier.summary for tier in all_tiers()}
    found[FOOTAGE] = "What a camera saw: boxes drawn by hand, or found by a detector."
    return {name: Term(name=name, full=name.capitalize(), meaning=meaning) for name, meaning in found.items()}


def term_of(words: dict[str, Term], key: str) -> Term:
    """The term of a key; a protocol or tier without one goes by its own name."""
    return words.get(key, Term(name=key, full=key, meaning=""))


def is_web_address(address: str) -> bool:
    """Whether it is a plain http or https address; nothing else becomes a link."""
    if not address.isprintable() or any(character.isspace() for character in address):
        return False
    try:
        parts = urlsplit(address)
    except ValueError:
        return False
    return parts.scheme in ("http", "https") and bool(parts.hostname)


def decimals(values: Iterable[float]) -> int:
    """Decimals of a column of figures: two, or what gives its smallest figure two digits, but no more than four."""
    sizes = [abs(value) for value in values if value and math.isfinite(value)]
    return min(4, max(2, 1 - _power(min(sizes, default=1.0))))


def figure(value: float, most: int) -> str:
    """A figure in two or three significant digits, in a column of ``most`` decimals: 0.043, 0.79, 1.24, 12.4, 5,670."""
    digits = figure_decimals(value, most)
    shown = f"{value if digits else _to_three_digits(value):,.{digits}f}"  # rounded once
    return f"<{10.0**-most:.{most}f}" if value > 0 and not float(shown.replace(",", "")) else shown


def figure_decimals(value: float, most: int) -> int:
    """The decimals that `figure` shows; the ends of an interval have those of its middle."""
    return min(most, max(0, 2 - _power(_to_three_digits(value)))) if value else most


def padding(value: float, most: int) -> str:
    """What follows a figure, unseen, so that the points of a column of ``most`` decimals stand in line."""
    missing = most - figure_decimals(value, most)
    return ("." if missing == most and most else "") + "0" * missing


def signed(value: float, most: int) -> str:
    """A difference, with its sign."""
    return ("−" if value < 0 else "+") + figure(abs(value), most)


def percent(share: float) -> str:
    """A share in percent, finer near its ends, so that nothing but all is 100 %: 100 %, 99.95 %, 12 %, 2.5 %, 0 %."""
    value = 100 * share
    if value > 99:
        finest = max(1, -_power(100 - value)) if value < 100 else 0
        return f"{value:.{finest}f} %"
    return f"{value:.0f} %" if value >= 10 or value == 0 else f"{value:.1f} %"


def with_code(text: str) -> Markup:
    """A text whose words between backticks are code."""
    parts = enumerate(text.split("`"))
    return Markup().join(Markup("<code>{}</code>").format(part) if n % 2 else part for n, part in parts)


def provided(name: str, value: Any) -> str:
    """A data file of the site: one call, safe even inside a page."""
    words = json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    separators = words.replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    return f"vbbench.provide({json.dumps(name)},{separators});\n"


def _to_three_digits(value: float) -> float:
    return float(f"{value:.3g}")


def _power(value: float) -> int:
    """The power of ten of the first digit of a number, 0 for 0."""
    return math.floor(math.log10(abs(value))) if value else 0
