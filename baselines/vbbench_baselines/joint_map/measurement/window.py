"""The frames that a causal solver keeps in mind, in arrays whose last row is the newest frame."""

from dataclasses import dataclass, field

import numpy as np

from vbbench.arrays import BoolArray, FloatArray, IntArray
from vbbench.sequence import Given
from vbbench_baselines.joint_map.optimiser.people import Scene
from vbbench_baselines.joint_map.measurement.boxes import Statures, inform
from vbbench_baselines.common.sightings import Sightings


@dataclass
class Window:
    """The last frames, at most ``size``; NaN = absent or unknown.

    Attributes
    ----------
    poses, places : [n, 3] and [n, K, 2] as believed.
    given_poses, given : [n, 3] and [n, K, 2].
    relative, information : [n, K, 2] and [n, K, 3], see `vbbench_baselines.joint_map.optimiser.people.Scene`.
    """

    size: int
    people: int
    poses: FloatArray = field(init=False)
    places: FloatArray = field(init=False)
    given_poses: FloatArray = field(init=False)
    given: FloatArray = field(init=False)
    relative: FloatArray = field(init=False)
    information: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        shapes = {
            "poses": (3,),
            "given_poses": (3,),
            "places": (2,),
            "given": (2,),
            "relative": (2,),
            "information": (3,),
        }
        for name, shape in shapes.items():
            rows = shape if "poses" in name else (self.people, *shape)
            setattr(self, name, np.full((self.size, *rows), np.nan))
        self.frames = 0

    def push(self, seen: Sightings, statures: Statures, given: Given) -> None:
        """Take in a frame; what is given of the two before it is learned, too."""
        self.frames += 1
        boxes = inform(*seen, statures.mean)
        _push(self.poses, self.given_poses, given.poses)
        _push(self.places, self.given, given.positions)
        _shift(self.relative, self.information, *boxes)

    @property
    def filled(self) -> slice:
        """The rows in use."""
        return slice(max(self.size - self.frames, 0), self.size)

    def scene(self, statures: Statures) -> Scene:
        """The rows in use as the kernels take them."""
        rows = self.filled
        return make_scene(self.relative[rows], self.information[rows], self.given[rows], statures)


def make_scene(relative: FloatArray, information: FloatArray, given: FloatArray, statures: Statures) -> Scene:
    """A scene in which everybody is followed from the first to the last frame that says anything about them."""
    known: BoolArray = ~(np.isnan(relative[..., 0]) & np.isnan(given[..., 0]))
    frames = len(known)
    first: IntArray = np.argmax(known, axis=0)
    last: IntArray = np.where(known.any(axis=0), frames - 1 - np.argmax(known[::-1], axis=0), -1)
    return Scene(relative, information, given, first, last, statures.mean, statures.variance)


def _push(believed: FloatArray, given: FloatArray, window: FloatArray) -> None:
    """Move both on by one row; ``window`` holds what is given of the last three, which is believed from now on."""
    for rows in (believed, given):
        rows[:-1] = rows[1:]
        rows[-1] = np.nan
        np.copyto(rows[-3:], window, where=~np.isnan(window))


def _shift(relative: FloatArray, information: FloatArray, newest: FloatArray, informed: FloatArray) -> None:
    """Move both on by one row, and put in the newest."""
    relative[:-1], information[:-1] = relative[1:], information[1:]
    relative[-1], information[-1] = newest, informed
