"""Which person observes which frames of a scene, after a recipe's rules."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import BoolArray
from vbbench.parsing.numbers import Within, check_ranges
from vbbench.scene import Scene


@dataclass(frozen=True, kw_only=True)
class Rules:
    """What a recipe says of its sequences (table ``[sequences]``).

    Parameters
    ----------
    skip_first_frames : frames skipped at the start of each observer's track.
    min_others : a frame counts where at least so many other walkers are present.
    min_frames : an observer needs at least so many such frames.
    standing_displacement : who moves less than this in m from first to last frame is not part of the observed crowd.
    count_observer : whether the people of Table 1 include the observer.
    """

    skip_first_frames: Annotated[int, Within(0, 10**6)] = 0
    min_others: Annotated[int, Within(0, 10**6)] = 1
    min_frames: Annotated[int, Within(1, 10**6)] = 2
    standing_displacement: Annotated[float, Within(0.0, 1e5, "m")] = 0.0
    count_observer: bool = False

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, kw_only=True)
class Span:
    """An observer's frames: scene frames first … first + len(counted) − 1.

    ``column`` is the observer's among the people of the scene, −1 for a vehicle. ``counted`` [T] says in which of them
    enough others are present; in the rest nobody is observed, but time goes on.
    """

    scene: int
    column: int
    first: int
    counted: BoolArray

    def of(self, values: NDArray[Any]) -> NDArray[Any]:
        """Those rows of ``values`` [T, …], one a frame of the scene, that are the span's."""
        return values[self.first : self.first + len(self.counted)]

    def others(self, crowd: BoolArray) -> BoolArray:
        """[T, K] who of the ``crowd`` [T, K] in these frames is there for the observer to see."""
        others = crowd & self.counted[:, None]
        if self.column >= 0:
            others[:, self.column] = False
        return others


def observed_crowd(scene: Scene, rules: Rules) -> BoolArray:
    """[T, K] who is there to be observed: everybody present but for people who stand the whole time."""
    present = scene.present
    first = present.argmax(axis=0)
    last = scene.frames - 1 - present[::-1].argmax(axis=0)
    column = np.arange(len(scene.people))
    way = scene.positions[last, column] - scene.positions[first, column]
    walks: BoolArray = np.hypot(way[:, 0], way[:, 1]) >= rules.standing_displacement
    return present & walks


def find_spans(scene: Scene, number: int, rules: Rules) -> list[Span]:
    """One span for each person that may be an observer, in order of person id."""
    present, crowd = scene.present, observed_crowd(scene, rules)
    others = crowd.sum(axis=1)
    spans = []
    for column in range(len(scene.people)):
        frames = np.flatnonzero(present[:, column])[rules.skip_first_frames :]
        enough = frames[others[frames] - crowd[frames, column] >= rules.min_others]
        if len(frames) > 1 and len(enough) >= rules.min_frames:
            counted = np.zeros(enough[-1] - enough[0] + 1, bool)
            counted[enough - enough[0]] = True
            spans.append(Span(scene=number, column=column, first=int(enough[0]), counted=counted))
    return spans
