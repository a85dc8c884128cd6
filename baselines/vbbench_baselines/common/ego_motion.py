"""Ego-motion: the observer's pose as the exact minimiser of its energy, and people's positions once it is known.

People are expected at p_k with variance σ_k² and measured at z_k in the camera's frame with covariance N_k. The
energy of a pose (c, R) and the people's positions x_k,

    Σ_k ‖x_k − p_k‖²/σ_k² + (z_k − Rᵀ(x_k − c))ᵀ N_k⁻¹ (z_k − Rᵀ(x_k − c)),

is least over the x_k, that is with the people's own places (their depths among them) eliminated, at

    E(c, R) = Σ_k r_kᵀ W_k r_k,   r_k = z_k + Rᵀ(c − p_k),   W_k = (σ_k² I + N_k)⁻¹,

because a sum of two independent normal errors has the sum of their covariances and σ_k² I does not turn with R. This is
E_c of arXiv 2111.05060, section IV-B, for normal factors. The observer is one more person with z = 0 and N = 0.

With m = (cos yaw, sin yaw), q = −Rᵀ(c − o) and d_k = p_k − o about any origin o, r_k = z_k − q − D_k m is linear in q
and m; eliminating q leaves mᵀAm − 2gᵀm on the unit circle, a trigonometric polynomial of degree two, whose global
minimum one scan and Newton's method find. With every W_k a multiple of I, A is one too, and yaw = atan2(g_2, g_1) is
the weighted rigid (Procrustes) fit. The people are summed over once.

With the origin o at any other place c, q = 0 and E(c, R) = mᵀAm − 2gᵀm + const.: how likely the observer is to be there
instead, its yaw minimised out. E is a sum of squared, normalised errors, so −ln p = E/2.
"""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench.kernels import kernel

VAGUE = 1e-6
"""Information (1/m² and 1/rad²) that holds the pose at its prediction where people say nothing about it."""

Symmetric = tuple[float, float, float]
"""A symmetric matrix as (cc, cs, ss) over m = (cos yaw, sin yaw)."""

Vector = tuple[float, float]
"""A vector over m."""

SCAN = 32
"""Yaws at which Newton's method looks for a start; a polynomial of degree two has at most two minima on the circle."""


class Factors(NamedTuple):
    """The terms of a frame's energy, as the kernels take them.

    Attributes
    ----------
    relative : [K, 2] measured (right, forward) in m, NaN = not observed.
    covariance : [K, 3] its covariance (rr, rf, ff) in m².
    expected, std : [K, 2] and [K] where people are expected, in m, NaN = unknown.
    walk, walk_std : [3] the observer's own predicted pose and the standard deviation in m of its place, inf for no
        such prior.
    """

    relative: FloatArray
    covariance: FloatArray
    expected: FloatArray
    std: FloatArray
    walk: FloatArray
    walk_std: float

    def of(self, chosen: BoolArray) -> "Factors":
        """The terms of the ``chosen`` people [K] and the observer."""
        relative, covariance, expected, std = (rows[chosen] for rows in self[:4])
        return Factors(relative, covariance, expected, std, self.walk, self.walk_std)

    @property
    def helpful(self) -> BoolArray:
        """[K] who is observed and expected."""
        return ~np.isnan(self.std + self.relative[:, 0])

    def spread(self, times: float) -> "Factors":
        """The same terms with standard deviations of motion that many times as large."""
        return self._replace(std=self.std * times, walk_std=self.walk_std * times)


