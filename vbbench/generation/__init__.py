"""Makes datasets: what a split offers, where its sources are, and the folder that is written."""

from typing import TYPE_CHECKING

from vbbench import lazy_names

if TYPE_CHECKING:
    from vbbench.generation.datasets import generate, write_dataset

__all__ = ["generate", "write_dataset"]

__getattr__ = lazy_names(__name__, dict.fromkeys(__all__, "datasets"))
