"""Numbers and days from outside: their one grammar in text, and ranges in the annotations of fields.

A frozen dataclass writes ``dt: Annotated[float, Within(0.001, 60.0, "s")]`` and is `Checked`, or calls `check_ranges`.
"""

import math
import re
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from functools import cache
from numbers import Real
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from vbbench.errors import FileError, quoted, suggestion


@dataclass(frozen=True)
class Within:
    """A closed range; NaN is outside of every one.

    Parameters
    ----------
    least, most : its ends.
    unit : of the number.
    what : what it is in words, where the field's name does not say it.
    """

    least: float
    most: float
    unit: str = ""
    what: str = ""

    def __str__(self) -> str:
        return f"{_shown(self.least)} to {_shown(self.most)} {self.unit}".strip()

    def check(self, name: str, value: float) -> None:
        """Raise ValueError, which names ``name``, range and value, if ``value`` lies outside or is not a number."""
        called = f"{name}, {self.what}," if self.what else name
        if isinstance(value, bool) or not isinstance(value, Real):
            raise ValueError(f"{called} must be a number, {self}, not {quoted(value)}")
        if not self.least <= value <= self.most:
            raise ValueError(f"{called} must be {self}, not {_shown(value)}")


FRAME_TIME = Within(0.001, 60.0, "s", "the time of a frame")
"""How long a frame may last."""
SLOW = 2.0
"""Seconds a frame from which a frame rate may have been meant."""
BODY_HEIGHT = Within(0.5, 2.5, "m")
"""How tall people may be on average."""
Share = Annotated[float, Within(0.0, 1.0)]
"""A field from 0 to 1."""


def notes_on_dt(dt: float) -> list[str]:
    """A note if a frame is so long that ``dt`` may be a frame rate."""
    return [f"a frame is said to last {dt:g} s: is it the frame rate? Then write fps = {dt:g}"] if dt >= SLOW else []


def check_ranges(values: object) -> None:
    """Check every number of a dataclass against the `Within` in its annotation, in tuples as well, and every choice.

    Raises ValueError at the first number that lies outside, or word that is not one of a ``Literal``; the nearest is
    suggested.
    """
    kind: Any = type(values)
    for name, hint in _hints(kind).items():
        _check(name, getattr(values, name), hint)


class Checked:
    """Base of a frozen dataclass whose numbers are checked when it is made; see `check_ranges`."""

    def __post_init__(self) -> None:
        check_ranges(self)


@cache
def _hints(kind: type[Any]) -> dict[str, Any]:
    return get_type_hints(kind, include_extras=True)


def _check(name: str, value: Any, hint: Any) -> None:
    """Check ``value`` by whatever ranges its annotation holds."""
    if value is None:
        return
    if get_origin(hint) is Annotated:
        for limit in hint.__metadata__:
            limit.check(name, value)
    elif get_origin(hint) is Literal:
        if value not in get_args(hint):
            raise ValueError(f"{name} cannot be {quoted(value)}; {suggestion(str(value), map(str, get_args(hint)))}")
    elif get_origin(hint) is tuple:
        for item in value:
            _check(name, item, get_args(hint)[0])
    else:
        for option in get_args(hint):
            _check(name, value, option)


def _shown(value: float) -> str:
    """A number in few characters."""
    if isinstance(value, int):
        if abs(value) < 10**15:
            return f"{value:,}"
        bits = value.bit_length()
        return f"2^{bits - 1}" if value == 2 ** (bits - 1) else f"a whole number of {bits} bits"
    return f"{value:,.6g}" if math.isfinite(value) else str(value)


_NUMBER = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?|nan|inf)", re.IGNORECASE | re.ASCII)


def parse_number(text: str) -> float | None:
    """The decimal number in a cell, blanks and tabs around it; ``None`` where there is none.

    ``nan`` and ``inf`` are read, so that a message can say what they are. Python's underscores (``0_2``), its
    ``infinity``, hexadecimals and digits of other scripts are not accepted.
    """
    text = text.strip(" \t")
    return float(text) if _NUMBER.fullmatch(text) else None


def finite_number(path: Path, line: int | None, name: str, cell: str) -> float:
    """The number in the cell of a file's column ``name``.

    Raises FileError with the line, if there is none, or it is not finite.
    """
    value = parse_number(cell)
    if value is None:
        raise FileError(path, f"{name} is {quoted(cell.strip())}; write a number", line)
    if not math.isfinite(value):
        raise FileError(path, f"{name} is {value}; write a finite number", line)
    return value


def is_day(text: str) -> bool:
    """Whether a text is a day as YYYY-MM-DD, and in no other form."""
    with suppress(ValueError):
        return date.fromisoformat(text).isoformat() == text
    return False
