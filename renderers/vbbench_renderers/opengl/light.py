"""Shadow maps of people and of what stands still, and how open the ground is under feet."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vbbench_renderers.mesh import Float32

if TYPE_CHECKING:
    import moderngl

HALF_WIDTH = 16.0
"""m around its centre in which people throw shadows."""
AHEAD = 12.0
"""m by which that centre lies ahead of a camera that looks one way."""
TEXELS, FIXED_TEXELS, CONTACT_TEXELS = 1024, 2048, 512
LARGEST_HALF_WIDTH = 80.0
FOOT_HEIGHT = 0.3
"""Limbs below this height (m) darken the ground under them."""


class Shadows:
    """Two depth maps along the sun, and a map of the openness of the ground."""

    def __init__(self, context: "moderngl.Context") -> None:
        self._context = context
        self._maps = [_depth_map(context, TEXELS), _depth_map(context, FIXED_TEXELS)]
        self._targets = [context.framebuffer(depth_attachment=part) for part in self._maps]
        self._contact = context.texture((CONTACT_TEXELS, CONTACT_TEXELS), 1)
        self._contact.repeat_x = self._contact.repeat_y = False
        self._ground = context.framebuffer(self._contact)

    def use(self, first_unit: int) -> None:
        """Bind the three maps for shaders: people, fixed, contact."""
        for n, part in enumerate((*self._maps, self._contact)):
            part.use(first_unit + n)

    def begin_people(self) -> None:
        """Draw people's shadows from here on."""
        self._targets[0].use()
        self._targets[0].clear()

    def begin_fixed(self) -> None:
        """Draw the shadows of the surroundings from here on."""
        self._targets[1].use()
        self._targets[1].clear()

    def draw_contacts(self, blobs: "moderngl.VertexArray", count: int) -> None:
        """Darken the ground at ``count`` spots."""
        context = self._context
        self._ground.use()
        self._ground.clear(1.0, 1.0, 1.0, 1.0)
        context.disable(context.DEPTH_TEST)
        context.enable(context.BLEND)
        context.blend_func = (context.ZERO, context.SRC_COLOR)
        blobs.render(context.TRIANGLE_STRIP, vertices=4, instances=count)
        context.disable(context.BLEND)
        context.enable(context.DEPTH_TEST)

    def release(self) -> None:
        """Give back the memory."""
        parts: list[Any] = [*self._targets, self._ground, *self._maps, self._contact]
        for part in parts:
            part.release()


def spots(instances: NDArray[Any], bodies: Float32) -> Float32:
    """[N, 4] x, y, radius and strength of the dark spots: one under each foot, a wide one under each body."""
    centres = instances["rows"][:, :, 3]
    feet = centres[centres[:, 2] < FOOT_HEIGHT]
    near = np.column_stack((feet[:, :2], np.full(len(feet), 0.22), 0.55 - feet[:, 2]))
    wide = np.column_stack((bodies, np.full(len(bodies), 0.6), np.full(len(bodies), 0.45)))
    return np.concatenate([near, wide]).astype(np.float32)


def fixed_window(vertices: Float32) -> Float32:
    """[4] the window of the map of what stands still: its centre, 1 / half width, and the texel in m."""
    least, most = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
    return window(0.5 * (least + most), min(float((most - least).max()) / 2, LARGEST_HALF_WIDTH), FIXED_TEXELS)


def people_window(pose: NDArray[np.float64], ahead: bool) -> Float32:
    """[4] the window of people's shadows; it moves by whole texels, so that shadows do not crawl."""
    centre = pose[:2] + ahead * AHEAD * np.array((np.cos(pose[2]), np.sin(pose[2])))
    texel = 2.0 * HALF_WIDTH / TEXELS
    return window(np.round(centre / texel) * texel, HALF_WIDTH, TEXELS)


def window(centre: NDArray[np.floating[Any]], half: float, texels: int) -> Float32:
    """[4] as shaders read it."""
    return np.array((*centre, 1.0 / half, 2.0 * half / texels), dtype=np.float32)


def _depth_map(context: "moderngl.Context", texels: int) -> "moderngl.Texture":
    texture = context.depth_texture((texels, texels))
    texture.compare_func = "<="
    texture.filter = (context.LINEAR, context.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture
