"""A vehicle or robot that carries the camera among the people of a scene.

A vehicle's speed v and yaw rate ω are Ornstein–Uhlenbeck processes. Its path is placed at random many times: at a
random time the middle of the crowd is straight ahead, at a random distance and from a random side. Each placement is
cut to the longest run of frames in which enough people are in view and nobody is run over. Of the placements with long
runs, the one is chosen whose nearest person is closest to a random distance: the longest runs are far from people,
where no box reaches the picture's border.
"""

from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Annotated, Any

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.generation.generator import Look, Options
from vbbench.geometry import BoolArray, FloatArray, IntArray, moved_as_one, runs_of_true, wrap_angle
from vbbench.parsing.numbers import Checked, Share, Within
from vbbench.parsing.toml_text import read_bundled
from vbbench.scene import Scene
from vbbench.sequence import NO_OBSERVER, Odometry
from vbbench_generators import _core
from vbbench_generators.footage.odometry_filter import Readings, filter_motion
from vbbench_generators.recordings.recipe import Span
from vbbench_generators.tiers.noise import wandering
from vbbench_generators.views.looking import natural_look

STEP = 0.005
"""Seconds of a step of the drive."""
WHEELS_EVERY, GYRO_EVERY = 4, 10
"""Steps from a reading of the wheels, and of the gyro, to the next."""
SPIN_STEPS = 60
"""Steps for which a wheel spins."""

Positive = Annotated[float, Within(1e-3, 1e3)]


@dataclass(frozen=True, kw_only=True)
class RobotModel(Checked):
    """The file ``robot.toml``, which documents each value."""

    top_speed: Positive
    acceleration: Positive
    turn_rate: Positive
    turn_time: Positive
    lead: Positive
    speed_slip: Share
    turn_slip: Share
    slip_time: Positive
    spins: Annotated[float, Within(0.0, 1e3)]
    gyro_bias: Share
    wheel_std: Share
    gyro_std: Share


@cache
def get_robot() -> RobotModel:
    """The model that comes with this package."""
    return read_bundled("vbbench_generators", "views/robot.toml", RobotModel, "top level")


def follow(walk: FloatArray, dt: float, rng: np.random.Generator) -> tuple[FloatArray, Odometry]:
    """Poses [T, 3] (x, y, yaw) in m and rad of a robot that follows a person, and odometry by its wheels and gyro.

    Parameters
    ----------
    walk : [T, 2] places of the person in m, ``dt`` seconds apart.
    """
    model = get_robot()
    times = np.asarray(STEP * np.arange(round((len(walk) - 1) * dt / STEP) + 1), np.float64)
    frames = np.asarray(dt * np.arange(len(walk)), np.float64)
    ahead = times + model.lead
    goals = np.stack([np.interp(ahead, frames, axis) for axis in walk.T], axis=-1)
    names = ("top_speed", "acceleration", "turn_rate", "turn_time", "lead")
    way = _core.steer(goals, walk[0], **{name: getattr(model, name) for name in names}, step=STEP)
    speed, turn, gyro = sense(times, way[:, 3], way[:, 4], model, rng.normal(0.0, model.gyro_bias), rng)
    measured = filter_motion(frames, speed, turn, gyro)
    poses = way[np.rint(frames / STEP).astype(int), :3]
    poses[:, 2] = wrap_angle(poses[:, 2])
    return poses, measured.odometry


def sense(
    times: FloatArray, speed: FloatArray, turn: FloatArray, model: RobotModel, bias: float, rng: np.random.Generator
) -> tuple[Readings, Readings, Readings]:
    """Simulated readings of the wheels' speed and turning rate, and of the gyro's turning rate.

    Parameters
    ----------
    times : [N] in s, `STEP` apart.
    speed, turn : [N] true values, in m/s and rad/s.
    bias : bias of the gyro in rad/s.
    """
    wheels = speed * (1.0 + changing(rng, len(times), model.speed_slip, model.slip_time))
    spins = round(model.spins * len(times) * STEP / 60.0)
    for first in rng.integers(0, len(times), spins):
        wheels[first : first + SPIN_STEPS] *= rng.uniform(1.1, 1.4)
    turning = turn * (1.0 + changing(rng, len(times), model.turn_slip, model.slip_time))
    gyro = turn + bias + rng.normal(0.0, model.gyro_std, len(times))
    often, seldom = slice(None, None, WHEELS_EVERY), slice(None, None, GYRO_EVERY)
    said = [(one + rng.normal(0.0, model.wheel_std, len(times)))[often] for one in (wheels, turning)]
    return (
        Readings(times=times[often], values=said[0]),
        Readings(times=times[often], values=said[1]),
        Readings(times=times[seldom], values=gyro[seldom]),
    )


