"""What a solver's class says of itself in its attribute ``facts``, for its submissions and its rows on boards."""

from collections.abc import Mapping

from vbbench.errors import VbbenchError
from vbbench.registry import load, own_words

FACTS = ("authors", "code", "trained_on", "tuned_on")
"""Keys of ``facts``: those of ``submission.json`` that only the solver's makers know."""


def declared_facts(solver: str) -> dict[str, str]:
    """The attribute ``facts`` of the class called ``solver``, by key; what a class of vbbench's says is not yours.

    Raises
    ------
    VbbenchError
        If it is not a mapping of these keys to text, or the solver cannot be imported.
    """
    found = own_words(load("solver", solver), "facts")
    sound = isinstance(found, Mapping) and all(isinstance(text, str) for text in found.values())
    if not sound or set(found) - set(FACTS):
        raise VbbenchError(f"solver '{solver}': facts must map some of {', '.join(FACTS)} to text")
    return dict(found)