@kernel
def fit_pose(factors: Factors, yaw_information: float = VAGUE) -> FloatArray:
    """The pose (x, y, yaw) of least energy.

    ``yaw_information`` in 1/rad² is that of the predicted yaw; as 2(1 − cos d) for d², a multiple of the polynomial's
    own terms.
    """
    walk, information = factors.walk, max(1.0 / factors.walk_std**2, VAGUE)
    s, (wz_r, wz_f), (wd_rc, wd_rs, wd_fc, wd_fs), a, g = _sums(factors, walk[0], walk[1], information, (0.0, 0.0))
    rr, rf, ff = invert(*s)
    # A less (Σ W D)ᵀ S⁻¹ (Σ W D), g less (Σ W D)ᵀ S⁻¹ (Σ W z)
    c_r, c_f = wd_rc * rr + wd_fc * rf, wd_rc * rf + wd_fc * ff
    s_r, s_f = wd_rs * rr + wd_fs * rf, wd_rs * rf + wd_fs * ff
    a_cc = a[0] - c_r * wd_rc - c_f * wd_fc
    a_cs = a[1] - c_r * wd_rs - c_f * wd_fs
    a_ss = a[2] - s_r * wd_rs - s_f * wd_fs
    g_c = g[0] - (c_r * wz_r + c_f * wz_f) + yaw_information * np.cos(walk[2])
    g_s = g[1] - (s_r * wz_r + s_f * wz_f) + yaw_information * np.sin(walk[2])
    yaw = least_angle((a_cc, a_cs, a_ss), (g_c, g_s))
    sin, cos = np.sin(yaw), np.cos(yaw)
    off_r, off_f = wz_r - (wd_rc * cos + wd_rs * sin), wz_f - (wd_fc * cos + wd_fs * sin)
    q_r, q_f = rr * off_r + rf * off_f, rf * off_r + ff * off_f
    pose = np.empty(3)
    pose[0], pose[1], pose[2] = walk[0] - sin * q_r - cos * q_f, walk[1] + cos * q_r - sin * q_f, yaw
    return pose


@kernel
def location_energies(places: FloatArray, factors: Factors) -> FloatArray:
    """−ln p of the observer at each of the places [N, 2] in m, up to a constant."""
    energies = np.empty(len(places))
    walk, information = factors.walk, max(1.0 / factors.walk_std**2, VAGUE)
    for n in range(len(places)):
        start = VAGUE * np.cos(walk[2]), VAGUE * np.sin(walk[2])
        _, _, _, a, g = _sums(factors, places[n, 0], places[n, 1], 0.0, start)
        moved = (places[n, 0] - walk[0]) ** 2 + (places[n, 1] - walk[1]) ** 2
        energies[n] = 0.5 * (_energy(a, g, least_angle(a, g)) + information * moved)
    return energies


@kernel
def _sums(
    factors: Factors, x: float, y: float, information: float, start: Vector
) -> tuple[Symmetric, Vector, tuple[float, float, float, float], Symmetric, Vector]:
    """S = Σ W, Σ W z, Σ W D, Σ Dᵀ W D and Σ Dᵀ W z about the origin (x, y).

    The first begins with ``information`` on the place, the last with ``start``.
    """
    relative, covariance, std = factors.relative, factors.covariance, factors.std
    s_rr, s_rf, s_ff = information, 0.0, information
    wz_r, wz_f = 0.0, 0.0
    wd_rc, wd_rs, wd_fc, wd_fs = 0.0, 0.0, 0.0, 0.0
    a_cc, a_cs, a_ss, (g_c, g_s) = 0.0, 0.0, 0.0, start
    for k in range(len(std)):
        if np.isnan(std[k]) or np.isnan(relative[k, 0]):
            continue
        v = std[k] ** 2
        rr, rf, ff = invert(covariance[k, 0] + v, covariance[k, 1], covariance[k, 2] + v)
        dx, dy = factors.expected[k, 0] - x, factors.expected[k, 1] - y
        zr, zf = rr * relative[k, 0] + rf * relative[k, 1], rf * relative[k, 0] + ff * relative[k, 1]
        # D = [[−dy, dx], [dx, dy]], W D = [[rc, rs], [fc, fs]]
        rc, rs, fc, fs = rf * dx - rr * dy, rr * dx + rf * dy, ff * dx - rf * dy, rf * dx + ff * dy
        s_rr, s_rf, s_ff = s_rr + rr, s_rf + rf, s_ff + ff
        wz_r, wz_f = wz_r + zr, wz_f + zf
        wd_rc, wd_rs, wd_fc, wd_fs = wd_rc + rc, wd_rs + rs, wd_fc + fc, wd_fs + fs
        a_cc, a_cs, a_ss = a_cc + dx * fc - dy * rc, a_cs + dx * fs - dy * rs, a_ss + dx * rs + dy * fs
        g_c, g_s = g_c + dx * zf - dy * zr, g_s + dx * zr + dy * zf
    return (s_rr, s_rf, s_ff), (wz_r, wz_f), (wd_rc, wd_rs, wd_fc, wd_fs), (a_cc, a_cs, a_ss), (g_c, g_s)


