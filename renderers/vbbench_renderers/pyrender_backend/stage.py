"""The scene graph: static objects, one mesh per person, a sun, a camera, and a sky behind everything."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray
from vbbench.scene import Scene
from vbbench_renderers import _core
from vbbench_renderers.drawing import Surroundings
from vbbench_renderers.mesh import PLAIN, Float32
from vbbench_renderers.people import Walkers
from vbbench_renderers.pyrender_backend.baking import bake
from vbbench_renderers.pyrender_backend.loading import load_pyrender
from vbbench_renderers.raster.crowd import joined_library, joined_limbs
from vbbench_renderers.raster.light import light_table, srgb_table
from vbbench_renderers.raster.parts import join_parts
from vbbench_renderers.rays import NEAR, camera_rays, eye_transform
from vbbench_renderers.surroundings import surroundings_of

FAR = 1000.0
_AXES = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])


class Stage:
    """One scene in pyrender's terms."""

    def __init__(self, scene: Scene, seed: int, surroundings: bool) -> None:
        self._pyrender = load_pyrender()
        around = surroundings_of(scene, seed, plain=not surroundings)
        self._people = Walkers(scene, seed)
        self._parts = join_parts(joined_library(self._people))
        self._light, self._table = light_table(around.sky), srgb_table()
        sky = around.sky
        self.scene: Any = self._pyrender.Scene(
            bg_color=[*sky.horizon.tolist(), 1.0],
            ambient_light=0.5 * (0.4 * sky.horizon + 0.6 * sky.zenith + sky.ground_glow),
        )
        self.codes: dict[Any, tuple[int, int, int]] = {}
        self._drawn: list[Any] = []
        self._camera: Any = None
        self._add_sun()
        self._add_surroundings(around)

    def set_people(self, frame: int, pose: FloatArray, focal: float, without: int | None) -> None:
        """Replace the people by those of a frame, except the one in column ``without``.

        A focal length of ``focal`` px decides their level of detail.
        """
        for node in self._drawn:
            self.scene.remove_node(node)
            del self.codes[node]
        self._drawn = []
        limbs = joined_limbs(self._people, frame, pose[:2], focal, without)
        baked = bake(self._parts, limbs)
        starts = np.flatnonzero(np.diff(limbs.person, prepend=-1))
        for first, last in zip(starts, [*starts[1:], len(limbs.person)], strict=True):
            points = slice(baked.first_point[first], baked.first_point[last])
            faces = baked.triangles[baked.first_triangle[first] : baked.first_triangle[last]]
            node = self._add(
                baked.points[points], baked.normals[points], baked.colours[points], faces - baked.first_point[first]
            )
            row = int(limbs.person[first]) + 1
            self.codes[node] = (row >> 16, row >> 8 & 255, row & 255)
            self._drawn.append(node)

    def set_camera(self, camera: Camera, pose: FloatArray) -> None:
        """Look from a pose (x, y, yaw)."""
        if self._camera is not None:
            self.scene.remove_node(self._camera)
        eye = eye_transform(camera, pose)
        matrix = np.eye(4)
        matrix[:3, :3] = (_AXES @ eye[:, :3]).T
        matrix[:3, 3] = -eye[:, :3].T @ eye[:, 3]
        (fx, _, cx), (_, fy, cy) = np.asarray(camera.intrinsics)[:2].tolist()
        lens = self._pyrender.IntrinsicsCamera(fx=fx, fy=fy, cx=cx, cy=cy, znear=NEAR, zfar=FAR)
        self._camera = self.scene.add(lens, pose=matrix)

    def with_sky(self, rgb: NDArray[np.uint8], empty: BoolArray, camera: Camera, pose: FloatArray) -> NDArray[np.uint8]:
        """Colours with the sky where nothing was drawn."""
        sky = _core.sky_picture(self._light, self._table, camera_rays(camera), eye_transform(camera, pose))
        return np.where(empty[..., None], sky, rgb)

    def _add_sun(self) -> None:
        towards, colour = self._light[0], self._light[1]
        side = np.cross([0.0, 1.0, 0.0], towards)
        side /= np.linalg.norm(side)
        pose = np.eye(4)
        pose[:3, :3] = np.column_stack([side, np.cross(towards, side), towards])
        self.scene.add(self._pyrender.DirectionalLight(color=colour, intensity=np.pi), pose=pose)

    def _add_surroundings(self, around: Surroundings) -> None:
        mesh = around.mesh
        layers = mesh.layers[mesh.triangles[:, 0]]
        for layer in np.unique(layers):
            used, faces = np.unique(mesh.triangles[layers == layer], return_inverse=True)
            texture = None if layer == PLAIN else self._texture(around.textures[layer])
            node = self._add(
                mesh.vertices[used],
                mesh.normals[used],
                mesh.colours[used],
                faces.reshape(-1, 3),
                texture,
                mesh.uv[used],
            )
            self.codes[node] = (0, 0, 0)

    def _texture(self, layer: NDArray[np.uint8]) -> Any:
        """A repeating texture; row 0 is at v = 0, where pyrender has the last row."""
        sampler = self._pyrender.Sampler(wrapS=self._pyrender.GLTF.REPEAT, wrapT=self._pyrender.GLTF.REPEAT)
        return self._pyrender.Texture(sampler=sampler, source=np.ascontiguousarray(layer[::-1]), source_channels="RGB")

    def _add(
        self, points: Float32, normals: Float32, colours: Float32, faces: Any, texture: Any = None, uv: Any = None
    ) -> Any:
        pyrender = self._pyrender
        material = pyrender.MetallicRoughnessMaterial(
            baseColorTexture=texture, metallicFactor=0.0, roughnessFactor=1.0, doubleSided=True
        )
        primitive = pyrender.Primitive(
            positions=points,
            normals=normals,
            color_0=np.column_stack([colours, np.ones(len(colours), np.float32)]),
            texcoord_0=None if texture is None else uv,
            indices=faces,
            material=material,
        )
        return self.scene.add(pyrender.Mesh(primitives=[primitive], is_visible=True))
