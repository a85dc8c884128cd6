"""The one grammar of numbers in text that strangers write: CSV, MOTChallenge and TUM files."""

import re

_NUMBER = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?|nan|inf)", re.IGNORECASE | re.ASCII)


def parse_number(text: str) -> float | None:
    """The decimal number in a cell, blanks and tabs around it; ``None`` where there is none.

    ``nan`` and ``inf`` are read, so that a message can say what they are. Python's underscores (``0_2``), its
    ``infinity``, hexadecimals and digits of other scripts are no numbers.
    """
    text = text.strip(" \t")
    return float(text) if _NUMBER.fullmatch(text) else None
