"""One simulated scene and its observer, drawn again until nobody is stuck and the observer sees enough people."""

from dataclasses import dataclass

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.generation.generator import Engine
from vbbench.geometry import BoolArray, FloatArray, IntArray, world_to_relative
from vbbench.scene import Scene
from vbbench_generators.heading import causal_headings, limit_turns
from vbbench_generators.scenario import Scenario
from vbbench_generators.social_force import Crowd, HelbingMolnar, Model, Moussaid, simulate
from vbbench_generators.spawning import draw_crowd

REPULSIONS: dict[str, type[Moussaid] | type[HelbingMolnar]] = {"moussaid": Moussaid, "helbing-molnar": HelbingMolnar}
ATTEMPTS = 100
"""Crowds drawn for one sequence before giving up."""
STUCK_TIME, STUCK_SPEED = 2.0, 0.1
"""Who walks, over this time in s, less than this part of the desired way is stuck."""


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
    """A scene of the scenario in which nobody is stuck, with an observer who sees enough; heights are unknown.

    Parameters
    ----------
    people : K.
    engine : who walks the crowd.
    camera, height : what the observer carries, and how tall in m the people are who must be seen.
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
                return ObservedScene(_as_scene(scenario, positions), int(observer), ahead)
    raise VbbenchError(
        f"scenario '{scenario.name}' with {people} people: in each of {ATTEMPTS} crowds somebody was stuck, or nobody "
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


def _as_scene(scenario: Scenario, positions: FloatArray) -> Scene:
    people = np.arange(positions.shape[1])
    unknown = np.full(len(people), np.nan)
    return Scene(name=scenario.name, dt=scenario.dt, people=people, positions=positions, heights=unknown)
