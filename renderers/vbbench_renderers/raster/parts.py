"""Many meshes joined in a few arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vbbench.geometry import IntArray
from vbbench_renderers import _core
from vbbench_renderers.mesh import Float32, Int32, Mesh

CHUNK = 256
"""The largest number of triangles in one piece of the surroundings."""


@dataclass(frozen=True)
class Parts:
    """M meshes.

    Parameters
    ----------
    vertices, normals, colours : [V, 3] as in `Mesh`.
    uv : [V, 2].
    layers : [F] texture layer of each triangle.
    grain : [F] texture widths a metre of each triangle, the geometric mean of both directions.
    triangles : [F, 3] rows of ``vertices``.
    first_vertex, first_triangle : [M + 1].
    spheres : [M, 4] centre and radius of a sphere around each mesh.
    """

    vertices: Float32
    normals: Float32
    colours: Float32
    uv: Float32
    layers: Int32
    grain: Float32
    triangles: Int32
    first_vertex: IntArray
    first_triangle: IntArray
    spheres: Float32

    @cached_property
    def core(self) -> _core.Meshes:
        """The same for the functions in C++."""
        return _core.Meshes(**vars(self))


def join_parts(meshes: Sequence[Mesh]) -> Parts:
    """The meshes as `Parts`, in their order."""
    first_vertex = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    first_triangle = np.cumsum([0, *(len(mesh.triangles) for mesh in meshes)])
    triangles = np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, first_vertex, strict=False)])
    vertices, normals, colours, uv = (
        np.ascontiguousarray(np.concatenate([getattr(mesh, name) for mesh in meshes]), np.float32)
        for name in ("vertices", "normals", "colours", "uv")
    )
    boxes = np.array([(mesh.vertices.min(0), mesh.vertices.max(0)) for mesh in meshes], np.float32)
    layers = np.concatenate([mesh.layers[mesh.triangles[:, 0]] for mesh in meshes]).astype(np.int32)
    return Parts(
        vertices,
        normals,
        colours,
        uv,
        layers,
        _grain(vertices, uv, triangles),
        np.ascontiguousarray(triangles, np.int32),
        first_vertex,
        first_triangle,
        np.array([_sphere(mesh, box) for mesh, box in zip(meshes, boxes, strict=True)], np.float32),
    )


def split_mesh(mesh: Mesh) -> list[Mesh]:
    """The mesh in pieces of neighbouring triangles, so that pieces out of view can be skipped together."""
    corners = mesh.vertices[mesh.triangles]
    return [_piece(mesh, rows) for rows in _halves(corners.mean(axis=1), np.arange(len(corners)))]


def _halves(centres: Float32, rows: IntArray) -> list[IntArray]:
    """Rows halved along their longer side until few are left."""
    if len(rows) <= CHUNK:
        return [rows]
    axis = int(np.ptp(centres[rows], axis=0).argmax())
    ordered = rows[np.argsort(centres[rows, axis], kind="stable")]
    middle = len(rows) // 2
    return _halves(centres, ordered[:middle]) + _halves(centres, ordered[middle:])


def _piece(mesh: Mesh, rows: IntArray) -> Mesh:
    used, triangles = np.unique(mesh.triangles[rows], return_inverse=True)
    names = ("vertices", "normals", "colours", "uv", "layers")
    return Mesh(
        **{name: getattr(mesh, name)[used] for name in names}, triangles=triangles.reshape(-1, 3).astype(np.int32)
    )


def _sphere(mesh: Mesh, box: Float32) -> Float32:
    centre = box.mean(axis=0)
    return np.append(centre, np.linalg.norm(mesh.vertices - centre, axis=1).max()).astype(np.float32)


def _grain(vertices: Float32, uv: Float32, triangles: Int32) -> Float32:
    corners, places = vertices[triangles].astype(np.float64), uv[triangles].astype(np.float64)
    sides, steps = corners[:, 1:] - corners[:, :1], places[:, 1:] - places[:, :1]
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    cover = np.abs(steps[:, 0, 0] * steps[:, 1, 1] - steps[:, 0, 1] * steps[:, 1, 0])
    grain: Float32 = np.sqrt(cover / np.maximum(area, 1e-12)).astype(np.float32)
    return grain
