"""Smooths tracks on the ground: Kalman filter and Rauch–Tung–Striebel smoother, one coordinate at a time.

State: position and velocity under white-noise acceleration of density q (Y. Bar-Shalom, X. R. Li, T. Kirubarajan,
Estimation with Applications to Tracking and Navigation, 2001, section 6.2). Frames without a box are predicted over.
"""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel

_FIRST_SPEED_STD = 5.0
"""Standard deviation in m/s of a velocity of which nothing is known yet."""


def smooth(value: FloatArray, variance: FloatArray, row: IntArray, starts: IntArray, q: float, dt: float) -> FloatArray:
    """Smoothed coordinate [M], gaps filled.

    Parameters
    ----------
    value, variance : [N] measured coordinate and variance of its noise, in m and m².
    row : [N] where in the result each stands; ascending.
    starts : [K + 1] where each piece of a track begins in the result; the last is M. Pieces begin and end with a box.
    q : density of acceleration in m²/s³.
    dt : seconds a frame.
    """
    total = int(starts[-1])
    known = np.full(total, np.nan)
    noise = np.zeros(total)
    known[row], noise[row] = value, variance
    return _smooth(known, noise, starts, q, dt)


@kernel
def _smooth(known: FloatArray, noise: FloatArray, starts: IntArray, q: float, dt: float) -> FloatArray:
    result = np.empty(len(known))
    state = np.empty((len(known), 5))
    for k in range(len(starts) - 1):
        _filter(known, noise, state, starts[k], starts[k + 1], q, dt)
        _smooth_back(state, result, starts[k], starts[k + 1], q, dt)
    return result


@kernel
def _filter(known: FloatArray, noise: FloatArray, state: FloatArray, first: int, end: int, q: float, dt: float) -> None:
    """Position, velocity and their variances (pp, pv, vv) after each frame's measurement."""
    x, v, pp, pv, vv = known[first], 0.0, noise[first], 0.0, _FIRST_SPEED_STD**2
    for t in range(first, end):
        if t > first:
            x += dt * v
            pp += dt * (2.0 * pv + dt * vv) + q * dt**3 / 3.0
            pv += dt * vv + q * dt**2 / 2.0
            vv += q * dt
            if not np.isnan(known[t]):
                total = pp + noise[t]
                surprise = known[t] - x
                x += pp / total * surprise
                v += pv / total * surprise
                vv -= pv * pv / total
                pv *= noise[t] / total
                pp *= noise[t] / total
        state[t, 0], state[t, 1], state[t, 2], state[t, 3], state[t, 4] = x, v, pp, pv, vv


@kernel
def _smooth_back(state: FloatArray, result: FloatArray, first: int, end: int, q: float, dt: float) -> None:
    """Rauch–Tung–Striebel recursion of the means."""
    x, v = state[end - 1, 0], state[end - 1, 1]
    result[end - 1] = x
    for t in range(end - 2, first - 1, -1):
        m, w, pp, pv, vv = state[t]
        app = pp + dt * (2.0 * pv + dt * vv) + q * dt**3 / 3.0
        apv = pv + dt * vv + q * dt**2 / 2.0
        avv = vv + q * dt
        determinant = app * avv - apv * apv
        dx, dv = x - (m + dt * w), v - w
        a = (avv * dx - apv * dv) / determinant
        b = (app * dv - apv * dx) / determinant
        x = m + (pp + dt * pv) * a + pv * b
        v = w + (pv + dt * vv) * a + vv * b
        result[t] = x
