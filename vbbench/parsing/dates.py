"""Days as files and command lines write them."""

from contextlib import suppress
from datetime import date


def is_day(text: str) -> bool:
    """Whether a text is a day as YYYY-MM-DD, and in no other form."""
    with suppress(ValueError):
        return date.fromisoformat(text).isoformat() == text
    return False
