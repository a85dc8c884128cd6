"""The joint solvers' terms and kernels against plain NumPy, and what they answer on made walks."""

from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pytest

from tests.solver_runs import CAMERAS, DT, assert_close, problem_of, run, see, walk
from vbbench.camera import Camera
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.solver import Estimate, FrameSolver, SequenceSolver
from vbbench.solving.runner import frames_of
from vbbench_baselines.common.odometry import Motions, motions_of, stray
from vbbench_baselines.common.sightings import Sightings
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.measurement.boxes import Eye, Statures, inform, statures_of
from vbbench_baselines.joint_map.measurement.window import Measurements, gather
from vbbench_baselines.joint_map.motion.walks import add_walk, innovation, reweigh, walk_of
from vbbench_baselines.joint_map.optimiser.banded import (
    BAND,
    factor,
    factor_wide,
    invert,
    invert_wide,
    solve,
    solve_wide,
)
from vbbench_baselines.joint_map.optimiser.marginalisation import NOTHING_KEPT, anchor_of
from vbbench_baselines.joint_map.optimiser.people import axes_of, eliminate
from vbbench_baselines.joint_map.optimiser.poses import (
    linearise,
)
from vbbench_baselines.joint_map.optimiser.state import JointProblem, believe, deviance_of
from vbbench_baselines.joint_map.prior import Prior, get_prior

NORMAL = Prior(nu=1e9, a0=1e9, yaw_scale=1e3)
LOOKING_ABOUT = replace(get_prior("default"), following=(0.0, 0.0))
"""For walks whose observers drift away from the path with their heads."""
PROTOCOLS = ("one-step", "sequential", "rollout")


def test_banded_kernels_agree_with_numpy() -> None:
    rng = np.random.default_rng(0)
    full = np.zeros((14, 14))
    for i in range(14):
        full[i, max(i - 8, 0) : i + 1] = rng.normal(size=min(i, 8) + 1)
    full = full @ full.T + 0.5 * np.eye(14)
    far = np.abs(np.subtract.outer(np.arange(14), np.arange(14)))
    banded, band = np.where(far <= BAND, full, 0.0), np.zeros((14 + BAND, 2 * BAND + 1))
    for j in range(14):
        column = banded[j : j + BAND + 1, j]
        band[j, : len(column)] = column
    right, inverse, wide = rng.normal(size=14), np.zeros((14 + BAND, BAND + 14)), band[:, : BAND + 1].copy()
    expected = np.linalg.solve(banded, right)
    factor(band)
    solve(band, right)
    invert(band, inverse)
    np.testing.assert_allclose(right, expected, rtol=1e-9)
    upper, other = np.linalg.inv(banded), expected * 0.0 + banded @ expected
    for i, j in zip(*np.triu_indices(14), strict=True):
        assert inverse[i, BAND + j - i] == pytest.approx(upper[i, j], rel=1e-8, abs=1e-12)
    assert factor_wide(wide)
    solve_wide(wide, other)
    np.testing.assert_allclose(other, expected, rtol=1e-9)
    near = invert_wide(wide)
    for i, j in zip(*np.triu_indices(14), strict=True):
        if j - i <= BAND:
            assert near[i, j - i] == pytest.approx(upper[i, j], rel=1e-8, abs=1e-12)
    assert not factor_wide(-np.ones((3, 2)))


def test_the_quadratic_form_of_a_walk_is_its_energy() -> None:
    rng = np.random.default_rng(1)
    numbers, track, weights = walk_of(Prior(), DT), rng.normal(size=(9, 2)), rng.uniform(1, 9, 9)
    band = np.zeros((9, 5))
    add_walk(weights, numbers, band)
    full = np.array([[band[max(i, j), abs(i - j)] if abs(i - j) < 5 else 0.0 for j in range(9)] for i in range(9)])
    weights[1] = 1.0  # the velocity's spread is not a walker's own
    energy = sum(weights[i] * innovation(track, i, numbers) for i in range(1, 9))
    np.testing.assert_allclose(np.sum(track * (full @ track)), energy)


