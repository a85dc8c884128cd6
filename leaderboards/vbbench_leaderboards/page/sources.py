"""The source files of the solvers that come with vbbench, which the site holds itself: code that needs no net."""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from vbbench.registry import registered


@dataclass(frozen=True, kw_only=True)
class Source:
    """Where a solver is written.

    Parameters
    ----------
    place : ``module:class``.
    address : of the copy in the site.
    text : of the module.
    """

    place: str
    address: str
    text: str


def bundled_sources(solvers: Iterable[str]) -> dict[str, Source]:
    """The sources of those solvers that come with vbbench, by name."""
    found = {}
    for name in solvers:
        place = _bundled(name)
        spec = find_spec(place.partition(":")[0]) if place else None
        if spec is not None and spec.origin is not None:
            address = f"code/{spec.name.replace('.', '/')}.py.txt"
            found[name] = Source(place=place, address=address, text=Path(spec.origin).read_text("utf-8"))
    return found


def _bundled(solver: str) -> str:
    """The ``module:class`` of a solver that this distribution registers; empty for any other."""
    point = registered("solver").get(solver)
    return point.value if point and point.dist and point.dist.name == "vbbench" else ""
