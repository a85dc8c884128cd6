"""Draws a crowd at its start: where everybody stands, how fast they want to walk, and where they head for."""

import numpy as np
from scipy.special import ndtr, ndtri

from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench_generators.scenario import Flow, Rectangle, Scenario
from vbbench_generators.social_force import Crowd, Model

SPEED_RANGE = 3.0
"""Desired speeds end so many standard deviations from their mean."""
DRAWS, AT_ONCE = 64, 32
"""A place is looked for among so many draws of so many candidates."""


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
    low, high = ndtr(-SPEED_RANGE), ndtr(SPEED_RANGE)
    speeds: FloatArray = scenario.speed_mean + scenario.speed_std * ndtri(rng.uniform(low, high, people))
    return speeds


def _draw_goals(
    flow: Flow, start: FloatArray, farthest: float, scenario: Scenario, rng: np.random.Generator
) -> FloatArray:
    """Goals [G, 2] in m, enough of them that nobody who may walk on arrives at the last."""
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
