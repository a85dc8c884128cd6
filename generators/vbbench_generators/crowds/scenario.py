"""A scenario: a file in ``scenarios/`` that says what a simulated crowd does, and the frozen dataclasses made of it."""

from dataclasses import dataclass
from functools import cached_property
from math import hypot
from pathlib import Path
from typing import Annotated, Literal

from vbbench.errors import UnknownNameError
from vbbench.generation.generator import MOST_PEOPLE
from vbbench.parsing.numbers import FRAME_TIME, Within, check_ranges
from vbbench.parsing.toml_text import bundled_names, read_bundled, read_toml

Place = Annotated[float, Within(-1e5, 1e5, "m")]
Rectangle = tuple[Place, ...]
"""x0, y0, x1, y1 in m."""

MOST_POSITIONS = 10**8
"""Frames, those of the warm-up included, times people: 1.6 GB."""
MOST_GOALS = 10**7
"""Goals that the people of a crowd may need, one after the other."""
MOST_WALL = 1e5
"""Length of all walls in m: the forces know a wall by ten points a metre."""


@dataclass(frozen=True, kw_only=True)
class Flow:
    """People who start in one place and head for another.

    Parameters
    ----------
    start : where they start, uniformly.
    goal : where they head for, uniformly.
    beyond : whether they pass their goal and walk straight on, so that nobody arrives.
    then : who arrives heads for a place in one of these rectangles next, and so on; if there are none, it stays.
    """

    start: Rectangle
    goal: Rectangle
    beyond: bool = False
    then: tuple[Rectangle, ...] = ()

    def __post_init__(self) -> None:
        check_ranges(self)
        for rectangle in (self.start, self.goal, *self.then):
            if len(rectangle) != 4 or rectangle[0] > rectangle[2] or rectangle[1] > rectangle[3]:
                raise ValueError(f"{list(rectangle)} is not a rectangle x0, y0, x1, y1 with x0 <= x1 and y0 <= y1")
        if self.beyond and self.then:
            raise ValueError("who walks beyond the goal never arrives: remove 'then' or 'beyond'")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """What a simulated crowd does, and how it is recorded.

    Parameters
    ----------
    name, title : what it is called and shows.
    sequences : number of sequences; each has its own crowd.
    people : numbers of people K; the sequences take them in turn.
    frames, dt : frames per sequence, and seconds per frame.
    step : seconds of an integration step.
    warm_up : seconds that the crowd walks before frame 0.
    camera : what the observer carries unless the user says otherwise.
    min_seen : the observer is one who sees at least so many people in every frame, and at least one person in some.
    forces : how people keep apart: Moussaïd et al. 2009, or Helbing & Molnár 1995.
    turn_rate : how fast the camera turns at most, in rad/s: people take about a second to turn round.
    speed_mean, speed_std : desired speeds in m/s, normal, cut off at three standard deviations.
    spacing : least distance of two people at the start, in m.
    least_way : least distance from the start, or the last goal, to the next goal, in m.
    flow : who walks where; people belong to the flows in turn.
    walls : line segments x0, y0, x1, y1 in m that people keep away from.
    """

    name: str
    title: str
    sequences: Annotated[int, Within(1, 10**7)]
    people: tuple[Annotated[int, Within(2, MOST_PEOPLE)], ...]
    frames: Annotated[int, Within(1, 10**6)]
    dt: Annotated[float, FRAME_TIME]
    flow: tuple[Flow, ...] = ()
    step: Annotated[float, Within(0.001, 10.0, "s")] = 0.05
    warm_up: Annotated[float, Within(0.0, 3600.0, "s")] = 0.0
    camera: str = "perspective"
    min_seen: Annotated[int, Within(0, MOST_PEOPLE)] = 0
    forces: Literal["moussaid", "helbing-molnar"] = "moussaid"
    turn_rate: Annotated[float, Within(0.01, 100.0, "rad/s")] = 3.0
    speed_mean: Annotated[float, Within(0.01, 10.0, "m/s")] = 1.34
    speed_std: Annotated[float, Within(0.0, 3.0, "m/s")] = 0.26
    spacing: Annotated[float, Within(0.0, 100.0, "m")] = 0.5
    least_way: Annotated[float, Within(0.01, 1e4, "m")] = 4.0
    walls: tuple[Rectangle, ...] = ()

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.people:
            raise ValueError("people must be one number or more: a crowd is an observer and at least one other")
        if not self.flow:
            raise ValueError("there is no [[flow]]: nobody would know where to go")
        if abs(self.substeps * self.step - self.dt) > 1e-9:
            raise ValueError(f"a frame of {self.dt:g} s is not a whole number of steps of {self.step:g} s")
        if self.speed_mean <= 3.0 * self.speed_std:
            raise ValueError(
                "three standard deviations below the mean, people would walk backwards: speed_std is too large"
            )
        if any(len(wall) != 4 for wall in self.walls):
            raise ValueError("a wall is four numbers: x0, y0, x1, y1 in m")
        self._check_size()

    def _check_size(self) -> None:
        """Refuse what no memory holds, though each number by itself can be."""
        crowd, frames = max(self.people), self.warm_up_frames + self.frames
        if crowd * frames > MOST_POSITIONS:
            raise ValueError(f"{crowd:,} people in {frames:,} frames, the warm-up's included, are too many")
        goals = (self.speed_mean + 3.0 * self.speed_std) * self.duration / self.least_way * crowd
        if any(flow.then for flow in self.flow) and goals > MOST_GOALS:
            raise ValueError(f"{crowd:,} people would need {goals:,.0f} goals: give them a longer least_way")
        length = sum(hypot(wall[2] - wall[0], wall[3] - wall[1]) for wall in self.walls)
        if length > MOST_WALL:
            raise ValueError(f"the walls are {length:,.0f} m long, more than {MOST_WALL:,.0f} m")

    @property
    def substeps(self) -> int:
        """Integration steps per frame."""
        return max(1, round(self.dt / self.step))

    @property
    def warm_up_frames(self) -> int:
        """Frames that are simulated and thrown away."""
        return round(self.warm_up / self.dt)

    @cached_property
    def duration(self) -> float:
        """Seconds that are simulated."""
        return (self.warm_up_frames + self.frames) * self.dt


def scenario_names() -> list[str]:
    """The scenarios of this package, in alphabetical order."""
    return bundled_names("vbbench_generators", "scenarios")


def get_scenario(name: str) -> Scenario:
    """The scenario ``name``, or the one in the file of that path.

    Raises
    ------
    UnknownNameError
        If there is neither; the nearest name is suggested.
    """
    if name in scenario_names():
        return read_bundled("vbbench_generators", f"scenarios/{name}.toml", Scenario, "scenario")
    if name.endswith(".toml"):
        return read_scenario(Path(name))
    raise UnknownNameError("scenario", name, scenario_names())


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file; see `read_toml`."""
    return read_toml(path, Scenario, "scenario")
