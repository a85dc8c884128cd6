"""What may stand in ``dataset.json``: each key, and what its value must be."""

import re
from collections.abc import Callable, Mapping
from typing import Any

from vbbench.errors import is_printable, quoted
from vbbench.files.schemas import SCHEMAS, TRACK_TABLE

TABLES = tuple(name for name in SCHEMAS if name not in ("poses", "positions", "heights"))
"""Names that a table of a dataset can have; what stands there under another one is never made a path."""

ALWAYS = tuple(name for name in TABLES if name != TRACK_TABLE)
"""The tables that every dataset has."""

COUNTS = ("sequences", "frames", "observations", "people_min", "people_max")
"""What is counted of every dataset that is whole."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,39}")
_ID = re.compile(r"[0-9a-f]{16}")
_SHA256 = re.compile(r"[0-9a-f]{64}")
_LARGEST_COUNT = 1 << 53
_LONGEST_TEXT = 1000

Fault = str | None
Check = Callable[[Any], Fault]


def find_fault(values: Mapping[str, Any]) -> Fault:
    """The first thing that is wrong with the object in a ``dataset.json``, by its key; ``None`` if nothing is."""
    for name in values:
        if name not in _CHECKS and name not in _OPTIONAL:
            return f"key {quoted(name)} is unknown"
    for name, check in _CHECKS.items():
        if name not in values:
            return f"key '{name}' is missing"
        fault = check(values[name])
        if fault is not None:
            return f"key '{name}' {fault}"
    for name, check in _OPTIONAL.items():
        fault = check(values[name]) if name in values else None
        if fault is not None:
            return f"key '{name}' {fault}"
    return None


def _text(longest: int = _LONGEST_TEXT) -> Check:
    def check(value: Any) -> Fault:
        good = isinstance(value, str) and 0 < len(value) <= longest and is_printable(value)
        return None if good else f"is {quoted(value)}, no text of 1 to {longest} printable characters"

    return check


def _like(pattern: re.Pattern[str], kind: str) -> Check:
    def check(value: Any) -> Fault:
        good = isinstance(value, str) and pattern.fullmatch(value)
        return None if good else f"is {quoted(value)}, no {kind}"

    return check


def _number(least: float, most: float, *, above: bool = False) -> Check:
    """A number from ``least``, or ``above`` it, to ``most``."""

    def check(value: Any) -> Fault:
        known = isinstance(value, (int, float)) and not isinstance(value, bool)
        good = known and least <= value <= most and not (above and value == least)
        return None if good else f"is {quoted(value)}, no number {'above' if above else 'from'} {least:g} to {most:g}"

    return check


def _whole(least: int, most: int | None = _LARGEST_COUNT) -> Check:
    def check(value: Any) -> Fault:
        known = isinstance(value, int) and not isinstance(value, bool)
        good = known and value >= least and (most is None or value <= most)
        return None if good else f"is {quoted(value)}, no whole number from {least} on"

    return check


def _or_null(check: Check) -> Check:
    return lambda value: None if value is None else check(value)


def _object(value: Any) -> Fault:
    return None if isinstance(value, dict) else f"is {quoted(value)}, no object"


def _each_of(checks: Mapping[str, Check]) -> Check:
    """An object with exactly these keys."""

    def check(value: Any) -> Fault:
        if not isinstance(value, dict) or set(value) != set(checks):
            return f"is {quoted(value)}, no object with the keys {', '.join(checks)}"
        faults = ((name, checks[name](value[name])) for name in checks)
        return next((f"has '{name}', which {fault}" for name, fault in faults if fault), None)

    return check


def _scenes(value: Any) -> Fault:
    if not isinstance(value, list):
        return f"is {quoted(value)}, no list of names"
    fault = next((fault for fault in map(_text(), value) if fault), None)
    return f"has a name that {fault}" if fault else None


def _camera(value: Any) -> Fault:
    """Its kind and parameters are checked by who makes it; here, that they are numbers."""
    if not isinstance(value, dict) or not isinstance(value.get("kind"), str):
        return f"is {quoted(value)}, no camera: it has a 'kind' and its parameters"
    number = _number(-1e9, 1e9)
    faults = ((name, number(part)) for name, part in value.items() if name != "kind")
    return next((f"has {quoted(name)}, which {fault}" for name, fault in faults if fault), None)


def _counts(value: Any) -> Fault:
    """Counts may be absent: those of a dataset in partitions are not known yet."""
    return None if value == {} else _each_of(dict.fromkeys(COUNTS, _whole(0)))(value)


def _tables(value: Any) -> Fault:
    if not isinstance(value, dict):
        return f"is {quoted(value)}, no object of tables"
    facts = _each_of({"bytes": _whole(0), "rows": _whole(0), "sha256": _like(_SHA256, "SHA-256 in hex")})
    for name, told in value.items():
        if name not in TABLES:
            return f"has {quoted(name)}, which is the name of no table; there are {', '.join(TABLES)}"
        fault = facts(told)
        if fault is not None:
            return f"has '{name}', which {fault}"
    missing = [name for name in ALWAYS if name not in value]
    return f"lacks {', '.join(missing)}" if value and missing else None


def _calibration(value: Any) -> Fault:
    """Its ``summary`` is printed; the rest is for programs."""
    if not isinstance(value, dict):
        return f"is {quoted(value)}, no object"
    fault = _text(_LONGEST_TEXT)(value.get("summary"))
    return f"has 'summary', which {fault}" if fault else None


_CHECKS: dict[str, Check] = {
    "id": _like(_ID, "id of 16 hex digits"),
    "split": _like(_NAME, "name of a split"),
    "title": _text(),
    "camera": _camera,
    "tier": _like(_NAME, "name of a tier"),
    "seed": _or_null(_whole(0, None)),
    "dt": _number(0, 1000, above=True),
    "height_mean": _number(0, 10, above=True),
    "height_std": _number(0, 10),
    "pixel_std": _number(0, 1e6),
    "scenes": _scenes,
    "definition": _object,
    "caution": _or_null(_text()),
    "counts": _counts,
    "tables": _tables,
    "package_version": lambda value: None if value == "" else _text(80)(value),
    "format_version": _whole(1),
}

_OPTIONAL: dict[str, Check] = {"calibration": _or_null(_calibration), "digest": _like(_SHA256, "SHA-256 in hex")}
