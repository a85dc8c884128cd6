"""Whose feet somebody nearer hides, or the picture's border: the bottom of such a box tells of no distance.

Three things tell. A box ends at the picture's lower border, or above the horizon. It ends where a nearer outline
begins, at its head or at its shoulders, or anywhere before somebody whose own feet are cut. Or its person seems to have
grown: cutting a box moves the height that it implies (`Camera.statures`) away from the camera's.
In most data boxes are of whole people, whoever is before them. There many end between the shoulders and the feet of a
nearer outline, right before its axis, which none does where people hide one another. So none is taken to be cut by
others once as many boxes have ended so as have ended where outlines begin.
"""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench.solver import Problem

SHOULDERS, HALF = 0.8, 0.12
"""Of a person's height, of a box that is whole: of the shoulders, and from the axis to the side of the body."""

NEAR, BEFORE = 0.7, 3.0
"""In px, besides a standard deviation: how near to where an outline begins a box that it cuts ends; and so many times
that is how much lower feet must be to be those of somebody nearer."""

LOWEST_FOOT = 3.0
"""In px below the horizon; feet that seem to be higher are hidden."""

GROWN, SURELY = 0.01, 4.0
"""In m, and in standard deviations besides: how much farther from the camera's an implied height is if feet are cut."""


class Hiding:
    """What boxes so far have told of who hides whom.

    Parameters
    ----------
    problem : tells camera and noise.
    """

    def __init__(self, problem: Problem) -> None:
        camera = self._camera = problem.camera
        self._period = camera.period or 0.0
        self._border = np.inf if camera.period is not None else float(camera.picture_size[1])
        self._std = problem.pixel_std
        self._ends = np.zeros(2)
        self._off, self._off_std = np.full(len(problem.tracks), np.inf), np.zeros(len(problem.tracks))

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people."""
        self._off[columns] = np.inf

    def hidden(self, boxes: FloatArray) -> BoolArray:
        """[..., K] whose feet are hidden, of boxes [..., K, 3] in px, of frames in order."""
        feet, heights = self._camera.statures(boxes)
        shape = (-1, boxes.shape[-2])
        frames = boxes.reshape(*shape, 3), feet.reshape(shape), heights.reshape(shape)
        lengths = self._camera.mount_height, self._border, self._period, self._std
        return _hidden(*frames, *lengths, self._ends, self._off, self._off_std).reshape(feet.shape)


@kernel
def _hidden(
    boxes: FloatArray,
    feet: FloatArray,
    heights: FloatArray,
    mount: float,
    border: float,
    period: float,
    std: float,
    ends: FloatArray,
    least: FloatArray,
    least_std: FloatArray,
) -> BoolArray:
    """[T, K] whose feet are hidden, of boxes [T, K, 3] whose ``feet`` [T, K] are so many px below the horizon.

    ``least`` [K] in m, with a standard deviation, is how near ``heights`` [T, K] that they imply were to the mount's.
    """
    frames, people = feet.shape
    cut = np.zeros((frames, people), np.bool_)
    for t in range(frames):
        for k in range(people):
            bottom = boxes[t, k, 1] + 0.5 * boxes[t, k, 2]
            cut[t, k] = feet[t, k] < LOWEST_FOOT or abs(bottom - border) <= NEAR + std
        behind = _behind(boxes[t], cut[t], NEAR + std, period, ends)
        for k in range(people):
            cut[t, k] |= behind[k] and ends[0] > ends[1]
            if cut[t, k] or np.isnan(feet[t, k]):
                continue
            off, off_std = abs(heights[t, k] - mount), std / feet[t, k] * np.hypot(mount, mount - heights[t, k])
            cut[t, k] = off > least[k] + GROWN + SURELY * np.hypot(off_std, least_std[k])
            if not cut[t, k] and off < least[k]:
                least[k], least_std[k] = off, off_std
    return cut


@kernel
def _behind(boxes: FloatArray, cut: BoolArray, near: float, period: float, ends: FloatArray) -> BoolArray:
    """[K] whose boxes end where somebody nearer begins; the feet of those who are ``cut`` [K] are not to be trusted.

    To ``ends`` [2] is added how many do, and how many end where nobody's can who is hidden by others.
    """
    hidden = np.zeros(len(boxes), np.bool_)
    bottoms, sides = boxes[:, 1] + 0.5 * boxes[:, 2], HALF * boxes[:, 2]
    for k in np.argsort(-bottoms):  # nearer people first
        inside = False
        for j in range(len(boxes)):
            if not bottoms[j] > bottoms[k] + BEFORE * near:
                continue
            aside = abs(boxes[k, 0] - boxes[j, 0])
            if period > 0.0:
                aside = min(aside, period - aside)
            head, shoulders = bottoms[j] - boxes[j, 2], bottoms[j] - SHOULDERS * boxes[j, 2]
            if cut[j] or hidden[j]:
                hidden[k] |= aside + 0.5 * sides[k] < sides[j] and bottoms[k] > head - near
            elif aside < sides[j] + sides[k]:
                hidden[k] |= min(abs(bottoms[k] - head), abs(bottoms[k] - shoulders)) <= near
                inside |= aside < 0.5 * (sides[j] - sides[k]) and bottoms[k] > shoulders + BEFORE * near
        if not cut[k] and (hidden[k] or inside):
            ends[0 if hidden[k] else 1] += 1.0
    return hidden