def test_weights_fall_with_the_innovation_and_scales_stay_near_the_prior() -> None:
    rng = np.random.default_rng(2)
    numbers, weights = walk_of(Prior(), DT), np.zeros(40)
    track = np.cumsum(np.cumsum(rng.normal(0.0, 0.08, (40, 2)), axis=0), axis=0)
    calm, _ = reweigh(track, numbers, numbers.sigma, weights, 0.08**2)
    assert 0.04 < np.sqrt(calm) < 0.16
    track[20:] += 3.0
    reweigh(track, numbers, numbers.sigma, weights, calm)
    assert weights[20] < 0.1 * np.median(weights[2:])


def test_the_observers_own_scale_is_known_where_nobody_is_in_sight() -> None:
    """A window that forgot it handed on information of other weights, and the poses after it ran away."""
    poses, numbers = np.array(walk(3, frames=8, wobble=0.1).poses), walk_of(Prior(), DT)
    nobody = np.full((8, 2, 2), np.nan)
    data = gather(nobody, np.full((8, 2, 3), np.nan), nobody, Statures(np.full(2, 1.7), np.zeros(2)))
    problem = JointProblem(data, anchor_of(np.zeros(8, bool), NOTHING_KEPT), numbers, unmeasured(8))
    state = believe(poses, nobody, np.full(2, 1.7), problem, np.full(3, numbers.sigma**2))
    own, improbable = reweigh(poses[:, :2].copy(), numbers, numbers.own, np.zeros(8), numbers.sigma**2)
    assert state.variances[-1] == pytest.approx(own)
    assert state.variances[-1] != pytest.approx(numbers.sigma**2, rel=0.1)
    turned = np.log1p((np.diff(poses[:, 2]) / numbers.head.wandering) ** 2).sum()
    assert deviance_of(state, data) == pytest.approx(improbable + turned)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
def test_feet_tell_the_distance_without_the_height(camera: Camera) -> None:
    truth = walk(3)
    sequence = see(truth, camera)
    problem = problem_of(sequence, camera)
    assert camera.horizon(np.zeros(())) == pytest.approx(vars(camera)["cy"])
    rays = Eye(problem, feet=True).sight(sequence.observations).rays
    expected = world_to_relative(truth.positions, truth.poses)
    seen = ~np.isnan(rays[..., 0])
    np.testing.assert_allclose((rays * camera.mount_height)[seen], expected[seen], rtol=1e-9)


def made_data(feet: bool, frames: int = 7, pixel_std: float = 1.0) -> tuple[Measurements, FloatArray]:
    truth = walk(4, frames=frames, wobble=0.03)
    sequence = see(truth, CAMERAS[0], pixel_std)
    problem = problem_of(sequence, CAMERAS[0], pixel_std)
    statures, seen = statures_of(problem, feet), Eye(problem, feet).sight(sequence.observations)
    rows = [inform(Sightings(*(row[t] for row in seen)), statures.mean) for t in range(frames)]
    relative, information = (np.stack(part) for part in zip(*rows, strict=True))
    return gather(relative, information, sequence.given.positions, statures), np.array(truth.poses)


def unmeasured(frames: int) -> Motions:
    return motions_of(np.full((frames, 3), np.nan), np.full((frames, 3, 3), np.nan))


def measured_motions(poses: FloatArray) -> Motions:
    """Odometry of every other frame, off by some centimetres and hundredths of a radian."""
    rng, moved = np.random.default_rng(9), np.full(poses.shape, np.nan)
    for t in range(1, len(poses), 2):
        moved[t] = stray(poses[t - 1], poses[t], np.zeros(3))[0] + rng.normal(0.0, 0.03, 3)
    spread = rng.normal(0.0, 0.05, (len(poses), 3, 3))
    return motions_of(moved, spread @ spread.transpose(0, 2, 1) + 1e-3 * np.eye(3))


