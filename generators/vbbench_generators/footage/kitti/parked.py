"""How well poses hold together: parked cars, seen again and again on the way, should stay where they are."""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_generators.footage.kitti.labels import CARS, Labels
from vbbench_generators.footage.kitti.poses import in_the_world

LEAST_DRIVEN = 20.0
"""m that the camera must drive while a car is seen: over less, poses are good, and places are labelled no better."""
FASTEST = 0.8
"""m/s: no parked car seems to move faster, by the poses that suit it best, from one spell of frames to the next."""
SPELL = 20
"""Frames of a spell; the median over it is where the car was."""


@dataclass(frozen=True, kw_only=True)
class ParkedCars:
    """How far parked cars seem to move between the first and the last fifth of the frames that they are seen in.

    Parameters
    ----------
    moved : [C] by each car, in m.
    driven : [C] by the camera meanwhile, in m.
    """

    moved: FloatArray
    driven: FloatArray

    @property
    def typical(self) -> float:
        """The median over cars in m, NaN without any."""
        return float(np.median(self.moved)) if len(self.moved) else float("nan")

    def values(self) -> dict[str, object]:
        """As JSON has it."""
        return {
            "cars": len(self.moved),
            "moved": [round(value, 3) for value in self.moved.tolist()],
            "driven": [round(value, 1) for value in self.driven.tolist()],
        }


def watch_parked_cars(labels: Labels, sources: list[FloatArray], dt: float) -> list[ParkedCars]:
    """The parked cars by each source of motions [T, 4, 4] of camera 0; the cars are the same for all.

    A car counts if the camera drives `LEAST_DRIVEN` while it is seen, and if it is slow by one of the sources.
    """
    rows, tracks, column = labels.of(CARS).tracked()
    driven = [_driven(motions) for motions in sources]
    parked, moved = [], []
    for number in range(len(tracks)):
        mine = np.flatnonzero(column == number)
        mine = mine[np.argsort(rows.frame[mine])]
        frame = rows.frame[mine]
        way = np.median([one[frame[-1]] - one[frame[0]] for one in driven])
        places = [in_the_world(rows.places[mine], motions[frame]) for motions in sources]
        if way >= LEAST_DRIVEN and min(_fastest(place, frame, dt) for place in places) < FASTEST:
            parked.append(way)
            moved.append([_moved(place) for place in places])
    found = np.array(moved).reshape(-1, len(sources)).T
    return [ParkedCars(moved=one, driven=np.array(parked)) for one in found]


def _driven(motions: FloatArray) -> FloatArray:
    """[T] m driven up to each frame."""
    steps = np.linalg.norm(np.diff(motions[:, :2, 3], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _moved(places: FloatArray) -> float:
    part = max(len(places) // 5, 1)
    return float(np.linalg.norm(np.median(places[-part:], axis=0) - np.median(places[:part], axis=0)))


def _fastest(places: FloatArray, frame: IntArray, dt: float) -> float:
    """The greatest speed in m/s between the medians of one spell and the next."""
    spell = (frame - frame[0]) // SPELL
    spells: list[BoolArray] = [spell == one for one in np.unique(spell)]
    if len(spells) < 2:
        return float("inf")
    middle = np.array([np.median(places[one], axis=0) for one in spells])
    when = np.array([frame[one].mean() * dt for one in spells])
    speeds = np.linalg.norm(np.diff(middle, axis=0), axis=1) / np.diff(when)
    return float(speeds.max())
