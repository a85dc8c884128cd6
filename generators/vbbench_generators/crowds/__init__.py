"""Simulated crowds: a scenario, a TOML file in ``scenarios/``, as frozen dataclasses, and the splits made of them."""

from dataclasses import dataclass
from functools import cached_property
from math import hypot
from pathlib import Path
from typing import Annotated, Literal

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.generation.generator import MOST_PEOPLE
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.parsing.numbers import FRAME_TIME, Within, check_ranges
from vbbench.parsing.toml_text import bundled_names, read_bundled, read_toml
from vbbench.scene import Scene
from vbbench_generators.social_force import Crowd, Model, simulate
from vbbench_generators.views.looking import causal_headings, limit_turns

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
    """People who start in one rectangle and head for another.

    Parameters
    ----------
    start, goal : places are drawn uniformly in these rectangles.
    beyond : whether people pass their goal and walk straight on, so that nobody arrives.
    then : rectangles of further goals after arrival, drawn in turn; without any, people stay.
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
            raise ValueError("people who walk beyond the goal never arrive: remove 'then' or 'beyond'")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A simulated crowd, and its recording.

    Parameters
    ----------
    name, title : its name, and its description.
    sequences : number of sequences; each has its own crowd.
    people : numbers of people K; the sequences take them in turn.
    frames, dt : frames per sequence, and seconds per frame.
    step : seconds of an integration step.
    warm_up : seconds that the crowd walks before frame 0.
    camera : the observer's camera by default.
    min_seen : the observer sees at least so many people in every frame, and at least one person in some.
    forces : the model of repulsion: Moussaïd et al. 2009.
    turn_rate : limit of the camera's yaw rate in rad/s: people take about a second to turn round.
    speed_mean, speed_std : desired speeds in m/s, normal, cut off at three standard deviations.
    spacing : least distance of two people at the start, in m.
    least_way : least distance in m from the start, or the last goal, to the next goal.
    flow : the flows; people are assigned to them in turn.
    walls : line segments x0, y0, x1, y1 in m that repel people.
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
    forces: Literal["moussaid"] = "moussaid"
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
            raise ValueError("there is no [[flow]]: add one, since people need goals")
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
        """Refuse sequences that would not fit in memory, though each number is valid."""
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
        """Frames that are simulated and discarded."""
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

    Raises UnknownNameError if there is neither; the nearest name is suggested.
    """
    if name in scenario_names():
        return read_bundled("vbbench_generators", f"scenarios/{name}.toml", Scenario, "scenario")
    if name.endswith(".toml"):
        return read_scenario(Path(name))
    raise UnknownNameError("scenario", name, scenario_names())


def read_scenario(path: Path) -> Scenario:
    """Read a scenario file; see `read_toml`."""
    return read_toml(path, Scenario, "scenario")


SPEED_RANGE = 3.0
"""Desired speeds are cut off at this number of standard deviations from their mean."""
DRAWS, AT_ONCE = 64, 32
"""Number of draws for a place, and of candidates per draw."""
ATTEMPTS = 100
"""Crowds drawn for one sequence before giving up."""
STUCK_TIME, STUCK_SPEED = 2.0, 0.1
"""People who walk, over this time in s, less than this part of the desired way are stuck."""


def draw_crowd(scenario: Scenario, people: int, model: Model, rng: np.random.Generator) -> Crowd:
    """A crowd of K people at the scenario's start, walking at their desired speeds.

    Raises VbbenchError if there is no room for them.
    """
    speeds = draw_speeds(scenario, people, rng)
    flows = [scenario.flow[person % len(scenario.flow)] for person in range(people)]
    starts = np.empty((people, 2))
    for person, flow in enumerate(flows):
        starts[person] = _draw_place(flow.start, starts[:person], scenario.spacing, rng, scenario)
    farthest = float(np.max(speeds)) * model.top_speed * scenario.duration + model.arrival_radius
    goals = [_draw_goals(flow, start, farthest, scenario, rng) for flow, start in zip(flows, starts, strict=True)]
    legs = np.arange(max(map(len, goals)))
    queue = np.stack([goal[legs.clip(max=len(goal) - 1)] for goal in goals])
    way = queue[:, 0] - starts
    velocities = way * (speeds / np.hypot(way[:, 0], way[:, 1]))[:, None]
    return Crowd(positions=starts, velocities=velocities, speeds=speeds, goals=queue)


def draw_speeds(scenario: Scenario, people: int, rng: np.random.Generator) -> FloatArray:
    """Desired speeds [K] in m/s: a normal distribution cut off at three standard deviations, by inversion."""
    from scipy.special import ndtr, ndtri  # slow to import, and only simulations need it

    low, high = ndtr(-SPEED_RANGE), ndtr(SPEED_RANGE)
    return scenario.speed_mean + scenario.speed_std * ndtri(rng.uniform(low, high, people))