@pytest.mark.parametrize("cold", [False, True])
@pytest.mark.parametrize("feet", [True, False])
def test_the_gradient_is_that_of_the_deviance(feet: bool, cold: bool) -> None:
    """With everybody and the weights where they belong, and the boxes linearised there."""
    data, poses = made_data(feet)
    poses += np.random.default_rng(5).normal(0.0, 0.02, poses.shape)
    frames, people = len(poses), len(data.first)
    numbers = walk_of(Prior(following=(0.3, 0.3)), DT, cold=cold)
    motions = measured_motions(poses) if cold else unmeasured(frames)
    problem = JointProblem(data, anchor_of(np.zeros(frames, bool), NOTHING_KEPT), numbers, motions)
    places, variances = np.full((frames, people, 2), np.nan), np.full(people + 1, numbers.sigma**2)
    state = believe(poses, places, data.stature.copy(), problem, variances)
    for _ in range(60):
        for k in range(people):
            person = eliminate(k, poses, axes_of(poses), state.data, state.weights[k], numbers)
            state.places[person.first : person.first + len(person.track), k] = person.track
            state.heights[k] = person.height
        state = believe(poses, state.places, state.heights, problem, variances)
    gradient, hessian = linearise(state, problem)
    assert np.linalg.eigvalsh(hessian)[0] > -1e-6

    def deviance(moved: FloatArray) -> float:
        rest = state.places, state.heights, problem, variances
        return deviance_of(believe(poses + moved.reshape(-1, 3), *rest), state.data)

    for i in range(3 * frames):
        step = np.zeros(3 * frames)
        step[i] = 1e-6
        assert (deviance(step) - deviance(-step)) / 2e-6 == pytest.approx(gradient[i], rel=5e-3, abs=5e-2)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
def test_straight_walks_seen_exactly_are_found(camera: Camera, protocol: str, solver: type[Any]) -> None:
    truth = walk(6)
    estimate = run_any(solver(prior=LOOKING_ABOUT), truth, protocol, camera)
    assert_close(estimate, truth.poses, truth.positions, 3e-2)  # the yaw's prior pulls a little
    assert estimate.converged is not None
    assert estimate.converged[2:].all()


@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
def test_heights_are_estimated_where_feet_do_not_tell(solver: type[Any]) -> None:
    truth = walk(7, frames=12)
    estimate = run_any(solver(prior=LOOKING_ABOUT, feet=False), truth, "sequential", CAMERAS[0])
    assert np.abs(estimate.poses[:, :2] - truth.poses[:, :2]).max() < 0.1


def test_nothing_leaks_from_the_future() -> None:
    truth = walk(9, frames=12, wobble=0.02)
    sequence = see(truth, CAMERAS[0], 1.0)
    problem, given = problem_of(sequence, CAMERAS[0], 1.0), sequence.given
    solver = MapCausal()
    solver.start(problem)
    told = [solver.step(frame).pose for frame in islice(frames_of(sequence, given, given), 8)]
    np.testing.assert_array_equal(np.stack(told), run_any(MapCausal(), truth, "rollout", CAMERAS[0], 1.0).poses[:8])


@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
@pytest.mark.parametrize("people", [0, 1, 2])
def test_hardly_anybody_in_sight(solver: type[Any], people: int) -> None:
    estimate = run_any(solver(), walk(10, people=people), "rollout", CAMERAS[1])
    assert np.isfinite(estimate.poses).all()


@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_a_robot_need_not_walk_like_a_person(protocol: str, solver: type[Any]) -> None:
    """An observer that jumps about among people who walk straight on."""
    errors = np.zeros(2)
    for seed in range(6):
        truth, jumps = walk(seed), np.random.default_rng(seed).normal(0.0, 0.3, (8, 3)) * (1.0, 1.0, 0.0)
        jumps[0] = 0.0
        truth = replace(truth, poses=truth.poses + jumps)
        for i, ego_prior in enumerate((False, True)):
            found = run_any(solver(ego_prior=ego_prior, prior=LOOKING_ABOUT), truth, protocol, CAMERAS[0])
            errors[i] += np.abs(found.poses[:, :2] - truth.poses[:, :2]).mean()
    assert errors[0] < 0.8 * errors[1]
    assert errors[0] < 0.03


def run_any(solver: Any, truth: Any, protocol: str, camera: Camera, pixel_std: float = 0.0) -> Estimate:
    assert isinstance(solver, FrameSolver | SequenceSolver)
    return run(solver, truth, protocol, camera, pixel_std)  # type: ignore[arg-type]
