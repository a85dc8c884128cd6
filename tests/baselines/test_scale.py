"""How large a world is that boxes alone tell of: as people are tall, however they walk, and at any frame rate."""

from collections.abc import Callable

import numpy as np
import pytest

from vbbench import PerspectiveCamera, Session
from vbbench.geometry import FloatArray
from vbbench_baselines.joint_map import MapCausal

CAMERA = PerspectiveCamera(mount_height=1.2)
TALL, EDGE = 1.72, 0.22
"""m; the near edge is that of `Constants::edge`."""
STILL = ((0.0, 0.0, 0.0), np.diag((0.001, 0.001, 0.0005)) ** 2)
"""Odometry of a robot that stands."""


def box(place: FloatArray, noise: FloatArray, tall: float = TALL) -> tuple[float, float, float, float]:
    """Left, top, width and height of somebody at ``place`` (forward, left), whose box ends nearer than the middle.

    ``noise`` [3] of left, top and bottom, in box heights.
    """
    forward, left = place
    length = CAMERA.focal * tall / (forward - EDGE)
    bottom = CAMERA.cy + CAMERA.focal * CAMERA.mount_height / (forward - EDGE)
    middle = CAMERA.cx - CAMERA.focal * left / forward
    u, top, low = length * noise
    return middle - 0.2 * length + u, bottom - length + top, 0.4 * length, length - top + low


def ratio(places: Callable[[float], FloatArray], dt: float, seconds: float, noise: float, whole: bool = False) -> float:
    """Distances answered of people at ``places`` (seconds) [K, 2], over the true ones, in the last second."""
    session, rng, found = Session(MapCausal(), CAMERA, dt, tilt_std=0.03, people=20), np.random.default_rng(0), []
    frames = round(seconds / dt)
    for t in range(frames):
        true = places(t * dt)
        boxes = [box(place, noise * rng.normal(size=3)) for place in true]
        boxes = [tuple(np.round(one)) if whole else one for one in boxes]
        answer = session.step(dict(enumerate(boxes)), STILL if t else None)
        if t * dt > seconds - 1.0:
            found += [np.hypot(*answer.positions[k]) / np.hypot(*place) for k, place in enumerate(true)]
    return float(np.mean(found))


def circles(seconds: float) -> FloatArray:
    """Six people who walk round in circles of 1.2 m, which no law of straight walks expects."""
    k = np.arange(6)
    round_ = 1.2 * np.stack((np.cos(seconds + k), np.sin(seconds + k)), axis=-1)
    return np.asarray(np.stack((5.5 + 1.5 * k, (-1.0) ** k), axis=-1) + round_)


def strollers(seconds: float) -> FloatArray:
    """Three people who cross, one of them slowly, and one who stands."""
    return np.array(((7.0, -2.0 + 0.8 * seconds), (9.0, 2.0 - 0.3 * seconds), (11.0, -1.5)))


@pytest.mark.slow
@pytest.mark.parametrize("whole", [False, True])
def test_people_who_walk_in_circles_do_not_shrink_the_world(whole: bool) -> None:
    """Their walks are the likelier the smaller they are; frames that left said so for ever, and it became a tenth."""
    assert ratio(circles, 0.1, 30.0, 0.0, whole) == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [10, 20, 30])
@pytest.mark.parametrize("noise", [0.001, 0.02])
def test_the_world_is_as_large_at_any_frame_rate_of_a_camera(rate: int, noise: float) -> None:
    """Feet held against the box's own noisy length placed people farther off the more frames a second has."""
    assert ratio(strollers, 1.0 / rate, 5.0, noise) == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_somebody_who_stands_does_not_drift_off() -> None:
    """So exact boxes, sixty times a second, had people 18 % too far away after six seconds."""

    def standing(_seconds: float) -> FloatArray:
        return np.array(((9.0, -1.5),))

    assert ratio(standing, 1.0 / 60.0, 6.0, 0.001) == pytest.approx(1.0, abs=0.06)


def log_scale(seed: int, spread: float, standing: bool) -> float:
    """Mean log ratio of distances answered to the true ones, from 4 s to 9 s: 8 people of such a spread of heights."""
    rng, dt = np.random.default_rng(seed), 0.4
    tall = TALL * np.exp(rng.normal(0.0, spread, 8))
    place = np.stack((rng.uniform(5.0, 12.0, 8), rng.uniform(-3.0, 3.0, 8)), axis=-1)
    angle, speed = rng.uniform(-np.pi, np.pi, 8), np.abs(rng.normal(1.3, 0.35, 8)) * (not standing)
    velocity = np.stack((np.cos(angle), np.sin(angle)), axis=-1) * speed[:, None]
    session = Session(MapCausal(), CAMERA, dt, height_std=spread * TALL, tilt_std=0.03, mount_height_std=0.2, people=8)
    errors = []
    for t in range(24):
        velocity += np.sqrt(0.03 * dt) * rng.normal(size=(8, 2)) * (not standing)
        place = place + velocity * dt
        inside = np.flatnonzero((place[:, 0] > 3.0) & (np.abs(place[:, 1]) < 0.6 * place[:, 0]))
        boxes = {int(k): box(place[k], 0.02 * rng.normal(size=3), tall[k]) for k in inside}
        answer = session.step(boxes, STILL if t else None)
        if t > 10:
            errors += [np.log(np.hypot(*answer.positions[k]) / np.hypot(*place[k])) for k in inside]
    return float(np.mean(errors))


@pytest.mark.slow
@pytest.mark.parametrize("spread", [0.05, 0.15, 0.22])
@pytest.mark.parametrize("standing", [True, False])
def test_walks_bias_the_scale_of_no_map(spread: float, standing: bool) -> None:
    """However vague heights are, and whether people stand: as probable walks, maps of those who stand grew by 16 %."""
    found = np.array([log_scale(seed, spread, standing) for seed in range(25)])
    assert abs(found.mean()) < 0.01 + 2.5 * found.std() / np.sqrt(len(found))
