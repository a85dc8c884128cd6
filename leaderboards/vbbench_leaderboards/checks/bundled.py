"""The solvers that come with vbbench: their names, and what boards say they are."""

REFERENCES = {
    "cv": "Constant-velocity extrapolation, bundled with vbbench (baseline CV of arXiv 2111.05060)",
    "sf": "Social-force extrapolation, bundled with vbbench (baseline SF of arXiv 2111.05060)",
    "vb-cv": "View birdification with constant velocity, bundled with vbbench "
    "(VB-CV of arXiv 2111.05060, with changes)",
    "vb-sf": "View birdification with the social force, bundled with vbbench (VB-SF of arXiv 2111.05060, with changes)",
    "ground-plane": "Distances by the heights of boxes, a rigid fit and Kalman filters, bundled with vbbench",
    "map-causal": "Joint maximum a posteriori over a sliding window, causal, bundled with vbbench",
    "map-batch": "Joint maximum a posteriori over whole sequences, bundled with vbbench",
    "vb-former": "Recurrent attention about a pose fit, learned from simulated crowds, bundled with vbbench",
}

SINGLE_PRECISION = ("vb-former",)
"""Solvers that count with 24 bits."""


def bundled_solvers() -> list[str]:
    """Names of the solvers that come with vbbench and stand on its boards."""
    return sorted(REFERENCES)
