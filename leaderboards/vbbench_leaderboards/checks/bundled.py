"""The solvers that come with vbbench: their names, and what boards say of them."""

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any

from vbbench.registry import registered

AUTHORS = "the authors of vbbench"


def bundled_solvers() -> list[str]:
    """Names of the solvers that come with vbbench, strangers' left out."""
    return sorted(name for name, point in registered("solver").items() if point.dist and point.dist.name == "vbbench")


def bundled_facts(solver: str) -> dict[str, str]:
    """What the row of a bundled solver says (`About`); empty for a stranger's, whose submission says it."""
    found: dict[str, str] = _table().get(solver, {})
    return {"authors": AUTHORS, **found} if found else {}


@cache
def _table() -> dict[str, Any]:
    return tomllib.loads((files("vbbench_leaderboards.checks") / "bundled.toml").read_text("utf-8"))
