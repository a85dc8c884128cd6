"""How likely the observer is to be anywhere else: the energy of `vbbench_baselines.ego_motion` as a function of place.

With the origin o at the place c itself, q = 0 and E(c, R) = mᵀAm − 2gᵀm + const.; the yaw of least energy at c is found
as there. The people's places are eliminated already. E is a sum of squared, normalised errors, so −ln p = E/2.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.ego_motion import VAGUE, invert, least_angle


@kernel
def location_energies(
    places: FloatArray,
    relative: FloatArray,
    covariance: FloatArray,
    expected: FloatArray,
    std: FloatArray,
    predicted: FloatArray,
    ego_std: float,
) -> FloatArray:
    """−ln p of the observer at each of the places [N, 2] in m, up to a constant; the rest as in `fit_pose`."""
    energies = np.empty(len(places))
    information = max(1.0 / ego_std**2, VAGUE)
    for n in range(len(places)):
        cc, cs, ss, g_c, g_s = 0.0, 0.0, 0.0, VAGUE * np.cos(predicted[2]), VAGUE * np.sin(predicted[2])
        for k in range(len(std)):
            if np.isnan(std[k]) or np.isnan(relative[k, 0]):
                continue
            v = std[k] ** 2
            rr, rf, ff = invert(covariance[k, 0] + v, covariance[k, 1], covariance[k, 2] + v)
            x, y = expected[k, 0] - places[n, 0], expected[k, 1] - places[n, 1]
            # W D with D = [[−y, x], [x, y]], and W z
            rc, rs, fc, fs = rf * x - rr * y, rr * x + rf * y, ff * x - rf * y, rf * x + ff * y
            zr, zf = rr * relative[k, 0] + rf * relative[k, 1], rf * relative[k, 0] + ff * relative[k, 1]
            cc, cs, ss = cc + x * fc - y * rc, cs + x * fs - y * rs, ss + x * rs + y * fs
            g_c, g_s = g_c + x * zf - y * zr, g_s + x * zr + y * zf
        yaw = least_angle((cc, cs, ss), (g_c, g_s))
        cos, sin = np.cos(yaw), np.sin(yaw)
        moved = (places[n, 0] - predicted[0]) ** 2 + (places[n, 1] - predicted[1]) ** 2
        turned = cc * cos * cos + 2.0 * cs * cos * sin + ss * sin * sin - 2.0 * (g_c * cos + g_s * sin)
        energies[n] = 0.5 * (turned + information * moved)
    return energies
