"""What keeps a world that boxes alone tell of from shrinking.

Nobody knows the tracks x. With the rest z held, their energy is ½xᵀAx about its least, and what counts is the density
of z with x integrated out,

    E(z) + ½ ln det A(z),   A = P + B,

P of how people walk, which does not depend on how far off anybody is, and B of the boxes, which falls with the square
of the distance r: a box tells of shares. Without the second term a world is the likelier the smaller it is, since
nobody errs by much in it. By each ln r_t the term falls by

    w_t = tr (A⁻¹B)_tt,

how many numbers of the place its box tells of, between 0 and 2. w is taken as it was about the point before, and the
energy gets −Σ w_t ln(r_t − δ). Unless the start is cold, places are given and tell the scale, and the term is left out.
"""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_baselines.joint_map.optimiser.banded import BAND, invert
from vbbench_baselines.joint_map.real_camera.cues import CUES, LENGTH, Residuals, Whitened
from vbbench_baselines.joint_map.real_camera.elimination import Person


@kernel
def volume_deviance(found: Residuals, told: FloatArray, height: float) -> float:
    """−Σ w_t ln(r_t − δ) of a person, up to a constant, with w = ``told`` [n] and η = ``height``."""
    total = 0.0
    for i in range(len(found.frame)):
        total -= told[found.frame[i]] * (found.value[i, LENGTH] * found.scale[i, LENGTH] + height)
    return total


@kernel
def push(found: Residuals, told: FloatArray, white: Whitened) -> float:
    """Add its slope by the length's residuals to Ωq; returns Σ w_t, by which that by η is too large then."""
    total = 0.0
    for i in range(len(found.frame)):
        white.force[i, LENGTH] -= told[found.frame[i]] * found.scale[i, LENGTH]
        total += told[found.frame[i]]
    return total


@kernel
def told_of(person: Person) -> FloatArray:
    """How many numbers of its place the box in each frame of a person's track tells of, w_t [n]."""
    found, white, n = person.found, person.white, len(person.pull) // 2
    inverse, told = np.zeros((2 * n + BAND, 2 * BAND + 1)), np.zeros(n)
    invert(person.lower, inverse)
    for i in range(len(found.frame)):
        here = found.frame[i]
        for j in range(CUES):
            told[here] += white.diagonal[i, j] * _between(found, i, i, j, inverse)
            if i > 0 and white.beside[i, j] != 0.0:
                both = white.beside[i, j] * _between(found, i, i - 1, j, inverse)
                told[here] += both
                told[found.frame[i - 1]] += both
    return told


@kernel
def _between(found: Residuals, i: int, h: int, j: int, inverse: FloatArray) -> float:
    """The slopes of a cue of two boxes by their places, with A⁻¹ between them; ``inverse`` as of `banded.invert`."""
    total, row, column = 0.0, 2 * found.frame[i], 2 * found.frame[h]
    for a in range(2):
        for b in range(2):
            share = inverse[row + a, BAND + column + b - row - a]
            total += found.by_place[i, j, a] * share * found.by_place[h, j, b]
    return total
