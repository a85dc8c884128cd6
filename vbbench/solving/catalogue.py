"""Every registered solver: its package, how it works, and its variants for files that it was fitted on."""

import inspect
import json
import re
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.registry import load_all, make_solver, own_words, registered
from vbbench.solver import FrameSolver, SequenceSolver


@dataclass(frozen=True, kw_only=True)
class SolverCard:
    """What is known about a solver before it runs.

    Parameters
    ----------
    name : its registered name.
    package : the distribution that registers it, with its version.
    kind : ``frame by frame``, or ``whole sequence``.
    summary : the first line of its docstring, if it has one.
    held_out : what runs instead of it, by the SHA-256 of a source file; see `vbbench.registry.held_out`.
    """

    name: str
    package: str
    kind: str
    summary: str
    held_out: Mapping[str, str]


def solver_cards() -> list[SolverCard]:
    """The cards of all solvers, by name; a broken one is a warning that names it."""
    cards = []
    for name, factory in sorted(load_all("solver").items()):
        try:
            cards.append(_card(name, factory))
        except VbbenchError as error:
            warnings.warn(str(error), VbbenchWarning, stacklevel=2)
    return cards


def describe_solvers() -> str:
    """All solvers as text."""
    lines = []
    for card in solver_cards():
        lines.append(f"{card.name}: {card.summary} [{', '.join(filter(None, (card.kind, card.package)))}]")
        if card.held_out:
            variants = ", ".join(sorted(set(card.held_out.values())))
            lines.append(
                f"    fitted on {len(card.held_out)} public files; where data come from one of them: {variants}"
            )
    return "\n".join(lines)


def solvers_json() -> str:
    """All solvers as a JSON list of cards."""
    return json.dumps([asdict(card) for card in solver_cards()], indent=2, ensure_ascii=False)


def _card(name: str, factory: Any) -> SolverCard:
    solver = factory if inspect.isclass(factory) else make_solver(name)
    held_out = own_words(factory, "held_out")
    if not isinstance(held_out, Mapping):
        raise VbbenchError(f"solver '{name}': held_out must map files to solvers, not be {type(held_out).__name__}")
    for source in held_out:
        if not re.fullmatch("[0-9a-f]{64}", str(source)):
            raise VbbenchError(f"solver '{name}': held_out maps files to solvers by SHA-256, which '{source}' is not")
    distribution = registered("solver")[name].dist
    return SolverCard(
        name=name,
        package=f"{distribution.name} {distribution.version}" if distribution else "",
        kind=_kind(name, solver),
        summary=(inspect.getdoc(factory) or "").partition("\n")[0],
        held_out={str(source): str(variant) for source, variant in held_out.items()},
    )


def _kind(name: str, solver: Any) -> str:
    for protocol, kind in ((FrameSolver, "frame by frame"), (SequenceSolver, "whole sequence")):
        if all(callable(getattr(solver, method, None)) for method in vars(protocol) if not method.startswith("_")):
            return kind
    raise VbbenchError(f"solver '{name}' has neither start and step nor solve")
