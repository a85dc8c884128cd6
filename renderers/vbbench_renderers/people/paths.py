"""The whole path of everybody, in time and in steps: rendering knows the future, so nothing needs to be predicted.

Step length follows from the walk ratio W = step length / step rate, which healthy adults hold constant from about
1 m/s up (Sekiya and Nagasaki 1998; Murakami and Otaka 2017): length = √(W · speed), here with W in proportion to
the person's height. Slower steps are a little longer than that, and never shorter than `SHORTEST` of the height.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.ndimage import gaussian_filter1d

from vbbench.geometry import FloatArray, IntArray, runs_of_true
from vbbench.scene import Scene

STEP_AT_1_3 = 0.41
"""Step length over height at 1.3 m/s: W = 0.0064 m min for 1.72 m."""
SHORTEST, LONGEST = 0.10, 0.50
STILL, WALKING = 0.12, 0.40
"""Speeds in m/s below which a person stands, and above which they walk; they shuffle in between."""
SMOOTH_S = 0.25
FINE_S = 0.1
X, Y, PHASE, HEADING, SPEED, SMOOTH_X, SMOOTH_Y = range(7)


@dataclass(frozen=True, kw_only=True)
class Paths:
    """Tables with a row for every fine time step of every run (a stretch of frames without a gap) of every person.

    Parameters
    ----------
    fine : rows a frame.
    first_row : [T, K] row of a frame, −1 where the person is absent.
    rows : [R, 7] x, y in m, phase in strides, heading in rad (unwrapped), speed in m/s, smoothed x, y in m.
    run : [R] run of a row.
    first_plant : [runs] where the footfalls of a run start in `plants`, less their number of half strides.
    plants : [P, 4] x, y in m of the body in the middle of each stance, cosine and sine of its heading.
    """

    fine: int
    first_row: IntArray
    rows: FloatArray
    run: IntArray
    first_plant: IntArray
    plants: FloatArray


def step_length(speed: FloatArray, height: FloatArray | float) -> FloatArray:
    """Step length in m at a speed in m/s of a person of a height in m."""
    length = STEP_AT_1_3 * np.sqrt(speed / 1.3)
    return np.asarray(np.clip(length, SHORTEST, LONGEST) * height)


def trace_paths(scene: Scene, heights: FloatArray, stride_scale: FloatArray, starts: FloatArray) -> Paths:
    """The paths of a scene.

    Parameters
    ----------
    scene : who is where.
    heights : [K] in m.
    stride_scale : [K] personal factor of the step length.
    starts : [K] phase in strides at which each person sets out.
    """
    fine = max(1, int(np.ceil(scene.dt / FINE_S - 1e-6)))
    first_row = np.full(scene.present.shape, -1, dtype=np.int64)
    tables, plants, first_plant = [], [], []
    rows = footfalls = 0
    for k in range(len(scene.people)):
        phase = starts[k]
        for begin, end in runs_of_true(scene.present[:, k]).tolist():
            table = _trace(scene.positions[begin:end, k], scene.dt, fine, heights[k] * stride_scale[k], phase)
            feet, first = _plants(table, heights[k] * stride_scale[k])
            first_row[begin:end, k] = rows + fine * np.arange(end - begin)
            first_plant.append(footfalls - first)
            tables.append(table)
            plants.append(feet)
            rows, footfalls, phase = rows + len(table), footfalls + len(feet), table[-1, PHASE]
    return Paths(
        fine=fine,
        first_row=first_row,
        rows=np.concatenate([*tables, np.empty((0, 7))]),
        run=np.repeat(np.arange(len(tables)), [len(table) for table in tables]),
        first_plant=np.array(first_plant, dtype=np.int64),
        plants=np.concatenate([*plants, np.empty((0, 4))]),
    )


def _trace(positions: FloatArray, dt: float, fine: int, height: float, phase: float) -> FloatArray:
    """The rows of a run."""
    frames = len(positions)
    if frames == 1:
        heading = 2.0 * np.pi * (phase % 1.0)
        return np.array([[*positions[0], phase, heading, 0.0, *positions[0]]])
    spline = make_interp_spline(np.arange(frames), positions, k=min(3, frames - 1))
    points = spline(np.arange((frames - 1) * fine + 1) / fine)
    points[::fine] = positions
    step = dt / fine
    smooth = _smoothed(points, SMOOTH_S / step)
    velocity = np.gradient(smooth, step, axis=0)
    speed = np.hypot(*velocity.T)
    stride = 2.0 * step_length(speed, height)
    gain = np.concatenate([[0.0], np.cumsum(0.5 * (speed / stride)[1:] + 0.5 * (speed / stride)[:-1]) * step])
    eased = np.minimum(gaussian_filter1d(speed, 0.15 / step, mode="nearest"), speed + 0.2)
    return np.column_stack([points, phase + gain, _headings(velocity, speed, step), eased, smooth])


def _smoothed(points: FloatArray, sigma: float) -> FloatArray:
    """Gaussian smoothing that continues in a straight line beyond both ends."""
    pad = int(np.ceil(3 * sigma))
    reach = min(len(points) - 1, max(1, round(sigma)))
    before = points[0] + (points[0] - points[reach]) / reach * np.arange(pad, 0, -1)[:, None]
    after = points[-1] + (points[-1] - points[-1 - reach]) / reach * np.arange(1, pad + 1)[:, None]
    return np.asarray(
        gaussian_filter1d(np.concatenate([before, points, after]), sigma, axis=0)[pad : pad + len(points)]
    )


def _headings(velocity: FloatArray, speed: FloatArray, step: float) -> FloatArray:
    """Unwrapped direction of motion; it is kept while the person is slow."""
    moving = np.flatnonzero(speed > 0.25)
    if len(moving) == 0:
        moving = np.array([int(np.argmax(speed))])
    angles = np.unwrap(np.arctan2(velocity[moving, 1], velocity[moving, 0]))
    last = np.clip(np.searchsorted(moving, np.arange(len(speed)), side="right") - 1, 0, len(moving) - 1)
    return np.asarray(gaussian_filter1d(angles[last], 0.2 / step, mode="nearest"))


def _plants(table: FloatArray, height: float) -> tuple[FloatArray, int]:
    """Where the body is in the middle of each stance, two footfalls more than needed at either end; the first's number.

    Footfall j belongs to phase j/2; even ones are of the left foot.
    """
    phase = table[:, PHASE] + 1e-9 * np.arange(len(table))
    first = int(np.floor(2.0 * phase[0])) - 3
    numbers = np.arange(first, int(np.ceil(2.0 * phase[-1])) + 4)
    at = 0.5 * numbers
    heading = np.interp(at, phase, table[:, HEADING])
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    stride = 2.0 * step_length(np.interp(at, phase, table[:, SPEED]), height)
    beyond = np.where(at > phase[-1], at - phase[-1], np.minimum(at - phase[0], 0.0)) * stride
    place = np.stack([np.interp(at, phase, table[:, column]) for column in (SMOOTH_X, SMOOTH_Y)], axis=-1)
    return np.concatenate([place + beyond[:, None] * ahead, ahead], axis=-1), first
