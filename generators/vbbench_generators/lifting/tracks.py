"""From head boxes and a camera to smooth tracks on the ground."""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.scene import Scene
from vbbench_generators.lifting.camera import GroundCamera
from vbbench_generators.lifting.smoothing import smooth
from vbbench_generators.lifting.strength import estimate_strength

_LEAST_STD = 1e-6
_LEAST_ACCELERATION = 1e-6


@dataclass(frozen=True, kw_only=True)
class Heads:
    """Head centres in px from the picture's centre, by track, then by frame: [N] each; ``dt`` in s."""

    x: FloatArray
    nu: FloatArray
    frame: IntArray
    track: IntArray
    dt: float

    def take(self, chosen: BoolArray | IntArray) -> "Heads":
        """Those at the places, or with the truth values, ``chosen``."""
        return Heads(
            x=self.x[chosen], nu=self.nu[chosen], frame=self.frame[chosen], track=self.track[chosen], dt=self.dt
        )


@dataclass(frozen=True, kw_only=True)
class Smoothed:
    """Tracks as a scene, and the root mean square of what the smoother took off them, in m and in px."""

    scene: Scene
    residual_m: float
    residual_px: float


def split_at_gaps(heads: Heads, gap: float) -> Heads:
    """The same heads where the part of a track after a gap of more than ``gap`` s is somebody new.

    The first part keeps its id; the others get those above the highest. Heads stay by track, then by frame.
    """
    limit = max(1, int(np.floor(gap / heads.dt + 1e-9)))
    opening = np.r_[True, heads.track[1:] != heads.track[:-1]]
    broken = np.r_[False, np.diff(heads.frame) > limit] & ~opening
    if not broken.any():
        return heads
    piece = np.cumsum(broken)
    since = np.maximum.accumulate(np.where(opening | broken, np.arange(len(opening)), 0))
    track = np.where(broken[since], heads.track.max() + piece[since], heads.track)
    order = np.argsort(track, kind="stable")
    return Heads(x=heads.x, nu=heads.nu, frame=heads.frame, track=track, dt=heads.dt).take(order)


def smooth_tracks(heads: Heads, camera: GroundCamera, head_size: float, name: str) -> Smoothed:
    """Put heads on the ground and smooth their tracks, gaps filled, as strongly as the tracks themselves tell."""
    ground, jacobian = camera.to_ground(heads.x, heads.nu), camera.jacobian(heads.x, heads.nu)
    size = head_size / np.hypot(jacobian[:, 0, 0], jacobian[:, 1, 0])
    scale = size[:, None] * np.hypot(jacobian[:, :, 0], jacobian[:, :, 1])
    starts, row = _rows(heads)
    smoothed = np.empty((int(starts[-1]), 2))
    for axis in range(2):
        strength = estimate_strength(ground[:, axis], scale[:, axis], heads.frame, heads.track, dt=heads.dt)
        variance = (strength.noise * scale[:, axis]) ** 2 / heads.dt + _LEAST_STD**2
        density = max(strength.acceleration, _LEAST_ACCELERATION)
        smoothed[:, axis] = smooth(ground[:, axis], variance, row, starts, density, heads.dt)
    off = ground - smoothed[row]
    moved = np.linalg.solve(jacobian, off[:, :, None])[:, :, 0]
    return Smoothed(
        scene=_scene(heads, smoothed, starts, name),
        residual_m=float(np.sqrt(np.mean((off**2).sum(axis=1)))),
        residual_px=float(np.sqrt(np.mean((moved**2).sum(axis=1)))),
    )


def _rows(heads: Heads) -> tuple[IntArray, IntArray]:
    """Where each track begins [K + 1] in a table with a row a frame from its first to its last, and each head's row."""
    first = np.flatnonzero(np.r_[True, heads.track[1:] != heads.track[:-1]])
    last = np.r_[first[1:], len(heads.track)] - 1
    spans = heads.frame[last] - heads.frame[first] + 1
    starts = np.r_[0, np.cumsum(spans)]
    row = heads.frame + np.repeat(starts[:-1] - heads.frame[first], last - first + 1)
    return starts, row


def _scene(heads: Heads, smoothed: FloatArray, starts: IntArray, name: str) -> Scene:
    people, first = np.unique(heads.track, return_index=True)
    spans = np.diff(starts)
    column = np.repeat(np.arange(len(people)), spans)
    frame = np.arange(len(smoothed)) - np.repeat(starts[:-1] - heads.frame[first], spans)
    positions = np.full((int(frame.max()) + 1, len(people), 2), np.nan)
    positions[frame, column] = smoothed
    return Scene(name=name, dt=heads.dt, people=people, positions=positions, heights=np.full(len(people), np.nan))
