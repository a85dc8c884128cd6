"""Lifting heads to the ground: exact where boxes are, one clear error where they tell nothing, vectorised."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.lib.lifting_crowd import HEAD_HEIGHT, SIZE, Camera, ground_matrix, photograph, walk
from vbbench.errors import VbbenchError
from vbbench_generators._core import smooth
from vbbench_generators.lifting import lift
from vbbench_generators.lifting.camera import camera_of_homography, camera_of_plane
from vbbench_generators.lifting.heads import Heads, LiftingSettings, SizePlane, split_at_gaps

DT = 0.04
AREA = (-9.0, 10.0, 9.0, 32.0)


def crowd(seed=0, people=40, frames=150, camera=None, **noise):
    rng = np.random.default_rng(seed)
    truth = walk(rng, people, frames, DT, rng.uniform(0, 2 * np.pi, people), area=AREA)
    return truth, photograph(camera or Camera(), truth, DT, rng, **noise)


cameras = st.builds(
    Camera,
    focal=st.floats(1000.0, 2500.0),
    tilt=st.floats(np.radians(20.0), np.radians(40.0)),
    roll=st.floats(-0.15, 0.15),
    height=st.floats(8.0, 20.0),
)


@settings(deadline=None, max_examples=12)
@given(camera=cameras)
def test_without_noise_sizes_give_the_horizon_exactly(camera):
    truth, boxes = crowd(camera=camera, people=100, frames=80)
    assume(len(np.unique(boxes.track)) > 12)  # a steep, long lens sees too few people
    found = lift(boxes, LiftingSettings(resamples=20)).calibration
    assert found["horizon"]["value"] == pytest.approx(camera.horizon, abs=1e-4)
    assert found["roll"]["value"] == pytest.approx(camera.roll, abs=1e-6)
    true = truth[boxes.frame, boxes.track - 1]
    centre = boxes.boxes[:, :2] + (boxes.boxes[:, 2:] - SIZE) / 2
    plane = SizePlane(**dict(zip("abc", found["size_plane"], strict=True)))
    lens = camera_of_plane(plane, camera.focal, 0.24, HEAD_HEIGHT)
    assert lens.height == pytest.approx(camera.height, rel=1e-6)
    np.testing.assert_allclose(lens.to_ground(*centre.T), true, atol=1e-5)


@settings(deadline=None, max_examples=25)
@given(camera=cameras, turn=st.floats(-3.0, 3.0), mirrored=st.booleans())
def test_a_homography_gives_the_camera_in_any_frame(camera, turn, mirrored):
    frame = np.array([[np.cos(turn), -np.sin(turn), 4.0], [np.sin(turn), np.cos(turn), -7.0], [0.0, 0.0, 1.0]])
    if mirrored:
        frame[1] *= -1.0
    homography = -3.0 * frame @ np.linalg.inv(ground_matrix(camera))
    found = camera_of_homography(homography, np.array(SIZE) / 2, np.array(SIZE) / 2, HEAD_HEIGHT)
    assert found.focal == pytest.approx(camera.focal, rel=1e-6)
    assert found.tilt == pytest.approx(camera.tilt, abs=1e-6)
    assert found.roll == pytest.approx(camera.roll, abs=1e-6)
    assert found.height == pytest.approx(camera.height, rel=1e-6)
    ground = np.array([[3.0, 15.0], [-4.0, 20.0]])
    u, v, _ = camera.view(ground, HEAD_HEIGHT)
    lifted = found.to_ground(u - SIZE[0] / 2, v - SIZE[1] / 2)
    np.testing.assert_allclose(lifted, ground @ frame[:2, :2].T + frame[:2, 2], atol=1e-6)


def test_the_same_boxes_give_the_same_intervals_and_json_takes_them():
    _, boxes = crowd(size_noise=0.12, jitter=0.06)
    first, second = (lift(boxes, LiftingSettings()).calibration for _ in range(2))
    assert first == second
    assert json.loads(json.dumps(first))["stretch"] == first["stretch"]


@pytest.mark.parametrize("kind", ["one row", "two tracks", "horizon in the crowd", "looking straight down", "nobody"])
def test_a_crowd_that_tells_nothing_is_one_clear_error(kind):
    _, boxes = crowd(size_noise=0.12)
    placed = boxes.boxes.copy()
    if kind == "one row":
        placed[:, 1] = 500.0 - placed[:, 3] / 2
    if kind == "looking straight down":
        placed[:, 2:] = 20.0
    if kind == "horizon in the crowd":
        placed[:, 2:] = np.maximum(0.03 * (placed[:, 1:2] - np.quantile(placed[:, 1], 0.1)), 1.0)
    boxes = replace(boxes, boxes=placed)
    few = {"two tracks": boxes.track < 3, "nobody": boxes.track < 0}
    with pytest.raises(VbbenchError, match="made: ") as caught:
        lift(taken(boxes, few.get(kind, boxes.track > 0)), LiftingSettings())
    assert "\n" not in str(caught.value)
    assert kind == "nobody" or "`homography`" in str(caught.value)


def taken(boxes, chosen):
    parts = {name: getattr(boxes, name)[chosen] for name in ("frame", "track", "boxes", "visible")}
    return replace(boxes, **parts)


@pytest.mark.parametrize("across", [0.02, 0.03], ids=["straight down", "pixels that are not square"])
def test_a_homography_of_no_camera_is_an_error(across):
    _, boxes = crowd()
    with pytest.raises(VbbenchError, match="no camera with square pixels"):
        lift(boxes, LiftingSettings(), np.diag([across, 0.02, 1.0]))


@pytest.mark.parametrize("wrong", [{"head_size": 0.0}, {"gap": -1.0}, {"resamples": 3}])
def test_settings_that_cannot_be_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        LiftingSettings(**wrong)


def test_short_gaps_are_filled_and_long_ones_divide_a_track():
    frame = np.r_[0:10, 15:25, 130:140, 0:5]
    track = np.repeat([4, 7], [30, 5])
    x = frame.astype(float)
    divided = split_at_gaps(Heads(x=x, nu=x, frame=frame, track=track, dt=DT), 4.0)
    assert [(n, int((divided.track == n).sum())) for n in np.unique(divided.track)] == [(4, 20), (7, 5), (8, 10)]
    assert np.all(np.diff(divided.frame)[np.diff(divided.track) == 0] > 0)
    truth, boxes = crowd()
    holes = taken(boxes, boxes.frame % 20 < 12)
    lifted = lift(holes, LiftingSettings(), np.linalg.inv(ground_matrix(Camera()))).tracks
    inner = ~np.isnan(lifted.positions[..., 0])
    assert inner.sum() > 1.4 * len(holes)
    error = lifted.positions - truth[:, lifted.people - 1][: lifted.frames]
    assert np.nanmax(np.abs(error)) < 0.1


def test_the_smoother_is_the_least_squares_solution():
    rng = np.random.default_rng(1)
    count, q = 12, 0.3
    value, variance = rng.normal(size=count), rng.uniform(0.01, 0.1, count)
    transition = np.array([[1.0, DT], [0.0, 1.0]])
    process = q * np.array([[DT**3 / 3, DT**2 / 2], [DT**2 / 2, DT]])
    information = np.zeros((2 * count, 2 * count))
    information[1, 1] += 1 / 25.0
    for t in range(count):
        information[2 * t, 2 * t] += 1 / variance[t]
    for t in range(count - 1):
        block = np.hstack([-transition, np.eye(2)])
        part = slice(2 * t, 2 * t + 4)
        information[part, part] += block.T @ np.linalg.inv(process) @ block
    right = np.zeros(2 * count)
    right[::2] = value / variance
    wanted = np.linalg.solve(information, right)[::2]
    got = smooth(value, variance, np.array([0, count]), q, DT)
    np.testing.assert_allclose(got, wanted, atol=1e-7)


def test_smoothing_brings_tracks_nearer_to_the_truth():
    truth, boxes = crowd(people=80, frames=300, jitter=0.2)
    lifted = lift(boxes, LiftingSettings(), np.linalg.inv(ground_matrix(Camera())))
    speed = np.diff(lifted.tracks.positions, axis=0) / DT
    wanted = np.diff(truth[:, lifted.tracks.people - 1], axis=0)[: len(speed)] / DT
    assert np.sqrt(np.nanmean((speed - wanted) ** 2)) < 0.15
    assert 0.5 < lifted.calibration["smoothing_residual_px"] / (0.2 * 18.0 * np.sqrt(2.0)) < 1.5


NOISE = {"size_noise": 0.12, "jitter": 0.06, "key": 10, "person": 0.04, "height": 0.065}


@pytest.mark.parametrize("balls", [False, True])
def test_round_heads_are_told_from_flat_ones(balls):
    """A lens of 75° makes balls in the corners a fifth longer, which would move the horizon by 27 px."""
    camera, rng = Camera(focal=1250.0), np.random.default_rng(11)
    truth = walk(rng, 200, 250, DT, rng.uniform(0, 2 * np.pi, 200), area=(-14.0, 4.0, 14.0, 35.0))
    boxes = photograph(camera, truth, DT, rng, size_noise=0.06, key=5, balls=balls)
    found = lift(boxes, LiftingSettings()).calibration
    assert found["roundness"] == pytest.approx(float(balls), abs=0.1)
    assert abs(found["horizon"]["value"] - camera.horizon) < 8.0


def ways(kind, rng, people):
    angle = rng.uniform(0, 2 * np.pi) + 0.1 * rng.normal(size=people)
    turns = {"all": 2 * np.pi * rng.uniform(size=people), "one": np.zeros(people)}
    turns["two"] = np.pi * rng.integers(0, 2, people)
    return angle + turns[kind]


def preference(rng, spread):
    """Log speed as a function of direction, drawn from what the lifting allows for."""
    order = np.arange(1, 7)
    size = spread * np.where(order == 1, 3.0, 1.0)[:, None] * rng.normal(size=(6, 2))
    return lambda phi: size[:, 0] @ np.cos(np.outer(order, phi)) + size[:, 1] @ np.sin(np.outer(order, phi))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["all", "one", "two"])
def test_the_interval_of_the_stretch_holds_as_often_as_it_says(kind):
    """Lenses from the prior, speeds that may depend on the direction: 95 % of 40 are 35 or more, 97 times in 100."""
    settings = LiftingSettings(resamples=30)
    held = [holds(kind, seed, settings) for seed in range(40)]
    assert sum(held) >= 35


def holds(kind, seed, settings):
    rng = np.random.default_rng(500 + seed)
    focal = 1920 * settings.focal_median * np.exp(settings.focal_spread * rng.normal())
    camera = Camera(focal=focal, tilt=rng.uniform(np.radians(15), np.radians(40)), height=rng.uniform(7, 15))
    truth = walk(rng, 60, 250, DT, ways(kind, rng, 60), area=view_of(camera), prefer=preference(rng, 0.02))
    found = lift(photograph(camera, truth, DT, rng, **NOISE), settings).calibration
    return found["stretch"]["low"] <= camera.focal / np.cos(camera.tilt) <= found["stretch"]["high"]


def view_of(camera):
    """A rectangle of ground in the picture."""
    above = camera.height - 1.58
    near, far = (above / np.tan(max(np.arctan2(nu, camera.focal) + camera.tilt, 0.1)) for nu in (450.0, -450.0))
    half = 0.4 * 960 / camera.focal * np.hypot(above, (near + far) / 2)
    return -half, near, half, min(far, 50.0)
