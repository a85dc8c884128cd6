"""How far an estimated way drifts from the true one over a distance: relative errors of segments of it.

As KITTI's odometry benchmark measures (Geiger, Lenz, Urtasun, CVPR 2012; ``evaluate_odometry`` of its devkit, there
with 100 to 800 m): from every frame i to the first frame j by which the camera has gone L m along the true way,

    shift = ‖(x_j − x_i)^ − (x_j − x_i)*‖ / L, in the axes of frame i;   turn = |wrap((ψ_j − ψ_i)^ − (ψ_j − ψ_i)*)| / L

with places x, yaws ψ, estimates ^ and truth *. Where the map lies, and how it is turned, does not count.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, motion_between, wrap_angle
from vbbench.sequence import Odometry

TABLE_LENGTHS = (5.0, 10.0, 20.0, 40.0)
"""m of the table's columns."""
LENGTHS = tuple(float(length) for length in range(5, 45, 5))
"""m of the curve's points."""


@dataclass(frozen=True, kw_only=True)
class Drift:
    """Errors of all segments of one length.

    Parameters
    ----------
    length : of a segment, in m.
    shift : [N] where it ends, off the truth by so much of its length.
    turn : [N] how it ends turned, off the truth in rad for each m.
    """

    length: float
    shift: FloatArray
    turn: FloatArray

    def quantile(self, share: float) -> float:
        """Of the ``shift``; NaN without segments."""
        return float(np.quantile(self.shift, share)) if len(self.shift) else float("nan")

    @property
    def mean(self) -> float:
        """Of the ``shift``; NaN without segments."""
        return float(self.shift.mean()) if len(self.shift) else float("nan")

    def to_dict(self) -> dict[str, float | int | None]:
        """Its figures, with ``None`` for NaN, as JSON needs it."""
        known = bool(len(self.shift))
        return {
            "length": self.length,
            "segments": len(self.shift),
            "mean": self.mean if known else None,
            "quartile": self.quantile(0.25) if known else None,
            "median": self.quantile(0.5) if known else None,
            "upper_quartile": self.quantile(0.75) if known else None,
            "turn_mean": float(self.turn.mean()) if known else None,
        }


def distances(poses: FloatArray) -> FloatArray:
    """[T] metres driven since frame 0, by poses [T, 3]."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def drift(pairs: list[tuple[FloatArray, FloatArray]], length: float) -> Drift:
    """The errors of all segments of ``length`` m.

    Parameters
    ----------
    pairs : of each sequence, the estimated and the true poses [T, 3] (x, y, yaw); NaN where nothing was estimated.
    """
    errors = np.concatenate([np.empty((0, 2)), *(_segments(*pair, length) for pair in pairs)])
    return Drift(length=length, shift=errors[:, 0], turn=errors[:, 1])


def _segments(estimate: FloatArray, truth: FloatArray, length: float) -> FloatArray:
    """[N, 2] shift and turn by ``length`` of each segment of one sequence."""
    way = distances(truth)
    first = np.arange(len(way))
    last = np.searchsorted(way, way + length)
    known = last < len(way)
    first, last = first[known], last[known]
    off: FloatArray = motion_between(estimate[first], estimate[last]) - motion_between(truth[first], truth[last])
    errors = np.stack([np.hypot(off[:, 0], off[:, 1]), np.abs(wrap_angle(off[:, 2]))], axis=-1) / length
    kept: FloatArray = errors[np.isfinite(errors).all(axis=1)]
    return kept


def dead_reckoning(odometry: Odometry, start: FloatArray) -> FloatArray:
    """[T, 3] the poses that measured motions lead to from the pose ``start`` [3]; NaN after one that is missing."""
    moved = np.array(odometry.motions)
    moved[0] = 0.0
    yaw = start[2] + np.cumsum(moved[:, 2])
    before = np.concatenate([[start[2]], yaw[:-1]])
    forward, left, cos, sin = moved[:, 0], moved[:, 1], np.cos(before), np.sin(before)
    x, y = np.cumsum(cos * forward - sin * left), np.cumsum(sin * forward + cos * left)
    return np.stack([start[0] + x, start[1] + y, wrap_angle(yaw)], axis=-1)
