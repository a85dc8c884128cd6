"""Walk crowds: the same numbers for one crowd or many, on one thread or more."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vbbench.generation.generator import Engine
from vbbench.geometry import FloatArray, frozen_array
from vbbench_generators import _core
from vbbench_generators.crowds.social_force.model import STOP_RADIUS, Crowd, HelbingMolnar, Model

NUMBERS = (
    *("desired_factor", "relaxation_time", "top_speed", "arrival_radius", "stop_radius"),
    *("factor", "velocity_weight", "reach", "side_sharpness", "brake_sharpness"),
    *("fall_off", "stride_time", "view_cosine", "unseen_weight"),
    *("wall_factor", "wall_fall_off", "wall_reach", "body_radius"),
    *("cohesion", "gaze", "separation", "personal_space"),
)
"""Names of a model's numbers; lengths are in m, times in s."""

MOUSSAID, HELBING_MOLNAR, PYSOCIALFORCE = range(3)
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
        from vbbench_generators.crowds.social_force.library import walk

        segments = _checked(frames, dt, substeps, walls)
        return walk(crowd, model, frames=frames, dt=dt, substeps=substeps, walls=segments)
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
    repulsion, walls = model.repulsion, vars(model.walls)
    own = {**vars(model), **vars(model.groups), **vars(repulsion), "desired_factor": 1.0}
    own |= {"stop_radius": STOP_RADIUS, "kind": MOUSSAID}
    if isinstance(repulsion, HelbingMolnar):
        own |= {"kind": HELBING_MOLNAR, "factor": repulsion.strength, "wall_factor": repulsion.wall_strength}
        own["view_cosine"] = np.cos(np.radians(repulsion.view_angle / 2.0))
    else:
        own |= {f"wall_{name}": value for name, value in walls.items()} | {"body_radius": walls["body_radius"]}
    if model.strict:
        own |= {"kind": PYSOCIALFORCE, "desired_factor": model.top_speed}
    return {name: float(own.get(name, 0.0)) for name in ("kind", *NUMBERS)}
