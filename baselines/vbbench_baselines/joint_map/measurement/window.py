"""The frames that are solved together: what is known of them, and the window that a causal solver keeps of the last."""

from typing import NamedTuple

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray, relative_to_world
from vbbench.sequence import Given
from vbbench_baselines.common.sightings import Sightings
from vbbench_baselines.joint_map.measurement.boxes import Statures, inform


class Measurements(NamedTuple):
    """What is known of T frames and K people, as the kernels take it; NaN = absent.

    Attributes
    ----------
    relative : [T, K, 2] z in m for the statures' means.
    information : [T, K, 3] N⁻¹ as (rr, rf, ff) in 1/m².
    given : [T, K, 2] positions in m.
    first, last : [K] the frames between which a person is followed; last < first for nobody.
    stature, stature_variance : [K] μ in m and σ_s² in m².
    """

    relative: FloatArray
    information: FloatArray
    given: FloatArray
    first: IntArray
    last: IntArray
    stature: FloatArray
    stature_variance: FloatArray


def gather(relative: FloatArray, information: FloatArray, given: FloatArray, statures: Statures) -> Measurements:
    """Each person's measurements, from the first to the last frame with any."""
    known: BoolArray = ~(np.isnan(relative[..., 0]) & np.isnan(given[..., 0]))
    frames = len(known)
    first: IntArray = np.argmax(known, axis=0)
    last: IntArray = np.where(known.any(axis=0), frames - 1 - np.argmax(known[::-1], axis=0), -1)
    return Measurements(relative, information, given, first, last, statures.mean, statures.variance)


class Window:
    """The last frames, at most ``size``, in arrays whose last row is the newest; NaN = absent or unknown.

    Attributes
    ----------
    poses, places : [n, 3] and [n, K, 2] as believed.
    given_poses, given : [n, 3] and [n, K, 2].
    relative, information : [n, K, 2] and [n, K, 3], see `Measurements`.
    motions, covariances : [n, 3] and [n, 3, 3] of the observer's odometry, see `vbbench.sequence.Odometry`.
    new : [n] how many people were seen for the second time.
    frames : how many were pushed.
    """

    def __init__(self, size: int, people: int) -> None:
        self.size, self.frames = size, 0
        self.poses, self.given_poses = np.full((2, size, 3), np.nan)
        self.places, self.given, self.relative = np.full((3, size, people, 2), np.nan)
        self.information = np.full((size, people, 3), np.nan)
        self.new = np.zeros(size, np.int64)
        self.motions, self.covariances = np.full((size, 3), np.nan), np.full((size, 3, 3), np.nan)

    def push(self, seen: Sightings, statures: Statures, given: Given) -> None:
        """Add a frame, and what is given of the two before it."""
        self.frames += 1
        poses, people = (self.poses, self.given_poses), (self.places, self.given, self.relative, self.information)
        for rows in (*poses, *people, self.motions, self.covariances):
            rows[:-1] = rows[1:]
            rows[-1] = np.nan
        self.relative[-1], self.information[-1] = inform(seen, statures.mean)
        known = ~np.isnan(self.relative[..., 0])
        self.new[:-1] = self.new[1:]
        self.new[-1] = np.count_nonzero(known[-1] & (np.count_nonzero(known[:-1], axis=0) == 1))
        for rows, window in (
            (self.poses, given.poses),
            (self.given_poses, given.poses),
            (self.places, given.positions),
            (self.given, given.positions),
        ):
            np.copyto(rows[-3:], window, where=~np.isnan(window))
        if given.odometry is not None:
            self.motions[-1], self.covariances[-1] = given.odometry.motions[-1], given.odometry.covariances[-1]

    @property
    def filled(self) -> slice:
        """The rows in use."""
        return slice(max(self.size - self.frames, 0), self.size)

    def measure_again(self, seen: list[Sightings], statures: Statures) -> None:
        """Take what was ``seen`` in the last frames in place of what was measured, and people to be there."""
        for row, sightings in zip(range(-len(seen), 0), seen, strict=True):
            gone = np.isnan(self.relative[row, :, 0])
            self.relative[row], self.information[row] = inform(sightings, statures.mean)
            self.relative[row, gone] = self.information[row, gone] = np.nan
            self.places[row] = relative_to_world(self.relative[row], self.poses[row])

    def present(self) -> IntArray:
        """The columns [M] of people of whom anything is known, ascending."""
        known = ~(np.isnan(self.relative[..., 0]) & np.isnan(self.given[..., 0]) & np.isnan(self.places[..., 0]))
        return np.flatnonzero(known.any(axis=0))

    def forget(self, columns: IntArray) -> bool:
        """The ``columns`` [M] stand for new people from now on; returns whether anything was known of the old ones."""
        known = not np.isnan(self.places[:, columns, 0]).all()
        for rows in (self.places, self.given, self.relative, self.information):
            rows[:, columns] = np.nan
        return known

    def measurements(self, statures: Statures, columns: IntArray | None = None) -> Measurements:
        """The rows in use as the kernels take them; only these ``columns`` [M], if any are named."""
        rows = self.filled
        relative, information, given = (
            chosen(values[rows], columns, 1) for values in (self.relative, self.information, self.given)
        )
        return gather(relative, information, given, Statures(*(chosen(values, columns, 0) for values in statures)))


def chosen(values: FloatArray, columns: IntArray | None, axis: int) -> FloatArray:
    """The ``columns`` [M] of values along an axis, in memory of their own; all of them as they are for ``None``."""
    return values if columns is None else values.take(columns, axis=axis)
