"""The catalogue of registered solvers."""

import inspect
import json
import warnings
from dataclasses import asdict, dataclass
from typing import Any

from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.registry import load_all, make_solver, registered
from vbbench.solver import FrameSolver, SequenceSolver


@dataclass(frozen=True, kw_only=True)
class SolverCard:
    """Facts of a solver that is not imported yet.

    Parameters
    ----------
    name : its registered name.
    package : the distribution that registers it, with its version.
    kind : ``frame by frame``, or ``whole sequence``.
    summary : the first line of its docstring, if it has one.
    """

    name: str
    package: str
    kind: str
    summary: str


def solver_cards() -> list[SolverCard]:
    """The cards of all solvers, by name; warns of solvers that cannot be loaded."""
    cards = []
    for name, factory in sorted(load_all("solver").items()):
        try:
            cards.append(_card(name, factory))
        except VbbenchError as error:
            warnings.warn(str(error), VbbenchWarning, stacklevel=2)
    return cards


def describe_solvers() -> str:
    """All solvers as text."""
    return "\n".join(
        f"{card.name}: {card.summary} [{', '.join(filter(None, (card.kind, card.package)))}]" for card in solver_cards()
    )


def solvers_json() -> str:
    """All solvers as a JSON list of cards."""
    return json.dumps([asdict(card) for card in solver_cards()], indent=2, ensure_ascii=False)


def _card(name: str, factory: Any) -> SolverCard:
    solver = factory if inspect.isclass(factory) else make_solver(name)
    distribution = registered("solver")[name].dist
    return SolverCard(
        name=name,
        package=f"{distribution.name} {distribution.version}" if distribution else "",
        kind=_kind(name, solver),
        summary=(inspect.getdoc(factory) or "").partition("\n")[0],
    )


def _kind(name: str, solver: Any) -> str:
    for protocol, kind in ((FrameSolver, "frame by frame"), (SequenceSolver, "whole sequence")):
        if all(callable(getattr(solver, method, None)) for method in vars(protocol) if not method.startswith("_")):
            return kind
    raise VbbenchError(f"solver '{name}' has neither start and step nor solve")
