"""What kernels see of crowds and models: rows of plain arrays, and one record of numbers."""

import numpy as np

X, Y, VX, VY, TARGET_X, TARGET_Y, TARGET_DISTANCE = range(7)
"""Rows of ``people`` [7, K]: place (m), velocity (m/s), unit vector to the current goal, distance (m) from it."""

PEOPLE_ROWS = 7

PAIRS = 1024
"""Pairs whose forces are computed at a time: few enough for the processor's first cache."""

SETTINGS = np.dtype(
    [
        ("kind", np.int64),
        ("desired_factor", np.float64),
        ("relaxation_time", np.float64),
        ("top_speed", np.float64),
        ("arrival_radius", np.float64),
        ("factor", np.float64),
        ("velocity_weight", np.float64),
        ("reach", np.float64),
        ("side_sharpness", np.float64),
        ("brake_sharpness", np.float64),
        ("fall_off", np.float64),
        ("stride_time", np.float64),
        ("view_cosine", np.float64),
        ("unseen_weight", np.float64),
        ("wall_factor", np.float64),
        ("wall_fall_off", np.float64),
        ("wall_reach", np.float64),
        ("body_radius", np.float64),
        ("cohesion", np.float64),
        ("gaze", np.float64),
        ("separation", np.float64),
        ("personal_space", np.float64),
    ]
)
"""A `Model` as kernels read it; lengths in m, times in s."""

MOUSSAID, HELBING_MOLNAR, PYSOCIALFORCE = range(3)
"""The kinds of repulsion."""
