"""vbbench: data, solvers and trusted numbers for view birdification.

View birdification recovers, on the ground plane, where a moving camera is and where everybody around it
walks, from nothing but the boxes of the people it sees (Nishimura, Nobuhara, Nishino, arXiv 2111.05060).

Everything public is reachable from here and imported on first use, so that ``import vbbench`` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOMES = {
    "Dataset": "dataset",
    "Estimate": "estimate",
    "Frame": "solver",
    "FrameEstimate": "estimate",
    "FrameSolver": "solver",
    "Given": "sequence",
    "LocationPosterior": "solver",
    "PanoramaCamera": "camera",
    "PerspectiveCamera": "camera",
    "Problem": "solver",
    "Scene": "scene",
    "Sequence": "sequence",
    "SequenceSolver": "solver",
    "Truth": "sequence",
    "VbbenchError": "errors",
    "compare": "comparison",
    "generate": "generation",
    "score": "scoring",
    "solve": "solving",
}

__all__ = [
    "Dataset",
    "Estimate",
    "Frame",
    "FrameEstimate",
    "FrameSolver",
    "Given",
    "LocationPosterior",
    "PanoramaCamera",
    "PerspectiveCamera",
    "Problem",
    "Scene",
    "Sequence",
    "SequenceSolver",
    "Truth",
    "VbbenchError",
    "__version__",
    "compare",
    "generate",
    "score",
    "solve",
]

if TYPE_CHECKING:
    from vbbench.camera import PanoramaCamera, PerspectiveCamera
    from vbbench.comparison import compare
    from vbbench.dataset import Dataset
    from vbbench.errors import VbbenchError
    from vbbench.estimate import Estimate, FrameEstimate
    from vbbench.generation import generate
    from vbbench.scene import Scene
    from vbbench.scoring import score
    from vbbench.sequence import Given, Sequence, Truth
    from vbbench.solver import Frame, FrameSolver, LocationPosterior, Problem, SequenceSolver
    from vbbench.solving import solve


def __getattr__(name: str) -> Any:
    """Import a public name from the module it lives in, on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module 'vbbench' has no attribute {name!r}")
    return getattr(import_module(f"vbbench.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
