"""How much of each head shows: nearer heads and bodies stand before it, and so do poles and a board."""

import numpy as np

from vbbench.exchange.heads.camera import SurveillanceCamera
from vbbench.exchange.heads.sighting import HEAD, Heads
from vbbench.geometry import BoolArray, FloatArray, IntArray

SHOULDER_WIDTH = 0.46
"""Width of a body in m, from the shoulders down to the ground."""
BELOW_HEAD = 0.18
"""How far in m the shoulders are below the head's centre."""
LEAST_VISIBLE = 0.15
"""Of whom less shows, nothing counts as visible."""
POLES, POLE_WIDTH, POLE_END = 3, 0.012, (0.4, 0.8)
"""Lamp posts from the top of the picture down: how many, how wide in picture widths, and where in the picture's height
they end."""
BOARD = (0.04, 0.06)
"""Width and height of a sign, in parts of the picture's."""
_SIDE = 7
_GRID = np.stack(np.meshgrid(*[(np.arange(_SIDE) + 0.5) / _SIDE - 0.5] * 2), axis=-1).reshape(-1, 2)
_SPOTS = _GRID[np.hypot(_GRID[:, 0], _GRID[:, 1]) <= 0.5]
"""[S, 2] spots of a head, in its widths and heights from its centre."""


def draw_screens(camera: SurveillanceCamera, rng: np.random.Generator) -> FloatArray:
    """[P, 4] (left, top, width, height) in px of what stands before the crowd: `POLES` and a board."""
    left = rng.uniform(0.0, 1.0 - POLE_WIDTH, POLES)
    poles = np.column_stack([left, np.zeros(POLES), np.full(POLES, POLE_WIDTH), rng.uniform(*POLE_END, POLES)])
    board = [*rng.uniform([0.0, 0.0], 1.0 - np.array(BOARD)), *BOARD]
    screens: FloatArray = np.vstack([poles, board]) * np.tile([float(camera.width), float(camera.height)], 2)
    return screens


def visible_fractions(heads: Heads, heights: FloatArray, camera: SurveillanceCamera, screens: FloatArray) -> FloatArray:
    """[N] the part of each head that nothing nearer hides: 0, or `LEAST_VISIBLE` to 1.

    A nearer head hides the ellipse that it fills, and its body the strip of `SHOULDER_WIDTH` from shoulders to feet.

    Parameters
    ----------
    heads : as `see_heads` makes them.
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
    """Pairs among ``rows``, all of one frame: whose head may be hidden, ascending, and who is nearer and may do it."""
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
    covered: BoolArray = np.hypot(offset[..., 0], offset[..., 1]) <= 0.5
    return covered


def _by_bodies(shoulders: FloatArray, feet: FloatArray, focal: float, spots: FloatArray) -> BoolArray:
    """[P, S] spots [P, S, 2] px that bodies from ``shoulders`` to ``feet``, [P, 3] (u, v, Z), cover."""
    along = (spots[..., 1] - shoulders[:, None, 1]) / (feet - shoulders)[:, None, 1]
    middle = shoulders[:, None, 0] + along * (feet - shoulders)[:, None, 0]
    depth = shoulders[:, None, 2] + along * (feet - shoulders)[:, None, 2]
    beside = np.abs(spots[..., 0] - middle) <= focal * SHOULDER_WIDTH / 2.0 / depth
    covered: BoolArray = beside & (along >= 0.0) & (along <= 1.0)
    return covered
