"""Text as safe HTML and scripts, and numbers in one format."""

import json
from html import escape
from typing import Any
from urllib.parse import urlsplit

from vbbench.table import decimals as decimals

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


def percent(share: float) -> str:
    """A share in percent, finer near its ends: 100 %, 99.95 %, 12 %, 2.5 %, 0 %."""
    value = 100 * share
    if value > 99:
        return f"{value:.4g} %"
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
