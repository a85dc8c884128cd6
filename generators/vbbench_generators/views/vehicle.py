"""A vehicle that stands or drives among the people of a scene and carries the camera, in place of one of them.

Its speed v and yaw rate ω are Ornstein–Uhlenbeck processes. The way that they make is laid so that at a time drawn at
random the middle of the crowd is straight ahead, at a distance and from a side that are drawn, too. It is cut to the
longest run of frames in which enough people are in view and nobody is run over.
"""

from dataclasses import asdict, dataclass
from functools import cache
from itertools import pairwise
from typing import Annotated, Any

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.generation.generator import Look, Options
from vbbench.geometry import BoolArray, FloatArray, world_to_relative, wrap_angle
from vbbench.parsing.numbers import Within, check_ranges
from vbbench.parsing.toml_text import read_bundled
from vbbench.scene import Scene
from vbbench_generators.footage.sequences import NO_OBSERVER
from vbbench_generators.recordings.eligibility import Span
from vbbench_generators.tiers.noise import wandering
from vbbench_generators.views.viewing import look_definition

Speed = Annotated[float, Within(0.0, 100.0, "m/s")]
Seconds = Annotated[float, Within(1e-3, 1e4, "s")]
Metres = Annotated[float, Within(0.0, 1e4, "m")]
Count = Annotated[int, Within(1, 10**6)]


@dataclass(frozen=True, kw_only=True)
class VehicleModel:
    """The file ``vehicle.toml``, which says what each value is."""

    standing: Annotated[float, Within(0.0, 1.0)]
    slowest: Speed
    fastest: Speed
    speed_std: Speed
    speed_time: Seconds
    yaw_rate_std: Annotated[float, Within(0.0, 10.0, "rad/s")]
    yaw_rate_time: Seconds
    nearest_crowd: Metres
    farthest_crowd: Metres
    clearance: Metres
    horizon: Metres
    fewest: Count
    shortest: Count
    tries: Count

    def __post_init__(self) -> None:
        check_ranges(self)


@cache
def get_vehicle() -> VehicleModel:
    """The model that comes with this package."""
    return read_bundled("vbbench_generators", "views/vehicle.toml", VehicleModel, "top level")


def observer_definition(options: Options, look: Look) -> dict[str, Any]:
    """What a camera's way follows from, as JSON: part of a dataset's definition and id.

    Raises
    ------
    VbbenchError
        If a vehicle is asked to look somewhere else than ahead.
    """
    if options.observer == "walker":
        return look_definition(look)
    if options.look is not None:
        raise VbbenchError("a vehicle looks where it drives; leave --look out, or ask for --observer walker")
    return {"observer": options.observer, "vehicle": asdict(get_vehicle())}


@dataclass(frozen=True)
class Drive:
    """A vehicle's way.

    Parameters
    ----------
    first : frame of the crowd at which it begins.
    poses : [T, 3] (x, y, yaw) in m and rad, from there on.
    """

    first: int
    poses: FloatArray


def ride(
    scene: Scene, span: Span, crowd: BoolArray, camera: Camera, rng: np.random.Generator
) -> tuple[Span, FloatArray]:
    """The frames of a ``span`` that a vehicle watches, in place of the person who would, and its poses [T, 3].

    ``crowd`` [T, K] says who is there to be seen in the frames of the span.
    """
    positions = scene.positions[span.first : span.first + len(span.counted)]
    way = drive(positions, crowd & span.counted[:, None], scene.dt, camera, get_vehicle(), rng)
    counted = span.counted[way.first : way.first + len(way.poses)]
    return Span(scene=span.scene, column=NO_OBSERVER, first=span.first + way.first, counted=counted), way.poses


