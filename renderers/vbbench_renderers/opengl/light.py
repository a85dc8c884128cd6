"""Shadow maps of people and of static objects, and how much light reaches the ground under feet."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vbbench_renderers.drawing import (
    FIXED_SHADOW_TEXELS,
    FOOT_HEIGHT,
    LARGEST_SHADOW_HALF_WIDTH,
    SHADOW_AHEAD,
    SHADOW_HALF_WIDTH,
    SHADOW_TEXELS,
)
from vbbench_renderers.mesh import Float32

if TYPE_CHECKING:
    import moderngl

PENUMBRA = 1.5
SPOT_BYTES = 32


class Shadows:
    """Two depth maps along the sun, and a map of the light that reaches the ground."""

    def __init__(self, context: "moderngl.Context") -> None:
        self._context = context
        self._maps = [_depth_map(context, SHADOW_TEXELS), _depth_map(context, FIXED_SHADOW_TEXELS)]
        self._targets = [context.framebuffer(depth_attachment=part) for part in self._maps]
        self._ground = context.texture((SHADOW_TEXELS, SHADOW_TEXELS), 2)
        self._ground.repeat_x = self._ground.repeat_y = False
        self._ground_target = context.framebuffer(self._ground)

    def use(self, first_unit: int) -> None:
        """Bind the three maps for shaders: people, fixed, ground."""
        for n, part in enumerate((*self._maps, self._ground)):
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
        self._ground_target.use()
        self._ground_target.clear(1.0, 1.0, 1.0, 1.0)
        context.disable(context.DEPTH_TEST)
        context.enable(context.BLEND)
        context.blend_func = (context.ZERO, context.SRC_COLOR)
        blobs.render(context.TRIANGLE_STRIP, vertices=4, instances=count)
        context.disable(context.BLEND)
        context.enable(context.DEPTH_TEST)


def spots(centres: Float32, axes: Float32, bodies: Float32, sun: Float32) -> Float32:
    """[M, 8] soft dark ellipses on the ground, as ``blob.vert`` reads them.

    Every limb takes the sun: its ellipsoid with half axes a_i, projected along the sun, is an ellipse with the matrix
    Σ p_i p_iᵀ, where p_i = (x, y) − z s of a_i and s is the shadow of a stick 1 m high. Feet and bodies take the sky.

    Parameters
    ----------
    centres : [N, 3] of the limbs, in m.
    axes : [N, 3, 3] their half axes, in columns.
    bodies : [B, 2] where people stand.
    sun : [3] direction towards the sun.
    """
    stick = sun[:2] / sun[2]
    flat = axes[:, :2] - stick[:, None] * axes[:, 2:]
    soft = PENUMBRA * (0.03 + 0.012 * np.maximum(centres[:, 2], 0.0)) ** 2
    a = np.square(flat[:, 0]).sum(axis=1) + soft
    b = (flat[:, 0] * flat[:, 1]).sum(axis=1)
    c = np.square(flat[:, 1]).sum(axis=1) + soft
    l00 = np.sqrt(a)
    l10 = b / l00
    l11 = np.sqrt(np.maximum(c - l10 * l10, 1e-6))
    inner = np.clip(1.0 - 2.0 * np.sqrt(soft / np.minimum(a, c)), 0.0, 0.8)
    full, none = np.ones_like(l00), np.zeros_like(l00)
    rows = [np.column_stack((centres[:, :2] - stick * centres[:, 2:], l00, l10, l11, full, none, inner))]
    feet = centres[centres[:, 2] < FOOT_HEIGHT]
    rows.append(_round(feet[:, :2], 0.2, np.maximum(0.75 - 2.0 * feet[:, 2], 0.0)))
    rows.append(_round(bodies, 0.6, np.full(len(bodies), 0.35)))
    return np.concatenate(rows).astype(np.float32)


def _round(centres: Float32, radius: float, strength: NDArray[np.floating[Any]]) -> NDArray[np.floating[Any]]:
    row = np.tile((radius, 0.0, radius, 0.0, 0.0, 0.0), (len(centres), 1))
    row[:, 4] = strength
    return np.concatenate([centres, row], axis=1)


def fixed_window(vertices: Float32) -> Float32:
    """[4] the window of the map of static objects: its centre, 1 / half width, and the texel in m."""
    least, most = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
    half = min(float((most - least).max()) / 2, LARGEST_SHADOW_HALF_WIDTH)
    return window(0.5 * (least + most), half, FIXED_SHADOW_TEXELS)


def people_window(pose: NDArray[np.float64], ahead: bool) -> Float32:
    """[4] the window of people's shadows; it moves by whole texels, so that shadows do not flicker."""
    centre = pose[:2] + ahead * SHADOW_AHEAD * np.array((np.cos(pose[2]), np.sin(pose[2])))
    texel = 2.0 * SHADOW_HALF_WIDTH / SHADOW_TEXELS
    return window(np.round(centre / texel) * texel, SHADOW_HALF_WIDTH, SHADOW_TEXELS)


def window(centre: NDArray[np.floating[Any]], half: float, texels: int) -> Float32:
    """[4] as shaders read it."""
    return np.array((*centre, 1.0 / half, 2.0 * half / texels), dtype=np.float32)


def _depth_map(context: "moderngl.Context", texels: int) -> "moderngl.Texture":
    texture = context.depth_texture((texels, texels))
    texture.compare_func = "<="
    texture.filter = (context.LINEAR, context.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture
