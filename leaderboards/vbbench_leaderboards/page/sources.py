"""The source files of the solvers that come with vbbench, which the site holds itself: code that needs no net."""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from vbbench.registry import registered
from vbbench_leaderboards.checks.bundled import bundled_solvers


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
    points, own = registered("solver"), set(bundled_solvers())
    found = {}
    for name in solvers:
        module = points[name].value.partition(":")[0] if name in own and name in points else ""
        spec = find_spec(module) if module else None
        if spec is not None and spec.origin is not None:
            address = f"code/{module.replace('.', '/')}.py.txt"
            text = Path(spec.origin).read_text("utf-8")
            found[name] = Source(place=points[name].value, address=address, text=text)
    return found
