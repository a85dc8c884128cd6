"""Whose feet somebody nearer hides, or the picture's border: the bottom of such a box tells of no distance.

Three things tell. A box ends at the picture's lower border, or at the horizon. It ends where a nearer outline begins,
at its head or at its shoulders, or anywhere before somebody whose own feet are cut. Or its person seems to have grown:
cutting a box moves the height that it implies (`Camera.statures`) away from the camera's, each time by another length.
In most data boxes are of whole people, whoever is before them. There many end between the shoulders and the feet of a
nearer outline, right before its axis, which none does where people hide one another. So none is taken to be cut by
others once more boxes have ended so than have ended where outlines begin.
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

AT_HORIZON, DOUBT = 1.0, 2.0
"""In px, and in standard deviations besides: feet that seem to be less below the horizon are hidden."""

GROWN, SURELY = 0.01, 4.0
"""In m, and in standard deviations besides: how much farther from the camera's an implied height is if feet are cut."""

AGREEING = 3
"""So many boxes in a row that imply one height are whole, whatever others implied: how far boxes are cut changes."""


IMPLIED = 4
"""Of each person: how near to the mount's an implied height was, its standard deviation, the same of the last box that
seemed to have grown, and how many in a row agreed with it."""


class Hiding:
    """What boxes so far have told of who hides whom.

    Parameters
    ----------
    problem : tells camera and noise.
    level : whether ground and camera are as the problem says, so that heights are implied and the horizon is known.
    """

    def __init__(self, problem: Problem, level: bool) -> None:
        camera, people = problem.camera, len(problem.tracks)
        self._camera, self._std, self._level = camera, problem.pixel_std, level
        self._period = camera.period or 0.0
        self._border = np.inf if camera.period is not None else float(camera.picture_size[1])
        self._ends, self._implied = np.zeros(2), np.empty((people, IMPLIED))
        self.forget(np.arange(people))

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people."""
        self._implied[columns] = np.inf, 0.0, np.inf, 0.0

    def hidden(self, boxes: FloatArray) -> BoolArray:
        """[..., K] whose feet are hidden, of boxes [..., K, 3] in px, of frames in order."""
        if boxes.size == 0:
            return np.zeros(boxes.shape[:-1], np.bool_)
        feet, heights = self._camera.statures(boxes)
        shape = (-1, boxes.shape[-2])
        frames = boxes.reshape(*shape, 3), feet.reshape(shape), heights.reshape(shape)
        lengths = self._camera.mount_height, self._border, self._period, self._std
        return _hidden(*frames, *lengths, self._level, self._ends, self._implied).reshape(feet.shape)


@kernel
def _hidden(
    boxes: FloatArray,
    feet: FloatArray,
    heights: FloatArray,
    mount: float,
    border: float,
    period: float,
    std: float,
    level: bool,
    ends: FloatArray,
    implied: FloatArray,
) -> BoolArray:
    """[T, K] whose feet are hidden, of boxes [T, K, 3] whose ``feet`` [T, K] are so many px below the horizon."""
    cut = np.zeros(feet.shape, np.bool_)
    top = -np.inf if period > 0.0 else NEAR + std
    for t in range(len(boxes)):
        _by_borders(boxes[t], feet[t], border, std, level, cut[t])
        _by_others(boxes[t], NEAR + std, period, ends, cut[t])
        if level:
            _by_growth(boxes[t], feet[t], heights[t], mount, std, top, implied, cut[t])
    return cut


@kernel
def _by_borders(boxes: FloatArray, feet: FloatArray, border: float, std: float, level: bool, cut: BoolArray) -> None:
    """Write to ``cut`` [K] whose boxes [K, 3] end at the lower ``border``, or at the horizon."""
    for k in range(len(boxes)):
        at_border = abs(boxes[k, 1] + 0.5 * boxes[k, 2] - border) <= NEAR + std
        cut[k] = at_border or (level and feet[k] < AT_HORIZON + DOUBT * std)


@kernel
def _by_others(boxes: FloatArray, near: float, period: float, ends: FloatArray, cut: BoolArray) -> None:
    """Add to ``cut`` [K] whose boxes end where somebody nearer begins, if people hide one another.

    To ``ends`` [2] is added how many do, and how many end where nobody's can who is hidden by others.
    """
    coincide, behind = np.zeros(len(boxes), np.bool_), np.zeros(len(boxes), np.bool_)
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
            if cut[j] or coincide[j] or behind[j]:
                behind[k] |= aside + 0.5 * sides[k] < sides[j] and bottoms[k] > head - near
            elif aside < sides[j] + sides[k]:
                coincide[k] |= min(abs(bottoms[k] - head), abs(bottoms[k] - shoulders)) <= near
                inside |= aside < 0.5 * (sides[j] - sides[k]) and bottoms[k] > shoulders + BEFORE * near
        if not cut[k] and (coincide[k] or inside):
            ends[0 if coincide[k] else 1] += 1.0
    if ends[0] >= ends[1]:
        for k in range(len(boxes)):
            cut[k] |= coincide[k] or behind[k]


@kernel
def _by_growth(
    boxes: FloatArray,
    feet: FloatArray,
    heights: FloatArray,
    mount: float,
    std: float,
    top: float,
    implied: FloatArray,
    cut: BoolArray,
) -> None:
    """Add to ``cut`` [K] who seems to have grown; ``implied`` [K, 4] is kept up, see `IMPLIED`.

    Boxes that begin above the row ``top``, at the upper border, imply nothing.
    """
    for k in range(len(boxes)):
        if cut[k] or np.isnan(feet[k]) or boxes[k, 1] - 0.5 * boxes[k, 2] <= top:
            continue
        off, spread = abs(heights[k] - mount), std / feet[k] * np.hypot(mount, mount - heights[k])
        least = implied[k]
        if off <= least[0] + GROWN + SURELY * np.hypot(spread, least[1]):
            if off < least[0]:
                least[0], least[1] = off, spread
            least[2] = np.inf
            continue
        agrees = abs(off - least[2]) <= GROWN + SURELY * spread
        least[2], least[3] = off, least[3] + 1.0 if agrees else 1.0
        if least[3] >= AGREEING:
            least[0], least[1], least[2] = off, spread, np.inf
        else:
            cut[k] = True
