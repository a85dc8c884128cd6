"""A solver's answer: poses and positions, and optionally heights and uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeVar

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, freeze

LARGEST = 1e6
"""Largest absolute coordinate (m) or angle (rad) of an answer: float64 is exact to 0.2 nm at 1000 km, and errors can be
squared and summed over any split. A larger one would dominate means and intervals, or make them overflow."""


def is_credible(values: FloatArray) -> BoolArray:
    """Which values in m or rad can be an answer: finite, and within ± `LARGEST`."""
    credible: BoolArray = np.abs(values) <= LARGEST
    return credible


@dataclass(frozen=True, kw_only=True)
class FrameEstimate:
    """A solver's answer for one frame; ``None`` = not reported.

    Parameters
    ----------
    pose : [3] (x, y, yaw) in m and rad.
    positions : [K, 2] in m, for every observed track; the rest is ignored.
    fallback : whether fewer than two people were usable, so that the observer's own prior decided the pose.
    converged : whether the solver considers its optimum found; False warns that the pose may be far off.
    pose_covariance : [3, 3] of (x, y, yaw), in m², m·rad and rad².
    position_covariances : [K, 2, 2] of world positions, in m².
    heights, height_variances : [K] current estimates of people's heights, in m and m².
    """

    pose: FloatArray
    positions: FloatArray
    fallback: bool | None = None
    converged: bool | None = None
    pose_covariance: FloatArray | None = None
    position_covariances: FloatArray | None = None
    heights: FloatArray | None = None
    height_variances: FloatArray | None = None

    def __post_init__(self) -> None:
        freeze(self, pose=(3,), positions=(None, 2))
        people = len(self.positions)
        _freeze_reported(self, pose_covariance=(3, 3), position_covariances=(people, 2, 2))
        _freeze_reported(self, heights=(people,), height_variances=(people,))


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A solver's answer for a whole sequence; ``None`` = not reported.

    Parameters
    ----------
    poses : [T, 3] in m and rad.
    positions : [T, K, 2] in m.
    fallback, converged : [T] as in `FrameEstimate`.
    pose_covariances, position_covariances : [T, 3, 3] and [T, K, 2, 2], likewise; NaN = not reported for that frame.
    heights, height_variances : [K] final estimates of people's heights, in m and m².
    """

    poses: FloatArray
    positions: FloatArray
    fallback: BoolArray | None = None
    converged: BoolArray | None = None
    pose_covariances: FloatArray | None = None
    position_covariances: FloatArray | None = None
    heights: FloatArray | None = None
    height_variances: FloatArray | None = None

    def __post_init__(self) -> None:
        freeze(self, poses=(None, 3))
        frames = len(self.poses)
        freeze(self, positions=(frames, None, 2))
        people = self.positions.shape[1]
        _freeze_reported(self, pose_covariances=(frames, 3, 3), position_covariances=(frames, people, 2, 2))
        _freeze_reported(self, heights=(people,), height_variances=(people,))
        _freeze_reported(self, np.bool_, fallback=(frames,), converged=(frames,))

    @staticmethod
    def of_frames(frames: Sequence[FrameEstimate]) -> "Estimate":
        """Stack the answers of consecutive frames; the heights are those reported last."""
        last = next((frame for frame in reversed(frames) if frame.heights is not None), frames[-1])
        return Estimate(
            poses=np.stack([frame.pose for frame in frames]),
            positions=np.stack([frame.positions for frame in frames]),
            fallback=_marks([frame.fallback for frame in frames]),
            converged=_marks([frame.converged for frame in frames]),
            pose_covariances=_stack([frame.pose_covariance for frame in frames]),
            position_covariances=_stack([frame.position_covariances for frame in frames]),
            heights=last.heights,
            height_variances=last.height_variances,
        )

    def frame(self, t: int) -> FrameEstimate:
        """The answer for frame ``t``, with the final heights."""
        return FrameEstimate(
            pose=self.poses[t],
            positions=self.positions[t],
            fallback=None if self.fallback is None else bool(self.fallback[t]),
            converged=None if self.converged is None else bool(self.converged[t]),
            pose_covariance=None if self.pose_covariances is None else self.pose_covariances[t],
            position_covariances=None if self.position_covariances is None else self.position_covariances[t],
            heights=self.heights,
            height_variances=self.height_variances,
        )


Answer = TypeVar("Answer", FrameEstimate, Estimate)


def copy_of(answer: Answer) -> Answer:
    """The same answer in its own memory: whatever its solver writes into its arrays later changes nothing."""
    kind = FrameEstimate if isinstance(answer, FrameEstimate) else Estimate
    values: dict[str, Any] = {field.name: getattr(answer, field.name) for field in fields(kind)}
    own: dict[str, Any] = {
        name: value.copy() if isinstance(value, np.ndarray) else value for name, value in values.items()
    }
    return kind(**own)


def _freeze_reported(
    answer: FrameEstimate | Estimate, dtype: type[Any] = np.float64, **shapes: tuple[int | None, ...]
) -> None:
    """`freeze` those of the named fields that are reported."""
    freeze(answer, dtype, **{name: shape for name, shape in shapes.items() if getattr(answer, name) is not None})


def _marks(frames: list[bool | None]) -> BoolArray | None:
    """Flags of consecutive frames, False for a frame without one; ``None`` if no frame has one."""
    return None if all(mark is None for mark in frames) else np.array(frames, dtype=np.bool_)


def _stack(frames: list[FloatArray | None]) -> FloatArray | None:
    """Stacked arrays of consecutive frames, NaN for a frame without one; ``None`` if no frame has one."""
    known = next((array for array in frames if array is not None), None)
    if known is None:
        return None
    nothing = np.full(known.shape, np.nan)
    return np.stack([nothing if array is None else array for array in frames])
