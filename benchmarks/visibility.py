"""Ground truth from pictures: where each person shows, how much of them, and how much the border cuts off.

Whatever drew the picture, the pixels that a person would cover alone are counted here, from the same limbs and with
the exact rays of `vbbench_renderers.raster`.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers import _core
from vbbench_renderers.meshes import Int32, Limbs
from vbbench_renderers.people import Walkers
from vbbench_renderers.raster import Scenery, draw_shadows, middles_of, place
from vbbench_renderers.views import Rays, camera_rays, eye_transform

ALL, INSIDE, ON_BORDER = range(3)
"""Columns of the counts: pixels, those inside the window, those on its border."""

COARSE = 4
"""Pixels from one ray to the next where truncation is measured."""


Window = tuple[int, int, int, int]
"""First column and row, and last column and row, of the part of a picture that counts as inside."""


@dataclass(frozen=True, kw_only=True)
class Seen:
    """The people of a picture: everybody who would show if alone.

    Parameters
    ----------
    person : [N] ids, ascending.
    box : [N, 4] left, top, right, bottom in px of what shows, NaN where nothing does: pixel i reaches from i to i + 1.
        In a panorama left is in [0, W), and right may be larger than W.
    visible : [N] visible pixels over the pixels that the person would cover alone.
    truncated : [N] share of the person's pixels, if alone, that lie outside the picture. The picture goes on for
        its own width and height beyond each border; what lies farther out counts as nowhere.
    """

    person: IntArray
    box: FloatArray
    visible: FloatArray
    truncated: FloatArray

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(self.person))
        freeze(self, np.int64, person=(count,))
        freeze(self, box=(count, 4), visible=(count,), truncated=(count,))

    def observations(self, camera: Camera) -> FloatArray:
        """[N, 3] (u, v, l) of the boxes in px, as `vbbench.camera.Camera.project` gives them."""
        left, top, right, bottom = self.box.T
        return np.stack([camera.wrap_column(0.5 * (left + right)), 0.5 * (top + bottom), bottom - top], axis=-1)


class Onlooker:
    """Reads people off pictures of one scene.

    Parameters
    ----------
    scene : the scene.
    people : its bodies, as drawn: `vbbench_renderers.people.Walkers` with the renderer's seed.
    """

    def __init__(self, scene: Scene, people: Walkers) -> None:
        self._scene, self._people = scene, people
        self._meshes, self._middles = _core.Meshes(people.meshes), middles_of(people.meshes)
        nobody = people.limbs(0, np.zeros(2)).of(np.zeros(0, np.int64))
        none = draw_shadows(self._meshes, nobody, nobody.mesh, np.array([0.0, 0.0, 1.0]), np.zeros(2), 1.0, 16)
        self._dark = Scenery(np.ones((6, 3)), [np.zeros((1, 1, 1, 3), np.uint8)], none, none)

    def look(
        self, picture: Picture, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None
    ) -> Seen:
        """Who is seen in a picture; frame, camera, pose and observer as it was rendered.

        Raises
        ------
        VbbenchError
            If the scene has no such observer.
        """
        rays, eye = camera_rays(camera), eye_transform(camera, pose)
        without = None if observer is None else self._scene.column_of(observer)
        limbs = self._people.limbs(frame, np.asarray(pose[:2], np.float64), camera.focal, without=without)
        columns, person = np.unique(limbs.person, return_inverse=True)
        alone = self._count(limbs, person, len(columns), eye, rays, _window(rays, 0, 0))
        there = alone[:, ALL] > 0
        truncated = np.zeros(len(columns))
        cut = alone[:, ON_BORDER] > 0
        truncated[cut] = self._truncated(limbs, person, cut, eye, rays)
        people = self._scene.people[columns[there]]
        found = _find(picture.ids, people)
        visible = np.minimum(found[:, 0] / alone[there, ALL], 1.0)
        return Seen(person=people, box=_boxes(found, rays), visible=visible, truncated=truncated[there])

    def _count(
        self, limbs: Limbs, person: IntArray, people: int, eye: FloatArray, rays: Rays, window: Window
    ) -> IntArray:
        """[K, 3] pixels that each person covers in a picture of nobody else: all, inside the window, on its border."""
        counts = np.zeros((people, 3), np.int64)
        for k in range(people):
            own = limbs.of(person == k)
            first, cut = _columns(own, eye, rays)
            row, column = np.nonzero(self._alone(own, eye, cut))
            column = column + first
            inside = (column >= window[0]) & (row >= window[1]) & (column <= window[2]) & (row <= window[3])
            border = (column == window[0]) | (row == window[1]) | (column == window[2]) | (row == window[3])
            counts[k] = len(row), inside.sum(), (inside & border).sum()
        return counts

    def _alone(self, limbs: Limbs, eye: FloatArray, rays: Rays) -> BoolArray:
        """[H, W] whether limbs show in a picture of nothing else."""
        owners = np.append(np.zeros(len(limbs.mesh), np.int32), NOBODY)
        placement = place(self._middles, limbs, np.zeros(len(limbs.mesh), bool), eye, owners)
        _, _, ids = _core.draw(self._meshes, limbs, placement, rays, self._dark, _core.available_threads())
        return ids != NOBODY

    def _truncated(
        self,
        limbs: Limbs,
        person: IntArray,
        cut: np.ndarray[tuple[int], np.dtype[np.bool_]],
        eye: FloatArray,
        rays: Rays,
    ) -> FloatArray:
        """Share of their pixels that some people have outside, in a larger and coarser picture."""
        if not cut.any():
            return np.empty(0)
        chosen = limbs.of(cut[person])
        rows = (np.cumsum(cut) - 1)[person[cut[person]]]
        wider, window = _wider(rays)
        counts = self._count(chosen, rows, int(cut.sum()), eye, wider, window)
        return np.asarray(1.0 - counts[:, INSIDE] / np.maximum(counts[:, ALL], 1))


def _columns(limbs: Limbs, eye: FloatArray, rays: Rays) -> tuple[int, Rays]:
    """The first of the columns that limbs may cover, and their rays; all of a panorama, or if limbs are near."""
    places = limbs.transform[:, :, 3] @ eye[:, :3].T + eye[:, 3]
    if not rays.closed and places[:, 2].max() < -1.0:  # behind the camera
        return 0, rays._replace(side=rays.side[:1], ahead=rays.ahead[:1])
    if rays.closed or places[:, 2].min() < 1.0:
        return 0, rays
    columns = rays.centre + rays.across * places[:, 0] / places[:, 2]
    reach = 0.6 * rays.across / places[:, 2].min()
    first, last = np.clip([columns.min() - reach, columns.max() + reach], 0, len(rays.side)).astype(int)
    last = min(last + 1, len(rays.side))
    first = min(first, last - 1)
    return first, rays._replace(side=rays.side[first:last], ahead=rays.ahead[first:last], centre=rays.centre - first)


def _window(rays: Rays, left: int, top: int) -> Window:
    """All of a picture but for borders; the sides of a closed picture are no border."""
    last = len(rays.side) - 1 - left
    sides = (-1, last + 1) if rays.closed else (left, last)
    return sides[0], top, sides[1], rays.height - 1 - top


def _wider(rays: Rays) -> tuple[Rays, Window]:
    """Rays of a picture three times as high and, unless it is closed, as wide, one for `COARSE` x `COARSE` px."""
    width, rows = len(rays.side), -(-rays.height // COARSE)
    focal, horizon = rays.focal / COARSE, (rays.horizon + 0.5) / COARSE + rows - 0.5
    if rays.closed:
        azimuth = 2.0 * np.pi * (np.arange(width // COARSE) + 0.5) / (width // COARSE) - np.pi
        wider = Rays(np.sin(azimuth), np.cos(azimuth), focal, 1.0, horizon, 0.0, 3 * rows, True)
        return wider, _window(wider, 0, rows)
    columns = -(-width // COARSE)
    centre = rays.centre / COARSE + columns
    across = rays.across / COARSE
    side = (np.arange(3 * columns, dtype=np.float64) + 0.5 - centre) / across
    wider = Rays(side, np.ones(len(side)), focal, across, horizon, centre, 3 * rows, False)
    return wider, _window(wider, columns, rows)


def _boxes(found: IntArray, rays: Rays) -> FloatArray:
    """Boxes of a table of `_find`; in a closed picture the narrower of the ways to go round."""
    count, left, right, top, bottom, turned_left, turned_right = found.T.astype(np.float64)
    width = len(rays.side)
    if rays.closed:
        turned = turned_right - turned_left < right - left
        left, right = (
            np.where(turned, (turned_left - width // 2) % width, left),
            np.where(turned, turned_right - turned_left, right - left),
        )
        right = left + right
    boxes = np.stack([left, top, right + 1.0, bottom + 1.0], axis=-1)
    boxes[count == 0] = np.nan
    return boxes


def _find(ids: Int32, people: IntArray) -> IntArray:
    """[N, 7] pixels of each person; first and last column, first and last row; columns turned by half a picture."""
    found = np.zeros((len(people), 7), np.int64)
    found[:, 1::2], found[:, 2::2] = 1 << 30, -1
    row, column = np.nonzero(ids >= 0)
    person = np.searchsorted(people, ids[row, column])
    known = np.append(people, -1)[person] == ids[row, column]
    row, column, person = row[known], column[known], person[known]
    found[:, 0] = np.bincount(person, minlength=len(people))
    width = ids.shape[1]
    for n, values in enumerate((column, row, (column + width // 2) % width)):
        np.minimum.at(found[:, 2 * n + 1], person, values)
        np.maximum.at(found[:, 2 * n + 2], person, values)
    return found
