"""Runs solvers on sequences, datasets and live data, isolated if requested, and writes submissions."""

from typing import TYPE_CHECKING

from vbbench import lazy_names

if TYPE_CHECKING:
    from vbbench.solving.provenance import hardware, solver_version
    from vbbench.solving.submissions import solve

__all__ = ["hardware", "solve", "solver_version"]

__getattr__ = lazy_names(__name__, {"hardware": "provenance", "solver_version": "provenance", "solve": "submissions"})
