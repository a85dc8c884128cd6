"""Static objects in chunks: compact groups of triangles, so that those out of view are not drawn."""

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from vbbench_renderers import _core
from vbbench_renderers.mesh import Float32, Int32, Mesh
from vbbench_renderers.opengl.packing import COMMAND, Records

FULL = 80
"""The largest number of triangles in a chunk."""
SIZES = (0.3, 0.6, 1.2, 2.4, 5.0)
"""Triangles are grouped by their longest horizontal edge (m), so that small ones are not refined with large ones."""


@dataclass(frozen=True)
class Chunks:
    """Triangles sorted by chunk.

    Parameters
    ----------
    triangles : [F, 3] vertex indices.
    commands : [C] `COMMAND`, one instance each.
    spheres : [C, 4] centre and radius in m.
    longest : [C] longest horizontal edge in m.
    """

    triangles: Int32
    commands: Records
    spheres: Float32
    longest: Float32

    def drawn(self, chosen: NDArray[np.int64], eye: NDArray[np.floating[Any]]) -> tuple[NDArray[np.int64], Records]:
        """The order in which to draw the ``chosen``, near ones first, and their commands."""
        order = np.argsort(np.hypot(*(self.spheres[chosen, :2] - eye[:2]).T), kind="stable")
        commands = self.commands[chosen[order]]
        commands["instance"] = np.arange(len(order))
        return order, commands

    def narrow(self, eye: NDArray[np.floating[Any]]) -> NDArray[np.bool_]:
        """Whether every edge of a chunk spans so little azimuth that a panorama needs no refining."""
        near = np.hypot(*(self.spheres[:, :2] - eye[:2]).T) - self.spheres[:, 3]
        return cast(NDArray[np.bool_], self.longest < np.tan(_core.WIDEST) * near)

    def triangles_of(self, chosen: NDArray[np.bool_]) -> Int32:
        """[F, 3] the triangles of some chunks."""
        return self.triangles[np.repeat(chosen, self.commands["count"] // 3)]


def split_mesh(mesh: Mesh) -> Chunks:
    """The triangles of a mesh in chunks, made by halving boxes across their longer sides."""
    corners = mesh.vertices[mesh.triangles]
    edges = np.hypot(*np.moveaxis((corners - np.roll(corners, 1, axis=1))[..., :2], -1, 0)).max(axis=1)
    middle, size = corners.mean(axis=1), np.searchsorted(SIZES, edges)
    groups = [group for n in range(len(SIZES) + 1) for group in _halved(np.nonzero(size == n)[0], middle)]
    commands = np.zeros(len(groups), dtype=COMMAND)
    commands["count"] = [3 * len(group) for group in groups]
    commands["first"] = np.cumsum([0, *commands["count"][:-1]])
    commands["instances"] = 1
    return Chunks(
        triangles=np.ascontiguousarray(mesh.triangles[np.concatenate(groups)], dtype=np.int32),
        commands=commands,
        spheres=np.array([_sphere(corners[group].reshape(-1, 3)) for group in groups], dtype=np.float32),
        longest=np.array([edges[group].max() for group in groups], dtype=np.float32),
    )


def _halved(rows: NDArray[np.int64], middle: Float32) -> list[NDArray[np.int64]]:
    if len(rows) <= FULL:
        return [rows] if len(rows) else []
    axis = int(np.argmax(np.ptp(middle[rows], axis=0)))
    rows = rows[np.argsort(middle[rows, axis], kind="stable")]
    half = len(rows) // 2
    return [*_halved(rows[:half], middle), *_halved(rows[half:], middle)]


def _sphere(points: Float32) -> Float32:
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return np.append(centre, np.linalg.norm(points - centre, axis=1).max()).astype(np.float32)
