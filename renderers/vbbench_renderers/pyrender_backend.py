"""Backend ``pyrender``: the common scene-graph renderer, off-screen through EGL or OSMesa, for comparison.

Ids and depth come from the segmentation pass: those of the colour pass are mixed from several samples at silhouettes.
The import is the only place with workarounds for faults of pyrender 0.1.45; it changes no other library.

* It opens an interactive viewer's libraries on import, which need a display: a stand-in is imported for that module.
* It uses ``np.infty``, which NumPy 2 dropped: its own modules see a NumPy that has it.
* It reads PYOPENGL_PLATFORM when PyOpenGL is first imported and whenever a renderer is made: the variable is set for
  as long as that takes.
"""

import ctypes.util
import importlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench.camera import Camera
from vbbench.errors import VbbenchError, needs_extra
from vbbench.geometry import FloatArray
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers.meshes import PLAIN, Float32, Limbs, Mesh, Sky, Surroundings, join_meshes, linear_to_srgb
from vbbench_renderers.people import Walkers
from vbbench_renderers.raster import normals_of
from vbbench_renderers.surroundings import surroundings_of
from vbbench_renderers.views import NEAR, assemble, eye_transform

FAR = 1000.0
_VARIABLE = "PYOPENGL_PLATFORM"
_LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}
_MESA = "install Mesa (on Debian mesa-utils-bin), or use backend 'raster'"


class PyrenderRenderer:
    """Draws a scene with pyrender; a `vbbench.pictures.rendering.Renderer`.

    Parameters
    ----------
    scene : its people are drawn.
    seed : of looks and surroundings.
    surroundings : draw houses, trees and lamps; otherwise ground and sky only.
    """

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        self._scene = scene
        self._screen: Any = open_off_screen(64, 64)
        name = importlib.import_module("OpenGL.GL")
        self._device = f"{name.glGetString(name.GL_RENDERER).decode()}, through pyrender"
        self._people = Walkers(scene, seed)
        self._pyrender, around = load_pyrender(), surroundings_of(scene, seed, plain=not surroundings)
        sky = around.sky
        self._stage: Any = self._pyrender.Scene(
            bg_color=[*linear_to_srgb(0.5 * (sky.horizon + sky.zenith)).tolist(), 1.0],
            ambient_light=0.5 * (0.4 * sky.horizon + 0.6 * sky.zenith + sky.ground_glow),
        )
        self._codes: dict[Any, tuple[int, int, int]] = {}
        self._drawn: list[Any] = []
        self._camera: Any = None
        self._add_sun(sky)
        self._add_surroundings(around)

    @property
    def device(self) -> str:
        """See `vbbench.pictures.rendering.Renderer`."""
        return self._device

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """See `vbbench.pictures.rendering.Renderer`."""
        if self._screen is None:
            raise VbbenchError("this renderer was closed")
        pose = np.asarray(pose, np.float64)
        without = None if observer is None else self._scene.column_of(observer)
        self._set_people(self._people.limbs(frame, pose[:2], camera.focal, without=without))
        return self._shoot(camera, pose) if camera.intrinsics is not None else assemble(camera, pose, self._shoot)

    def close(self) -> None:
        """Give back the context."""
        if self._screen is not None:
            self._screen.delete()
            self._screen = None

    def _shoot(self, camera: Camera, pose: FloatArray) -> Picture:
        """What a pinhole sees."""
        self._screen.viewport_width, self._screen.viewport_height = camera.picture_size
        self._set_camera(camera, pose)
        flags = self._pyrender.RenderFlags
        rgb, _ = self._screen.render(self._stage, flags=flags.NONE)
        codes, depth = self._screen.render(self._stage, flags=flags.SEG, seg_node_map=self._codes)
        rows = codes.astype(np.int32) @ np.array([65536, 256, 1], np.int32)
        depth = np.where(depth == 0.0, np.inf, depth).astype(np.float32)
        ids = np.append(NOBODY, self._scene.people).astype(np.int32)[rows]
        return Picture(rgb=rgb, depth=depth, ids=ids)

    def _set_people(self, limbs: Limbs) -> None:
        """Replace the people by those of a frame, one node each: one per limb would cost ten times the draw calls."""
        for node in self._drawn:
            self._stage.remove_node(node)
            del self._codes[node]
        self._drawn = []
        starts = np.flatnonzero(np.diff(limbs.person, prepend=-1)).tolist()
        normals = normals_of(limbs)
        for first, last in pairwise([*starts, len(limbs.person)]):
            node = self._add(_baked(self._people.meshes, limbs, normals, range(first, last)))
            row = int(limbs.person[first]) + 1
            self._codes[node] = (row >> 16, row >> 8 & 255, row & 255)
            self._drawn.append(node)

    def _set_camera(self, camera: Camera, pose: FloatArray) -> None:
        """Look from a pose (x, y, yaw)."""
        if self._camera is not None:
            self._stage.remove_node(self._camera)
        eye = eye_transform(camera, pose)
        matrix = np.eye(4)
        matrix[:3, :3] = (np.diag([1.0, 1.0, -1.0]) @ eye[:, :3]).T
        matrix[:3, 3] = -eye[:, :3].T @ eye[:, 3]
        (fx, _, cx), (_, fy, cy) = np.asarray(camera.intrinsics)[:2].tolist()
        lens = self._pyrender.IntrinsicsCamera(fx=fx, fy=fy, cx=cx, cy=cy, znear=NEAR, zfar=FAR)
        self._camera = self._stage.add(lens, pose=matrix)

    def _add_sun(self, sky: Sky) -> None:
        towards = sky.sun_direction.astype(np.float64)
        side = np.cross([0.0, 1.0, 0.0], towards)
        side /= np.linalg.norm(side)
        pose = np.eye(4)
        pose[:3, :3] = np.column_stack([side, np.cross(towards, side), towards])
        self._stage.add(self._pyrender.DirectionalLight(color=sky.sun_colour, intensity=np.pi), pose=pose)

    def _add_surroundings(self, around: Surroundings) -> None:
        layers = around.mesh.layers[around.mesh.triangles[:, 0]]
        for layer in np.unique(layers):
            texture = None if layer == PLAIN else self._texture(around.textures[layer])
            node = self._add(around.mesh.piece(np.flatnonzero(layers == layer)), texture)
            self._codes[node] = (0, 0, 0)

    def _texture(self, layer: NDArray[np.uint8]) -> Any:
        """A repeating texture; row 0 is at v = 0, where pyrender has the last row."""
        sampler = self._pyrender.Sampler(wrapS=self._pyrender.GLTF.REPEAT, wrapT=self._pyrender.GLTF.REPEAT)
        return self._pyrender.Texture(sampler=sampler, source=np.ascontiguousarray(layer[::-1]), source_channels="RGB")

    def _add(self, mesh: Mesh, texture: Any = None) -> Any:
        primitive = self._pyrender.Primitive(
            positions=mesh.vertices,
            normals=mesh.normals,
            color_0=np.column_stack([mesh.colours, np.ones(len(mesh.colours), np.float32)]),
            texcoord_0=None if texture is None else mesh.uv,
            indices=mesh.triangles,
            material=self._pyrender.MetallicRoughnessMaterial(
                baseColorTexture=texture, metallicFactor=0.0, roughnessFactor=1.0, doubleSided=True
            ),
        )
        return self._stage.add(self._pyrender.Mesh(primitives=[primitive], is_visible=True))


