"""Solvers with one thing changed each, which packages register in mappings from names under ``vbbench.variants``.

Plugins import this module, so it imports no study.
"""

from dataclasses import dataclass

from vbbench.registry import load_all


@dataclass(frozen=True, kw_only=True)
class Variant:
    """A solver as it is or with one thing changed.

    Parameters
    ----------
    solver : a registered name, or ``module:attribute``.
    feet : whether it uses the foot cue, the rows of people's feet in the picture.
    """

    solver: str
    feet: bool = False


def registered_variants() -> dict[str, Variant]:
    """The variants of all installed packages, by name."""
    return {name: variant for found in load_all("variant").values() for name, variant in found.items()}
