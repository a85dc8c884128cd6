"""Where two results differ by more than the tolerance."""

from typing import Any

TOLERANCE = 1e-6
"""How far a figure may lie from the committed one, in m or rad, or in parts of it where it is larger than one."""

_NOT_COMPARED = ("package_version", "solver_version")


def drift(old: Any, new: Any, name: str = "") -> list[str]:
    """Differences of two results as JSON has them, a line each; versions are not compared."""
    if isinstance(old, dict) and isinstance(new, dict):
        keys = [key for key in dict.fromkeys([*old, *new]) if key not in _NOT_COMPARED]
        return [line for key in keys for line in drift(old.get(key), new.get(key), f"{name}.{key}".lstrip("."))]
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        return _drift_of_rows(old, new, name)
    return [] if _same(old, new) else [f"{name}: was {_short(old)}, is {_short(new)}"]


def _drift_of_rows(old: list[Any], new: list[Any], name: str) -> list[str]:
    rows = [row for row, pair in enumerate(zip(old, new, strict=True)) if not _same(*pair)]
    if not rows:
        return []
    worst = max(rows, key=lambda row: abs((old[row] or 0.0) - (new[row] or 0.0)))
    return [f"{name}: {len(rows)} of {len(old)} differ, most row {worst}: was {old[worst]}, is {new[worst]}"]


def _same(old: Any, new: Any) -> bool:
    if isinstance(old, float) and isinstance(new, (int, float)):
        return abs(old - new) <= TOLERANCE * max(1.0, abs(old))
    return bool(old == new)


def _short(value: Any) -> str:
    return f"{len(value)} values" if isinstance(value, (dict, list)) else repr(value)
