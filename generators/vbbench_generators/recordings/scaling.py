"""Recordings scaled to a square field of one size, as the text of arXiv 2111.05060 has them: x, y ∈ [−8, 8] m.

People keep their heights, and the camera its own: only the ground shrinks or grows. Who stands and who walks is decided
as in the recording, so that a scaled split has the same sequences.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vbbench.scene import Scene
from vbbench_generators.recordings.eligibility import Rules


def scale_to_field(scenes: Sequence[Scene], rules: Rules, half_width: float) -> tuple[list[Scene], Rules]:
    """The scenes within ±``half_width`` m about their middles, all by the factor of the largest, and their rules."""
    corners = [(np.nanmin(scene.positions, axis=(0, 1)), np.nanmax(scene.positions, axis=(0, 1))) for scene in scenes]
    factor = 2.0 * half_width / float(max(np.max(high - low) for low, high in corners))
    scaled = [
        replace(scene, positions=(scene.positions - (low + high) / 2.0) * factor)
        for scene, (low, high) in zip(scenes, corners, strict=True)
    ]
    return scaled, replace(rules, standing_displacement=rules.standing_displacement * factor)
