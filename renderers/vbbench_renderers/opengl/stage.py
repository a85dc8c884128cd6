"""The data of a scene in an OpenGL context, and how a frame is drawn from it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray
from vbbench_renderers import _core
from vbbench_renderers.drawing import Limbs, Surroundings
from vbbench_renderers.mesh import Int32
from vbbench_renderers.opengl import light, packing
from vbbench_renderers.opengl.chunks import split_mesh
from vbbench_renderers.opengl.context import is_software, make_program, uniform
from vbbench_renderers.opengl.targets import Targets
from vbbench_renderers.people import Walkers

if TYPE_CHECKING:
    import moderngl

FRAME = np.dtype(
    [
        (name, np.float32, 4)
        for name in (
            "eye", "heading", "lens", "tilt_right", "tilt_down", "tilt_forward", "sun_direction", "sun_colour",
            "zenith", "horizon", "ground_glow", "window", "fixed_window",
        )
    ]
)  # fmt: skip
_PLACE = ("3f 3f 3f 3f", "position", "normal", "colour", "uv")
_LIMB = ("4f 4f 4f 4f 4f 1f 1f/i", "row_x", "row_y", "row_z", "first_dye", "second_dye", "base", "person")
MOST_REFINED = 3 * 40_000
_UNITS = (
    ("textures", "people_shadow", "fixed_shadow", "ground_map"),
    ("people_picture", "people_truth", "place_picture", "place_depth"),
)
"""Texture units of the samplers, while layers are drawn and while they are composed."""
Key = str | tuple[str, bool]


class Stage:
    """Buffers, programs and maps of one scene."""

    def __init__(self, context: "moderngl.Context", walkers: Walkers, around: Surroundings) -> None:
        self._context = context
        self.fine_place = not is_software(str(context.info["GL_RENDERER"]))  # too slow on a processor
        self._library = packing.pack_library([walkers.library(level) for level in range(walkers.levels)])
        self._shadow_level = walkers.levels - 1
        self._place = packing.pack_vertices(around.mesh)
        self._chunks = split_mesh(around.mesh)
        self._refined = np.empty((MOST_REFINED, _core.REFINED_COLUMNS), np.float32)
        self._make_buffers()
        self._make_programs()
        self._textures = _texture_array(context, around.textures, 8.0 if self.fine_place else 1.0)
        self._sun = around.sky.sun_direction
        self._shadows = light.Shadows(context)
        self._fixed_window = light.fixed_window(self._place)
        self._fixed_drawn = False

    def _make_buffers(self) -> None:
        buffer = self._context.buffer
        self._frame = buffer(reserve=FRAME.itemsize)
        self._limb_vertices = buffer(self._library.vertices)
        self._limb_triangles = buffer(self._library.triangles)
        self._place_vertices, self._place_triangles = buffer(self._place), buffer(self._chunks.triangles)
        self._refined_vertices = buffer(reserve=self._refined.nbytes, dynamic=True)
        self._instances = buffer(reserve=packing.INSTANCE.itemsize, dynamic=True)
        self._commands = buffer(reserve=packing.COMMAND.itemsize * self._library.commands.size, dynamic=True)
        self._chunk_bases = buffer(reserve=4, dynamic=True)
        self._chunk_commands = buffer(reserve=packing.COMMAND.itemsize, dynamic=True)
        self._spots = buffer(reserve=light.SPOT_BYTES, dynamic=True)

    def _make_programs(self) -> None:
        context = self._context
        programs: dict[Key, moderngl.Program] = {
            "blob": make_program(context, "blob.vert", "blob.frag"),
            "limb_shadow": make_program(context, "shadow_limb.vert", "nothing.frag"),
            "place_shadow": make_program(context, "shadow_place.vert", "nothing.frag"),
            "compose": make_program(context, "screen.vert", "compose.frag", ["FINE_PLACE"] if self.fine_place else []),
        }
        for panorama in (False, True):
            defines = ["PANORAMA"] if panorama else []
            for kind, vertex in (("limb", "limb"), ("place", "place"), ("sky", "screen")):
                programs[kind, panorama] = make_program(context, f"{vertex}.vert", f"{kind}.frag", defines)
        for program in programs.values():
            for units in _UNITS:
                for unit, name in enumerate(units):
                    if name in program:
                        uniform(program, name).value = unit
        self._programs = programs
        self._arrays = {name: self._vertex_array(name) for name in programs}
        self._refined_array = self._array(
            ("place", True), [(self._refined_vertices, f"{_PLACE[0]} 1f", *_PLACE[1:], "base")]
        )
        self.compose = self._arrays["compose"]

    def _vertex_array(self, name: Key) -> "moderngl.VertexArray":
        kind, panorama = name if isinstance(name, tuple) else (name, False)
        limb = [(self._limb_vertices, *_PLACE), (self._instances, *_LIMB)]
        if kind in ("limb", "limb_shadow"):
            return self._array(name, limb, self._limb_triangles)
        place = [(self._place_vertices, *_PLACE)]
        if kind == "place" and panorama:
            return self._array(name, [*place, (self._chunk_bases, "1f/i", "base")], self._place_triangles)
        if kind in ("place", "place_shadow"):
            return self._array(name, place, self._place_triangles)
        return self._array(name, [(self._spots, "2f 3f 3f/i", "centre", "axes", "effect")] if kind == "blob" else [])

    def _array(self, name: Key, content: list[Any], index: "moderngl.Buffer | None" = None) -> "moderngl.VertexArray":
        return self._context.vertex_array(self._programs[name], content, index_buffer=index, skip_errors=True)

    def draw(
        self,
        targets: Targets,
        frame: dict[str, Any],
        drawn: list[tuple[int, Limbs]],
        camera: Camera,
        pose: FloatArray,
        bodies: FloatArray,
    ) -> None:
        """Draw a frame.

        Parameters
        ----------
        targets : where people and surroundings are drawn.
        frame : values of `FRAME`, the fixed window excepted.
        drawn : limbs by level of detail.
        camera, pose : where the picture is taken.
        bodies : [N, 2] where people stand.
        """
        context, panorama = self._context, camera.cylinder is not None
        record = np.zeros((), dtype=FRAME)
        for name, value in frame.items():
            record[name] = value
        record["fixed_window"] = self._fixed_window
        self._frame.write(record)
        self._frame.bind_to_uniform_block(0)
        context.enable_only(context.DEPTH_TEST | context.CULL_FACE)
        context.depth_func = "<="
        context.front_face = "ccw"
        self._draw_fixed_shadows()
        shown, shadowed = self._upload_limbs(drawn, camera, pose, frame["window"], bodies)
        self._shadows.begin_people()
        self._arrays["limb_shadow"].render_indirect(self._commands, count=shadowed, first=shown)
        self._shadows.draw_contacts(self._arrays["blob"], self._spots.size // light.SPOT_BYTES)
        self._textures.use(0)
        self._shadows.use(1)
        context.front_face = "cw"  # rows count downwards
        targets.people.use()
        context.clear(depth=1.0)
        self._shift("limb", panorama, targets.shift(fine=True))
        self._arrays["limb", panorama].render_indirect(self._commands, count=shown)
        targets.place.use()
        context.clear(depth=1.0)  # starts drawing people in the background
        chunks, corners = self._upload_place(camera, pose)
        for kind in ("place", "sky"):
            self._shift(kind, panorama, targets.shift(self.fine_place))
        self._arrays["place", panorama].render_indirect(self._chunk_commands, count=chunks)
        if corners:
            self._refined_array.render(vertices=corners)
        self._arrays["sky", panorama].render(vertices=3)

    def _shift(self, kind: str, panorama: bool, shift: tuple[float, float]) -> None:
        uniform(self._programs[kind, panorama], "shift").value = shift

    def _draw_fixed_shadows(self) -> None:
        if not self._fixed_drawn:
            self._shadows.begin_fixed()
            self._arrays["place_shadow"].render()
            self._fixed_drawn = True

    def _upload_limbs(
        self, drawn: list[tuple[int, Limbs]], camera: Camera, pose: FloatArray, window: Any, bodies: FloatArray
    ) -> tuple[int, int]:
        """Upload limbs in view, limbs that cast shadows, and ground spots; return how many commands draw each."""
        instances, levels, meshes = packing.pack_limbs(drawn)
        spheres = packing.bounds(instances, meshes, self._library)
        reach = np.hypot(spheres[:, 0] - pose[0], spheres[:, 1] - pose[1])
        chosen, base = packing.in_view(spheres, camera, pose)
        order, shown = packing.draw_commands(levels[chosen], meshes[chosen], self._library, reach[chosen])
        visible = instances[chosen][order]
        visible["base"] = base[order]
        near = np.nonzero(np.abs(spheres[:, :2] - window[:2]).max(axis=1, initial=0.0) < 1.0 / window[2] + 2.0)[0]
        coarse = np.full(len(near), self._shadow_level)
        order, shadowed = packing.draw_commands(coarse, meshes[near], self._library, reach[near])
        shadowed["instance"] += len(visible)
        self._fill(self._instances, np.concatenate([visible, instances[near][order]]))
        self._fill(self._commands, np.concatenate([shown, shadowed]))
        lengths = packing.axes(instances[near], meshes[near], self._library)
        self._fill(self._spots, light.spots(spheres[near, :3], lengths, bodies.astype(np.float32), self._sun))
        return len(shown), len(shadowed)

    def _upload_place(self, camera: Camera, pose: FloatArray) -> tuple[int, int]:
        """Upload static objects in view; return how many chunks are not refined, and how many corners were."""
        chunks, corners = self._chunks, 0
        whole = np.arange(len(chunks.spheres))
        if camera.cylinder is not None:
            narrow = chunks.narrow(pose)
            whole = np.nonzero(narrow)[0]
            corners = self._upload_refined(camera, pose, chunks.triangles_of(~narrow))
        chosen, base = packing.in_view(chunks.spheres[whole], camera, pose)
        order, commands = chunks.drawn(whole[chosen], pose)
        self._fill(self._chunk_bases, base[order])
        self._fill(self._chunk_commands, commands)
        return len(commands), corners

    def _upload_refined(self, camera: Camera, pose: FloatArray, triangles: Int32) -> int:
        focal, row = np.asarray(camera.cylinder).tolist()
        eye, slope = np.array((*pose[:2], camera.mount_height)), (row + 2.0) / focal
        corners = len(self._refined) + 1
        while corners > len(self._refined):
            corners = _core.refine(self._place, triangles, eye, float(pose[2]), -slope, slope, self._refined)
            if corners > len(self._refined):
                self._refined, corners = np.empty((corners, _core.REFINED_COLUMNS), np.float32), corners + 1
        self._fill(self._refined_vertices, self._refined[:corners])
        return corners

    def _fill(self, buffer: "moderngl.Buffer", values: Any) -> None:
        if values.nbytes:
            buffer.orphan(values.nbytes)
            buffer.write(values)


def _texture_array(context: "moderngl.Context", layers: Any, anisotropy: float) -> "moderngl.TextureArray":
    count, size = layers.shape[:2]
    texture = context.texture_array((size, size, count), 3, np.ascontiguousarray(layers))
    texture.build_mipmaps()
    texture.filter = (context.LINEAR_MIPMAP_LINEAR, context.LINEAR)
    texture.anisotropy = anisotropy
    return texture
