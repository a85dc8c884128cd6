"""Walk crowds: the same numbers for one crowd or many, on one thread or more."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from vbbench.generation.generator import Engine
from vbbench.geometry import FloatArray, frozen_array
from vbbench_generators.social_force.crowd import Crowd
from vbbench_generators.social_force.model import Model
from vbbench_generators.social_force.schedule import march_crowds

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
    crowd, model : who walks, and how.
    frames : number of frames T; the first one is the start.
    dt : seconds a frame.
    substeps : steps of integration between two frames.
    walls : [M, 4] line segments x0, y0, x1, y1 in m.
    engine : ``numba``, or ``pysocialforce`` to have the library of that name do it.
    threads : at most so many, numba's number of threads by default; the result does not depend on it.

    Returns
    -------
    [T, K, 2] positions in m.

    Raises
    ------
    ValueError
        If a number is out of range, or the engine cannot do what the model says.
    """
    if engine == "pysocialforce":
        from vbbench_generators.social_force.library import walk

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
    return march_crowds(crowds, model, segments, frames, dt, substeps, threads)


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
