"""The bundled solvers: exact on exact data, indifferent to the choice of world, finite whatever they are shown."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from vbbench.arrays import FloatArray
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.geometry import relative_to_world, world_to_relative, wrap_angle
from vbbench.protocol import PROTOCOLS, get_protocol
from vbbench.runner import run_sequence
from vbbench.sequence import Given, Sequence, Truth
from vbbench.solver import Estimate, Frame, FrameSolver, Problem
from vbbench_baselines.ego_motion import fit_pose, invert, least_angle
from vbbench_baselines.extrapolation import ConstantVelocity, SocialForce
from vbbench_baselines.heights import Heights
from vbbench_baselines.history import History
from vbbench_baselines.localisation import localise
from vbbench_baselines.sightings import measure, sight
from vbbench_baselines.social_force import adapt_velocities
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

CAMERAS: list[Camera] = [PanoramaCamera(), PerspectiveCamera()]
BIRDIFIERS = [ConstantVelocityBirdifier, SocialForceBirdifier]
SOLVERS = [ConstantVelocity, SocialForce, *BIRDIFIERS]
DT = 0.4


def walk(seed: int, frames: int = 8, people: int = 6, wobble: float = 0.0) -> Truth:
    """People in front of an observer who turns its head; everybody at constant velocity but for ``wobble`` m."""
    rng = np.random.default_rng(seed)
    start = np.column_stack((rng.uniform(-2, 2, people), rng.uniform(5, 9, people)))
    steps = np.arange(frames)[:, None, None] * DT
    positions = start + (np.array((0, 1)) + rng.uniform(-0.2, 0.2, (people, 2))) * steps
    positions += rng.normal(0.0, wobble, positions.shape)
    yaw = np.pi / 2 + np.cumsum(rng.normal(0.0, 0.03, frames))
    poses = np.column_stack((np.zeros(frames), np.arange(frames) * DT, yaw))
    return Truth(poses=poses, positions=positions, heights=np.clip(rng.normal(1.7, 0.07, people), 1.45, 1.95))


def see(truth: Truth, camera: Camera, pixel_std: float = 0.0, seed: int = 0) -> Sequence:
    """The boxes of ``truth``, and its first two frames given."""
    frames, people = truth.positions.shape[:2]
    heights = np.broadcast_to(truth.heights, (frames, people))
    boxes = camera.project(world_to_relative(truth.positions, truth.poses), heights)
    noise = np.random.default_rng(seed).normal(0.0, pixel_std, boxes.shape) * (1.0, np.sqrt(0.5), np.sqrt(2.0))
    everything = Given(poses=truth.poses, positions=np.where(np.isnan(boxes[..., :2]), np.nan, truth.positions))
    return Sequence(
        index=0,
        scene=0,
        observer=0,
        first_frame=0,
        tracks=np.arange(people) + 1,
        observations=boxes + noise,
        visible=np.where(np.isnan(boxes[..., 2]), np.nan, 1.0),
        given=everything.first_frames(2),
    )


def problem_of(sequence: Sequence, camera: Camera, pixel_std: float = 0.0) -> Problem:
    return Problem(
        sequence=0,
        camera=camera,
        dt=DT,
        tracks=sequence.tracks,
        height_mean=1.7,
        height_std=0.07,
        pixel_std=pixel_std,
    )


def run(
    solver: FrameSolver, truth: Truth, protocol: str, camera: Camera | None = None, pixel_std: float = 0.0
) -> Estimate:
    camera = camera or CAMERAS[0]
    sequence, how = see(truth, camera, pixel_std), get_protocol(protocol)
    shown = truth if how.needs_truth else None
    return run_sequence(solver, problem_of(sequence, camera, pixel_std), sequence, how, shown)[0]


def assert_close(estimate: Estimate, poses: FloatArray, positions: FloatArray, atol: float) -> None:
    np.testing.assert_allclose(estimate.poses[:, :2], poses[:, :2], atol=atol)
    np.testing.assert_allclose(wrap_angle(estimate.poses[:, 2] - poses[:, 2]), 0.0, atol=atol)
    np.testing.assert_allclose(estimate.positions, positions, atol=atol)


@pytest.mark.parametrize("solver", SOLVERS)
def test_is_a_frame_solver_made_without_arguments(solver: type[Any]) -> None:
    assert isinstance(solver(), FrameSolver)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("ego_prior", [True, False])
@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_exact_data_give_the_truth(protocol: str, camera: Camera, ego_prior: bool, seed: int) -> None:
    truth = walk(seed)
    estimate = run(ConstantVelocityBirdifier(ego_prior=ego_prior), truth, protocol, camera)
    assert_close(estimate, truth.poses, truth.positions, 1e-6)


def test_without_ego_prior_the_observer_need_not_walk_on() -> None:
    truth = walk(3)
    poses = truth.poses + np.random.default_rng(3).normal(0.0, 0.2, truth.poses.shape)
    estimate = run(ConstantVelocityBirdifier(ego_prior=False), replace(truth, poses=poses), "one-step")
    assert_close(estimate, poses, truth.positions, 1e-6)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**16),
    turn=st.floats(-np.pi, np.pi),
    shift=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    which=st.sampled_from(SOLVERS),
    protocol=st.sampled_from(PROTOCOLS),
)
def test_the_choice_of_world_does_not_matter(
    seed: int, turn: float, shift: tuple[float, float], which: type[Any], protocol: str
) -> None:
    def moved(points: FloatArray) -> FloatArray:
        rotation = np.array(((np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn))))
        return np.asarray(points @ rotation.T + np.array(shift))

    def moved_poses(poses: FloatArray) -> FloatArray:
        return np.column_stack((moved(poses[:, :2]), poses[:, 2] + turn))

    truth = walk(seed, wobble=0.05)
    other = replace(truth, poses=moved_poses(truth.poses), positions=moved(truth.positions))
    here, there = run(which(), truth, protocol, None, 1.0), run(which(), other, protocol, None, 1.0)
    assert_close(there, moved_poses(here.poses), moved(here.positions), 1e-5)


def pose_energy(pose: FloatArray, *terms: Any) -> float:
    """E(c, R) of `vbbench_baselines.ego_motion`, person by person."""
    relative, covariance, expected, std, predicted, ego_std = terms
    total = float(np.sum((pose[:2] - predicted[:2]) ** 2)) / ego_std**2
    residuals = relative - world_to_relative(expected, pose)
    for r, (rr, rf, ff), s in zip(residuals, covariance, std, strict=True):
        total += float(r @ np.linalg.inv(np.array(((rr + s * s, rf), (rf, ff + s * s)))) @ r)
    return float(total)


def random_terms(seed: int, people: int = 5, depth_std: float = 1.0) -> tuple[Any, ...]:
    rng = np.random.default_rng(seed)
    pose = np.append(rng.normal(0, 3, 2), rng.uniform(-3, 3))
    relative = rng.normal(0, 5, (people, 2))
    axes = rng.normal(0, depth_std, (people, 2, 2))
    spread = axes @ axes.transpose(0, 2, 1)
    covariance = np.stack((spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]), axis=1)
    expected = relative_to_world(relative, pose) + rng.normal(0, 0.3, (people, 2))
    return relative, covariance, expected, rng.uniform(0.05, 0.3, people), pose + rng.normal(0, 0.3, 3), 0.1


@pytest.mark.parametrize("seed", range(20))
def test_the_pose_is_the_least_that_scipy_finds(seed: int) -> None:
    terms = random_terms(seed)
    pose = fit_pose(*terms)
    starts = [np.append(terms[4][:2], yaw) for yaw in np.linspace(-np.pi, np.pi, 6)]
    best = min((minimize(pose_energy, start, terms, options={"gtol": 1e-9}) for start in starts), key=lambda r: r.fun)
    assert pose_energy(pose, *terms) <= best.fun + 1e-9
    np.testing.assert_allclose(
        np.append(pose[:2], wrap_angle(pose[2] - best.x[2])), np.append(best.x[:2], 0), atol=1e-5
    )


@pytest.mark.parametrize("seed", range(20))
def test_the_gradient_vanishes_at_the_pose(seed: int) -> None:
    terms = random_terms(seed)
    pose, h = fit_pose(*terms), 1e-5
    slopes = [pose_energy(pose + d, *terms) - pose_energy(pose - d, *terms) for d in h * np.eye(3)]
    np.testing.assert_allclose(np.array(slopes) / (2 * h), 0.0, atol=1e-3)


def test_with_exact_heights_the_fit_is_the_closed_rigid_one() -> None:
    relative, _, expected, std, predicted, _ = random_terms(1)
    pose = fit_pose(relative, np.zeros((5, 3)), expected, std, predicted, np.inf)
    weight = std**-2 / np.sum(std**-2)
    a, b = relative - weight @ relative, expected - weight @ expected
    # world = (right sin + forward cos, forward sin − right cos) = Rot(yaw) (forward, −right)
    a = np.column_stack((a[:, 1], -a[:, 0]))
    yaw = np.arctan2(weight @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), weight @ np.sum(a * b, axis=1))
    assert pose[2] == pytest.approx(yaw, abs=1e-6)


@pytest.mark.parametrize("seed", range(50))
def test_the_least_angle_is_the_least_of_the_circle(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(2, 2)) * rng.choice((1.0, 1e3))
    a, g = root @ root.T, rng.normal(size=2)

    def energy(angle: FloatArray) -> FloatArray:
        m = np.stack((np.cos(angle), np.sin(angle)))
        return np.asarray(np.sum(m * (a @ m), axis=0) - 2.0 * (g @ m))

    least = energy(np.array([least_angle(a, g)]))[0]
    assert least <= np.min(energy(np.linspace(-np.pi, np.pi, 100_001))) + 1e-9 * abs(least)


def test_a_person_stands_between_measurement_and_expectation() -> None:
    relative, covariance, expected, std, pose, _ = random_terms(7)
    found = world_to_relative(localise(pose, relative, covariance, expected, std), pose)
    for x, z, e, (rr, rf, ff), s in zip(
        found, relative, world_to_relative(expected, pose), covariance, std, strict=True
    ):
        information = np.linalg.inv(np.array(((rr, rf), (rf, ff))))
        np.testing.assert_allclose(x, np.linalg.solve(information + np.eye(2) / s**2, information @ z + e / s**2))


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
def test_the_covariance_of_a_measurement_is_that_of_samples(camera: Camera) -> None:
    rng = np.random.default_rng(0)
    heights = np.full(40_000, 1.7) + rng.normal(0, 0.05, 40_000)
    boxes = np.tile(camera.project(np.array((2.0, 5.0)), np.array(1.7)), (40_000, 1))
    boxes += rng.normal(0, 1.0, boxes.shape) * (1.0, 1.0, np.sqrt(2.0))
    _, (n, *_) = measure(
        *sight(camera, boxes[:1] * 0 + camera.project(np.array((2.0, 5.0)), np.array(1.7)), 1.0),
        np.array([1.7]),
        np.array([0.05**2]),
    )
    sampled = np.cov(camera.unproject(boxes, heights).T)
    np.testing.assert_allclose(n, sampled[(0, 0, 1), (0, 1, 1)], rtol=0.05)


def test_heights_sharpen_and_stay_plausible() -> None:
    truth, camera = walk(5, frames=30), PanoramaCamera()
    truth = replace(truth, heights=np.append(truth.heights[:-1], 2.5))
    solver = ConstantVelocityBirdifier()
    run(solver, truth, "one-step", camera, 1.0)
    assert np.all(solver._heights.variance < (0.07 / 3) ** 2)
    assert np.all(abs(solver._heights.mean - truth.heights)[:-1] < 0.04)
    assert solver._heights.mean[-1] == 2.0


def test_the_height_of_a_single_exact_frame_is_exact() -> None:
    truth, camera = walk(6, frames=2), PerspectiveCamera()
    sequence, history = see(truth, camera), History(6)
    heights = Heights(6, 1.7, 0.07, (1.4, 2.0), 0.0)
    for t in (0, 1):
        row = [np.full_like(sequence.given.positions[0], np.nan)] * 2 + [sequence.given.positions[t]]
        poses = [np.full(3, np.nan)] * 2 + [sequence.given.poses[t]]
        history.advance(Given(poses=np.array(poses), positions=np.array(row)))
    nowhere = np.full((6, 2), np.nan), np.full(6, np.nan)
    heights.learn(history, sight(camera, sequence.observations[0], 0.0), *nowhere)
    np.testing.assert_allclose(heights.mean, truth.heights, atol=1e-7)


def test_a_confidently_expected_place_teaches_a_height_as_far_as_it_is_trusted() -> None:
    truth, camera = walk(4, frames=2, people=4), PanoramaCamera()
    sequence, history = see(truth, camera), History(4)
    nothing = np.full((4, 2), np.nan)
    for t in (0, 1):
        poses = np.array([np.full(3, np.nan)] * 2 + [truth.poses[t]])
        history.advance(Given(poses=poses, positions=np.array([nothing] * 3)))
    heights = Heights(4, 1.7, 0.07, (1.4, 2.0), 0.0)
    std = np.array([0.0, 0.05, 5.0, np.nan])
    heights.learn(history, sight(camera, sequence.observations[0], 0.0), truth.positions[0], std)
    assert abs(heights.mean[0] - truth.heights[0]) < 1e-7
    assert 1e-9 < heights.variance[0] + 1e-8 < heights.variance[1] < heights.variance[2] < heights.variance[3]
    assert (heights.mean[3], heights.variance[3]) == (1.7, 0.07**2)


@pytest.mark.parametrize("people", [0, 1, 2])
@pytest.mark.parametrize("ego_prior", [True, False])
@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("solver", BIRDIFIERS)
def test_few_people_are_enough_for_a_finite_answer(
    solver: type[Any], protocol: str, ego_prior: bool, people: int
) -> None:
    truth = walk(8, people=people)
    estimate = run(solver(ego_prior=ego_prior), truth, protocol)
    assert np.isfinite(estimate.poses).all()
    assert np.isfinite(estimate.positions).all()


@pytest.mark.parametrize("solver", SOLVERS)
def test_with_nobody_in_sight_the_observer_walks_on(solver: type[Any]) -> None:
    truth = walk(9)
    gone = np.where(np.arange(8)[:, None, None] < 2, truth.positions, np.nan)
    estimate = run(solver(), replace(truth, positions=gone), "rollout")
    np.testing.assert_allclose(estimate.poses[:, :2], truth.poses[:, :2], atol=1e-6)
    np.testing.assert_allclose(estimate.poses[2:, 2], truth.poses[1, 2], atol=1e-9)
    assert np.isnan(estimate.positions[2:]).all()


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_stranger_is_put_on_its_ray_at_the_mean_height(solver: type[Any]) -> None:
    truth = walk(10)
    truth = replace(truth, heights=np.full(6, 1.7))
    late = truth.positions.copy()
    late[:3, 0] = np.nan
    estimate = run(solver(), replace(truth, positions=late), "rollout")
    pose = truth.poses[3] if solver is ConstantVelocityBirdifier else estimate.poses[3]
    relative = world_to_relative(truth.positions[3, :1], truth.poses[3])
    np.testing.assert_allclose(estimate.positions[3, :1], relative_to_world(relative, pose), atol=1e-6)


@pytest.mark.parametrize("solver", SOLVERS)
def test_start_forgets_the_last_sequence(solver: type[Any]) -> None:
    used = solver()
    run(used, walk(11, wobble=0.1), "sequential", None, 1.0)
    first = run(used, walk(12, wobble=0.1), "sequential", None, 1.0)
    fresh = run(solver(), walk(12, wobble=0.1), "sequential", None, 1.0)
    np.testing.assert_array_equal(first.positions, fresh.positions)
    np.testing.assert_array_equal(first.poses, fresh.poses)


@pytest.mark.parametrize("solver", SOLVERS)
def test_what_is_given_is_returned(solver: type[Any]) -> None:
    truth = walk(13, wobble=0.1)
    estimate = run(solver(), truth, "rollout", None, 1.0)
    np.testing.assert_array_equal(estimate.poses[:2], truth.poses[:2])
    np.testing.assert_array_equal(estimate.positions[:2], truth.positions[:2])


def test_given_positions_beat_own_estimates_and_are_kept() -> None:
    nothing = Given(poses=np.full((3, 3), np.nan), positions=np.full((3, 2, 2), np.nan))
    history = History(2)
    history.advance(nothing)
    history.store(np.ones(3), np.ones((2, 2)))
    late = nothing.positions.copy()
    late[1, 0] = 5.0
    history.advance(Given(poses=nothing.poses, positions=late))
    np.testing.assert_array_equal(history.positions[1], ((5.0, 5.0), (1.0, 1.0)))
    np.testing.assert_array_equal(history.position_given, ((False, False), (True, False), (False, False)))
    history.advance(nothing)
    assert history.position_given[0, 0]


def test_constant_velocity_is_exact_for_constant_velocity() -> None:
    truth = walk(14)
    estimate = run(ConstantVelocity(), truth, "rollout")
    np.testing.assert_allclose(estimate.positions, truth.positions, atol=1e-9)
    np.testing.assert_allclose(estimate.poses[:, :2], truth.poses[:, :2], atol=1e-9)


def test_a_person_known_at_one_frame_stays() -> None:
    truth = walk(15)
    late = truth.positions.copy()
    late[0, 0] = np.nan
    estimate = run(ConstantVelocity(), replace(truth, positions=late), "rollout")
    np.testing.assert_array_equal(estimate.positions[2, 0], truth.positions[1, 0])


def test_social_force_equals_a_slow_one() -> None:
    truth = walk(16, people=12, wobble=0.1)
    everybody = np.concatenate((truth.positions, truth.poses[:, None, :2]), axis=1)
    before, last = everybody[0], everybody[1]
    velocity = (last - before) / DT
    near = np.linalg.norm(last[:, None] - last[None], axis=-1) < 1.0
    mean = np.array([velocity[row].mean(axis=0) for row in near])
    wanted = last + (velocity + DT * (mean - velocity) / 0.5) * DT
    estimate = run(SocialForce(), truth, "rollout")
    np.testing.assert_allclose(estimate.positions[2], wanted[:-1], atol=1e-9)
    np.testing.assert_allclose(estimate.poses[2, :2], wanted[-1], atol=1e-9)


def test_people_of_unknown_velocity_pull_nobody() -> None:
    velocities = np.array(((1.0, 0.0), (np.nan, np.nan)))
    np.testing.assert_array_equal(adapt_velocities(np.zeros((2, 2)), velocities, 1.0, 0.8), np.zeros((2, 2)))


def test_invert() -> None:
    rr, rf, ff = invert(4.0, 1.0, 2.0)
    np.testing.assert_allclose(np.array(((rr, rf), (rf, ff))) @ ((4.0, 1.0), (1.0, 2.0)), np.eye(2), atol=1e-15)


def test_a_solver_survives_a_world_without_any_given_pose() -> None:
    truth, camera = walk(17), PanoramaCamera()
    sequence = see(truth, camera)
    solver = ConstantVelocityBirdifier()
    solver.start(problem_of(sequence, camera))
    nothing = Given(poses=np.full((3, 3), np.nan), positions=np.full((3, 6, 2), np.nan))
    for t in range(3):
        answer = solver.step(Frame(index=t, observations=sequence.observations[t], given=nothing))
        assert np.isfinite(answer.pose).all()
        assert np.isfinite(answer.positions).all()
