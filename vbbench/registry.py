"""Finds cameras, generators, renderers, solvers and other plugins by entry point; imports none until asked."""

import warnings
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Literal

from vbbench.errors import MissingExtraError, UnknownNameError, VbbenchError, VbbenchWarning

Kind = Literal["camera", "generator", "renderer", "detector", "tracker", "solver", "command"]
_SPOKEN = {"generator": "split"}


@cache
def registered(kind: Kind) -> dict[str, EntryPoint]:
    """Everything registered under ``vbbench.<kind>s`` by name; of two with one name, the first found counts."""
    found: dict[str, EntryPoint] = {}
    for point in _in_stable_order(entry_points(group=f"vbbench.{kind}s")):
        if found.setdefault(point.name, point).value != point.value:
            warnings.warn(
                f"{kind} '{point.name}' is registered twice; {found[point.name].value} is used, not {point.value}",
                VbbenchWarning,
                stacklevel=2,
            )
    return found


def load(kind: Kind, name: str) -> Any:
    """Import what is registered as ``name``, or what ``module:attribute`` names.

    Raises
    ------
    UnknownNameError
        If nothing is called so; the nearest name is suggested.
    VbbenchError
        If it is broken: its import fails or the attribute is missing.
    """
    points = registered(kind)
    if name in points:
        return _import(kind, name, points[name].value)
    if ":" in name:
        return _import(kind, name, name)
    raise UnknownNameError(_SPOKEN.get(kind, kind), name, points)


def make_solver(name: str) -> Any:
    """A new solver of the class that ``name`` stands for.

    Raises
    ------
    VbbenchError
        If it is no class, or needs arguments.
    """
    found = load("solver", name)
    try:
        return found()
    except TypeError as error:
        raise VbbenchError(f"solver '{name}' is no class that is called without arguments: {error}") from error


def held_out(solver: str, split: str) -> str:
    """What is run where ``solver`` is asked to solve ``split``: itself, or what it names for a split it was fitted on.

    A solver is not told which split it has. One whose parameters were fitted on public splits names a variant for each
    that was not, in a class attribute ``held_out``: split to registered name or ``module:attribute``.

    Raises
    ------
    UnknownNameError, VbbenchError
        As of `load`.
    """
    variants: Mapping[str, str] = getattr(load("solver", solver), "held_out", {})
    return variants.get(split, solver)


def load_all(kind: Kind) -> dict[str, Any]:
    """Everything that imports; a broken plugin is a warning that names it."""
    found: dict[str, Any] = {}
    for name in registered(kind):
        try:
            found[name] = load(kind, name)
        except VbbenchError as error:
            warnings.warn(str(error), VbbenchWarning, stacklevel=2)
    return found


def _in_stable_order(points: Iterable[EntryPoint]) -> list[EntryPoint]:
    """Our own first, then by distribution name, so that a stranger's package cannot replace a bundled name."""
    return sorted(points, key=lambda point: (_owner(point) != "vbbench", _owner(point), point.name))


def _owner(point: EntryPoint) -> str:
    return point.dist.name if point.dist else ""


def _import(kind: Kind, name: str, value: str) -> Any:
    module, _, attribute = value.partition(":")
    try:
        found: Any = import_module(module)
        for part in attribute.split("."):
            found = getattr(found, part)
    except MissingExtraError:
        raise
    except Exception as error:
        raise VbbenchError(f"{kind} '{name}' ({value}) cannot be imported: {type(error).__name__}: {error}") from error
    return found
