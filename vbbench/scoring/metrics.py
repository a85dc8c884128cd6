"""The table of metrics, and the errors behind them, in m and rad. No alignment is ever applied.

x0 is the observer's ground-plane position, x_k a person's, * marks truth (DESIGN section 6, after arXiv 2111.05060).
All functions are pure, take any leading shape and map NaN to NaN.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vbbench.files.dataset_checks import Known
from vbbench.geometry import BoolArray, FloatArray, motion_between, wrap_angle


def translation_error(poses: FloatArray, true_poses: FloatArray) -> FloatArray:
    """Δt = ‖x0 − x0*‖: poses [..., 3] (x, y, yaw) in m and rad → [...] in m."""
    return _distance(poses[..., :2], true_poses[..., :2])


def rotation_error(poses: FloatArray, true_poses: FloatArray) -> FloatArray:
    """Δr = |wrap(yaw − yaw*)|: poses [..., 3] → [...] in rad, within [0, π].

    For rotations of the plane this is arccos(½ tr(R R*ᵀ)); the paper prints the form for three dimensions.
    """
    return np.abs(wrap_angle(poses[..., 2] - true_poses[..., 2]))


def position_error(positions: FloatArray, true_positions: FloatArray) -> FloatArray:
    """‖x_k − x_k*‖ of each person: positions [..., 2] in m → [...] in m. Δx is its mean over people."""
    return _distance(positions, true_positions)


def relative_position_error(
    positions: FloatArray, poses: FloatArray, true_positions: FloatArray, true_poses: FloatArray
) -> FloatArray:
    """‖(x_k − x0) − (x_k* − x0*)‖ of each person, in world axes; Δx̃ is its mean over people.

    Parameters
    ----------
    positions, true_positions : [..., 2] in m.
    poses, true_poses : [..., 3] the observer's pose at the same instant, in m and rad.

    Returns
    -------
    [...] in m.
    """
    return _distance(positions - poses[..., :2], true_positions - true_poses[..., :2])


def motion_drift(
    start: FloatArray, end: FloatArray, true_start: FloatArray, true_end: FloatArray, seconds: float
) -> FloatArray:
    """Relative pose error per second, of the place: how far the estimated motion departs from the true one.

    With m = R(yaw_start)ᵀ (x0_end − x0_start), the motion in the frame of its start: ‖m − m*‖ / seconds.

    Parameters
    ----------
    start, end, true_start, true_end : poses [..., 3] in m and rad.
    seconds : time from start to end.

    Returns
    -------
    [...] in m/s.
    """
    return _distance(motion_between(start, end), motion_between(true_start, true_end)) / seconds


def turn_drift(
    start: FloatArray, end: FloatArray, true_start: FloatArray, true_end: FloatArray, seconds: float
) -> FloatArray:
    """Relative pose error per second, of the heading, in rad/s; parameters as in `motion_drift`.

    |wrap((yaw_end − yaw_start) − (yaw_end* − yaw_start*))| / seconds.
    """
    turn = (end[..., 2] - start[..., 2]) - (true_end[..., 2] - true_start[..., 2])
    return np.abs(wrap_angle(turn)) / seconds


def _distance(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.hypot(a[..., 0] - b[..., 0], a[..., 1] - b[..., 1])


@dataclass(frozen=True, kw_only=True)
class Metric:
    """A row of the table of metrics.

    Parameters
    ----------
    symbol, name, unit : how it is written in tables and beside curves, what it is in words, and its unit.
    meaning : for readers of a leaderboard.
    over : what it is the mean of, and so what ``function`` is called with: for ``frames`` poses and true poses; for
        ``people`` positions, the observer's poses, and the true ones of both; for ``seconds`` the poses at both ends of
        about a second, the true ones of both, and the time between.
    function : the errors, one per frame, person in a frame, or second.
    without_poses : of people, whether it holds where true positions are known relative to the camera only.
    """

    symbol: str
    name: str
    unit: str
    meaning: str
    over: Literal["frames", "people", "seconds"]
    function: Callable[..., FloatArray]
    without_poses: bool = False

    @property
    def known(self) -> tuple[Known, ...]:
        """What must be known of a dataset's truth for this metric."""
        if self.over != "people":
            return ("whole", "poses")
        return ("whole", "relative") if self.without_poses else ("whole",)

    def errors(self, *rows: FloatArray | float) -> FloatArray:
        """The errors of rows (see ``over``)."""
        return self.function(*rows)

    @property
    def label(self) -> str:
        """Symbol and unit, as the head of a column or an axis has them."""
        return f"{self.symbol} ({self.unit})"

    @property
    def section(self) -> Literal["metrics", "drift"]:
        """The part of a score's JSON that holds it."""
        return "drift" if self.over == "seconds" else "metrics"