@kernel
def localise(pose: FloatArray, factors: Factors) -> FloatArray:
    """World positions [K, 2] in m of least energy given the pose [3], the same as a Kalman update; NaN = not observed.

    Rᵀ(x_k − c) = e_k + σ_k² (σ_k² I + N_k)⁻¹ (z_k − e_k),   e_k = Rᵀ(p_k − c).

    With N_k → 0 a person stands on its ray where its height says; without expectation the measurement is all there is.
    """
    relative, covariance, expected, std = factors.relative, factors.covariance, factors.expected, factors.std
    people = len(std)
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    positions = np.empty((people, 2))
    for k in range(people):
        right, forward = relative[k, 0], relative[k, 1]
        if not np.isnan(std[k]):
            dx, dy = expected[k, 0] - pose[0], expected[k, 1] - pose[1]
            e_r, e_f = dx * sin - dy * cos, dx * cos + dy * sin
            v = std[k] ** 2
            rr, rf, ff = invert(covariance[k, 0] + v, covariance[k, 1], covariance[k, 2] + v)
            d_r, d_f = right - e_r, forward - e_f
            right, forward = e_r + v * (rr * d_r + rf * d_f), e_f + v * (rf * d_r + ff * d_f)
        positions[k, 0] = pose[0] + right * sin + forward * cos
        positions[k, 1] = pose[1] - right * cos + forward * sin
    return positions


@kernel
def invert(rr: float, rf: float, ff: float) -> tuple[float, float, float]:
    """Inverse of the symmetric matrix [[rr, rf], [rf, ff]], in the same three numbers."""
    determinant = rr * ff - rf * rf
    return ff / determinant, -rf / determinant, rr / determinant


@kernel
def wrapped(angle: float) -> float:
    """The angle in rad wrapped to [−π, π), as by `vbbench.geometry.wrap_angle`."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi


@kernel
def least_angle(a: Symmetric, g: Vector) -> float:
    """The angle in [−π, π) at which mᵀAm − 2gᵀm, m = (cos, sin), is least over the whole circle; A as (cc, cs, ss).

    Newton's method from every low of the scan: the deepest valley may be too narrow for the scan to tell.
    """
    step = 2.0 * np.pi / SCAN
    values = np.empty(SCAN)
    for i in range(SCAN):
        values[i] = _energy(a, g, i * step)
    best, least = 0.0, np.inf
    for i in range(SCAN):
        if values[i] <= values[i - 1] and values[i] <= values[(i + 1) % SCAN]:
            angle = _descend(a, g, i * step, step)
            value = _energy(a, g, angle)
            if value < least:
                best, least = angle, value
    return wrapped(best)


@kernel
def _descend(a: Symmetric, g: Vector, angle: float, reach: float) -> float:
    """Newton's method downhill from ``angle``, in moves of at most ``reach`` rad."""
    for _ in range(50):
        slope, curvature = _derivatives(a, g, angle)
        move = -slope / max(abs(curvature), abs(slope) / reach, 1e-300)
        while abs(move) > 1e-7 and _energy(a, g, angle + move) > _energy(a, g, angle):
            move *= 0.5
        angle += move
        if abs(move) < 1e-13:
            break
    return angle


@kernel
def _energy(a: Symmetric, g: Vector, angle: float) -> float:
    cos, sin = np.cos(angle), np.sin(angle)
    return float(a[0] * cos * cos + 2.0 * a[1] * cos * sin + a[2] * sin * sin - 2.0 * (g[0] * cos + g[1] * sin))


@kernel
def _derivatives(a: Symmetric, g: Vector, angle: float) -> tuple[float, float]:
    cos, sin = np.cos(angle), np.sin(angle)
    cos2, sin2 = cos * cos - sin * sin, 2.0 * sin * cos
    spread = a[2] - a[0]
    slope = spread * sin2 + 2.0 * a[1] * cos2 + 2.0 * (g[0] * sin - g[1] * cos)
    curvature = 2.0 * spread * cos2 - 4.0 * a[1] * sin2 + 2.0 * (g[0] * cos + g[1] * sin)
    return slope, curvature
