"""What the joint solvers keep of frames that leave the window, and what they cut of the Hessian of many frames."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.bench_joint_map import crowd
from tests.solver_runs import CAMERAS, DT, problem_of, see, walk
from tests.test_joint_map import LOOKING_ABOUT, NORMAL, made_data, measured_motions, run_any, unmeasured
from vbbench.protocol import get_protocol
from vbbench.solving.runner import run_sequence
from vbbench_baselines.common.odometry import Motions
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.measurement.boxes import Statures
from vbbench_baselines.joint_map.measurement.window import gather
from vbbench_baselines.joint_map.motion.walks import walk_of
from vbbench_baselines.joint_map.optimiser.descent import settle
from vbbench_baselines.joint_map.optimiser.marginalisation import NOTHING_KEPT, anchor_of, marginalise
from vbbench_baselines.joint_map.optimiser.poses import Curvature, eliminate_all, full, hessian_of
from vbbench_baselines.joint_map.optimiser.state import JointProblem
from vbbench_baselines.joint_map.prior import Prior, get_prior


@pytest.mark.parametrize("odometry", [False, True])
def test_what_leaves_is_kept_exactly_for_normal_walks(odometry: bool) -> None:
    data, poses = made_data(feet=True, frames=10, pixel_std=0.0)
    numbers, fixed = walk_of(NORMAL, DT, cold=odometry), np.arange(10) < 2
    places = np.full((10, len(data.first), 2), np.nan)
    motions = measured_motions(poses) if odometry else unmeasured(10)
    problem = JointProblem(data, anchor_of(fixed, NOTHING_KEPT), numbers, motions)
    whole = settle(poses, places, problem, 50, 1e-9, 0.0)
    assert whole.converged
    settled, before = whole, poses
    for _ in range(3):
        kept, continued, _told = marginalise(settled, problem, tells=False)
        data = gather(*(rows[1:] for rows in data[:3]), Statures(data.stature, data.stature_variance), continued)
        fixed, before, places = fixed[1:], settled.state.poses[1:], settled.state.places[1:]
        motions = Motions(problem.motions.moved[1:], problem.motions.information[1:])
        problem = JointProblem(data, anchor_of(fixed, kept), numbers, motions)
        settled = settle(before + 0.01 * ~fixed[:, None], places, problem, 50, 1e-9, 0.0)
        np.testing.assert_allclose(settled.state.poses, before, atol=1e-4)


@pytest.mark.parametrize("pixel_std", [0.0, 3.0])
def test_what_is_kept_has_no_negative_curvature(pixel_std: float) -> None:
    """Whatever the weights: a walk that began anew in every window needed some to make up for it."""
    data, poses = made_data(feet=True, frames=12, pixel_std=pixel_std)
    poses[2:] += np.random.default_rng(3).normal(0.0, 0.3, (10, 3))  # far from where weights are alike
    numbers, fixed = walk_of(get_prior("default"), DT), np.zeros(12, bool)
    problem = JointProblem(data, anchor_of(fixed, NOTHING_KEPT), numbers, unmeasured(12))
    places = np.full((12, len(data.first), 2), np.nan)
    for _ in range(6):
        settled = settle(poses, places, problem, 2, 0.0, 0.0)
        kept, continued, _told = marginalise(settled, problem, tells=False)
        values = np.linalg.eigvalsh(kept.information)
        assert values[0] > -1e-6 * values[-1]
        assert (np.linalg.eigvalsh(continued.information)[:, 0] > -1e-6).all()
        data = gather(*(rows[1:] for rows in data[:3]), Statures(data.stature, data.stature_variance), continued)
        poses, places, fixed = settled.state.poses[1:], settled.state.places[1:], fixed[1:]
        problem = JointProblem(data, anchor_of(fixed, kept), numbers, unmeasured(len(poses)))


@pytest.mark.slow
@pytest.mark.parametrize("feet", [True, False])
def test_a_cut_hessian_is_as_soft_as_the_whole_one(feet: bool) -> None:
    """What no box tells costs as little as it does uncut: a common motion of everybody."""
    data, poses = made_data(feet, frames=60)
    numbers, motions = walk_of(Prior(), DT), unmeasured(60)
    problem = JointProblem(data, anchor_of(np.arange(60) < 2, NOTHING_KEPT), numbers, motions)
    state = settle(poses, np.full((60, len(data.first), 2), np.nan), problem, 3, 0.0, 0.0).state
    people = eliminate_all(state, numbers)
    band, tall = hessian_of(people, state, problem, 24)
    assert band.shape == (3 * 60 + 74, 75)
    assert len(tall) == (0 if feet else len(people))
    cut, whole = full(Curvature(band, tall)), full(hessian_of(people, state, problem, 60))
    np.testing.assert_allclose(np.linalg.eigvalsh(cut)[:4], np.linalg.eigvalsh(whole)[:4], rtol=0.05)


@pytest.mark.slow
def test_a_long_walk_among_people_who_stray_converges() -> None:
    """Weights move slowly there, and a path bends as a whole: plain steps go on for hundreds of rounds."""
    assert MapBatch().solve(*crowd(160, 20)).converged.all()


def test_windows_lose_little() -> None:
    truth = walk(8, frames=40, people=8, wobble=0.02)
    whole = run_any(MapCausal(window=60), truth, "sequential", CAMERAS[0], 1.0)
    narrow = run_any(MapCausal(window=12), truth, "sequential", CAMERAS[0], 1.0)
    assert np.abs(whole.poses - narrow.poses).max() < 0.3


@pytest.mark.parametrize("ego_prior", [True, False])
def test_nobody_in_sight_for_a_while_leads_nobody_astray_unsaid(ego_prior: bool) -> None:
    """Blank frames, more than a window holds, then newcomers of whom two places are given."""
    for seed in range(3):
        truth = walk(seed, frames=70, people=8, wobble=0.03)
        moved = truth.positions.copy()
        moved[43:, 4:, 1] += truth.poses[43, 1] + 7.0 - moved[43, 4:, 1]
        truth = replace(truth, positions=moved)
        seen = see(truth, CAMERAS[0], 1.0)
        boxes, places = seen.observations.copy(), np.full_like(truth.positions, np.nan)
        boxes[16:43] = boxes[:16, 4:] = boxes[43:, :4] = np.nan
        places[:2, :4], places[43:45, 4:] = truth.positions[:2, :4], truth.positions[43:45, 4:]
        given = replace(seen.given, positions=places)
        sequence = replace(
            seen, observations=boxes, visible=np.where(np.isnan(boxes[..., 2]), np.nan, 1.0), given=given
        )
        problem = problem_of(sequence, CAMERAS[0], 1.0, covariances=True)
        rules = get_protocol("sequential")
        estimate, _ = run_sequence(MapCausal(ego_prior=ego_prior, prior=LOOKING_ABOUT), problem, sequence, rules, None)
        assert estimate.pose_covariances is not None
        off = np.hypot(*(estimate.poses - truth.poses)[:, :2].T)
        said = np.sqrt(np.trace(estimate.pose_covariances[:, :2, :2], axis1=1, axis2=2))
        assert (off <= 4.0 * said + 0.1).all()
        assert off[45:].max() < 5.0
        assert said[42] > said[16] + 1.0
