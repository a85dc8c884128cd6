"""vbbench: data, solvers and trusted numbers for view birdification.

View birdification recovers, on the ground plane, where a moving camera is and where everybody around it
walks, from nothing but the boxes of the people it sees (Nishimura, Nobuhara, Nishino, arXiv 2111.05060).

Everything public is reachable from here and imported on first use, so that ``import vbbench`` stays light.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOMES = {
    "Dataset": "files.dataset",
    "EquirectangularCamera": "camera",
    "Estimate": "estimate",
    "ForgettingSolver": "solver",
    "Frame": "solver",
    "FrameEstimate": "estimate",
    "FrameSolver": "solver",
    "Given": "sequence",
    "OdometryFacts": "exchange.own.camera_file",
    "PanoramaCamera": "camera",
    "PerspectiveCamera": "camera",
    "PosePosterior": "solver",
    "Problem": "solver",
    "Scene": "scene",
    "Sequence": "sequence",
    "SequenceSolver": "solver",
    "Session": "solving.session",
    "SessionAnswer": "solving.session",
    "Truth": "sequence",
    "VbbenchError": "errors",
    "__version__": "version",
    "compare": "scoring.comparison",
    "generate": "generation",
    "parts": "training",
    "score": "scoring",
    "solve": "solving",
}

__all__ = [*_HOMES]

if TYPE_CHECKING:
    from vbbench.camera import EquirectangularCamera as EquirectangularCamera
    from vbbench.camera import PanoramaCamera as PanoramaCamera
    from vbbench.camera import PerspectiveCamera as PerspectiveCamera
    from vbbench.errors import VbbenchError as VbbenchError
    from vbbench.estimate import Estimate as Estimate
    from vbbench.estimate import FrameEstimate as FrameEstimate
    from vbbench.exchange.own.camera_file import OdometryFacts as OdometryFacts
    from vbbench.files.dataset import Dataset as Dataset
    from vbbench.generation import generate as generate
    from vbbench.scene import Scene as Scene
    from vbbench.scoring import score as score
    from vbbench.scoring.comparison import compare as compare
    from vbbench.sequence import Given as Given
    from vbbench.sequence import Sequence as Sequence
    from vbbench.sequence import Truth as Truth
    from vbbench.solver import ForgettingSolver as ForgettingSolver
    from vbbench.solver import Frame as Frame
    from vbbench.solver import FrameSolver as FrameSolver
    from vbbench.solver import PosePosterior as PosePosterior
    from vbbench.solver import Problem as Problem
    from vbbench.solver import SequenceSolver as SequenceSolver
    from vbbench.solving import solve as solve
    from vbbench.solving.session import Session as Session
    from vbbench.solving.session import SessionAnswer as SessionAnswer
    from vbbench.training import parts as parts
    from vbbench.version import __version__ as __version__


def lazy_names(package: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """A ``__getattr__`` for a package: its public names, each imported on first use from the module it lives in."""

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module '{package}' has no attribute {name!r}")
        return getattr(import_module(f"{package}.{homes[name]}"), name)

    return get


__getattr__ = lazy_names(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