METRICS: dict[str, Metric] = {
    "dx_rel": Metric(
        symbol="Δx̃",
        name="relative position",
        unit="m",
        meaning="How far people are from their true places as seen from the camera: the estimated camera is laid upon "
        "the true one, without turning it. Mean over people and frames of each sequence, then over sequences.",
        over="people",
        function=relative_position_error,
        without_poses=True,
    ),
    "dx": Metric(
        symbol="Δx",
        name="position",
        unit="m",
        meaning="How far people are from their true places in the world. Mean over people and frames of each sequence, "
        "then over sequences.",
        over="people",
        function=lambda positions, _poses, true_positions, _true_poses: position_error(positions, true_positions),
    ),
    "dr": Metric(
        symbol="Δr",
        name="heading",
        unit="rad",
        meaning="How far the camera's heading is turned from the true one. A hundredth of a radian is 0.6 degrees.",
        over="frames",
        function=rotation_error,
    ),
    "dt": Metric(
        symbol="Δt",
        name="camera",
        unit="m",
        meaning="How far the camera is from its true place in the world.",
        over="frames",
        function=translation_error,
    ),
    "drift_m": Metric(
        symbol="drift",
        name="drift",
        unit="m/s",
        meaning="How far the camera's estimated motion over one second departs from the true motion.",
        over="seconds",
        function=motion_drift,
    ),
    "drift_rad": Metric(
        symbol="drift",
        name="drift of heading",
        unit="rad/s",
        meaning="How far the estimated turn over one second departs from the true turn.",
        over="seconds",
        function=turn_drift,
    ),
}
"""Every metric by its key in files: score, compare, reports, pictures and boards have those of this table,
in its order, which is that of the paper's tables."""


def section(part: Literal["metrics", "drift"]) -> dict[str, Metric]:
    """The metrics of one part of a score's JSON."""
    return {name: metric for name, metric in METRICS.items() if metric.section == part}


def frame_errors(
    poses: FloatArray, positions: FloatArray, true_poses: FloatArray, true_positions: FloatArray, counted: BoolArray
) -> dict[str, FloatArray]:
    """Errors of each frame by metric, without drifts; NaN without an answer or without people who count.

    Parameters
    ----------
    poses, true_poses : [..., 3] in m and rad.
    positions, true_positions : [..., K, 2] in m.
    counted : [..., K] who counts in errors of people; of these, those with an estimate and a true position do.
    """
    rows = {
        "frames": (poses, true_poses),
        "people": (positions, poses[..., None, :], true_positions, true_poses[..., None, :]),
    }
    errors = {name: metric.errors(*rows[metric.over]) for name, metric in METRICS.items() if metric.over in rows}
    return {name: _mean(e, counted) if METRICS[name].over == "people" else e for name, e in errors.items()}


def _mean(values: FloatArray, counted: BoolArray) -> FloatArray:
    """Mean over the last axis of the finite values that count, NaN without any."""
    use = counted & np.isfinite(values)
    total, number = np.where(use, values, 0.0).sum(axis=-1), use.sum(axis=-1)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)
