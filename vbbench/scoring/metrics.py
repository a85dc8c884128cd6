"""The table of metrics, and the errors behind them, in m and rad. No alignment is ever applied.

x0 is the observer's ground-plane position, x_k a person's, * marks truth (DESIGN section 6, after arXiv 2111.05060).
All functions are pure, take any leading shape and map NaN to NaN.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vbbench.estimate import is_credible
from vbbench.files.dataset_checks import Known
from vbbench.geometry import BoolArray, FloatArray, motion_between, wrap_angle

FEWEST = 5
"""Answers that are enough to see it."""
LEFT = 0.3
"""Most of the error that is left when answers are read so, as a share of it, and of how far the true values differ."""

Change = Callable[[FloatArray], FloatArray]
YAWS: dict[str, tuple[str, Change]] = {
    "in degrees": ("rad", np.radians),
    "the paper's θ_z": ("yaw, which is π/2 − θ_z", lambda yaw: 0.5 * np.pi - yaw),
    "clockwise": ("it counterclockwise, as −yaw", lambda yaw: -yaw),
    "counted from y": ("it from x, as yaw + π/2", lambda yaw: yaw + 0.5 * np.pi),
}
PLACES: dict[str, tuple[str, Change]] = {
    "in cm": ("m", lambda places: 0.01 * places),
    "in mm": ("m", lambda places: 0.001 * places),
    "in feet": ("m", lambda places: 0.3048 * places),
    "left-handed": ("−y in place of y", lambda places: places * [1.0, -1.0]),
    "y before x": ("x before y", lambda places: places[:, ::-1]),
}
"""What answers may be in place of what they should be, and how to read them so."""


def other_readings(
    poses: FloatArray, places: FloatArray, like: tuple[FloatArray, FloatArray], *, early: bool = False
) -> Iterator[str]:
    """Probable errors of unit or axes in poses [P, 3] and places [Q, 2] of people, a line each.

    Parameters
    ----------
    poses, places : the answers, which should be in m and rad; NaN = none.
    like : reference values: the truth, or the last given ones.
    early : whether they are of the first frames only, in which no camera turns around.
    """
    yield from _readings("yaw", poses[:, 2], like[0][:, 2], YAWS, early)
    yield from _readings("place of poses", poses[:, :2], like[0][:, :2], PLACES)
    yield from _readings("place of people", places, like[1], PLACES)


def _readings(
    what: str, values: FloatArray, like: FloatArray, changes: dict[str, tuple[str, Change]], early: bool = False
) -> Iterator[str]:
    """A line for each change that brings values [N] or [N, 2] close to the reference ``like``."""
    known = is_credible(np.column_stack([values, like])).all(axis=1)
    if known.sum() < FEWEST:
        return
    values, like = values[known], like[known]
    turning = values.ndim == 1
    middle = np.angle(np.exp(1j * like).mean()) if turning else np.median(like, axis=0)
    given, spread = _apart(values, like), _apart(np.broadcast_to(middle, like.shape), like)
    if early and np.median(np.abs(values)) > 2.0 * np.pi:
        spread = np.inf
    for name, (advice, change) in changes.items():
        left, unit = _apart(change(values), like), "rad" if turning else "m"
        if left < LEFT * min(given, spread):
            off = f"so it is off by {left:.2g} {unit} (median), otherwise by {given:.2g} {unit}"
            yield f"{what} seems to be {name}: {off}; write {advice}"
            return


def _apart(values: FloatArray, like: FloatArray) -> float:
    """The median distance of angles [N] or places [N, 2] from others."""
    off = np.abs(wrap_angle(values - like)) if values.ndim == 1 else np.linalg.norm(values - like, axis=-1)
    return float(np.median(off))


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
    symbol, name, unit : symbol in tables and plots, name in words, and unit.
    meaning : explanation for readers of a leaderboard.
    over : the mean's domain, and so the arguments of ``function``: for ``frames`` poses and true poses; for ``people``
        positions, the observer's poses, and the true ones of both; for ``seconds`` the poses at both ends of about a
        second, the true ones of both, and the time between in s.
    function : the errors, one per frame, person in a frame, or second.
    without_poses : whether a metric of people is defined if true positions are known relative to the camera only.
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
        """The kinds of truth for which this metric is defined."""
        if self.over != "people":
            return ("whole", "poses")
        return ("whole", "relative") if self.without_poses else ("whole",)

    @property
    def label(self) -> str:
        """Symbol and unit, for the head of a column or an axis."""
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
    counted : [..., K] mask of people in the means; those without estimate or true position are skipped.
    """
    rows = {
        "frames": (poses, true_poses),
        "people": (positions, poses[..., None, :], true_positions, true_poses[..., None, :]),
    }
    errors = {name: metric.function(*rows[metric.over]) for name, metric in METRICS.items() if metric.over in rows}
    return {name: _mean(e, counted) if METRICS[name].over == "people" else e for name, e in errors.items()}


def _mean(values: FloatArray, counted: BoolArray) -> FloatArray:
    """Mean over the last axis of the finite values that count, NaN without any."""
    use = counted & np.isfinite(values)
    total, number = np.where(use, values, 0.0).sum(axis=-1), use.sum(axis=-1)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)
