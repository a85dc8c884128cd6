"""Boxes as the joint solver sees them: rays that know their range from the feet, or from the height of the box.

A box's bottom stands at v + l/2 = c_y + f·h_0/r, whoever it shows: it measures the distance as a box of height
v + l/2 − c_y of somebody as tall as the camera's mount would, with the noise of one edge instead of two; so in a level
camera, and `Camera.to_horizon` makes that box in any. What the top
adds, (h_0 − h)²/h_0² of that information where the height h is known, is under one per cent for people about as tall
as the mount; it is left out, and no height is unknown any more. Without feet, the box height l = f·h/r and the prior of
h are all there is.

The same two edges tell how tall people are, wherever the camera is: h = h_0·l/(v + l/2 − c_y) in a level camera,
`Camera.statures` in any. With independent errors
of σ px in top and bottom edge,

    var h = σ² (h_0² + (h_0 − h)²)/(v + l/2 − c_y)².

All boxes of a person and the prior N(μ_h, σ_h²) are put together by their precisions.
"""

from typing import NamedTuple, TypedDict

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench.solver import Problem
from vbbench_baselines.common.ego_motion import invert
from vbbench_baselines.common.sightings import Sightings, measure, sight
from vbbench_baselines.joint_map.measurement.hiding import Hiding

FLOOR = 1e-3
"""Standard deviation in m that every measured place has at least, exact boxes or not."""

HEIGHT_FLOOR = 1e-4
"""The same of every measured height."""

LOWEST_FOOT = 1.0
"""Boxes that end less than so many px below the horizon are too far away, or too high, to measure anybody's height."""

MOST_SURPRISING, SURPRISED, EXPECTING = 25.0, 3.0, 2.0
"""Squared deviations of implied heights: most that one box counts, the mean from which on feet are not trusted, and the
number of people as which the expectation, one, counts."""

UNTOLD, ASIDE = 1.0, 0.03
"""Of a box whose feet are hidden: relative standard deviation of the distance, and standard deviation in m sideways for
each m of the stature, since what shows of somebody may be one side."""

FARTHEST = 1.5
"""Nobody is taken to be more than so many times as far, or as near, as measured."""


class Statures(NamedTuple):
    """What scales the rays: heights of people, or the mount's.

    Attributes
    ----------
    mean, variance : [K] in m and m²; a variance of zero is a known one.
    """

    mean: FloatArray
    variance: FloatArray


class Eye:
    """What turns boxes into rays.

    Parameters
    ----------
    problem : tells camera and noise.
    feet : whether a box tells its distance by its bottom, else by its height.
    """

    def __init__(self, problem: Problem, feet: bool) -> None:
        self._camera, self._pixel_std, self._feet = problem.camera, problem.pixel_std, feet
        self._hiding = Hiding(problem, level=feet)
        self._hidden = np.zeros(len(problem.tracks), np.bool_)

    def sight(self, boxes: FloatArray) -> Sightings:
        """Rays of boxes [..., K, 3] in px: per metre of the mount's height from the feet, of the person's otherwise.

        Frames come in order. Boxes whose feet are hidden tell hardly any distance, and the direction not exactly.
        """
        self._hidden = hidden = self._hiding.hidden(boxes)
        rays, sideways, stretch = sight(
            self._camera, self._camera.to_horizon(boxes) if self._feet else boxes, self._pixel_std
        )
        if self._feet:
            stretch = stretch * np.sqrt(0.5)
        if not hidden.any():
            return Sightings(rays, sideways, stretch)
        across = rays[..., ::-1] * (1.0, -1.0) / np.hypot(rays[..., 0], rays[..., 1])[..., None]
        across *= np.sqrt(ASIDE**2 + (sideways**2).sum(axis=-1))[..., None]
        sideways = np.where(hidden[..., None], across, sideways)
        return Sightings(rays, sideways, np.where(hidden, np.maximum(stretch, UNTOLD), stretch))

    def with_feet(self, boxes: FloatArray) -> FloatArray:
        """The ``boxes`` that were sighted last, those whose feet are hidden as if they were not there."""
        return np.where(self._hidden[..., None], np.nan, boxes)

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people."""
        self._hiding.forget(columns)


class GroundCheck:
    """Whether the ground is as flat and the camera as level as feet need, by the heights that feet imply.

    Feet that stand elsewhere than the camera's model says make people at a distance giants or dwarfs. The squared
    deviations of implied heights from N(μ_h, σ_h²) and the boxes' noise, averaged over each person's boxes and then
    over people, are about one where the model holds.

    Parameters
    ----------
    problem : tells camera, noise and the prior of heights.

    Attributes
    ----------
    boxes : [K] how many of each person it looked at.
    """

    def __init__(self, problem: Problem) -> None:
        self._camera, self._pixel_std = problem.camera, problem.pixel_std
        self._mean, self._variance = problem.height_mean, max(problem.height_std, HEIGHT_FLOOR) ** 2
        self._surprises, self.boxes = np.zeros((2, len(problem.tracks)))

    def look(self, boxes: FloatArray) -> bool:
        """Whether feet can still be trusted after the boxes [..., K, 3] in px; NaN = none."""
        (feet, heights), mount = self._camera.statures(boxes), self._camera.mount_height
        with np.errstate(divide="ignore", invalid="ignore"):
            noise = (self._pixel_std / feet) ** 2 * (mount**2 + (mount - heights) ** 2)
            squared = np.minimum((heights - self._mean) ** 2 / (self._variance + noise), MOST_SURPRISING)
        squared[feet < LOWEST_FOOT] = MOST_SURPRISING
        shown = ~np.isnan(squared)
        over = tuple(range(boxes.ndim - 2))
        self._surprises += np.where(shown, squared, 0.0).sum(axis=over)
        self.boxes += shown.sum(axis=over)
        seen = self.boxes > 0
        surprises = self._surprises[seen] / self.boxes[seen]
        return bool(EXPECTING + surprises.sum() < SURPRISED * (EXPECTING + len(surprises)))

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people."""
        self._surprises[columns] = self.boxes[columns] = 0.0


