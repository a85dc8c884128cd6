"""Solvers with one thing changed each, which packages register in mappings from names under ``vbbench.variants``."""

from dataclasses import dataclass

from vbbench.registry import load_all


@dataclass(frozen=True, kw_only=True)
class Variant:
    """A solver as it is or with something changed.

    Parameters
    ----------
    solver : a registered name, or ``module:attribute``.
    feet : whether it uses the rows of people's feet in the picture.
    """

    solver: str
    feet: bool = False


def registered_variants() -> dict[str, Variant]:
    """The variants of all installed packages, by name."""
    return {name: variant for found in load_all("variant").values() for name, variant in found.items()}
