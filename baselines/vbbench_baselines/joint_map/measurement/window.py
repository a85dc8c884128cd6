"""The frames that are solved together: what is known of them, and the window that a causal solver keeps of the last."""

from typing import Any, NamedTuple

import numpy as np

from vbbench.geometry import FloatArray, IntArray, relative_to_world
from vbbench.kernels import kernel
from vbbench.sequence import Given
from vbbench_baselines.common.sightings import Sightings
from vbbench_baselines.joint_map.measurement.boxes import Statures, inform

HELD = 4
"""Places of a walk that innovations of later frames reach back to."""


class Continued(NamedTuple):
    """What frames that are gone tell of walks that go on: of K people and, last, of the observer, [K + 1].

    Attributes
    ----------
    held : [K + 1] of how many frames, from the first on, the innovations are accounted for; 0 where a walk begins.
    places, slope, information : [K, 4, 2], [K, 4, 2] and [K, 4, 4] of people's first places: the energy qᵀd + ½ dᵀQd,
        in both coordinates, of their distance d from ``places``. What leaves of the observer is kept with the poses.
    tally : [K + 1, 2] number of innovations that are gone, and Σ u m² in m² of them (`motion.walks`).
    """

    held: IntArray
    places: FloatArray
    slope: FloatArray
    information: FloatArray
    tally: FloatArray


def nothing_continued(people: int) -> Continued:
    """For walks that all begin."""
    places, slope = np.zeros((2, people, HELD, 2))
    held = np.zeros(people + 1, np.int64)
    return Continued(held, places, slope, np.zeros((people, HELD, HELD)), np.zeros((people + 1, 2)))


class Measurements(NamedTuple):
    """What is known of T frames and K people, as the kernels take it; NaN = absent.

    Attributes
    ----------
    relative : [T, K, 2] z in m for the statures' means.
    information : [T, K, 3] N⁻¹ as (rr, rf, ff) in 1/m².
    given : [T, K, 2] positions in m.
    first, last : [K] the frames between which a person is followed; last < first for nobody.
    stature, stature_variance : [K] μ in m and σ_s² in m².
    continued : what frames before tell.
    """

    relative: FloatArray
    information: FloatArray
    given: FloatArray
    first: IntArray
    last: IntArray
    stature: FloatArray
    stature_variance: FloatArray
    continued: Continued


def gather(
    relative: FloatArray,
    information: FloatArray,
    given: FloatArray,
    statures: Statures,
    continued: Continued | None = None,
) -> Measurements:
    """Each person's measurements, from the first to the last frame with any; ``None``: all walks begin here."""
    given = np.require(given, requirements="W")  # for kernels, arrays that are read-only are another type to compile
    if continued is None:
        continued = nothing_continued(relative.shape[1])
    first, last = spans_of(relative, given, continued.held)
    return Measurements(relative, information, given, first, last, statures.mean, statures.variance, continued)


@kernel
def spans_of(relative: FloatArray, given: FloatArray, held: IntArray) -> tuple[IntArray, IntArray]:
    """The frames [K] between which people are followed, those whose walks go on with their ``held`` [K + 1] frames."""
    frames, people = given.shape[:2]
    first, last = np.zeros(people, np.int64), np.full(people, -1)
    for t in range(frames):
        for k in range(people):
            if not (np.isnan(relative[t, k, 0]) and np.isnan(given[t, k, 0])):
                if last[k] < 0:
                    first[k] = t
                last[k] = t
    for k in range(people):
        if held[k] > 0 and last[k] >= 0:
            first[k], last[k] = 0, max(last[k], held[k] - 1)
    return first, last


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
        self._rows = [np.full(shape, np.nan) for shape in ((2, size, 3), (3, size, people, 2))]
        self._name_rows()
        self.information = np.full((size, people, 3), np.nan)
        self.motions, self.covariances = np.full((size, 3), np.nan), np.full((size, 3, 3), np.nan)
        self.new = np.zeros(size, np.int64)

    def _name_rows(self) -> None:
        self.poses, self.given_poses = self._rows[0]
        self.places, self.given, self.relative = self._rows[1]

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Of a copy: its named rows are parts of its own rows, not copies of what they were."""
        self.__dict__.update(state)
        self._name_rows()

    def push(self, seen: Sightings, statures: Statures, given: Given) -> None:
        """Add a frame, and what is given of the two before it."""
        self.frames += 1
        for rows in self._rows:
            rows[:, :-1] = rows[:, 1:]
            rows[:, -1] = np.nan
        for rows in (self.information, self.motions, self.covariances, self.new):
            rows[:-1] = rows[1:]
        self.motions[-1] = self.covariances[-1] = np.nan
        self.relative[-1], self.information[-1] = inform(seen, statures.mean)
        known = ~np.isnan(self.relative[..., 0])
        self.new[-1] = np.count_nonzero(known[-1] & (np.count_nonzero(known[:-1], axis=0) == 1))
        for latest, window in ((self._rows[0], given.poses), (self._rows[1][:2], given.positions)):
            np.copyto(latest[:, -3:], window, where=~np.isnan(window))
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

    def forget(self, columns: IntArray) -> None:
        """The ``columns`` [M] stand for new people from now on."""
        for rows in (self.places, self.given, self.relative, self.information):
            rows[:, columns] = np.nan

    def measurements(self, statures: Statures, continued: Continued, columns: IntArray | None = None) -> Measurements:
        """The rows in use as the kernels take them; only these ``columns`` [M], if any are named.

        ``continued`` tells of these columns.
        """
        rows = self.filled
        relative, information, given = (
            chosen(values[rows], columns, 1) for values in (self.relative, self.information, self.given)
        )
        statures = Statures(*(chosen(values, columns, 0) for values in statures))
        return gather(relative, information, given, statures, continued)


def chosen(values: FloatArray, columns: IntArray | None, axis: int) -> FloatArray:
    """The ``columns`` [M] of values along an axis, in memory of their own; all of them as they are for ``None``."""
    return values if columns is None else values.take(columns, axis=axis)
