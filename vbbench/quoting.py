"""What a stranger wrote, made fit for one line on a terminal: escaped, and shortened."""

import re

LONGEST_QUOTE = 60
"""Characters of a quoted value that are repeated."""

LONGEST_LINE = 600
"""Characters of a message about a file, without the file's path."""

_CONTROL = (
    r"\x00-\x09\x0b-\x1f\x7f-\x9f"  # C0 and C1 controls but for the line feed
    r"\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # turns of the writing direction
    r"\u2028\u2029\ufeff\ufff9-\ufffb"  # separators of lines and paragraphs, marks that nobody sees
    r"\ud800-\udfff"  # halves of surrogate pairs: bytes that were no UTF-8
)
_IN_LINES = re.compile(f"[{_CONTROL}]")
_IN_LINE = re.compile(f"[\\n{_CONTROL}]")


def is_printable(text: str) -> bool:
    """Whether a text can be shown as it is on one line."""
    return _IN_LINE.search(text) is None


def escaped(text: str, *, lines: bool = False) -> str:
    r"""The text with ``\x1b`` and the like for whatever a terminal would obey, hide or fail to show.

    Parameters
    ----------
    lines : let line feeds stand.
    """
    return (_IN_LINES if lines else _IN_LINE).sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def one_line(text: str, longest: int = LONGEST_LINE) -> str:
    """The text escaped, and where it has more than ``longest`` characters cut, with their number."""
    if len(text) <= longest:
        return escaped(text)
    return f"{escaped(text[:longest])}… ({len(text)} characters)"


def quoted(value: object) -> str:
    """A value as messages repeat it: text between quotation marks, anything else as Python writes it."""
    if isinstance(value, str):
        return f"'{escaped(value)}'" if len(value) <= LONGEST_QUOTE else one_line(f"'{value}", LONGEST_QUOTE)
    return one_line(repr(value), LONGEST_QUOTE)
