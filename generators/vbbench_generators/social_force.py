"""Crowds that walk under the social force model: the engine, its model, and the library pysocialforce as an oracle.

The engine walks one crowd or many, on one thread or more, to the same numbers. The library is pysocialforce 1.1.2 with
its side effects contained: importing it opens ``file.log`` in the working directory, sets the root logger to DEBUG and
adds two handlers; it ignores its configured step width and keeps a copy of every state.
"""

import logging
import os
import sys
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, fields
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vbbench.errors import needs_extra
from vbbench.generation.generator import Engine
from vbbench.geometry import FloatArray, IntArray, frozen_array
from vbbench_generators import _core

__all__ = ["Crowd", "GroupForces", "Model", "Moussaid", "WallForce", "simulate", "simulate_many"]

NO_GROUP = -1


@dataclass(frozen=True, kw_only=True)
class Crowd:
    """One scene at its start.

    Parameters
    ----------
    positions : [K, 2] in m.
    velocities : [K, 2] in m/s.
    speeds : [K] desired speeds in m/s.
    goals : [K, G, 2] in m, the places each person heads for, one after the other; the last one is kept to.
    groups : [K] group number, -1 for people who walk alone; by default everyone does.

    Raises
    ------
    ValueError
        If a shape does not fit, a number is not finite, a speed is negative or there is no goal.
    """

    positions: FloatArray
    velocities: FloatArray
    speeds: FloatArray
    goals: FloatArray
    groups: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    def __post_init__(self) -> None:
        people = len(np.atleast_1d(self.positions))
        shapes = {"positions": (people, 2), "velocities": (people, 2), "speeds": (people,), "goals": (people, None, 2)}
        for name, shape in shapes.items():
            values = frozen_array(name, getattr(self, name), shape)
            if not np.all(np.isfinite(values)):
                raise ValueError(f"{name} must be finite; they hold NaN or infinity")
            object.__setattr__(self, name, values)
        groups = self.groups if np.size(self.groups) else np.full(people, NO_GROUP)
        object.__setattr__(self, "groups", frozen_array("groups", groups, (people,), np.int64))
        if np.any(self.groups < NO_GROUP):
            raise ValueError("groups must be numbers from 0, or -1 for people who walk alone")
        if np.any(self.speeds < 0):
            raise ValueError("speeds must not be negative")
        if self.goals.shape[1] == 0:
            raise ValueError("goals must have shape [K, G, 2] with G of at least 1: everybody heads for some place")

    @property
    def people(self) -> int:
        """Number of people K."""
        return len(self.positions)

    def members(self) -> list[IntArray]:
        """Indices of the people of each group."""
        return [np.flatnonzero(self.groups == group) for group in np.unique(self.groups) if group != NO_GROUP]


STOP_RADIUS = 0.5
"""Distance in m from the last goal at which a person stands still, as in pysocialforce."""


def _check(parameters: object, *free: str) -> None:
    """Raise ValueError unless every number is finite and positive; those called ``free`` may be zero."""
    for parameter in fields(parameters):  # type: ignore[arg-type]
        value = getattr(parameters, parameter.name)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if number and not (np.isfinite(value) and (value > 0 or (value == 0 and parameter.name in free))):
            least = "a finite number, zero or more" if parameter.name in free else "a positive number"
            raise ValueError(f"{type(parameters).__name__}.{parameter.name} must be {least}, not {value}")


@dataclass(frozen=True, kw_only=True)
class Moussaid:
    """Repulsion of Moussaïd et al., Proc. R. Soc. B 276 (2009) 2755; defaults of pysocialforce.

    Parameters
    ----------
    factor : strength A in m/s².
    velocity_weight : λ in s/m, weight of the relative velocity in the interaction vector.
    reach : γ in m, range of the force for an interaction vector of length 1.
    side_sharpness, brake_sharpness : n and n', how fast turning aside and braking fade with the angle.
    """

    factor: float = 5.1
    velocity_weight: float = 2.0
    reach: float = 0.35
    side_sharpness: float = 2.0
    brake_sharpness: float = 3.0

    def __post_init__(self) -> None:
        _check(self, "factor", "velocity_weight", "side_sharpness", "brake_sharpness")


@dataclass(frozen=True, kw_only=True)
class WallForce:
    """Walls, as in pysocialforce: lines sampled at 10 points a metre, each of which repels.

    Parameters
    ----------
    factor : strength in m/s².
    fall_off : in m.
    reach : distance in m from the body's rim beyond which a point does nothing.
    body_radius : in m.
    """

    factor: float = 10.0
    fall_off: float = 0.2
    reach: float = 3.35
    body_radius: float = 0.35

    def __post_init__(self) -> None:
        _check(self, "factor", "body_radius")