def _baked(meshes: tuple[Mesh, ...], limbs: Limbs, normals: Float32, rows: range) -> Mesh:
    """The limbs of a person as one mesh in the world; vertices are too far apart to show patterns of clothes."""
    placed = []
    for row in rows:
        mesh, turn = meshes[limbs.mesh[row]], limbs.transform[row]
        outward = mesh.normals @ normals[row].T
        placed.append(
            replace(
                mesh,
                vertices=mesh.vertices @ turn[:, :3].T + turn[:, 3],
                normals=outward / (np.linalg.norm(outward, axis=1, keepdims=True) + 1e-20),
                colours=mesh.colours * limbs.colour[row],
            )
        )
    return join_meshes(placed)


class _OlderNumpy:
    """NumPy with the names that pyrender still uses."""

    infty = np.inf

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)


def load_pyrender() -> Any:
    """The module `pyrender`, ready for off-screen use.

    Raises VbbenchError if it is not installed or finds no OpenGL.
    """
    if "pyrender" not in sys.modules:
        with needs_extra("pyrender", "backend 'pyrender'"), off_screen():
            _import_without_viewer()
    mesh: Any = sys.modules["pyrender.mesh"]
    if not hasattr(mesh.np, "infty"):
        mesh.np = _OlderNumpy()
    return sys.modules["pyrender"]


def open_off_screen(width: int, height: int) -> Any:
    """A `pyrender.OffscreenRenderer`.

    Raises VbbenchError if no context can be made.
    """
    pyrender = load_pyrender()
    with off_screen() as platform:
        try:
            return pyrender.OffscreenRenderer(width, height)
        except Exception as error:  # OpenGL's errors have no common base
            raise VbbenchError(f"pyrender gets no {platform} context ({type(error).__name__}); {_MESA}") from error


@contextmanager
def off_screen() -> Iterator[str]:
    """PYOPENGL_PLATFORM as it was set, otherwise EGL if available, otherwise OSMesa; restored afterwards."""
    before = os.environ.get(_VARIABLE)
    platform = before if before in _LIBRARIES else _first_library()
    os.environ[_VARIABLE] = platform
    try:
        yield platform
    finally:
        if before is None:
            del os.environ[_VARIABLE]
        else:
            os.environ[_VARIABLE] = before


def _first_library() -> str:
    for platform, library in _LIBRARIES.items():
        if ctypes.util.find_library(library):
            return platform
    raise VbbenchError(f"pyrender needs EGL or OSMesa; {_MESA}")


def _import_without_viewer() -> None:
    stand_in: Any = ModuleType("pyrender.viewer")
    stand_in.Viewer = None
    sys.modules["pyrender.viewer"] = stand_in
    try:
        pyrender = importlib.import_module("pyrender")
    except Exception as error:  # PyOpenGL passes on the exceptions of its platform
        for name in [name for name in sys.modules if name.split(".")[0] == "pyrender"]:
            del sys.modules[name]
        if isinstance(error, ModuleNotFoundError):
            raise
        raise VbbenchError(f"pyrender cannot be imported ({type(error).__name__}: {error}); {_MESA}") from error
    del sys.modules["pyrender.viewer"], pyrender.Viewer
