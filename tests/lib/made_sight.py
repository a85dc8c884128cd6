"""What a tier is shown: people at given places about a camera."""

import numpy as np

from vbbench.camera import Camera, PanoramaCamera
from vbbench.generation.generator import Observer
from vbbench.generation.tier import Sight
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.sequence import Truth

DT = 0.4


def sight_of(
    positions: FloatArray,
    poses: FloatArray | None = None,
    heights: FloatArray | None = None,
    *,
    camera: Camera | None = None,
    people: IntArray | None = None,
    seen: BoolArray | None = None,
    watched: BoolArray | None = None,
    dt: float = DT,
    observer: Observer = "walker",
) -> Sight:
    """The sight of people at ``positions`` [T, K, 2]; by default all who are there are seen, by a camera at rest."""
    frames, count = positions.shape[:2]
    truth = Truth(
        poses=np.zeros((frames, 3)) if poses is None else poses,
        positions=positions,
        heights=np.full(count, 1.7) if heights is None else heights,
    )
    return Sight(
        truth=truth,
        people=np.arange(count) if people is None else people,
        seen=~np.isnan(positions[..., 0]) if seen is None else seen,
        watched=np.ones(frames, bool) if watched is None else watched,
        camera=camera or PanoramaCamera(),
        dt=dt,
        observer=observer,
    )
