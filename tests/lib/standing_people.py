"""People who stand, and cameras at the origin that see them: shared by the tests of renderers."""

import numpy as np

from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.scene import Scene

AHEAD = PerspectiveCamera(width=160, height=120, focal=80.0, cx=80.0, cy=60.0)
AROUND = PanoramaCamera(width=360, focal=360 / (2 * np.pi), cy=60.0)
ORIGIN = np.zeros(3)


def standing(places: list[tuple[float, float]], frames: int = 2) -> Scene:
    """People of 1.7 m at places in m, the n-th of whom has the id 7n + 3."""
    positions = np.tile(np.array(places, dtype=np.float64).reshape(1, -1, 2), (frames, 1, 1))
    count = positions.shape[1]
    return Scene(name="t", dt=0.1, people=np.arange(count) * 7 + 3, positions=positions, heights=np.full(count, 1.7))
