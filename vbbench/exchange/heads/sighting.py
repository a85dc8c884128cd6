"""Which heads a surveillance camera sees where: one row a head a frame, without any error."""

from dataclasses import dataclass, fields

import numpy as np

from vbbench.exchange.heads.camera import SurveillanceCamera
from vbbench.geometry import FloatArray, IntArray, frozen_array, world_to_relative

HEAD = 0.24
"""Diameter of a head in m."""
BELOW_TOP = 0.12
"""How far in m the centre of the head is below the top of the person."""
SAME_TRACK = 1.0
"""Who is back in the picture within so many seconds keeps the track."""


@dataclass(frozen=True, kw_only=True)
class Heads:
    """Heads in the picture, by track and frame.

    Parameters
    ----------
    frame : [N] from 0.
    track : [N] from 1, in the order in which they appear; who comes back into the picture has a new one.
    person : [N] whose head it is, a column of the scene.
    ground : [N, 2] (right, forward) in m of the person from the ground below the camera.
    places : [N, 2] centre (u, v) of the head in px from 0.
    sizes : [N, 2] width and height of the head in px.
    depth : [N] distance in m along the optical axis.
    """

    frame: IntArray
    track: IntArray
    person: IntArray
    ground: FloatArray
    places: FloatArray
    sizes: FloatArray
    depth: FloatArray

    def __post_init__(self) -> None:
        count = len(self.frame)
        for name in ("frame", "track", "person"):
            object.__setattr__(self, name, frozen_array(name, getattr(self, name), (count,), np.int64))
        for name in ("ground", "places", "sizes"):
            object.__setattr__(self, name, frozen_array(name, getattr(self, name), (count, 2)))
        object.__setattr__(self, "depth", frozen_array("depth", self.depth, (count,)))

    def __len__(self) -> int:
        return len(self.frame)

    def sorted_by(self, *names: str) -> "Heads":
        """The same rows in another order; the first name counts most."""
        order = np.lexsort([getattr(self, name) for name in reversed(names)])
        return Heads(**{field.name: getattr(self, field.name)[order] for field in fields(self)})


def see_heads(
    positions: FloatArray,
    heights: FloatArray,
    camera: SurveillanceCamera,
    station: FloatArray,
    *,
    dt: float,
    round_heads: bool = False,
) -> Heads:
    """Every head whose centre is in the picture, hidden or not.

    Parameters
    ----------
    positions : [T, K, 2] of the people in m, NaN where somebody is absent.
    heights : [K] in m.
    station : [3] (x, y, yaw) of the camera in m and rad.
    dt : seconds a frame.
    round_heads : whether heads are balls, wider by 1/cos of the angle off the axis, and not discs facing the camera.
    """
    ground = world_to_relative(positions, station)
    up = np.broadcast_to(heights - BELOW_TOP, ground.shape[:2])
    seen = camera.project(np.concatenate([ground, up[..., None]], axis=-1))
    person, frame = np.nonzero(camera.inside(seen).T)
    rows = seen[frame, person]
    sizes = np.repeat(camera.focal * HEAD / rows[:, 2:], 2, axis=1)
    if round_heads:
        sizes = sizes * np.hypot(1.0, (rows[:, :2] - camera.middle) / camera.focal)
    return Heads(
        frame=frame,
        track=_tracks(person, frame, round(SAME_TRACK / dt)),
        person=person,
        ground=ground[frame, person],
        places=rows[:, :2],
        sizes=sizes,
        depth=rows[:, 2],
    ).sorted_by("track", "frame")


def _tracks(person: IntArray, frame: IntArray, gap: int) -> IntArray:
    """[N] tracks of rows sorted by person and frame: a new one where a person was away for more than ``gap`` frames."""
    begins = np.ones(len(frame), dtype=np.bool_)
    begins[1:] = (np.diff(person) != 0) | (np.diff(frame) > gap + 1)
    first = np.flatnonzero(begins)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.lexsort([person[first], frame[first]])] = np.arange(1, len(first) + 1)
    tracks: IntArray = rank[np.cumsum(begins) - 1]
    return tracks
