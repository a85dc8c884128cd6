"""A sequence: a run of consecutive frames of one scene, seen by one observer.

What a solver may see (`Sequence`), what it is given (`Given`) and what it never sees (`Truth`) are three types.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray, frozen_array
from vbbench.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Given:
    """Poses and positions that a solver is given as known; NaN = not given.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) of the observer in m and rad.
    positions : [T, K, 2] of the tracks in m.
    """

    poses: FloatArray
    positions: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "poses", frozen_array("poses", self.poses, (None, 3)))
        object.__setattr__(self, "positions", frozen_array("positions", self.positions, (len(self.poses), None, 2)))

    def first_frames(self, frames: int) -> "Given":
        """The same, with NaN after the first ``frames`` frames."""
        keep = np.arange(len(self.poses)) < frames
        poses = np.where(keep[:, None], self.poses, np.nan)
        return Given(poses=poses, positions=np.where(keep[:, None, None], self.positions, np.nan))


@dataclass(frozen=True, kw_only=True)
class Sequence:
    """What one observer sees, and what is given about it, without truth.

    Parameters
    ----------
    index : number of the sequence in its dataset.
    scene : number of the scene in its dataset.
    observer : person id of the camera's bearer in the scene.
    first_frame : scene frame of the sequence's frame 0.
    tracks : [K] integer ids of all observed tracks, ascending.
    observations : [T, K, 3] boxes (u, v, l) in px, NaN = not observed.
    visible : [T, K] visible fraction of each box in (0, 1], NaN = not observed.
    given : what the `sequential` protocol gives.
    """

    index: int
    scene: int
    observer: int
    first_frame: int
    tracks: IntArray
    observations: FloatArray
    visible: FloatArray
    given: Given

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(self.tracks))
        object.__setattr__(self, "tracks", frozen_array("tracks", self.tracks, (count,), np.int64))
        object.__setattr__(self, "observations", frozen_array("observations", self.observations, (None, count, 3)))
        shape = (len(self.observations), count)
        object.__setattr__(self, "visible", frozen_array("visible", self.visible, shape))
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
        object.__setattr__(self, "poses", frozen_array("poses", self.poses, (None, 3)))
        object.__setattr__(self, "positions", frozen_array("positions", self.positions, (len(self.poses), None, 2)))
        object.__setattr__(self, "heights", frozen_array("heights", self.heights, (self.positions.shape[1],)))


@dataclass(frozen=True, kw_only=True)
class SequenceData:
    """One generated sequence with its truth.

    Parameters
    ----------
    sequence, truth : what is seen, and its truth.
    scene : its scene, if no other sequence shares it.
    persons : [T, K] the person behind each track in each frame, −1 for a false alarm; of tiers that track only.
    """

    sequence: Sequence
    truth: Truth
    scene: Scene | None = None
    persons: IntArray | None = None
