"""Which heads a surveillance camera sees where, and how much of each is visible: one row per head and frame."""

from dataclasses import dataclass, fields

import numpy as np

from vbbench.exchange.heads.camera import SurveillanceCamera
from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze, world_to_relative

HEAD = 0.24
"""Diameter of a head in m."""
BELOW_TOP = 0.12
"""How far in m the centre of the head is below the top of the person."""
SAME_TRACK = 1.0
"""A person who is back in the picture within so many seconds keeps the track."""


@dataclass(frozen=True, kw_only=True)
class Heads:
    """Heads in the picture, by track and frame.

    Parameters
    ----------
    frame : [N] from 0.
    track : [N] from 1, in order of appearance; a person who comes back later has a new one.
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
        freeze(self, np.int64, frame=(count,), track=(count,), person=(count,))
        freeze(self, ground=(count, 2), places=(count, 2), sizes=(count, 2), depth=(count,))

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
    positions : [T, K, 2] of the people in m, NaN = absent.
    heights : [K] in m.
    station : [3] (x, y, yaw) of the camera in m and rad.
    dt : seconds per frame.
    round_heads : heads are spheres, wider by 1/cos of the angle off the axis, instead of discs facing the camera.
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
    return np.asarray(rank[np.cumsum(begins) - 1])


SHOULDER_WIDTH = 0.46
"""Width of a body in m, from the shoulders down to the ground."""
BELOW_HEAD = 0.18
"""How far in m the shoulders are below the head's centre."""
LEAST_VISIBLE = 0.15
"""Smaller visible fractions count as 0."""
POLES, POLE_WIDTH, POLE_END = 3, 0.012, (0.4, 0.8)
"""Lamp posts from the top of the picture down: number, width in picture widths, range of lower ends in its heights."""
BOARD = (0.04, 0.06)
"""Width and height of a sign, as fractions of the picture's."""
_SIDE = 7
_GRID = np.stack(np.meshgrid(*[(np.arange(_SIDE) + 0.5) / _SIDE - 0.5] * 2), axis=-1).reshape(-1, 2)
_SPOTS = _GRID[np.hypot(_GRID[:, 0], _GRID[:, 1]) <= 0.5]
"""[S, 2] spots of a head, in its widths and heights from its centre."""


def draw_screens(camera: SurveillanceCamera, rng: np.random.Generator) -> FloatArray:
    """[P, 4] (left, top, width, height) in px of what stands before the crowd: `POLES` and a board."""
    left = rng.uniform(0.0, 1.0 - POLE_WIDTH, POLES)
    poles = np.column_stack([left, np.zeros(POLES), np.full(POLES, POLE_WIDTH), rng.uniform(*POLE_END, POLES)])
    board = [*rng.uniform([0.0, 0.0], 1.0 - np.array(BOARD)), *BOARD]
    return np.asarray(np.vstack([poles, board]) * np.tile([float(camera.width), float(camera.height)], 2))


def visible_fractions(heads: Heads, heights: FloatArray, camera: SurveillanceCamera, screens: FloatArray) -> FloatArray:
    """[N] the part of each head that nothing nearer hides: 0, or `LEAST_VISIBLE` to 1.

    A nearer head hides the ellipse that it fills, and its body the strip of `SHOULDER_WIDTH` from shoulders to feet.

    Parameters
    ----------
    heads : from `see_heads`.
    heights : [N] in m of each head's centre over the ground.
    screens : [P, 4] (left, top, width, height) in px; they hide whatever is behind.
    """
    shoulders = camera.project(np.column_stack([heads.ground, heights - BELOW_HEAD]))
    feet = camera.project(np.column_stack([heads.ground, np.zeros(len(heads))]))
    shares = np.ones(len(heads))
    order = np.argsort(heads.frame, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(heads.frame[order])) + 1):
        spots = heads.places[rows, None] + heads.sizes[rows, None] * _SPOTS
        covered = _by_screens(screens, spots)
        hidden, hiding = _candidates(heads, feet, rows)
        if len(hidden):
            behind, nearer = spots[hidden], rows[hiding]
            each = _by_heads(heads, nearer, behind)
            each |= _by_bodies(shoulders[nearer], feet[nearer], camera.focal, behind)
            first = np.flatnonzero(np.diff(hidden, prepend=-1))
            covered[hidden[first]] |= np.logical_or.reduceat(each, first, axis=0)
        shares[rows] = 1.0 - covered.mean(axis=1)
    return np.where(shares < LEAST_VISIBLE, 0.0, shares)


def _by_screens(screens: FloatArray, spots: FloatArray) -> BoolArray:
    """[P, S] spots [P, S, 2] px that any of the ``screens`` [M, 4] covers."""
    covered = np.zeros(spots.shape[:2], dtype=np.bool_)
    for left, top, width, height in screens:
        across, down = spots[..., 0] - left, spots[..., 1] - top
        covered |= (across >= 0.0) & (across < width) & (down >= 0.0) & (down < height)
    return covered


def _candidates(heads: Heads, feet: FloatArray, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs among ``rows`` of one frame: whose head may be hidden, ascending, and who is nearer and may hide it."""
    u, v = heads.places[rows].T
    across, high = heads.sizes[rows].T
    left, right = np.minimum(u, feet[rows, 0]), np.maximum(u, feet[rows, 0])
    half = across * (SHOULDER_WIDTH / HEAD / 2.0)
    beside = (u[:, None] + across[:, None] > left - half) & (u[:, None] - across[:, None] < right + half)
    level = (v[:, None] + high[:, None] > v - high) & (v[:, None] - high[:, None] < feet[rows, 1])
    nearer = heads.depth[rows] < heads.depth[rows, None]
    hidden, hiding = np.nonzero(beside & level & nearer)
    return hidden, hiding


def _by_heads(heads: Heads, hiding: IntArray, spots: FloatArray) -> BoolArray:
    """[P, S] spots [P, S, 2] px that the heads ``hiding`` [P] cover."""
    offset = (spots - heads.places[hiding, None]) / heads.sizes[hiding, None]
    return np.asarray(np.hypot(offset[..., 0], offset[..., 1]) <= 0.5)


def _by_bodies(shoulders: FloatArray, feet: FloatArray, focal: float, spots: FloatArray) -> BoolArray:
    """[P, S] spots [P, S, 2] px that bodies from ``shoulders`` to ``feet``, [P, 3] (u, v, Z), cover."""
    along = (spots[..., 1] - shoulders[:, None, 1]) / (feet - shoulders)[:, None, 1]
    middle = shoulders[:, None, 0] + along * (feet - shoulders)[:, None, 0]
    depth = shoulders[:, None, 2] + along * (feet - shoulders)[:, None, 2]
    beside = np.abs(spots[..., 0] - middle) <= focal * SHOULDER_WIDTH / 2.0 / depth
    return np.asarray(beside & (along >= 0.0) & (along <= 1.0))