def _draw_goals(
    flow: Flow, start: FloatArray, farthest: float, scenario: Scenario, rng: np.random.Generator
) -> FloatArray:
    """Goals [G, 2] in m; with further goals, so many that nobody arrives at the last."""
    goal = _draw_place(flow.goal, start[None], scenario.least_way, rng, scenario)
    if flow.beyond:
        way = goal - start
        far: FloatArray = start + way * (1.0 + farthest / np.hypot(way[0], way[1]))
        return far[None]
    goals = [goal]
    if flow.then:
        for _ in range(int(np.ceil(farthest / scenario.least_way)) + 1):
            others = [place for place in flow.then if _leaves_way(place, goals[-1], scenario.least_way)]
            place = others[rng.integers(len(others))] if others else flow.then[0]
            goals.append(_draw_place(place, goals[-1][None], scenario.least_way, rng, scenario))
    return np.stack(goals)


def _leaves_way(place: Rectangle, point: FloatArray, least: float) -> bool:
    """Whether the centre of a rectangle is farther than ``least`` m from a point, or its half diagonal is longer."""
    x0, y0, x1, y1 = place
    away = np.hypot((x0 + x1) / 2.0 - point[0], (y0 + y1) / 2.0 - point[1])
    return bool(max(away, np.hypot(x1 - x0, y1 - y0) / 2.0) > least)


def _draw_place(
    place: Rectangle, others: FloatArray, distance: float, rng: np.random.Generator, scenario: Scenario
) -> FloatArray:
    """A point [2] of a rectangle, uniform among those at least ``distance`` m from all ``others`` [N, 2]."""
    low, high = np.array(place[:2]), np.array(place[2:])
    for _ in range(DRAWS):
        candidates = rng.uniform(low, high, (AT_ONCE, 2))
        apart = candidates[:, None] - others
        free = np.flatnonzero(np.all(apart[..., 0] ** 2 + apart[..., 1] ** 2 >= distance**2, axis=1))
        if len(free):
            point: FloatArray = candidates[free[0]]
            return point
    raise VbbenchError(
        f"scenario '{scenario.name}': no place left in {list(place)} m that is {distance:g} m from all other people; "
        f"ask for fewer people, or give a scenario with more room"
    )


def draw_scene(
    scenario: Scenario,
    people: int,
    *,
    camera: Camera,
    height: float,
    rng: np.random.Generator,
) -> tuple[Scene, int, FloatArray]:
    """A scene of the scenario in which nobody is stuck, with an observer who sees enough; heights are not drawn.

    Returns the scene, the observer's column, and the observer's heading [T] in rad.

    Raises VbbenchError if no such scene was found, or there is no room for the crowd.

    Parameters
    ----------
    people : number of people K.
    camera, height : the observer's camera, and the height in m of people for the test of what it sees.
    rng : the sequence's random numbers.
    """
    model = Model()
    for _ in range(ATTEMPTS):
        crowd = draw_crowd(scenario, people, model, rng)
        candidates = rng.permutation(people)
        positions = walk(scenario, crowd, model)
        if is_stuck(positions, crowd.speeds, scenario.dt).any():
            continue
        headings = causal_headings(positions, scenario.dt)
        for observer in candidates:
            ahead = limit_turns(headings[:, observer], scenario.dt, scenario.turn_rate)
            seen = _count_seen(positions, ahead, height, observer, camera)
            if seen.min() >= scenario.min_seen and seen.max() > 0:
                unknown = np.full(people, np.nan)
                ids = np.arange(people)
                scene = Scene(name=scenario.name, dt=scenario.dt, people=ids, positions=positions, heights=unknown)
                return scene, int(observer), ahead
    raise VbbenchError(
        f"scenario '{scenario.name}' with {people} people: in each of {ATTEMPTS} crowds a person was stuck, or nobody "
        f"saw {scenario.min_seen} others all the time; ask for another number of people, or another camera"
    )


def is_stuck(positions: FloatArray, speeds: FloatArray, dt: float) -> BoolArray:
    """Mask [K] of people who hardly move over some `STUCK_TIME`; ``speeds`` [K] are the desired ones in m/s."""
    steps = np.diff(positions, axis=0)
    covered = np.cumsum(np.concatenate([np.zeros((1, len(speeds))), np.hypot(steps[..., 0], steps[..., 1])]), axis=0)
    window = min(round(STUCK_TIME / dt), len(steps))
    stuck: BoolArray = np.any(
        covered[window:] - covered[: len(covered) - window] < STUCK_SPEED * speeds * window * dt, axis=0
    )
    return stuck


def walk(scenario: Scenario, crowd: Crowd, model: Model) -> FloatArray:
    """Positions [T, K, 2] in m of a crowd in the frames after the warm-up."""
    walls = np.array(scenario.walls).reshape(-1, 4)
    frames = scenario.warm_up_frames + scenario.frames
    paths = simulate(crowd, model, frames=frames, dt=scenario.dt, substeps=scenario.substeps, walls=walls)
    return paths[scenario.warm_up_frames :]


def _count_seen(positions: FloatArray, heading: FloatArray, height: float, observer: int, camera: Camera) -> IntArray:
    """[T] number of people in the picture of an ``observer`` with the yaws ``heading`` [T]."""
    poses = np.concatenate([positions[:, observer], heading[:, None]], axis=1)
    boxes = camera.project(world_to_relative(positions, poses), np.full(positions.shape[1], height))
    there = ~np.isnan(boxes[..., 2])
    there[:, observer] = False
    counts: IntArray = there.sum(axis=1)
    return counts
