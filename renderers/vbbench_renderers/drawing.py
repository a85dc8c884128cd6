"""The input of a backend: a library of limb meshes, the limbs of a frame, and the surroundings.

All backends share it.
A limb is a mesh of the library, placed by a transform and dyed by its own colours; a person is some twenty of them.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from vbbench_renderers import _core
from vbbench_renderers.mesh import Float32, Int32, Mesh


class Pattern(IntEnum):
    """Where a limb shows its second colour, by the point (x, y, z) of the limb's own frame; frac(a) = a − ⌊a⌋."""

    PLAIN = 0
    """Nowhere."""
    RINGS = 1
    """Where frac(`RINGS_PER_M` z) < ½."""
    STRIPES = 2
    """Where frac(`STRIPES_ROUND` atan2(y, x) / 2π) < ½."""
    CHECKS = 3
    """Where either frac(`CHECKS_PER_M` x) < ½ or frac(`CHECKS_PER_M` z) < ½, not both."""
    LOWER_HALF = 4
    """Where z < 0."""


RINGS_PER_M, STRIPES_ROUND, CHECKS_PER_M = _core.RINGS_PER_M, _core.STRIPES_ROUND, _core.CHECKS_PER_M

SHADOW_HALF_WIDTH, SHADOW_AHEAD = 16.0, 12.0
"""Half the width (m) of the square in which people cast shadows, and how far it is ahead of a camera that looks in one
way."""
LARGEST_SHADOW_HALF_WIDTH = 80.0
"""The largest half width (m) of the same square for objects that do not move."""
FOOT_HEIGHT = 0.3
"""Limbs centred below this height (m) darken the ground under them."""
SHADOW_TEXELS, FIXED_SHADOW_TEXELS = 1024, 2048
"""Width of the shadow maps of people and of objects that do not move."""


@dataclass(frozen=True, kw_only=True)
class Limbs:
    """The limbs of everybody who is drawn in a frame, one row per limb.

    Parameters
    ----------
    mesh : [N] index in the library.
    transform : [N, 3, 4] from the limb's frame to the world: x_world = A x_limb + b; A may scale and shear.
    colour, second_colour : [N, 3] linear RGB in 0 … 1, multiplied with the mesh's own colours.
    pattern : [N] `Pattern`.
    gloss : [N] strength of the highlight, 0 … 1.
    person : [N] column of the person in the scene.
    """

    mesh: Int32
    transform: Float32
    colour: Float32
    second_colour: Float32
    pattern: Int32
    gloss: Float32
    person: Int32


@dataclass(frozen=True, kw_only=True)
class Sky:
    """Light and air, linear RGB.

    Parameters
    ----------
    sun_direction : [3] unit vector towards the sun.
    sun_colour : [3] irradiance of a surface that faces the sun.
    zenith, horizon : [3] colours of the sky; in between they mix by the square root of the sine of the elevation.
    ground_glow : [3] light from below, from the ground.
    haze_distance : m at which the air has taken 63 % of the contrast.
    """

    sun_direction: Float32
    sun_colour: Float32
    zenith: Float32
    horizon: Float32
    ground_glow: Float32
    haze_distance: float


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """Everything that does not move.

    Parameters
    ----------
    mesh : ground, façades, trees and furniture as one mesh.
    textures : [L, S, S, 3] uint8 sRGB layers, which repeat.
    sky : light and air.
    """

    mesh: Mesh
    textures: NDArray[np.uint8]
    sky: Sky
