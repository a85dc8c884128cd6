"""Meshes and limbs as OpenGL reads them: vertices, instances and the commands of one indirect draw."""

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import Camera
from vbbench_renderers.drawing import Limbs
from vbbench_renderers.mesh import Float32, Mesh

Records = NDArray[Any]
INSTANCE = np.dtype(
    [
        ("rows", np.float32, (3, 4)),
        ("colour", np.float32, 3),
        ("pattern", np.float32),
        ("second_colour", np.float32, 3),
        ("gloss", np.float32),
        ("base", np.float32),
        ("person", np.float32),
    ]
)
COMMAND = np.dtype([(name, np.uint32) for name in ("count", "instances", "first", "vertex", "instance")])


def pack_vertices(mesh: Mesh) -> Float32:
    """[V, 12] position, normal, colour, uv and layer."""
    columns = (mesh.vertices, mesh.normals, mesh.colours, mesh.uv, mesh.layers[:, None])
    return np.concatenate([np.asarray(column, dtype=np.float32) for column in columns], axis=1)


@dataclass(frozen=True)
class Library:
    """All levels of all limb meshes in one vertex and one index buffer.

    Parameters
    ----------
    vertices : [V, 12] see `pack_vertices`.
    triangles : [F, 3] indices within a mesh.
    commands : [levels, meshes] `COMMAND` of one mesh, without instances.
    boxes : [meshes, 2, 3] centre and half size in the limb's frame, of the finest level.
    """

    vertices: Float32
    triangles: NDArray[np.int32]
    commands: Records
    boxes: Float32


def pack_library(levels: list[tuple[Mesh, ...]]) -> Library:
    """The library of limbs as buffers."""
    meshes = [mesh for level in levels for mesh in level]
    commands = np.zeros(len(meshes), dtype=COMMAND)
    commands["count"] = [mesh.triangles.size for mesh in meshes]
    commands["first"] = np.cumsum([0, *commands["count"][:-1]])
    commands["vertex"] = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return Library(
        vertices=np.concatenate([pack_vertices(mesh) for mesh in meshes]),
        triangles=np.concatenate([mesh.triangles for mesh in meshes]).astype(np.int32),
        commands=commands.reshape(len(levels), -1),
        boxes=np.array([_box(mesh.vertices) for mesh in levels[0]], dtype=np.float32),
    )


def _box(vertices: Float32) -> tuple[Float32, Float32]:
    least, most = vertices.min(axis=0), vertices.max(axis=0)
    return 0.5 * (least + most), 0.52 * (most - least)  # coarse levels may extend a little farther


def pack_limbs(drawn: list[tuple[int, Limbs]]) -> tuple[Records, NDArray[np.int64], NDArray[np.int64]]:
    """Instances [N], and the level [N] and the mesh [N] of each."""
    count = sum(len(limbs.mesh) for _, limbs in drawn)
    packed, levels, meshes = np.zeros(count, dtype=INSTANCE), np.zeros(count, np.int64), np.zeros(count, np.int64)
    start = 0
    for level, limbs in drawn:
        rows = slice(start, start := start + len(limbs.mesh))
        part = packed[rows]
        part["rows"] = limbs.transform
        part["colour"], part["second_colour"] = limbs.colour, limbs.second_colour
        part["pattern"], part["gloss"], part["person"] = limbs.pattern, limbs.gloss, limbs.person
        levels[rows], meshes[rows] = level, limbs.mesh
    return packed, levels, meshes


def axes(instances: Records, meshes: NDArray[np.int64], library: Library) -> Float32:
    """[N, 3, 3] in columns, the half axes of the limbs' boxes in the world, in m."""
    return cast(Float32, instances["rows"][:, :, :3] * library.boxes[meshes, 1][:, None])


def bounds(instances: Records, meshes: NDArray[np.int64], library: Library) -> Float32:
    """[N, 4] centre and radius of every limb in the world."""
    centre = np.einsum("nij,nj->ni", instances["rows"][:, :, :3], library.boxes[meshes, 0]) + instances["rows"][..., 3]
    radius = np.sqrt(np.square(axes(instances, meshes, library)).sum(axis=(1, 2)))  # half the diagonal, or more
    return np.concatenate([centre, radius[:, None]], axis=1)


def in_view(spheres: Float32, camera: Camera, pose: NDArray[np.float64]) -> tuple[NDArray[np.int64], Float32]:
    """Which limbs to draw, and the azimuth each counts from; a limb across a panorama's seam is drawn twice."""
    dx, dy = (spheres[:, :2] - pose[:2]).T
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    right, forward, radius = dx * sin - dy * cos, dx * cos + dy * sin, spheres[:, 3]
    if camera.intrinsics is not None:
        seen_from = np.stack([right, camera.mount_height - spheres[:, 2], forward], axis=-1)
        right, _, forward = camera.to_camera(seen_from).T
        focal, _, cx = camera.intrinsics[0]
        sides = (cx / focal, (camera.picture_size[0] - cx) / focal)
        seen = forward > -radius
        for side, sign in zip(sides, (-1.0, 1.0), strict=True):
            seen &= sign * right - side * forward < radius * np.hypot(1.0, side)
        return np.nonzero(seen)[0], np.zeros(int(seen.sum()), dtype=np.float32)
    azimuth, reach = np.arctan2(right, forward), np.hypot(right, forward)
    half = np.arcsin(np.minimum(radius / np.maximum(reach, 1e-6), 1.0))
    torn = np.nonzero(np.abs(azimuth) + half > np.pi)[0]
    shift = -2.0 * np.pi * np.sign(azimuth[torn])
    chosen = np.concatenate([np.arange(len(spheres)), torn])
    return chosen, np.concatenate([azimuth, azimuth[torn] + shift]).astype(np.float32)


def draw_commands(
    levels: NDArray[np.int64], meshes: NDArray[np.int64], library: Library, reach: NDArray[np.floating[Any]]
) -> tuple[NDArray[np.int64], Records]:
    """The order of instances, mesh by mesh with near ones first, and one command per mesh and level in use."""
    kinds = library.commands.shape[1]
    key = levels * kinds + meshes
    order = np.lexsort((reach, key))
    used, first, count = np.unique(key[order], return_index=True, return_counts=True)
    commands = library.commands.reshape(-1)[used]
    commands["instances"], commands["instance"] = count, first
    return order, commands


def lens(camera: Camera, size: tuple[int, int]) -> tuple[float, float, float, float]:
    """Clip x = a right + b w and clip y = c drop + d w (see ``frame.glsl``); a panorama needs c and d only."""
    width, height = size
    if camera.cylinder is not None:
        focal, row = camera.cylinder
        return 0.0, 0.0, 2.0 * focal / height, 2.0 * row / height - 1.0
    (across, _, cx), (_, down, cy) = np.asarray(camera.intrinsics)[:2]
    return 2.0 * across / width, 2.0 * cx / width - 1.0, 2.0 * down / height, 2.0 * cy / height - 1.0