def statures_of(problem: Problem, feet: bool) -> Statures:
    """What scales the rays of a problem's people before anything is seen."""
    people = len(problem.tracks)
    if feet:
        return Statures(np.full(people, problem.camera.mount_height), np.zeros(people))
    return Statures(np.full(people, problem.height_mean), np.full(people, problem.height_std**2))


@kernel
def inform(sightings: Sightings, statures: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where boxes [K] place people of known stature: places z [K, 2] in m and N⁻¹ [K, 3] as (rr, rf, ff) in 1/m²."""
    relative, noise = measure(sightings, statures, np.zeros(len(statures)))
    for k in range(len(statures)):
        n = noise[k]
        n[0], n[1], n[2] = invert(n[0] + FLOOR**2, n[1], n[2] + FLOOR**2)
    return relative, noise


@kernel
def farther(relative: FloatArray, place: FloatArray, pose: FloatArray) -> float:
    """The ratio q = r/r_m: how many times as far as measured (``relative`` [2]) a ``place`` [2] is from ``pose`` [3].

    A box measures 1/r with an error that does not depend on r. To first order about r this is the distance
    2r − r²/r_m = r_m(2q − q²) with the standard deviation of the measured distance times q². Taken at the measured
    distance instead, boxes that came out too low, and so too near, would count more and stray less, and everybody
    would seem to come nearer too fast.
    """
    return ratio(relative[0], relative[1], place[0] - pose[0], place[1] - pose[1])


@kernel
def ratio(right: float, forward: float, x: float, y: float) -> float:
    """`farther` of a measured place and one that is (``x``, ``y``) away."""
    return float(min(max(np.sqrt(x**2 + y**2) / np.sqrt(right**2 + forward**2), 1.0 / FARTHEST), FARTHEST))


class Report(TypedDict, total=False):
    """What an estimate says of heights: means [K] in m and variances [K] in m²."""

    heights: FloatArray
    height_variances: FloatArray


class BoxHeights:
    """Everybody's height as their boxes alone tell so far.

    Attributes
    ----------
    precision, weighted : [K] Σ 1/var in 1/m² and Σ h/var in 1/m, the prior's among them.
    """

    def __init__(self, problem: Problem) -> None:
        people = len(problem.tracks)
        self._known, self._mean = 1.0 / max(problem.height_std, HEIGHT_FLOOR) ** 2, problem.height_mean
        self.precision = np.full(people, self._known)
        self.weighted = np.full(people, self._known * self._mean)
        self._camera, self._pixel_std = problem.camera, problem.pixel_std

    def learn(self, boxes: FloatArray) -> None:
        """Take in the boxes [K, 3] of a frame, or [T, K, 3], in px; NaN = none."""
        boxes = boxes if boxes.ndim == 3 else boxes[None]
        feet, heights = map(np.ascontiguousarray, self._camera.statures(boxes))  # a slice would compile once more
        _learn(feet, heights, self._camera.mount_height, self._pixel_std, self.precision, self.weighted)

    def forget(self, columns: IntArray) -> None:
        """The columns [M] stand for new people."""
        self.precision[columns], self.weighted[columns] = self._known, self._known * self._mean

    def report(self) -> Report:
        """What is believed so far."""
        return {"heights": self.weighted / self.precision, "height_variances": 1.0 / self.precision}


@kernel
def _learn(
    feet: FloatArray, heights: FloatArray, mount: float, std: float, precision: FloatArray, weighted: FloatArray
) -> None:
    for t in range(feet.shape[0]):
        for k in range(feet.shape[1]):
            foot, height = feet[t, k], heights[t, k]
            if foot >= LOWEST_FOOT:
                known = 1.0 / (HEIGHT_FLOOR**2 + (std / foot) ** 2 * (mount**2 + (mount - height) ** 2))
                precision[k] += known
                weighted[k] += known * height
