"""pysocialforce 1.1.2 with its side effects contained, and with the steps and speeds of this package.

Importing it opens ``file.log`` in the working directory, sets the root logger to DEBUG and adds two handlers; it
ignores its configured step width and keeps a copy of every state. It is slow and serves as the reference
for the compiled engine.
"""

import logging
import os
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import needs_extra
from vbbench.geometry import FloatArray
from vbbench_generators.crowds.social_force.model import Crowd, Model, Moussaid

RESOLUTION = 10.0
"""Points a metre of wall in the library."""


def walk(crowd: Crowd, model: Model, *, frames: int, dt: float, substeps: int, walls: FloatArray) -> FloatArray:
    """Walk one crowd with the library; parameters and result are those of `simulate`.

    Raises
    ------
    ValueError
        If the model is not one that the library has, or a number is zero, which the library takes for "default".
    """
    repulsion = _repulsion(model)
    with _contained():
        simulator = _simulator(crowd, model, repulsion, walls, dt / substeps)
        paths = np.empty((frames, crowd.people, 2))
        current = np.zeros(crowd.people, dtype=np.int64)
        paths[0] = crowd.positions
        for frame in range(1, frames):
            for _ in range(substeps):
                _aim(simulator.peds, crowd, current, model.arrival_radius)
                simulator.step_once()
                simulator.peds.ped_states.clear()
                simulator.peds.group_states.clear()
            paths[frame] = simulator.peds.pos()
    return paths


def _repulsion(model: Model) -> Moussaid:
    """The model's repulsion; raises ValueError unless the library can do what the model says."""
    if not isinstance(model.repulsion, Moussaid):
        raise ValueError("engine='pysocialforce' has the repulsion of Moussaid only")
    numbers = [*vars(model.repulsion).values(), *vars(model.walls).values(), *vars(model.groups).values()]
    if 0 in numbers:
        raise ValueError("engine='pysocialforce' takes a parameter of 0 for its default; use the engine vbbench")
    return model.repulsion


@contextmanager
def _contained() -> Iterator[None]:
    """Keep prints and warnings in; the first time, import the library where its log file does no harm."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with np.errstate(all="ignore"):
            if "pysocialforce" not in sys.modules:
                _import_quietly()
            yield


def _import_quietly() -> None:
    """Import from within an empty folder, then give the root logger back its level and handlers."""
    root, home = logging.getLogger(), Path.cwd()
    level, handlers = root.level, list(root.handlers)
    named = logging.getLogger("root")
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            with needs_extra("pysocialforce", "engine 'pysocialforce'"):
                import_module("pysocialforce")
        finally:
            os.chdir(home)
            for logger in {root, named}:
                for handler in [h for h in logger.handlers if h not in handlers]:
                    logger.removeHandler(handler)
                    handler.close()
            root.setLevel(level)


def _simulator(crowd: Crowd, model: Model, repulsion: Moussaid, walls: FloatArray, step: float) -> Any:
    """The library's simulator with its parameters set."""
    library = import_module("pysocialforce")
    current = crowd.goals[:, 0]
    state = np.column_stack((crowd.positions, crowd.velocities, current))
    # It wants x0, x1, y0, y1, and breaks on walls too short for a point.
    long_enough = np.hypot(*(walls[:, 2:] - walls[:, :2]).T) * RESOLUTION >= 1
    obstacles = walls[long_enough][:, [0, 2, 1, 3]].tolist()
    simulator = library.Simulator(state, groups=[list(group) for group in crowd.members()], obstacles=obstacles)
    simulator.config.from_dict(_configuration(model, repulsion))
    simulator.forces = simulator.make_forces(simulator.config)
    people = simulator.peds
    people.step_width, people.agent_radius = step, model.walls.body_radius
    people.max_speed_multiplier = model.top_speed
    if not model.strict:
        people.initial_speeds = np.array(crowd.speeds)
        people.max_speed_multiplier = 1.0
        cap = people.capped_velocity
        people.capped_velocity = lambda velocity, top: cap(velocity, top * model.top_speed)
    people.max_speeds = people.max_speed_multiplier * people.initial_speeds
    return simulator


def _configuration(model: Model, repulsion: Moussaid) -> dict[str, dict[str, float]]:
    """The model in the words of the library."""
    walls, groups = model.walls, model.groups
    return {
        "desired_force": {"factor": 1.0, "relaxation_time": model.relaxation_time, "goal_threshold": 0.2},
        "social_force": {
            "factor": repulsion.factor,
            "lambda_importance": repulsion.velocity_weight,
            "gamma": repulsion.reach,
            "n": repulsion.side_sharpness,
            "n_prime": repulsion.brake_sharpness,
        },
        "obstacle_force": {
            "factor": walls.factor,
            "sigma": walls.fall_off,
            "threshold": walls.reach - walls.body_radius,
        },
        "group_coherence_force_alt": {"factor": groups.cohesion},
        "group_repulsive_force": {"factor": groups.separation, "threshold": groups.personal_space},
        "group_gaze_force_alt": {"factor": groups.gaze},
    }


def _aim(people: Any, crowd: Crowd, current: np.ndarray[Any, Any], arrival_radius: float) -> None:
    """Turn people who have arrived to their next goal."""
    everyone, last = np.arange(crowd.people), crowd.goals.shape[1] - 1
    while True:
        goals = crowd.goals[everyone, current]
        near = np.hypot(*(goals - people.pos()).T) <= arrival_radius
        if not np.any(turning := near & (current < last)):
            break
        current[turning] += 1
    people.state[:, 4:6] = goals
