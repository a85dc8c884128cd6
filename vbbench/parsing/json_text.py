"""JSON that strangers write, read within bounds; values without NaN, which JSON lacks; one text of them for digests."""

import hashlib
import json
import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from vbbench.errors import FileError, one_line, quoted

LARGEST_FILE = 64 * 2**20
"""Bytes of a JSON file that is read: the largest that vbbench writes has some hundred kilobytes."""

DEEPEST = 64
"""Objects and lists within one another; a parser or writer that recurses is safe there."""


def read_json(path: Path, *, finite: bool = True, largest: int = LARGEST_FILE) -> Any:
    """The value in a JSON file.

    Raises ValueError if the file is not UTF-8, not JSON, larger or deeper than anything sensible, or an object has a
    key twice; the message is one short line; OSError if it cannot be read.

    Parameters
    ----------
    finite : refuse numbers that JSON does not have: NaN, Infinity, and what is too large to be a float.
    largest : bytes of the largest file that is read.
    """
    size = path.stat().st_size
    if size > largest:
        raise ValueError(f"{size} bytes; a file of this kind has {largest} at most")
    hooks: dict[str, Any] = {"parse_constant": _refuse, "parse_float": _finite} if finite else {}
    try:
        value = json.loads(path.read_text("utf-8-sig"), object_pairs_hook=_unique, **hooks)
    except UnicodeDecodeError as error:
        raise ValueError(f"byte {error.start} is not UTF-8") from None
    except RecursionError:
        raise ValueError(_TOO_DEEP) from None
    _check_depth(value)
    return value


def read_object(path: Path, advice: str, **bounds: Any) -> dict[str, Any]:
    """The object in a JSON file, within the ``bounds`` of `read_json`.

    Raises FileError if it is missing, cannot be read (`read_json`), or is not an object.

    Parameters
    ----------
    advice : what to do where it is missing or damaged.
    """
    if not path.is_file():
        raise FileError(path, f"the file is missing; {advice}")
    try:
        values = read_json(path, **bounds)
    except ValueError as error:
        raise FileError(path, f"is damaged ({error}); {advice}") from error
    if not isinstance(values, dict):
        raise FileError(path, f"is damaged (not a JSON object); {advice}")
    return values


def canonical_digest(values: dict[str, Any]) -> str:
    """SHA-256, in hex, of the canonical text: keys sorted, no spaces, numbers as Python prints them, UTF-8.

    Raises ValueError if a number is not finite.
    """
    text = json.dumps(values, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def without_nan(values: Any) -> Any:
    """The values, however nested, with ``None`` for every number that JSON does not have."""
    if isinstance(values, Mapping):
        return {name: without_nan(value) for name, value in values.items()}
    if isinstance(values, list | tuple):
        return [without_nan(value) for value in values]
    return finite_or_none(values) if isinstance(values, float) else values


def finite_or_none(value: float) -> float | None:
    """The value, or ``None`` if it is NaN or infinite: JSON has neither."""
    return value if math.isfinite(value) else None


_TOO_DEEP = f"is nested more than {DEEPEST} levels deep"


def _check_depth(value: Any) -> None:
    level = [value]
    for _ in range(DEEPEST):
        parts = (part.values() if isinstance(part, dict) else part for part in level if isinstance(part, (dict, list)))
        level = [child for part in parts for child in part]
        if not level:
            return
    raise ValueError(_TOO_DEEP)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) != len(pairs):
        names = sorted(name for name, _ in pairs)
        again = next(name for name, following in pairwise(names) if name == following)
        raise ValueError(f"key {quoted(again)} stands twice")
    return values


def _refuse(text: str) -> Any:
    raise ValueError(f"{text} is not a JSON number")


def _finite(text: str) -> float:
    value = float(text)
    if value in (float("inf"), float("-inf")):
        raise ValueError(f"{one_line(text, 20)} is too large a number")
    return value