def changing(rng: np.random.Generator, count: int, spread: float, seconds: float) -> FloatArray:
    """Random numbers [count] of the deviation ``spread``, `STEP` s apart, smooth between knots ``seconds`` s apart."""
    knots = rng.normal(0.0, 1.0, len(np.arange(-2.0, count * STEP / seconds + 3.0)))
    at = np.arange(count) * STEP / seconds
    first, part = np.floor(at).astype(int) + 2, at - np.floor(at)
    weight = part * part * (3.0 - 2.0 * part)
    mixed = (1.0 - weight) * knots[first] + weight * knots[first + 1]
    numbers: FloatArray = spread * mixed / np.sqrt(np.mean((1.0 - weight) ** 2 + weight**2))
    return numbers


Speed = Annotated[float, Within(0.0, 100.0, "m/s")]
Seconds = Annotated[float, Within(1e-3, 1e4, "s")]
Metres = Annotated[float, Within(0.0, 1e4, "m")]
Count = Annotated[int, Within(1, 10**6)]


@dataclass(frozen=True, kw_only=True)
class VehicleModel(Checked):
    """The file ``vehicle.toml``, which documents each value."""

    standing: Share
    slowest: Speed
    fastest: Speed
    speed_std: Speed
    speed_time: Seconds
    yaw_rate_std: Annotated[float, Within(0.0, 10.0, "rad/s")]
    yaw_rate_time: Seconds
    nearest_crowd: Metres
    farthest_crowd: Metres
    nearest_person: Metres
    farthest_person: Metres
    clearance: Metres
    horizon: Metres
    fewest: Count
    shortest: Count
    longest: Count
    stride: Count
    tries: Count
    places: Count
    long_enough: Share


@cache
def get_vehicle() -> VehicleModel:
    """The model that comes with this package."""
    return read_bundled("vbbench_generators", "views/vehicle.toml", VehicleModel, "top level")


def observer_definition(options: Options, look: Look) -> dict[str, Any]:
    """The parameters of a camera's path, as JSON: part of a dataset's definition and id.

    Raises VbbenchError if a vehicle or a robot has another ``look`` than ahead.
    """
    if options.observer == "walker":
        return {"look": look, **({} if look in ("motion", "wander") else {"natural": asdict(natural_look())})}
    if options.look is not None:
        who = options.observer
        raise VbbenchError(f"a {who} looks where it drives; remove `look`, or choose `observer` walker")
    model = get_vehicle() if options.observer == "vehicle" else get_robot()
    return {"observer": options.observer, options.observer: asdict(model)}


def find_windows(scene: Scene, number: int, crowd: BoolArray) -> list[Span]:
    """The windows of a scene, the ``number``-th, in which a vehicle may see enough of the ``crowd`` [T, K]."""
    model = get_vehicle()
    first = np.arange(0, max(scene.frames - model.longest, 0) + 1, model.stride)
    enough = crowd.sum(axis=1) >= model.fewest
    runs = [_longest_run(enough[start : start + model.longest]) for start in first]
    return [
        Span(
            scene=number, column=NO_OBSERVER, first=int(start), counted=np.ones(min(model.longest, scene.frames), bool)
        )
        for start, (begin, end) in zip(first, runs, strict=True)
        if end - begin >= model.shortest
    ]


def draw_window(scene: Scene, number: int, rng: np.random.Generator) -> Span:
    """A window of a scene, the ``number``-th, drawn at random."""
    longest = min(get_vehicle().longest, scene.frames)
    first = int(rng.integers(scene.frames - longest + 1))
    return Span(scene=number, column=NO_OBSERVER, first=first, counted=np.ones(longest, bool))


def ride(
    scene: Scene, window: Span, crowd: BoolArray, camera: Camera, rng: np.random.Generator
) -> tuple[Span, FloatArray]:
    """The frames of a ``window`` in which a vehicle sees enough, and its poses [T, 3] in them.

    ``crowd`` [T, K] marks the people to be seen in the frames of the window.
    """
    places = window.of(scene.positions)
    there = ~np.isnan(places[..., 0]).all(axis=0)
    first, poses = drive(
        np.ascontiguousarray(places[:, there]),
        np.ascontiguousarray(crowd[:, there]),
        scene.dt,
        camera,
        get_vehicle(),
        rng,
    )
    return replace(window, first=window.first + first, counted=window.counted[: len(poses)]), poses


