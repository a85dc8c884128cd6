"""The tier `field`: its projection against another one, its recipe found again in what it makes, and its borders."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.lib.made_sight import sight_of
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.generation.tier import Sight, chosen_heights, chosen_tier, get_tier
from vbbench.geometry import FloatArray, world_to_relative
from vbbench_generators.splits import sim
from vbbench_generators.tiers.field import (
    Carriage,
    carry,
    cut_rows,
    draw_ground,
    drawn,
    frame,
    get_field,
    whole_boxes,
)

RECIPE = get_field()
SMALL = Simulation(sequences=2, people=(12,))


def crowd(frames: int = 12, people: int = 30, camera: Camera = RECIPE.camera, dt: float = 0.4) -> Sight:
    """People at 4 to 25 m ahead of a camera that walks on slowly, nearly nobody before anybody."""
    rng = np.random.default_rng(5)
    ahead, aside = np.linspace(4.0, 25.0, people), rng.uniform(-0.6, 0.6, people)
    positions = np.stack([ahead, ahead * aside], axis=-1) + np.zeros((frames, 1, 1))
    poses = np.stack([0.01 * np.arange(frames), np.zeros(frames), np.zeros(frames)], axis=-1)
    heights = rng.normal(1.75, 0.1, people)
    return sight_of(positions, poses, heights, camera=camera, dt=dt, observer="vehicle")


def by_rotations(sight: Sight, carriage: Carriage, near_edge: float) -> FloatArray:
    """Boxes [T, K, 3] by world coordinates and the rotation of one axis after another, a person at a time."""
    truth, camera, ground = sight.truth, sight.camera, carriage.ground
    boxes = np.full((*sight.seen.shape, 3), np.nan)

    def level(x: float, y: float) -> float:
        return float(np.sum(ground.amplitudes * np.sin(ground.waves @ np.array([x, y]) + ground.phases)))

    for t, (x, y, yaw) in enumerate(truth.poses):
        up, ahead = np.array([0.0, 0.0, 1.0]), np.array([np.cos(yaw), np.sin(yaw), 0.0])
        right = np.cross(ahead, up)
        p, r = carriage.pitch[t], carriage.roll[t]
        axis, tilted_up = np.cos(p) * ahead + np.sin(p) * up, np.cos(p) * up - np.sin(p) * ahead
        across, down = np.cos(r) * right - np.sin(r) * tilted_up, -np.cos(r) * tilted_up - np.sin(r) * right
        eye = np.array([x, y, level(x, y) + carriage.mount[t]])
        for k, place in enumerate(truth.positions[t]):
            away = np.hypot(*(place - (x, y)))
            edge = (x, y) + (place - (x, y)) * max(1.0 - near_edge / away, 0.5)
            foot = np.array([*edge, level(*place)])
            pixels = []
            for point in (foot, foot + truth.heights[k] * up):
                a, b, c = (float((point - eye) @ direction) for direction in (across, down, axis))
                if isinstance(camera, PerspectiveCamera):
                    assert c > 0.0
                    pixels.append((camera.cx + camera.focal * a / c, camera.cy + camera.focal * b / c))
                else:
                    column = (np.arctan2(a, c) / (2.0 * np.pi) + 0.5) * camera.picture_size[0]
                    pixels.append((column, 240.0 + camera.focal * b / np.hypot(a, c)))
            (u, low), (v, high) = pixels
            boxes[t, k] = 0.5 * (u + v), 0.5 * (low + high), low - high
    return boxes


@settings(max_examples=25)
@given(
    pitch=st.floats(-0.2, 0.2),
    roll=st.floats(-0.2, 0.2),
    mount=st.floats(0.8, 3.0),
    edge=st.floats(0.0, 1.0),
    seed=st.integers(0, 1000),
    panorama=st.booleans(),
)
def test_boxes_are_those_of_another_projection(
    pitch: float, roll: float, mount: float, edge: float, seed: int, panorama: bool
) -> None:
    camera = PanoramaCamera() if panorama else RECIPE.camera
    sight = crowd(frames=2, people=10, camera=camera)
    ground = draw_ground(replace(RECIPE.ground, std=0.2), np.random.default_rng(seed))
    carriage = Carriage(np.array([pitch, -pitch]), np.array([roll, 0.5 * roll]), np.full(2, mount), ground)
    relative = world_to_relative(sight.truth.positions, sight.truth.poses)
    made = whole_boxes(relative, sight, carriage, edge)
    np.testing.assert_allclose(made, by_rotations(sight, carriage, edge), atol=1e-7)


def test_the_camera_is_tilted_and_sways_as_the_recipe_says() -> None:
    rng, dt, poses = np.random.default_rng(0), 0.4, np.zeros((40, 3))
    made = [carry(poses, 1.65, dt, "vehicle", RECIPE, rng) for _ in range(800)]
    for values, std, sway in (
        (np.array([one.pitch for one in made]), RECIPE.tilt.pitch_std, RECIPE.tilt.sway_pitch_std),
        (np.array([one.roll for one in made]), RECIPE.tilt.roll_std, RECIPE.tilt.sway_roll_std),
    ):
        assert values.std() == pytest.approx(np.hypot(std, sway), rel=0.06)
        steps = np.diff(values, axis=1).std()  # what is constant does not show in steps
        assert steps == pytest.approx(sway * np.sqrt(2.0 * (1.0 - np.exp(-dt / RECIPE.tilt.sway_time))), rel=0.03)
    mounts = np.array([one.mount for one in made])
    assert mounts[:, 0].std() == pytest.approx(RECIPE.mount.std, rel=0.08)
    assert np.ptp(mounts, axis=1).max() == 0.0


def test_walkers_bob_and_vehicles_do_not() -> None:
    rng, frames, dt = np.random.default_rng(0), 200, 0.04
    walking = np.stack([1.4 * dt * np.arange(frames), np.zeros(frames), np.zeros(frames)], axis=-1)
    heights = carry(walking, 1.65, dt, "walker", RECIPE, rng).mount
    assert np.ptp(heights) == pytest.approx(2.0 * RECIPE.mount.bob, rel=0.05)
    spectrum = np.abs(np.fft.rfft(heights - heights.mean()))
    assert np.fft.rfftfreq(frames, dt)[spectrum.argmax()] == pytest.approx(RECIPE.mount.step_rate, abs=0.13)
    assert np.ptp(carry(np.zeros((9, 3)), 1.65, dt, "walker", RECIPE, rng).mount) == 0.0


def test_the_ground_is_uneven_as_the_recipe_says() -> None:
    rng, places = np.random.default_rng(0), np.random.default_rng(1).uniform(-500, 500, (2000, 2))
    ground = draw_ground(RECIPE.ground, rng)
    height = np.sin(places @ ground.waves.T + ground.phases) @ ground.amplitudes
    assert height.std() == pytest.approx(RECIPE.ground.std, rel=0.06)
    lengths = 2.0 * np.pi / np.hypot(*ground.waves.T)
    assert RECIPE.ground.shortest <= lengths.min() <= lengths.max() <= RECIPE.ground.longest


def test_boxes_are_drawn_as_the_recipe_says() -> None:
    model, dt, length = RECIPE.annotator, 0.4, 100.0
    exact = np.broadcast_to([600.0, 200.0, length], (60, 1500, 3))
    everybody = drawn(exact, np.arange(60 * 1500), dt, model, np.random.default_rng(0))
    some = np.arange(7, 60 * 1500, 11)
    np.testing.assert_array_equal(drawn(exact, some, dt, model, np.random.default_rng(0)), everybody[some])
    errors = (everybody.reshape(exact.shape) - exact) / length
    column, top = errors[..., 0], errors[..., 1] - 0.5 * errors[..., 2]
    bottom = errors[..., 1] + 0.5 * errors[..., 2]
    assert top.std() == pytest.approx(model.top_std, rel=0.02)
    for values, person, std, time in (
        (column, model.column_person_std, model.column_std, model.column_time),
        (bottom, model.bottom_person_std, model.bottom_std, model.bottom_time),
    ):
        assert values.std() == pytest.approx(np.hypot(person, std), rel=0.05)
        assert np.diff(values, axis=0).std() == pytest.approx(std * np.sqrt(2 * (1 - np.exp(-dt / time))), rel=0.03)
    assert float(np.sqrt(np.mean([column**2, top**2, bottom**2]))) == pytest.approx(model.box_std, rel=0.03)


def test_boxes_end_at_the_borders_of_the_picture() -> None:
    camera, aspect = RECIPE.camera, 0.4
    boxes = np.array([[[600.0, 200.0, 100.0], [600.0, 330.0, 200.0], [5.0, 200.0, 100.0], [-90.0, 200.0, 100.0]]])
    cut, inside = frame(boxes, camera, aspect)
    wanted = [boxes[0, 0], [600.0, 0.5 * (230.0 + 374.0), 144.0], [12.5, 200.0, 100.0], [np.nan] * 3]
    np.testing.assert_allclose(cut[0], wanted)
    np.testing.assert_allclose(inside[0], [1.0, 0.72, 25.0 / 40.0, 0.0])
    np.testing.assert_allclose(cut_rows(boxes, camera)[0, 1], cut[0, 1])
    np.testing.assert_array_equal(frame(boxes[:, :2], PanoramaCamera(), aspect)[0], boxes[:, :2])


@pytest.mark.parametrize("detector", [pytest.param(True, marks=pytest.mark.slow), False])
def test_datasets_do_not_depend_on_jobs(tmp_path: Path, detector: bool) -> None:
    options = Options(tier="field", detector=detector, simulation=SMALL)
    one, two = (generate("sim", tmp_path / str(jobs), options, jobs=jobs) for jobs in (1, 2))
    assert one.info == two.info
    camera = RECIPE.camera
    for sequence in one.sequences():
        u, v, length = sequence.observations[sequence.observed].T
        assert 0.0 <= u.min() <= u.max() <= camera.width - 1
        assert (v - 0.5 * length).min() >= 0.0
        assert (v + 0.5 * length).max() <= camera.height - 1 + 1e-9
        assert np.isclose(v + 0.5 * length, camera.height - 1).mean() > 0.1  # walkers are near one another


def test_solvers_are_given_how_exact_things_are_and_no_more(tmp_path: Path) -> None:
    options = Options(tier="field", detector=False, simulation=SMALL)
    info = sim.plan(options).info
    assert (info.pixel_std, info.mount_height_std) == (2.0, RECIPE.mount.std)
    assert info.box_std == pytest.approx(RECIPE.annotator.box_std)
    assert (info.height_mean, info.height_std) == (RECIPE.heights.told_mean, RECIPE.heights.told_std)
    data = generate("sim", tmp_path / "sim", options)
    problem = data.problem(data.sequence(0))
    for name in ("camera", "box_std", "tilt_std", "mount_height_std"):
        assert getattr(problem, name) == getattr(info, name)
    assert problem.camera == RECIPE.camera
    tall = np.concatenate([sim.plan(options).build(n).scene.heights for n in range(60)])  # type: ignore[union-attr]
    assert tall.mean() == pytest.approx(RECIPE.heights.mean, abs=0.01)
    assert tall.std() == pytest.approx(RECIPE.heights.std, rel=0.06)
    noisy = sim.plan(Options(tier="noisy", simulation=SMALL)).info
    assert '"box_std"' not in noisy.to_json()


def test_choices_that_a_tier_does_not_leave_are_refused() -> None:
    with pytest.raises(VbbenchError, match="tier 'noisy' has no detector that can be turned off"):
        chosen_tier(Options(tier="noisy", detector=False))
    with pytest.raises(VbbenchError, match="people of tier 'field' have heights of its recipe; remove `height_std`"):
        chosen_heights(Options(tier="field", height_std=0.05))
    assert chosen_heights(Options(tier="noisy", height_std=0.05)).told_std == 0.05
    assert get_tier("field").annotated().definition["detector"] is None


def test_a_detector_misses_people_and_finds_what_is_none() -> None:
    sight, tier = crowd(frames=30, people=12), get_tier("field")
    made = [tier.observe(sight, np.random.default_rng(seed)) for seed in range(3)]
    persons = [one.persons for one in made if one.persons is not None]
    found = sum((one >= 0).sum() for one in persons)
    boxes = sum((~np.isnan(one.boxes[..., 2])).sum() for one in made)
    assert 0.6 < found / (3 * sight.seen.sum()) < 0.95
    assert 0.005 < 1.0 - found / boxes < 0.25
