"""The bundled solvers: exact on exact data, indifferent to the choice of world, finite whatever they are shown."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.lib.solver_runs import BIRDIFIERS, CAMERAS, DT, SOLVERS, assert_close, elsewhere, pairs, run, walk
from vbbench.camera import Camera
from vbbench.geometry import relative_to_world, world_to_relative
from vbbench.protocol import PROTOCOLS
from vbbench.sequence import Truth
from vbbench_baselines.extrapolation import ConstantVelocity, SocialForce
from vbbench_baselines.view_birdification import ConstantVelocityBirdifier

WELL_POSED = [name for name in PROTOCOLS if name != "cold-start"]
"""After a cold start the velocity that all have in common is unknown, however exact the boxes are."""


@pytest.mark.parametrize("ego_prior", [True, False])
@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
@pytest.mark.parametrize("protocol", WELL_POSED)
@pytest.mark.parametrize(("make", "truth"), [(BIRDIFIERS[0], walk(0)), (BIRDIFIERS[1], pairs(0))], ids=["cv", "sf"])
def test_exact_data_give_the_truth(
    make: type[Any], truth: Truth, protocol: str, camera: Camera, ego_prior: bool
) -> None:
    estimate = run(make(ego_prior=ego_prior), truth, protocol, camera)
    assert_close(estimate, truth.poses, truth.positions, 1e-6 if make is ConstantVelocityBirdifier else 1e-5)


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
    truth = walk(seed, wobble=0.05)
    here, there = (run(which(), one, protocol, None, 1.0) for one in (truth, elsewhere(truth, shift, turn)))
    expected = elsewhere(replace(truth, poses=here.poses, positions=here.positions), shift, turn)
    assert_close(there, expected.poses, expected.positions, 1e-5)


@pytest.mark.parametrize("people", [0, 1, 2])
@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("solver", BIRDIFIERS)
def test_few_people_are_enough_for_a_finite_answer(solver: type[Any], protocol: str, people: int) -> None:
    truth = walk(8, people=people)
    estimate = run(solver(ego_prior=people != 1), truth, protocol)
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
