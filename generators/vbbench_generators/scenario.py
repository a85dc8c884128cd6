"""A scenario: a file in ``scenarios/`` that says what a simulated crowd does, and the frozen dataclasses made of it."""

from dataclasses import dataclass
from functools import cached_property
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any, Literal

from vbbench.errors import UnknownNameError
from vbbench_generators.strict import build, build_each, read_toml

Rectangle = tuple[float, ...]
"""x0, y0, x1, y1 in m."""


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
        for rectangle in (self.start, self.goal, *self.then):
            _check_rectangle(rectangle)
        if self.beyond and self.then:
            raise ValueError("who walks beyond the goal never arrives: leave 'then' out, or 'beyond'")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """What a simulated crowd does, and how it is recorded.

    Parameters
    ----------
    name, title : what it is called and shows.
    sequences : number of sequences; each has a crowd of its own.
    people : numbers of people K; the sequences take them in turn.
    frames, dt : frames a sequence, and seconds a frame.
    step : seconds of an integration step.
    warm_up : seconds that the crowd walks before frame 0.
    camera : what the observer carries unless the user says otherwise.
    min_seen : the observer is one who sees at least so many people in every frame, and anybody at all in some.
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
    sequences: int
    people: tuple[int, ...]
    frames: int
    dt: float
    flow: tuple[Flow, ...]
    step: float = 0.05
    warm_up: float = 0.0
    camera: Literal["panorama", "perspective"] = "perspective"
    min_seen: int = 0
    forces: Literal["moussaid", "helbing-molnar"] = "moussaid"
    turn_rate: float = 3.0
    speed_mean: float = 1.34
    speed_std: float = 0.26
    spacing: float = 0.5
    least_way: float = 4.0
    walls: tuple[Rectangle, ...] = ()

    def __post_init__(self) -> None:
        positive = ("sequences", "frames", "dt", "step", "turn_rate", "speed_mean", "least_way")
        if bad := [name for name in positive if not getattr(self, name) > 0]:
            raise ValueError(f"{bad[0]} must be above 0, not {getattr(self, bad[0])}")
        free = ("warm_up", "min_seen", "speed_std", "spacing")
        if bad := [name for name in free if not getattr(self, name) >= 0]:
            raise ValueError(f"{bad[0]} must be 0 or more, not {getattr(self, bad[0])}")
        if not self.people or min(self.people) < 2:
            raise ValueError(f"people = {list(self.people)}: a crowd is an observer and at least one other")
        if not self.flow:
            raise ValueError("there is no [[flow]]: nobody would know where to go")
        if abs(self.substeps * self.step - self.dt) > 1e-9:
            raise ValueError(f"a frame of {self.dt:g} s is no whole number of steps of {self.step:g} s")
        if self.speed_mean <= 3.0 * self.speed_std:
            raise ValueError(
                "three standard deviations below the mean, people would walk backwards: speed_std is too large"
            )
        if any(len(wall) != 4 for wall in self.walls):
            raise ValueError("a wall is four numbers: x0, y0, x1, y1 in m")

    @property
    def substeps(self) -> int:
        """Integration steps a frame."""
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
    return sorted(entry.name.removesuffix(".toml") for entry in _folder().iterdir() if entry.name.endswith(".toml"))


def get_scenario(name: str) -> Scenario:
    """The scenario ``name``, or the one in the file of that path.

    Raises
    ------
    UnknownNameError
        If there is neither; the nearest name is suggested.
    """
    if name in scenario_names():
        with as_file(_folder() / f"{name}.toml") as path:
            return read_scenario(path)
    if name.endswith(".toml"):
        return read_scenario(Path(name))
    raise UnknownNameError("scenario", name, scenario_names())


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file.

    Raises
    ------
    FileError
        If it is missing, no TOML, or a key is unknown, missing or cannot be.
    """

    def made(table: dict[str, Any]) -> Scenario:
        flows = build_each(Flow, table.pop("flow", []), path, "[[flow]]")
        return build(Scenario, {**table, "flow": flows}, path, "scenario")

    return read_toml(path, made)


def _check_rectangle(rectangle: Rectangle) -> None:
    if len(rectangle) != 4 or rectangle[0] > rectangle[2] or rectangle[1] > rectangle[3]:
        raise ValueError(f"{list(rectangle)} is no rectangle x0, y0, x1, y1 with x0 <= x1 and y0 <= y1")


def _folder() -> Any:
    return files("vbbench_generators") / "scenarios"
