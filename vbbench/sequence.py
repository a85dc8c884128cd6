"""A sequence: a run of consecutive frames of one scene, seen by one observer.

What a solver may see (`Sequence`), what it is given (`Given`) and what it never sees (`Truth`) are three types.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze
from vbbench.scene import Scene, World

NOBODY = -1
"""The person behind a false alarm, behind a box whose person's place was not measured, or in a pixel without people."""
NO_OBSERVER = -1
"""The observer of a sequence whose camera is carried by none of the people of its scene."""


@dataclass(frozen=True, kw_only=True)
class Odometry:
    """How the observer moved by its own measurement, such as that of its wheels; NaN = not measured.

    Parameters
    ----------
    motions : [T, 3] (forward, left, turn) from the frame before to each frame, in m and rad: the new place in the axes
        of the frame before, counter-clockwise positive.
    covariances : [T, 3, 3] of these, in m², m·rad and rad².
    """

    motions: FloatArray
    covariances: FloatArray

    def __post_init__(self) -> None:
        freeze(self, motions=(None, 3))
        freeze(self, covariances=(len(self.motions), 3, 3))

    @staticmethod
    def unmeasured(frames: int) -> "Odometry":
        """Of so many frames, none measured."""
        return Odometry(motions=np.full((frames, 3), np.nan), covariances=np.full((frames, 3, 3), np.nan))

    def frames(self, wanted: slice) -> "Odometry":
        """Some of the frames."""
        return Odometry(motions=self.motions[wanted], covariances=self.covariances[wanted])

    def followed_by(self, later: "Odometry") -> "Odometry":
        """These frames, and those of ``later`` after them."""
        return Odometry(
            motions=np.concatenate([self.motions, later.motions]),
            covariances=np.concatenate([self.covariances, later.covariances]),
        )


@dataclass(frozen=True, kw_only=True)
class Given:
    """Poses and positions that a solver is given as known, and what the observer measures of its motion.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) of the observer in m and rad; NaN = not given.
    positions : [T, K, 2] of the tracks in m; NaN = not given.
    odometry : of the same frames; ``None`` for an observer without any.
    """

    poses: FloatArray
    positions: FloatArray
    odometry: Odometry | None = None

    def __post_init__(self) -> None:
        freeze(self, poses=(None, 3))
        freeze(self, positions=(len(self.poses), None, 2))
        if self.odometry is not None and len(self.odometry.motions) != len(self.poses):
            raise ValueError(f"odometry has {len(self.odometry.motions)} frames, not {len(self.poses)}")

    def first_frames(self, frames: int) -> "Given":
        """The same, with no pose and position given after the first ``frames`` frames."""
        keep = np.arange(len(self.poses)) < frames
        return self.keeping(keep, np.broadcast_to(keep[:, None], self.positions.shape[:2]))

    def keeping(self, poses: BoolArray, positions: BoolArray) -> "Given":
        """The same with only the poses marked in ``poses`` [T] and the positions marked in ``positions`` [T, K]."""
        return Given(
            poses=np.where(poses[:, None], self.poses, np.nan),
            positions=np.where(positions[..., None], self.positions, np.nan),
            odometry=self.odometry,
        )

    def frames(self, wanted: slice) -> "Given":
        """What is given of some of the frames."""
        odometry = None if self.odometry is None else self.odometry.frames(wanted)
        return Given(poses=self.poses[wanted], positions=self.positions[wanted], odometry=odometry)


@dataclass(frozen=True, kw_only=True)
class Sequence:
    """What one observer sees, and what is given about it, without truth.

    Parameters
    ----------
    index : number of the sequence in its dataset.
    scene : number of the scene in its dataset.
    observer : person id of the camera's bearer in the scene, or `NO_OBSERVER`.
    first_frame : scene frame of the sequence's frame 0.
    tracks : [K] integer ids of all observed tracks, ascending.
    observations : [T, K, 3] boxes (u, v, l) in px, NaN = not observed.
    visible : [T, K] visible fraction of each box in (0, 1], NaN = not observed.
    given : what the `sequential` protocol gives.
    camera : number of the camera in its dataset.
    """

    index: int
    scene: int
    observer: int
    first_frame: int
    tracks: IntArray
    observations: FloatArray
    visible: FloatArray
    given: Given
    camera: int = 0

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(self.tracks))
        freeze(self, np.int64, tracks=(count,))
        freeze(self, observations=(None, count, 3))
        shape = (len(self.observations), count)
        freeze(self, visible=shape)
        if self.given.positions.shape != (*shape, 2):
            raise ValueError(f"given.positions must have shape {[*shape, 2]}, not {list(self.given.positions.shape)}")

    @property
    def frames(self) -> int:
        """Number of frames T."""
        return len(self.observations)

    @property
    def observed(self) -> BoolArray:
        """[T, K] whether a track has a box in a frame."""
        return ~np.isnan(self.observations[..., 2])


@dataclass(frozen=True, kw_only=True)
class Truth:
    """True poses of the observer and positions of the tracks.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) in m and rad.
    positions : [T, K, 2] in m; NaN where the track's person is absent, or the track is a false alarm.
    heights : [K] in m; NaN for false alarms.
    """

    poses: FloatArray
    positions: FloatArray
    heights: FloatArray

    def __post_init__(self) -> None:
        freeze(self, poses=(None, 3))
        freeze(self, positions=(len(self.poses), None, 2))
        freeze(self, heights=(self.positions.shape[1],))


@dataclass(frozen=True, kw_only=True)
class SequenceData:
    """One generated sequence with its truth.

    Parameters
    ----------
    sequence, truth : what is seen, and its truth.
    scene : its scene, if no other sequence shares it.
    persons : [T, K] the person behind each track in each frame, `NOBODY` for a false alarm; ``None`` where a track is
        the person of its number.
    world : where its scene lies in the sequence's own world; ``None`` if everything is still in the scene's.
    """

    sequence: Sequence
    truth: Truth
    scene: Scene | None = None
    persons: IntArray | None = None
    world: World | None = None


def held_persons(persons: IntArray, observed: BoolArray) -> IntArray:
    """[T, K] the person behind each track, held from a box to the next one; `NOBODY` before the first.

    Parameters
    ----------
    persons : [T, K] the person behind each box.
    observed : [T, K] whether there is one.
    """
    last = np.maximum.accumulate(np.where(observed, np.arange(len(observed))[:, None], -1), axis=0)
    return np.where(last >= 0, np.take_along_axis(persons, last.clip(min=0), axis=0), NOBODY)