@dataclass(frozen=True, kw_only=True)
class GroupForces:
    """What keeps a group together, as in pysocialforce, where these are the factors in effect.

    Parameters
    ----------
    cohesion : pull towards the centre of the group, in 1/s².
    gaze : walking on or waiting so that the others stay in view, in m/s².
    separation : push between members closer than ``personal_space``, in 1/s².
    personal_space : in m.
    """

    cohesion: float = 1.0
    gaze: float = 1.0
    separation: float = 1.0
    personal_space: float = 0.55

    def __post_init__(self) -> None:
        _check(self, "cohesion", "gaze", "separation", "personal_space")


@dataclass(frozen=True, kw_only=True)
class Model:
    """Everything that moves a crowd.

    Parameters
    ----------
    repulsion : how people keep apart.
    walls : how walls repel.
    groups : how groups keep together.
    relaxation_time : τ in s, to regain the desired velocity.
    top_speed : maximum speed, relative to the desired speed.
    arrival_radius : distance in m from a goal at which a person turns to the next one; at least 0.5.
    strict : compute what pysocialforce 1.1.2 computes: angles between directions are not wrapped, and both the desired
        and the top speed are ``top_speed`` times the speed at the start; ``Crowd.speeds`` is not looked at.
    """

    repulsion: Moussaid = field(default_factory=Moussaid)
    walls: WallForce = field(default_factory=WallForce)
    groups: GroupForces = field(default_factory=GroupForces)
    relaxation_time: float = 0.5
    top_speed: float = 1.3
    arrival_radius: float = 1.0
    strict: bool = False

    def __post_init__(self) -> None:
        _check(self)
        if self.top_speed < 1:
            raise ValueError(f"Model.top_speed must be at least 1, not {self.top_speed}")
        if self.arrival_radius < STOP_RADIUS:
            raise ValueError(f"Model.arrival_radius must be at least {STOP_RADIUS} m, not {self.arrival_radius}")


NUMBERS = (
    *("desired_factor", "relaxation_time", "top_speed", "arrival_radius", "stop_radius"),
    *("factor", "velocity_weight", "reach", "side_sharpness", "brake_sharpness"),
    *("wall_factor", "wall_fall_off", "wall_reach", "body_radius"),
    *("cohesion", "gaze", "separation", "personal_space"),
)
"""Names of a model's numbers; lengths are in m, times in s."""

MOUSSAID, PYSOCIALFORCE = range(2)
"""The kinds of repulsion."""

LARGE = 256
"""Crowds of this size or larger are simulated one at a time, with each step spread over threads."""

NO_WALLS: tuple[tuple[float, float, float, float], ...] = ()


def simulate(
    crowd: Crowd,
    model: Model,
    *,
    frames: int,
    dt: float,
    substeps: int,
    walls: ArrayLike = NO_WALLS,
    engine: Engine = "vbbench",
    threads: int | None = None,
) -> FloatArray:
    """Walk one crowd.

    Parameters
    ----------
    crowd, model : the people at the start, and the forces that move them.
    frames : number of frames T; the first one is the start.
    dt : seconds per frame.
    substeps : integration steps per frame.
    walls : [M, 4] line segments x0, y0, x1, y1 in m.
    engine : ``vbbench``, or ``pysocialforce`` for the library of that name.
    threads : maximum number, by default that of the processors; the result does not depend on it.

    Returns
    -------
    [T, K, 2] positions in m.

    Raises
    ------
    ValueError
        If a number is out of range, or the engine cannot do what the model says.
    """
    if engine == "pysocialforce":
        segments = _checked(frames, dt, substeps, walls)
        return walk_by_library(crowd, model, frames=frames, dt=dt, substeps=substeps, walls=segments)
    if engine != "vbbench":
        raise ValueError(f"engine must be 'vbbench' or 'pysocialforce', not {engine!r}")
    return simulate_many([crowd], model, frames=frames, dt=dt, substeps=substeps, walls=walls, threads=threads)[0]


def simulate_many(
    crowds: Sequence[Crowd],
    model: Model,
    *,
    frames: int,
    dt: float,
    substeps: int,
    walls: ArrayLike = NO_WALLS,
    threads: int | None = None,
) -> list[FloatArray]:
    """Walk several crowds, each by itself, side by side; the parameters and each array are those of `simulate`."""
    segments = _checked(frames, dt, substeps, walls)
    if threads is not None and threads < 1:
        raise ValueError(f"threads must be at least 1, not {threads}")
    paths: list[FloatArray] = [np.empty((frames, crowd.people, 2)) for crowd in crowds]
    most = _core.available_threads()
    threads = most if threads is None else min(threads, most)
    # The largest first, so that threads end together.
    small = sorted((n for n, c in enumerate(crowds) if 0 < c.people < LARGE), key=lambda n: -crowds[n].people)
    if small:
        packed = _pack([crowds[n] for n in small], model, segments, dt, substeps)
        together = np.empty((frames, packed["states"].shape[1], 2))
        _core.march(**packed, paths=together, threads=min(threads, len(small)), large=False)
        for n, scene in zip(small, packed["scenes"], strict=True):
            paths[n][:] = together[:, scene[0] : scene[1]]
    for n, crowd in enumerate(crowds):
        if crowd.people >= LARGE:
            _core.march(**_pack([crowd], model, segments, dt, substeps), paths=paths[n], threads=threads, large=True)
    return paths


