"""Where one box alone puts somebody of whom nothing else is known, and how far off that may be."""

import numpy as np

from vbbench.geometry import FloatArray

ALONG, ACROSS = 0.12, 0.02
"""Standard deviations along the ray and across it, as shares of the distance."""


def places_alone(azimuth: FloatArray, length: FloatArray, person: FloatArray) -> FloatArray:
    """[M, 2] in m to the right and forward of boxes [M] (`bearings`) of people with the numbers ``person`` [2]."""
    reach = np.exp(person[0]) / length + person[1]
    return np.asarray(reach[:, None] * np.column_stack((np.sin(azimuth), np.cos(azimuth))))


def spread_alone(places: FloatArray) -> FloatArray:
    """[M, 3] covariances (rr, rf, ff) in m² of such ``places`` [M, 2]."""
    right, forward = places[:, 0], places[:, 1]
    along, across = ALONG**2, ACROSS**2
    return np.column_stack(
        (
            along * right**2 + across * forward**2,
            (along - across) * right * forward,
            along * forward**2 + across * right**2,
        )
    )
