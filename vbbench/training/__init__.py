"""Feeds training: which sequences train, validate and test, samples of fixed shape with masks, PyTorch datasets."""

from typing import TYPE_CHECKING

from vbbench import lazy_names

if TYPE_CHECKING:
    from vbbench.training.samples import Sample
    from vbbench.training.sources import FolderSamples, GeneratedSamples
    from vbbench.training.splitting import Parts, parts

_HOMES = {
    "FolderSamples": "sources",
    "GeneratedSamples": "sources",
    "Parts": "splitting",
    "Sample": "samples",
    "parts": "splitting",
}

__all__ = ["FolderSamples", "GeneratedSamples", "Parts", "Sample", "parts"]

__getattr__ = lazy_names(__name__, _HOMES)