def _checked(frames: int, dt: float, substeps: int, walls: ArrayLike) -> FloatArray:
    """Return the walls as [M, 4]; raise ValueError where a number is out of range."""
    if frames < 1 or substeps < 1:
        raise ValueError(f"frames and substeps must be at least 1, not {frames} and {substeps}")
    if not (np.isfinite(dt) and dt > 0):
        raise ValueError(f"dt must be a positive number of seconds, not {dt}")
    segments = np.asarray(walls, dtype=np.float64)
    segments = frozen_array("walls", segments if segments.size else np.empty((0, 4)), (None, 4))
    if not np.all(np.isfinite(segments)):
        raise ValueError("walls must be finite; they hold NaN or infinity")
    return np.ascontiguousarray(segments)


def _pack(crowds: Sequence[Crowd], model: Model, walls: FloatArray, dt: float, substeps: int) -> dict[str, Any]:
    """Crowds laid end to end, as `_core.march` takes them."""
    members = [crowd.members() for crowd in crowds]
    groups = [group for crowd_groups in members for group in crowd_groups]
    ends = np.cumsum(
        [(crowd.people, crowd.goals.size // 2, len(own)) for crowd, own in zip(crowds, members, strict=True)], axis=0
    )
    bounds = np.stack((np.vstack((np.zeros((1, 3), np.int64), ends[:-1])), ends), axis=2)
    states = np.concatenate([np.column_stack((crowd.positions, crowd.velocities)) for crowd in crowds]).T
    # pysocialforce takes the speed at the start, 1.3 times, for the desired one.
    speeds = [np.hypot(*crowd.velocities.T) if model.strict else crowd.speeds for crowd in crowds]
    return {
        "scenes": bounds.reshape(len(crowds), 6).astype(np.int64),
        "states": np.ascontiguousarray(states),
        "speeds": np.concatenate(speeds),
        "goals": np.concatenate([crowd.goals.reshape(-1, 2) for crowd in crowds]),
        "members": np.concatenate([np.empty(0, np.int64), *groups]),
        "groups": np.cumsum([0, *map(len, groups)], dtype=np.int64),
        "walls": np.array(walls),
        "numbers": model_numbers(model),
        "dt": float(dt),
        "substeps": int(substeps),
    }


def model_numbers(model: Model) -> dict[str, float]:
    """The model's numbers; 0 for those that it has not."""
    walls = vars(model.walls)
    own = {**vars(model), **vars(model.groups), **vars(model.repulsion), "desired_factor": 1.0}
    own |= {"stop_radius": STOP_RADIUS, "kind": MOUSSAID}
    own |= {f"wall_{name}": value for name, value in walls.items()} | {"body_radius": walls["body_radius"]}
    if model.strict:
        own |= {"kind": PYSOCIALFORCE, "desired_factor": model.top_speed}
    return {name: float(own.get(name, 0.0)) for name in ("kind", *NUMBERS)}


RESOLUTION = 10.0
"""Points a metre of wall in the library."""


def walk_by_library(
    crowd: Crowd, model: Model, *, frames: int, dt: float, substeps: int, walls: FloatArray
) -> FloatArray:
    """Walk one crowd with the library; parameters and result are those of `simulate`.

    Raises
    ------
    ValueError
        If a number is zero, which the library takes for "default".
    """
    numbers = [*vars(model.repulsion).values(), *vars(model.walls).values(), *vars(model.groups).values()]
    if 0 in numbers:
        raise ValueError("engine='pysocialforce' takes a parameter of 0 for its default; use the engine vbbench")
    with _contained():
        simulator = _simulator(crowd, model, walls, dt / substeps)
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


def _simulator(crowd: Crowd, model: Model, walls: FloatArray, step: float) -> Any:
    """The library's simulator with its parameters set."""
    library = import_module("pysocialforce")
    current = crowd.goals[:, 0]
    state = np.column_stack((crowd.positions, crowd.velocities, current))
    # It wants x0, x1, y0, y1, and breaks on walls too short for a point.
    long_enough = np.hypot(*(walls[:, 2:] - walls[:, :2]).T) * RESOLUTION >= 1
    obstacles = walls[long_enough][:, [0, 2, 1, 3]].tolist()
    simulator = library.Simulator(state, groups=[list(group) for group in crowd.members()], obstacles=obstacles)
    simulator.config.from_dict(_configuration(model))
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


def _configuration(model: Model) -> dict[str, dict[str, float]]:
    """The model in the words of the library."""
    repulsion, walls, groups = model.repulsion, model.walls, model.groups
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
