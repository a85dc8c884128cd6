"""Scores submissions: rows matched with truth, errors, summaries and comparisons."""

from typing import TYPE_CHECKING

from vbbench import lazy_names

if TYPE_CHECKING:
    from vbbench.scoring.scores import score

__all__ = ["score"]

__getattr__ = lazy_names(__name__, dict.fromkeys(__all__, "scores"))
