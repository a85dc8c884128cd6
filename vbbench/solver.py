"""What a solver gets and gives back. A solver has no way to reach truth.

A solver is a class that is called without arguments and implements `FrameSolver` (frame by frame) or
`SequenceSolver` (whole sequence); the protocol runner drives both. It registers under the entry point group
``vbbench.solvers`` or is named ``module:attribute`` on the command line.
"""

from dataclasses import dataclass
from typing import Literal, Protocol, get_args, runtime_checkable

from vbbench.camera import Camera
from vbbench.errors import quoted, suggestion
from vbbench.estimate import Estimate, FrameEstimate
from vbbench.geometry import FloatArray, IntArray, freeze
from vbbench.parsing.numbers import Within
from vbbench.sequence import Given

__all__ = [
    "BOX_EDGE",
    "CARRIERS",
    "Carrier",
    "Estimate",
    "ForgettingSolver",
    "Frame",
    "FrameEstimate",
    "FrameSolver",
    "PosePosterior",
    "Problem",
    "SequenceSolver",
]

Carrier = Literal["unknown", "person", "vehicle", "robot"]
CARRIERS: tuple[Carrier, ...] = get_args(Carrier)
"""What may carry a camera."""
BOX_EDGE = Within(0.0, 1.0, "m")
"""How near the near edge of a source of boxes may be."""


@dataclass(frozen=True, kw_only=True)
class Problem:
    """The published facts about a sequence.

    Raises ValueError if ``carried_by`` is none of these, or ``box_edge`` outside its range.

    Parameters
    ----------
    camera : intrinsics and mount height.
    dt : seconds per frame.
    tracks : [K] ids of the columns of every array below.
    height_mean, height_std : prior N(μ_h, σ_h²) of a person's height, in m.
    pixel_std : standard deviation in px of u and of box top and bottom (0 in the ideal tier).
    covariances : whether covariances are wanted; otherwise they are ignored.
    box_std : standard deviation of column, top and bottom as a share of the box's height, next to ``pixel_std``.
    tilt_std : standard deviation in rad by which the camera's pitch and roll are off those of ``camera``.
    mount_height_std : standard deviation in m by which its mount height is.
    carried_by : what carries the camera, one of `CARRIERS`.
    box_edge : near edge of the source of boxes: distance in m from a person's axis to the plane in which top and bottom
        of the box lie; .45 for projections of cuboids. ``None`` = not known.
    """

    camera: Camera
    dt: float
    tracks: IntArray
    height_mean: float
    height_std: float
    pixel_std: float
    covariances: bool = False
    box_std: float = 0.0
    tilt_std: float = 0.0
    mount_height_std: float = 0.0
    carried_by: Carrier = "unknown"
    box_edge: float | None = None

    def __post_init__(self) -> None:
        if self.carried_by not in CARRIERS:
            raise ValueError(
                f"carried_by cannot be {quoted(self.carried_by)}; {suggestion(str(self.carried_by), CARRIERS)}"
            )
        if self.box_edge is not None:
            BOX_EDGE.check("box_edge", self.box_edge)


@dataclass(frozen=True, kw_only=True)
class Frame:
    """One frame as a solver sees it, with the window of two past frames that the paper uses.

    Parameters
    ----------
    index : t, from 0.
    observations : [K, 3] boxes (u, v, l) in px, NaN = not observed.
    given : poses [3, 3] and positions [3, K, 2] known at frames t−2, t−1 and t, NaN = not given; and the observer's
        odometry of these frames, where it has any.
    """

    index: int
    observations: FloatArray
    given: Given

    def __post_init__(self) -> None:
        freeze(self, observations=(None, 3))
        if self.given.positions.shape != (3, len(self.observations), 2):
            raise ValueError(f"given.positions must have shape [3, {len(self.observations)}, 2]")


@runtime_checkable
class FrameSolver(Protocol):
    """Solves frame by frame and keeps its own state between frames."""

    def start(self, problem: Problem) -> None:
        """Begin a sequence; forget the last one."""

    def step(self, frame: Frame) -> FrameEstimate:
        """Answer for this frame; called for t = 0, 1, 2, … in order."""


@runtime_checkable
class ForgettingSolver(FrameSolver, Protocol):
    """A solver whose columns can be given to new people while it runs, for sessions without an end."""

    def forget(self, columns: IntArray) -> None:
        """From the next frame on, these columns [M] stand for new people: what is known of the earlier ones is dropped.

        The observer's pose, and what else was learned from them, is kept.
        """


@runtime_checkable
class SequenceSolver(Protocol):
    """Solves a whole sequence at once."""

    def solve(self, problem: Problem, observations: FloatArray, given: Given) -> Estimate:
        """Answer for all frames: observations [T, K, 3] in px, given as in `Given`."""


@runtime_checkable
class PosePosterior(FrameSolver, Protocol):
    """A solver that also reports how probable other poses and places are, for studies of what a picture determines.

    Both are of the last frame stepped.
    """

    def pose_energy(self, poses: FloatArray) -> FloatArray:
        """−ln of the posterior density of the observer's pose, up to a constant: poses [N, 3] in m and rad → [N].

        All positions are minimised or integrated out.
        """

    def ray_posterior(self, samples: int, spacing: float) -> tuple[FloatArray, FloatArray]:
        """Where the people who are seen may stand along their viewing rays, given the pose that was found.

        ``samples`` places about each optimum, an odd number, as far apart as ``spacing`` m of a person's height moves
        them, in order along the ray: [M, S, 2] in m, and their probabilities [M, S]. Places with probability 0 need
        not be on the ray.
        """
