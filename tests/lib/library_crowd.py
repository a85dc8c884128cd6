"""Crowds walked by the library pysocialforce 1.1.2, the oracle of the crowd engine."""

import logging
import os
import tempfile
from contextlib import redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_generators.social_force import Crowd, Model


def imported() -> Any:
    """The library; importing it opens ``file.log`` in the working directory and sets the root logger to DEBUG."""
    root, home = logging.getLogger(), Path.cwd()
    level, handlers = root.level, list(root.handlers)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            return import_module("pysocialforce")
        finally:
            os.chdir(home)
            root.handlers[:] = handlers
            root.setLevel(level)


def walk_by_library(crowd: Crowd, model: Model, *, frames: int, dt: float, substeps: int = 1) -> FloatArray:
    """Positions [T, K, 2] of people without walls and further goals; otherwise as `simulate`."""
    repulsion = model.repulsion
    with redirect_stdout(StringIO()), np.errstate(all="ignore"):
        library = imported()
        simulator = library.Simulator(np.column_stack((crowd.positions, crowd.velocities, crowd.goals[:, 0])))
        forces = {
            "factor": repulsion.factor,
            "lambda_importance": repulsion.velocity_weight,
            "gamma": repulsion.reach,
            "n": repulsion.side_sharpness,
            "n_prime": repulsion.brake_sharpness,
        }
        desired = {"factor": 1.0, "relaxation_time": model.relaxation_time, "goal_threshold": 0.2}
        simulator.config.from_dict({"desired_force": desired, "social_force": forces})
        simulator.forces = simulator.make_forces(simulator.config)
        people = simulator.peds
        people.step_width, people.initial_speeds = dt / substeps, np.array(crowd.speeds)
        people.max_speed_multiplier, people.max_speeds = 1.0, people.initial_speeds
        cap = people.capped_velocity
        people.capped_velocity = lambda velocity, top: cap(velocity, top * model.top_speed)
        paths = [crowd.positions]
        for _ in range(frames - 1):
            for _ in range(substeps):
                simulator.step_once()
                people.ped_states.clear()
                people.group_states.clear()
            paths.append(people.pos().copy())
    return np.array(paths)
