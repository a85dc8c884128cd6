"""One simulated scene and its observer: crowds are drawn and simulated until one is acceptable.

A crowd at its start has places, desired speeds and goals. It is acceptable if no one is stuck, and if someone sees
enough people to be the observer.
"""

from dataclasses import dataclass

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.generation.generator import Engine
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.scene import Scene
from vbbench_generators.crowds.scenario import Flow, Rectangle, Scenario
from vbbench_generators.crowds.social_force.engine import simulate
from vbbench_generators.crowds.social_force.model import Crowd, HelbingMolnar, Model, Moussaid
from vbbench_generators.views.heading import causal_headings, limit_turns

SPEED_RANGE = 3.0
"""Desired speeds are cut off at this number of standard deviations from their mean."""
DRAWS, AT_ONCE = 64, 32
"""Number of draws for a place, and of candidates per draw."""
REPULSIONS: dict[str, type[Moussaid] | type[HelbingMolnar]] = {"moussaid": Moussaid, "helbing-molnar": HelbingMolnar}
ATTEMPTS = 100
"""Crowds drawn for one sequence before giving up."""
STUCK_TIME, STUCK_SPEED = 2.0, 0.1
"""People who walk, over this time in s, less than this part of the desired way are stuck."""


def draw_crowd(scenario: Scenario, people: int, model: Model, rng: np.random.Generator) -> Crowd:
    """A crowd of K people at the scenario's start, walking at their desired speeds.

    Raises
    ------
    VbbenchError
        If there is no room for them.
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
    """Goals [G, 2] in m, enough that no one with further goals arrives at the last."""
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
    """Whether most of a rectangle is farther than ``least`` from a point: its centre, or its half diagonal, is."""
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
        f"scenario '{scenario.name}': no place left in {list(place)} m that is {distance:g} m from everybody else; "
        f"ask for fewer people, or give a scenario with more room"
    )


@dataclass(frozen=True)
class ObservedScene:
    """A scene and who observes it: a column of the scene, and where that person looks, [T] in rad."""

    scene: Scene
    observer: int
    heading: FloatArray


def draw_scene(
    scenario: Scenario,
    people: int,
    *,
    engine: Engine,
    camera: Camera,
    height: float,
    rng: np.random.Generator,
) -> ObservedScene:
    """A scene of the scenario in which no one is stuck, with an observer who sees enough; heights are unknown.

    Parameters
    ----------
    people : K.
    camera, height : of the observer, and the height in m of the people whom it must see.
    rng : the sequence's random numbers.

    Raises
    ------
    VbbenchError
        If no such scene was found, or there is no room for the crowd.
    """
    model = Model(repulsion=REPULSIONS[scenario.forces]())
    for _ in range(ATTEMPTS):
        crowd = draw_crowd(scenario, people, model, rng)
        candidates = rng.permutation(people)
        positions = walk(scenario, crowd, model, engine)
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
                return ObservedScene(scene, int(observer), ahead)
    raise VbbenchError(
        f"scenario '{scenario.name}' with {people} people: in each of {ATTEMPTS} crowds a person was stuck, or nobody "
        f"saw {scenario.min_seen} others all the time; ask for another number of people, or another camera"
    )


def is_stuck(positions: FloatArray, speeds: FloatArray, dt: float) -> BoolArray:
    """[K] who hardly moves over some `STUCK_TIME`: positions [T, K, 2] in m, desired speeds [K] in m/s, dt in s."""
    steps = np.diff(positions, axis=0)
    covered = np.cumsum(np.concatenate([np.zeros((1, len(speeds))), np.hypot(steps[..., 0], steps[..., 1])]), axis=0)
    window = min(round(STUCK_TIME / dt), len(steps))
    stuck: BoolArray = np.any(
        covered[window:] - covered[: len(covered) - window] < STUCK_SPEED * speeds * window * dt, axis=0
    )
    return stuck


def walk(scenario: Scenario, crowd: Crowd, model: Model, engine: Engine) -> FloatArray:
    """Positions [T, K, 2] in m of a crowd in the frames after the warm-up."""
    walls = np.array(scenario.walls).reshape(-1, 4)
    frames = scenario.warm_up_frames + scenario.frames
    paths = simulate(
        crowd,
        model,
        frames=frames,
        dt=scenario.dt,
        substeps=scenario.substeps,
        walls=walls,
        engine=engine,
        threads=1,  # sequences fill the cores
    )
    return paths[scenario.warm_up_frames :]


def _count_seen(positions: FloatArray, heading: FloatArray, height: float, observer: int, camera: Camera) -> IntArray:
    """[T] how many others the observer has in the picture while looking ahead."""
    poses = np.concatenate([positions[:, observer], heading[:, None]], axis=1)
    boxes = camera.project(world_to_relative(positions, poses), np.full(positions.shape[1], height))
    there = ~np.isnan(boxes[..., 2])
    there[:, observer] = False
    counts: IntArray = there.sum(axis=1)
    return counts