def drive(
    places: FloatArray, crowd: BoolArray, dt: float, camera: Camera, model: VehicleModel, rng: np.random.Generator
) -> tuple[int, FloatArray]:
    """A path among people: its first frame, and its poses [T, 3] from there on.

    Parameters
    ----------
    places : [T, K, 2] in m of all people, NaN = absent.
    crowd : [T, K] mask of the people to be seen.
    dt : seconds per frame.
    camera : the camera.

    If no random path sees enough people for long enough, the vehicle stands aside and sees them all.
    """
    people = crowd.sum(axis=1)
    wanted = min(model.fewest, int(people.max(initial=1)))
    shortest = min(model.shortest, int((people >= wanted).sum()))
    away = rng.uniform(model.nearest_person, model.farthest_person)
    limits = (*(camera.view or (-np.pi, np.pi)), model.horizon, model.clearance)
    for _ in range(model.tries):
        ways = _lay(_draw_way(len(places), dt, model, rng), places, crowd, model, rng)
        best, first, last = _choose(*_core.look_round(places, crowd, ways, wanted, limits), away, model)
        if last - first >= shortest:
            return first, ways[best, first:last]
    first, last = _longest_run(people >= wanted)
    return first, np.tile(_aside(places[crowd], camera, model, rng), (last - first, 1))


def _choose(runs: IntArray, nearest: FloatArray, away: float, model: VehicleModel) -> tuple[int, int, int]:
    """The index of the chosen path, and its frames first ≤ t < last.

    Of the paths whose ``runs`` [P, 2] are nearly as long as the longest of all, it is the one whose median distance of
    the ``nearest`` [P, T] person is closest to ``away`` m.
    """
    lengths, frames, ways = runs[:, 1] - runs[:, 0], np.arange(nearest.shape[1]), np.arange(len(runs))
    inside = (runs[:, :1] <= frames) & (frames < runs[:, 1:])
    ordered = np.sort(np.where(inside, nearest, np.inf), axis=1)
    lower, upper = np.maximum((lengths - 1) // 2, 0), np.minimum(lengths // 2, len(frames) - 1)
    off = np.abs(0.5 * (ordered[ways, lower] + ordered[ways, upper]) - away)
    off[lengths < max(model.long_enough * lengths.max(), 1)] = np.inf
    best = int(np.argmin(off))
    return best, int(runs[best, 0]), int(runs[best, 1])


def _draw_way(frames: int, dt: float, model: VehicleModel, rng: np.random.Generator) -> FloatArray:
    """Draw a path [T, 3] of poses in m and rad, from the origin along x."""
    speeds, turns = _motion(frames, dt, model, rng)
    yaw = np.concatenate([[0.0], np.cumsum(turns * dt)])
    steps = speeds[:, None] * dt * np.stack([np.cos(yaw[:-1]), np.sin(yaw[:-1])], axis=-1)
    return np.concatenate([np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]), yaw[:, None]], axis=1)


def _lay(
    way: FloatArray, places: FloatArray, crowd: BoolArray, model: VehicleModel, rng: np.random.Generator
) -> FloatArray:
    """`VehicleModel.places` placements [P, T, 3] of the path ``way`` [T, 3], each with the crowd ahead at some time."""
    count = model.places
    at = rng.choice(np.flatnonzero(crowd.any(axis=1)), count)
    side, away = rng.uniform(-np.pi, np.pi, count), rng.uniform(model.nearest_crowd, model.farthest_crowd, count)
    middle = np.stack([places[t, crowd[t]].mean(axis=0) for t in at])
    goal = middle - away[:, None] * np.stack([np.cos(side), np.sin(side)], axis=-1)
    return moved_as_one(way, way[at], np.column_stack([goal, side]))


def _motion(frames: int, dt: float, model: VehicleModel, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Draw speeds and yaw rates [T − 1] in m/s and rad/s from each frame to the next."""
    if rng.random() < model.standing:
        return np.zeros(frames - 1), np.zeros(frames - 1)
    mean = rng.uniform(model.slowest, model.fastest)
    changes = wandering((frames - 1,), model.speed_time, dt, rng)
    turns = model.yaw_rate_std * wandering((frames - 1,), model.yaw_rate_time, dt, rng)
    speeds = np.maximum(mean + model.speed_std * changes, 0.0)
    return speeds, np.where(speeds > 0.0, turns, 0.0)


def _longest_run(good: BoolArray) -> tuple[int, int]:
    """The longest run of frames first ≤ t < last that are all ``good`` [T]; the first of several."""
    first, last = max(runs_of_true(good).tolist(), key=lambda run: run[1] - run[0], default=(0, 0))
    return first, last


def _aside(places: FloatArray, camera: Camera, model: VehicleModel, rng: np.random.Generator) -> FloatArray:
    """A pose [3] outside the crowd with all ``places`` [N, 2] in view."""
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    radius = float(np.hypot(*(places - middle).T).max())
    half = np.pi / 2 if camera.view is None else min(-camera.view[0], camera.view[1])
    away, side = max(radius / np.sin(half), radius + model.clearance), rng.uniform(-np.pi, np.pi)
    return np.array([*(middle - away * np.array([np.cos(side), np.sin(side)])), side])
