"""How limbs look, as they are shaded."""

from typing import NamedTuple

import numpy as np

from vbbench_renderers.drawing import Limbs
from vbbench_renderers.mesh import Float32, Int32


class Looks(NamedTuple):
    """How N limbs look; see `Limbs`.

    Parameters
    ----------
    colour, second_colour : [N, 3].
    pattern, gloss : [N].
    normal : [N, 3, 3] from normals of the limb's frame to normals in the world, of any length.
    """

    colour: Float32
    second_colour: Float32
    pattern: Int32
    gloss: Float32
    normal: Float32


def looks_of(limbs: Limbs) -> Looks:
    """Looks of limbs. Normals turn with the cofactors of A, so that they stay normal however A shears."""
    a, b, c = limbs.transform[:, :, 0], limbs.transform[:, :, 1], limbs.transform[:, :, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    outward = np.sign(np.einsum("ni,ni->n", a, cofactors[:, :, 0]))[:, None, None]
    normal = np.ascontiguousarray(cofactors * outward, np.float32)
    return Looks(limbs.colour, limbs.second_colour, limbs.pattern, limbs.gloss, normal)
