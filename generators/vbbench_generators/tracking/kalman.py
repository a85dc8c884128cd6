"""What a tracker believes of its boxes: a constant-velocity Kalman filter on centre, width and height.

The filter of SORT (Bewley et al. 2016) and its descendants: noise grows with the height of the box, and the four
coordinates do not mix, so that every one of them is a filter of its own on (value, speed):

    x ← F x,  P ← F P Fᵀ + diag(w² dt, a² dt),  F = (1 dt; 0 1);
    K = P Hᵀ/(P_00 + r²),  x ← x + K (z − x_0),  P ← P − K H P,  H = (1 0).
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_generators.tracking.settings import TrackerSettings


@dataclass(frozen=True)
class Beliefs:
    """What is believed of N boxes.

    Parameters
    ----------
    mean : [N, 4, 2] centre column, centre row, width and height in px, and their speeds in px/s.
    spread : [N, 4, 3] the covariances (P_00, P_01, P_11).
    """

    mean: FloatArray
    spread: FloatArray

    @property
    def boxes(self) -> FloatArray:
        """[N, 4] centre column, centre row, width and height in px."""
        return self.mean[..., 0]

    def take(self, rows: IntArray | BoolArray) -> "Beliefs":
        """Some of them."""
        return Beliefs(self.mean[rows], self.spread[rows])

    def join(self, others: "Beliefs") -> "Beliefs":
        """These and those behind them."""
        return Beliefs(np.concatenate([self.mean, others.mean]), np.concatenate([self.spread, others.spread]))


def begin(boxes: FloatArray, settings: TrackerSettings) -> Beliefs:
    """New beliefs of boxes [N, 4] seen for the first time."""
    height = boxes[:, 3:]
    mean = np.stack([boxes, np.zeros_like(boxes)], axis=-1)
    place, speed = (2.0 * settings.measurement * height) ** 2, (settings.start_speed * height) ** 2
    spread = np.stack([place, np.zeros_like(place), speed], axis=-1)
    return Beliefs(mean, np.broadcast_to(spread, (*boxes.shape, 3)).copy())


def predict(beliefs: Beliefs, dt: float, settings: TrackerSettings) -> Beliefs:
    """The beliefs ``dt`` seconds later."""
    (value, speed), (p, q, s) = np.moveaxis(beliefs.mean, -1, 0), np.moveaxis(beliefs.spread, -1, 0)
    height = np.maximum(beliefs.boxes[:, 3:], 1.0)
    place, pace = (settings.wander * height) ** 2 * dt, (settings.acceleration * height) ** 2 * dt
    mean = np.stack([value + dt * speed, speed], axis=-1)
    return Beliefs(mean, np.stack([p + dt * (2.0 * q + dt * s) + place, q + dt * s, s + pace], axis=-1))


def correct(beliefs: Beliefs, boxes: FloatArray, settings: TrackerSettings, period: float | None) -> Beliefs:
    """The beliefs after boxes [N, 4] were seen; ``period`` is the width of a picture that closes on itself."""
    (value, speed), (p, q, s) = np.moveaxis(beliefs.mean, -1, 0), np.moveaxis(beliefs.spread, -1, 0)
    height = np.maximum(beliefs.boxes[:, 3:], 1.0)
    total = p + (settings.measurement * height) ** 2
    surprise = boxes - value
    if period is not None:
        surprise[:, 0] -= period * np.round(surprise[:, 0] / period)
    mean = np.stack([value + p / total * surprise, speed + q / total * surprise], axis=-1)
    return Beliefs(mean, np.stack([p - p * p / total, q - p * q / total, s - q * q / total], axis=-1))