def drive(
    crowd: FloatArray, there: BoolArray, dt: float, camera: Camera, model: VehicleModel, rng: np.random.Generator
) -> Drive:
    """A way among people at ``crowd`` [T, K, 2] in m, NaN = absent, of whom ``there`` [T, K] are to be seen.

    Where no way that was drawn sees enough of them for long enough, the vehicle stands aside and sees them all.
    """
    wanted = min(model.fewest, int(there.sum(axis=1).max(initial=1)))
    shortest = min(model.shortest, int((there.sum(axis=1) >= wanted).sum()))
    for _ in range(model.tries):
        poses = _draw(crowd, there, dt, model, rng)
        first, last = _longest_run(_good(crowd, there, poses, wanted, camera, model))
        if last - first >= shortest:
            return Drive(first, poses[first:last])
    return Drive(0, np.tile(_aside(crowd[there], camera, model, rng), (len(crowd), 1)))


def _draw(crowd: FloatArray, there: BoolArray, dt: float, model: VehicleModel, rng: np.random.Generator) -> FloatArray:
    """A way [T, 3] that has the crowd ahead at some time."""
    speeds, turns = _motion(len(crowd), dt, model, rng)
    yaw = np.concatenate([[0.0], np.cumsum(turns * dt)])
    steps = speeds[:, None] * dt * np.stack([np.cos(yaw[:-1]), np.sin(yaw[:-1])], axis=-1)
    places = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    at = rng.choice(np.flatnonzero(there.any(axis=1)))
    side, away = rng.uniform(-np.pi, np.pi), rng.uniform(model.nearest_crowd, model.farthest_crowd)
    middle = np.median(crowd[at, there[at]], axis=0) - away * np.array([np.cos(side), np.sin(side)])
    turned = side - yaw[at]
    cos, sin = np.cos(turned), np.sin(turned)
    moved = (places - places[at]) @ np.array([[cos, sin], [-sin, cos]]) + middle
    return np.concatenate([moved, wrap_angle(yaw + turned)[:, None]], axis=1)


def _motion(frames: int, dt: float, model: VehicleModel, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Speeds and yaw rates [T − 1] in m/s and rad/s from each frame to the next."""
    if rng.random() < model.standing:
        return np.zeros(frames - 1), np.zeros(frames - 1)
    mean = rng.uniform(model.slowest, model.fastest)
    changes = wandering((frames - 1,), model.speed_time, dt, rng)
    turns = model.yaw_rate_std * wandering((frames - 1,), model.yaw_rate_time, dt, rng)
    speeds = np.maximum(mean + model.speed_std * changes, 0.0)
    return speeds, np.where(speeds > 0.0, turns, 0.0)


def _good(
    crowd: FloatArray, there: BoolArray, poses: FloatArray, wanted: int, camera: Camera, model: VehicleModel
) -> BoolArray:
    """[T] whether enough people are in view, and nobody is in the way."""
    right, forward = np.moveaxis(world_to_relative(crowd, poses), -1, 0)
    away = np.hypot(right, forward)
    seen = there & (away < model.horizon)
    if camera.view is not None:
        azimuth = np.arctan2(right, forward)
        seen &= (azimuth > camera.view[0]) & (azimuth < camera.view[1])
    good: BoolArray = (seen.sum(axis=1) >= wanted) & ~(away < model.clearance).any(axis=1)
    return good


def _longest_run(good: BoolArray) -> tuple[int, int]:
    """The longest run of frames first ≤ t < last that are all ``good`` [T]; the first of several."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]])))
    runs = [(int(first), int(last)) for first, last in pairwise(ends)][::2]
    return max(runs, key=lambda run: run[1] - run[0], default=(0, 0))


def _aside(places: FloatArray, camera: Camera, model: VehicleModel, rng: np.random.Generator) -> FloatArray:
    """A pose [3] out of everybody's way that has all ``places`` [N, 2] in view."""
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    radius = float(np.hypot(*(places - middle).T).max())
    half = np.pi / 2 if camera.view is None else min(-camera.view[0], camera.view[1])
    away, side = max(radius / np.sin(half), radius + model.clearance), rng.uniform(-np.pi, np.pi)
    return np.array([*(middle - away * np.array([np.cos(side), np.sin(side)])), side])
