"""Text as safe HTML and scripts, and numbers in one format."""

import json
import math
from collections.abc import Iterable
from html import escape
from typing import Any
from urllib.parse import urlsplit

NONE = '<span class="none" aria-label="none">–</span>'


def text(value: object) -> str:
    """A value as HTML text, also safe inside quotes."""
    return escape(str(value), quote=True)


def is_web_address(address: str) -> bool:
    """Whether it is a plain http or https address; nothing else becomes a link."""
    if not address.isprintable() or any(character.isspace() for character in address):
        return False
    try:
        parts = urlsplit(address)
    except ValueError:
        return False
    return parts.scheme in ("http", "https") and bool(parts.hostname)


def link(address: str, words: str) -> str:
    """A link if the address is valid, otherwise only the words."""
    if not is_web_address(address):
        return text(words)
    return f'<a href="{text(address)}" rel="noopener noreferrer nofollow">{text(words)}</a>'


def decimals(values: Iterable[float]) -> int:
    """Decimals of a column of figures: two, or what gives its smallest figure two digits, but no more than four."""
    sizes = [abs(value) for value in values if value and math.isfinite(value)]
    return min(4, max(2, 1 - _power(min(sizes, default=1.0))))


def figure(value: float, most: int) -> str:
    """A figure in two or three significant digits, in a column of ``most`` decimals: 0.043, 0.79, 1.24, 12.4, 5,670."""
    shown = f"{_to_three_digits(value):,.{figure_decimals(value, most)}f}"
    return f"<{10.0**-most:.{most}f}" if value > 0 and not float(shown.replace(",", "")) else shown


def figure_decimals(value: float, most: int) -> int:
    """The decimals that `figure` shows; the ends of an interval have those of its middle."""
    return min(most, max(0, 2 - _power(_to_three_digits(value)))) if value else most


def padded(value: float, most: int) -> str:
    """A figure as HTML that ends where a figure of ``most`` decimals would: the points of a column stand in line."""
    missing = most - figure_decimals(value, most)
    point = "." if missing == most and most else ""
    return figure(value, most) + (f'<span class="pad">{point}{"0" * missing}</span>' if missing else "")


def signed(value: float, most: int) -> str:
    """A difference, with its sign."""
    return ("−" if value < 0 else "+") + figure(abs(value), most)


def _to_three_digits(value: float) -> float:
    return float(f"{value:.3g}")


def _power(value: float) -> int:
    """The power of ten of the first digit of a number, 0 for 0."""
    return math.floor(math.log10(abs(value))) if value else 0


def percent(share: float) -> str:
    """A share in percent, finer near its ends, so that nothing but all is 100 %: 100 %, 99.95 %, 12 %, 2.5 %, 0 %."""
    value = 100 * share
    if value > 99:
        finest = max(1, -_power(100 - value)) if value < 100 else 0
        return f"{value:.{finest}f} %"
    return f"{value:.0f} %" if value >= 10 or value == 0 else f"{value:.1f} %"


def code(lines: list[str], name: str) -> str:
    """Command lines as a block called ``name``, which the keyboard can reach and scroll."""
    body = "\n".join(text(line) for line in lines)
    return f'<pre tabindex="0" role="region" aria-label="{text(name)}"><code>{body}</code></pre>'


def provided(name: str, value: Any) -> str:
    """A data file of the site: one call, safe even inside a page."""
    words = json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    separators = words.replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    return f"vbbench.provide({json.dumps(name)},{separators});\n"
