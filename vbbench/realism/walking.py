"""How the people of scenes walk: speed, nearest distance, acceleration, path efficiency, collisions."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from vbbench.geometry import BoolArray, FloatArray
from vbbench.realism.histogram import Axis, Histogram
from vbbench.scene import Scene

COLLISION = 0.4
"""Two people nearer than this, in m, collide."""
SHORTEST_PATH = 1.0
"""Walks along a shorter path, in m, have no efficiency: for people who stand, jitter decides it."""

SPEED = Axis("speed", "m/s", 5.0)
NEAREST = Axis("nearest distance", "m", 20.0)
ACCELERATION = Axis("acceleration", "m/s²", 10.0)
EFFICIENCY = Axis("path efficiency", "", 1.0)


@dataclass(frozen=True, kw_only=True)
class Walking:
    """Statistics of scenes; those of more scenes are their sum.

    A walk is one uninterrupted stay of a person in a scene.

    Parameters
    ----------
    scenes : number of scenes.
    person_frames, person_seconds : how long people are present, summed over them.
    collisions, collision_seconds : pairs of people nearer than `COLLISION`, counted in each frame, and their time.
    short_walks : walks left out of the path efficiency, being shorter than `SHORTEST_PATH`.
    speed : between frames that follow one another, in m/s.
    nearest_distance : from each person in each frame to the nearest other one, in m.
    acceleration : second difference over three frames that follow one another, divided by dt², in m/s².
    path_efficiency : net displacement divided by path length, of each walk.
    """

    scenes: int = 0
    person_frames: int = 0
    person_seconds: float = 0.0
    collisions: int = 0
    collision_seconds: float = 0.0
    short_walks: int = 0
    speed: Histogram = field(default_factory=lambda: Histogram.of(SPEED))
    nearest_distance: Histogram = field(default_factory=lambda: Histogram.of(NEAREST))
    acceleration: Histogram = field(default_factory=lambda: Histogram.of(ACCELERATION))
    path_efficiency: Histogram = field(default_factory=lambda: Histogram.of(EFFICIENCY))

    def __add__(self, other: "Walking") -> "Walking":
        return Walking(**{name: value + getattr(other, name) for name, value in vars(self).items()})

    @property
    def dt(self) -> float:
        """Seconds per frame, the mean if scenes differ; NaN without people."""
        return self.person_seconds / self.person_frames if self.person_frames else np.nan

    @property
    def collisions_a_minute(self) -> float:
        """Colliding pairs, counted in each frame, per person-minute; it grows with the frame rate."""
        return 60.0 * self.collisions / self.person_seconds if self.person_seconds else np.nan

    @property
    def collision_seconds_a_minute(self) -> float:
        """Seconds that pairs collide per person-minute, independent of the frame rate."""
        return 60.0 * self.collision_seconds / self.person_seconds if self.person_seconds else np.nan

    @property
    def distributions(self) -> tuple[Histogram, ...]:
        """The four histograms."""
        return self.speed, self.nearest_distance, self.acceleration, self.path_efficiency

    def to_json(self) -> dict[str, Any]:
        """All figures and bins."""
        there = self.person_frames > 0
        return {
            "dt": self.dt if there else None,
            "scenes": self.scenes,
            "person_frames": self.person_frames,
            "person_minutes": self.person_seconds / 60.0,
            "collisions": {
                "limit": COLLISION,
                "pair_frames": self.collisions,
                "per_person_minute": self.collisions_a_minute if there else None,
                "seconds_per_person_minute": self.collision_seconds_a_minute if there else None,
            },
            "short_walks": self.short_walks,
            **{h.axis.name.replace(" ", "_"): h.to_json() for h in self.distributions},
        }


def walking_statistics(scenes: Iterable[Scene]) -> Walking:
    """Measure scenes one by one; memory does not grow with their number."""
    return sum((_of_scene(scene) for scene in scenes), Walking())


def _of_scene(scene: Scene) -> Walking:
    nearest, collisions = _neighbours(scene.positions, scene.present)
    efficiency, short = _path_efficiency(scene.positions, scene.present)
    velocity = np.diff(scene.positions, axis=0) / scene.dt
    acceleration = np.diff(velocity, axis=0) / scene.dt
    there = int(scene.present.sum())
    return Walking(
        scenes=1,
        person_frames=there,
        person_seconds=there * scene.dt,
        collisions=collisions,
        collision_seconds=collisions * scene.dt,
        short_walks=short,
        speed=Histogram.of(SPEED, _lengths(velocity)),
        nearest_distance=Histogram.of(NEAREST, nearest),
        acceleration=Histogram.of(ACCELERATION, _lengths(acceleration)),
        path_efficiency=Histogram.of(EFFICIENCY, efficiency),
    )


def _lengths(vectors: FloatArray) -> FloatArray:
    """Lengths of those vectors [..., 2] that are known."""
    lengths = np.hypot(vectors[..., 0], vectors[..., 1])
    return lengths[~np.isnan(lengths)]


def _neighbours(positions: FloatArray, present: BoolArray) -> tuple[FloatArray, int]:
    """Distance in m of everybody in every frame to the nearest other one, and the number of colliding pairs."""
    nearest, collisions = [np.empty(0)], 0
    for people, there in zip(positions, present, strict=True):
        if there.sum() < 2:
            continue
        apart = cdist(people[there], people[there])
        np.fill_diagonal(apart, np.inf)
        nearest.append(apart.min(axis=1))
        collisions += int(np.sum(apart < COLLISION)) // 2
    return np.concatenate(nearest), collisions


def _path_efficiency(positions: FloatArray, present: BoolArray) -> tuple[FloatArray, int]:
    """Net displacement divided by path length of each walk that is long enough, and how many are not."""
    absent = np.zeros((1, present.shape[1]), dtype=np.bool_)
    earlier, later = np.vstack([absent, present[:-1]]), np.vstack([present[1:], absent])
    first, last = (np.flatnonzero((present & ~beside).T) for beside in (earlier, later))
    if not len(first):
        return np.empty(0), 0
    steps = np.diff(positions, axis=0, prepend=positions[:1])
    path = np.add.reduceat(np.nan_to_num(np.hypot(steps[..., 0], steps[..., 1])).T.ravel(), first)
    points = positions.transpose(1, 0, 2).reshape(-1, 2)
    net = np.linalg.norm(points[last] - points[first], axis=1)
    long_enough = path >= SHORTEST_PATH
    return np.minimum(net[long_enough] / path[long_enough], 1.0), int(np.sum(~long_enough))
