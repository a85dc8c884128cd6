"""Answers in other units or axes than the format's, found where they are nearly right once they are read so."""

from collections.abc import Callable, Iterator

import numpy as np

from vbbench.estimate import is_credible
from vbbench.geometry import FloatArray, wrap_angle

FEWEST = 5
"""Answers that are enough to see it."""
LEFT = 0.3
"""Most of the error that is left when answers are read so, as a share of it, and of how far the true values differ."""

Change = Callable[[FloatArray], FloatArray]
YAWS: dict[str, tuple[str, Change]] = {
    "in degrees": ("rad", np.radians),
    "the paper's θ_z": ("yaw, which is π/2 − θ_z", lambda yaw: 0.5 * np.pi - yaw),
}
PLACES: dict[str, tuple[str, Change]] = {
    "in cm": ("m", lambda places: 0.01 * places),
    "in mm": ("m", lambda places: 0.001 * places),
    "y before x": ("x before y", lambda places: places[:, ::-1]),
}
"""What answers may be in place of what they should be, and how to read them so."""


def other_readings(
    poses: FloatArray, places: FloatArray, like: tuple[FloatArray, FloatArray], *, early: bool = False
) -> Iterator[str]:
    """What poses [P, 3] and places [Q, 2] of people seem to be in, a line each.

    Parameters
    ----------
    poses, places : the answers, in m and rad as the format wants them; NaN = none.
    like : what they should be about: the truth, or the last ones given.
    early : whether they are of the first frames only, in which no camera turns around.
    """
    yield from _readings("yaw", poses[:, 2], like[0][:, 2], YAWS, early)
    yield from _readings("place of poses", poses[:, :2], like[0][:, :2], PLACES)
    yield from _readings("place of people", places, like[1], PLACES)


def _readings(
    what: str, values: FloatArray, like: FloatArray, changes: dict[str, tuple[str, Change]], early: bool = False
) -> Iterator[str]:
    """A line for each change after which values [N] or [N, 2] are nearly those they should be ``like``."""
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
