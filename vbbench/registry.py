"""Finds cameras, generators, renderers, solvers and other plugins by entry point; imports none until asked."""

import warnings
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path, PurePath
from typing import Any, Literal

from vbbench.errors import MissingExtraError, UnknownNameError, VbbenchError, VbbenchWarning

Kind = Literal[
    "camera", "generator", "tier", "reader", "renderer", "detector", "tracker", "solver", "variant", "command"
]
_SPOKEN = {"generator": "split", "reader": "recording format"}


@cache
def registered(kind: Kind) -> dict[str, EntryPoint]:
    """Everything registered under ``vbbench.<kind>s`` by name.

    Of two with one name, vbbench's own counts, then the first by distribution name: no other package replaces a
    bundled name.
    """
    found: dict[str, EntryPoint] = {}
    points = entry_points(group=f"vbbench.{kind}s")
    for point in sorted(points, key=lambda point: (_owner(point) != "vbbench", _owner(point), point.name)):
        if found.setdefault(point.name, point).value != point.value:
            warnings.warn(
                f"{kind} '{point.name}' is registered twice; {found[point.name].value} is used, not {point.value}",
                VbbenchWarning,
                stacklevel=2,
            )
    return found


def load(kind: Kind, name: str) -> Any:
    """Import what is registered as ``name``, or ``module:attribute``.

    Raises UnknownNameError if nothing has this name; the nearest one is suggested; VbbenchError if its import fails or
    the attribute is missing.
    """
    if ":" in name and name not in registered(kind):
        return _import(kind, name, name)
    file = Path(f"{name.removesuffix('.py')}.py")
    if kind == "solver" and name not in registered(kind) and file.is_file():
        raise VbbenchError(f"no solver is called '{name}'; of a class in {file} write {file.stem}:CLASS")
    return load_registered(kind, name)


def load_registered(kind: Kind, name: str) -> Any:
    """As `load`, but never a module that ``name`` names: for names that are read from strangers' files.

    Raises UnknownNameError, VbbenchError as of `load`.
    """
    points = registered(kind)
    if name not in points:
        raise UnknownNameError(_SPOKEN.get(kind, kind), name, points)
    return _import(kind, name, points[name].value)


def make_solver(name: str) -> Any:
    """A new solver of the class called ``name``; raises VbbenchError if it needs arguments or is not a class."""
    found = load("solver", name)
    try:
        return found()
    except TypeError as error:
        raise VbbenchError(f"solver '{name}' is not a class that can be called without arguments: {error}") from error


def own_words(found: Any, attribute: str) -> Mapping[str, str]:
    """What a solver's class says of itself in an ``attribute``; what a class of vbbench's says is not of yours."""
    makers = [one for one in getattr(found, "__mro__", ()) if attribute in vars(one)]
    if makers and makers[0].__module__.startswith("vbbench") and not found.__module__.startswith("vbbench"):
        return {}
    words: Mapping[str, str] = getattr(found, attribute, {})
    return words


def load_all(kind: Kind) -> dict[str, Any]:
    """Everything that can be imported; a broken plugin causes a warning that names it."""
    found: dict[str, Any] = {}
    for name in registered(kind):
        try:
            found[name] = load(kind, name)
        except VbbenchError as error:
            warnings.warn(str(error), VbbenchWarning, stacklevel=2)
    return found


def _owner(point: EntryPoint) -> str:
    return point.dist.name if point.dist else ""


def _import(kind: Kind, name: str, value: str) -> Any:
    module, _, attribute = value.partition(":")
    if module.endswith(".py") or "/" in module or module.startswith("."):
        name_of_it = f"{PurePath(module).stem}:{attribute}"
        raise VbbenchError(f"{kind} '{name}': name the module, not its file: {name_of_it}, from the folder of the file")
    try:
        found: Any = import_module(module)
        for part in attribute.split("."):
            found = getattr(found, part)
    except MissingExtraError:
        raise
    except Exception as error:
        of = "" if name == value else f" ({value})"
        file = module.partition(".")[0]
        absent = isinstance(error, ModuleNotFoundError) and error.name == file
        way = f"; run in the folder of {file}.py" if absent else ""
        raise VbbenchError(f"{kind} '{name}'{of} cannot be imported: {type(error).__name__}: {error}{way}") from error
    return found
