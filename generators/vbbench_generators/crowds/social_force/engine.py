"""Walk crowds: the same numbers for one crowd or many, on one thread or more."""

from collections.abc import Sequence
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from vbbench.generation.generator import Engine
from vbbench.geometry import FloatArray, frozen_array
from vbbench_generators.crowds.social_force.basics import HELBING_MOLNAR, MOUSSAID, NUMBERS, PYSOCIALFORCE, SETTINGS
from vbbench_generators.crowds.social_force.march import Crowds, march, march_large, march_side_by_side
from vbbench_generators.crowds.social_force.model import Crowd, HelbingMolnar, Model

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
    engine: Engine = "numba",
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
    engine : ``numba``, or ``pysocialforce`` for the library of that name.
    threads : maximum number, by default numba's; the result does not depend on it.

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
    if engine != "numba":
        raise ValueError(f"engine must be 'numba' or 'pysocialforce', not {engine!r}")
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
    available = numba.get_num_threads()
    threads = available if threads is None else min(threads, numba.config.NUMBA_NUM_THREADS)
    numba.set_num_threads(threads)
    try:
        # The largest first, so that threads end together.
        small = sorted((n for n, c in enumerate(crowds) if 0 < c.people < LARGE), key=lambda n: -crowds[n].people)
        if small:
            packed = _pack([crowds[n] for n in small], model, segments, dt, substeps)
            together = np.empty((frames, packed.states.shape[1], 2))
            if threads == 1 or len(small) == 1:
                march(packed, together)
            else:
                with numba.parallel_chunksize(1):
                    march_side_by_side(packed, together)
            for n, scene in zip(small, packed.scenes, strict=True):
                paths[n][:] = together[:, scene[0] : scene[1]]
        for n, crowd in enumerate(crowds):
            if crowd.people >= LARGE:
                march_large(_pack([crowd], model, segments, dt, substeps), paths[n])
    finally:
        numba.set_num_threads(available)
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


def _pack(crowds: Sequence[Crowd], model: Model, walls: FloatArray, dt: float, substeps: int) -> Crowds:
    """Lay crowds end to end."""
    members = [crowd.members() for crowd in crowds]
    groups = [group for crowd_groups in members for group in crowd_groups]
    ends = np.cumsum(
        [(crowd.people, crowd.goals.size // 2, len(own)) for crowd, own in zip(crowds, members, strict=True)], axis=0
    )
    bounds = np.stack((np.vstack((np.zeros((1, 3), np.int64), ends[:-1])), ends), axis=2)
    states = np.concatenate([np.column_stack((crowd.positions, crowd.velocities)) for crowd in crowds]).T
    # pysocialforce takes the speed at the start, 1.3 times, for the desired one.
    speeds = [np.hypot(*crowd.velocities.T) if model.strict else crowd.speeds for crowd in crowds]
    return Crowds(
        scenes=bounds.reshape(len(crowds), 6).astype(np.int64),
        states=np.ascontiguousarray(states),
        speeds=np.concatenate(speeds),
        goals=np.concatenate([crowd.goals.reshape(-1, 2) for crowd in crowds]),
        members=np.concatenate([np.empty(0, np.int64), *groups]),
        groups=np.cumsum([0, *map(len, groups)], dtype=np.int64),
        walls=np.array(walls),
        numbers=model_numbers(model),
        dt=float(dt),
        substeps=int(substeps),
    )


def model_numbers(model: Model) -> NDArray[Any]:
    """The model's numbers as one record."""
    repulsion, walls = model.repulsion, vars(model.walls)
    own = {**vars(model), **vars(model.groups), **vars(repulsion), "desired_factor": 1.0, "kind": MOUSSAID}
    if isinstance(repulsion, HelbingMolnar):
        own |= {"kind": HELBING_MOLNAR, "factor": repulsion.strength, "wall_factor": repulsion.wall_strength}
        own["view_cosine"] = np.cos(np.radians(repulsion.view_angle / 2.0))
    else:
        own |= {f"wall_{name}": value for name, value in walls.items()} | {"body_radius": walls["body_radius"]}
    if model.strict:
        own |= {"kind": PYSOCIALFORCE, "desired_factor": model.top_speed}
    numbers = np.zeros(1, SETTINGS)
    for name in own.keys() & {"kind", *NUMBERS.split()}:
        numbers[name] = own[name]
    return numbers
