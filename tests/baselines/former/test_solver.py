"""vb-former: what does not matter to them, gaps, absurd boxes, odometry, and how sure they are."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib import solver_runs
from tests.lib.make_dataset import Crowd, write_dataset
from tests.lib.solver_runs import CAMERAS, assert_close, elsewhere, measured, run, see, showing, walk
from vbbench.estimate import is_credible
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray
from vbbench.protocol import PROTOCOLS
from vbbench.scoring import score
from vbbench.sequence import Sequence
from vbbench.solver import Estimate
from vbbench.solving import solve
from vbbench_baselines.former.certainty import Certainty
from vbbench_baselines.former.layers import first_weights
from vbbench_baselines.former.solver import VbFormer

GOLDEN = {
    "one-step": (0.0414, 0.0524),
    "sequential": (0.0372, 0.0410),
    "rollout": (0.0372, 0.0410),
    "cold-start": (0.4996, 0.2992),
}
"""Δx and Δt in m on three made sequences; with new weights, or another fit, they are made anew."""


def first(**biases: float) -> dict[str, Any]:
    """Weights before any training, with these biases."""
    made = {name: values.astype(np.float32) for name, values in first_weights(np.random.default_rng(0)).items()}
    for name, value in biases.items():
        made[f"{name}.bias"][:] = value
    return made


def answer(sequence: Sequence, protocol: str = "rollout", **options: Any) -> Estimate:
    return solver_runs.answer(VbFormer(**options), sequence, protocol, covariances=True)


def without(sequence: Sequence, hidden: Any) -> Sequence:
    """The sequence without the boxes ``hidden`` [T, K]."""
    given = np.where(hidden[..., None], np.nan, sequence.given.positions)
    boxes = np.where(hidden[..., None], np.nan, sequence.observations)
    return showing(sequence, boxes, given=replace(sequence.given, positions=given))


def test_the_order_of_people_does_not_matter() -> None:
    sequence, order = see(walk(1, wobble=0.02), CAMERAS[0], 1.0), np.array([3, 0, 5, 1, 4, 2])
    given = replace(sequence.given, positions=sequence.given.positions[:, order])
    one, other = answer(sequence), answer(showing(sequence, sequence.observations[:, order], given=given))
    np.testing.assert_allclose(other.poses, one.poses, atol=1e-4)
    np.testing.assert_allclose(other.positions, one.positions[:, order], atol=1e-4)


@pytest.mark.parametrize(("shift", "turn"), [((30.0, -20.0), 2.1), ((1e5, -1e5), 0.0)])
def test_where_the_world_begins_does_not_matter(shift: tuple[float, float], turn: float) -> None:
    truth = walk(2, wobble=0.02)
    far = elsewhere(truth, shift, turn)
    here, there = (run(VbFormer(), walks, "rollout", pixel_std=1.0) for walks in (truth, far))
    expected = elsewhere(replace(truth, poses=here.poses, positions=here.positions), shift, turn)
    assert_close(there, expected.poses, expected.positions, 1e-4)


@pytest.mark.parametrize("people", [0, 1, 40])
def test_any_number_of_people(people: int) -> None:
    estimate = answer(see(walk(3, people=people), CAMERAS[0], 1.0), "cold-start")
    assert estimate.positions.shape == (8, people, 2)
    assert estimate.fallback[1:].all() == (people < 2)
    assert np.abs(estimate.poses).max() < 20.0


def test_gaps() -> None:
    """Nobody in some frames, a lone person in others, and some who come late."""
    t, k = np.arange(16)[:, None], np.arange(6)[None]
    hidden = ((t > 3) & (t < 7)) | ((t > 8) & (t < 11) & (k > 0)) | ((k == 4) & (t < 5)) | ((k == 5) & (t % 2 == 0))
    estimate = answer(without(see(walk(4, frames=16), CAMERAS[0], 1.0), hidden))
    assert is_credible(estimate.poses).all()
    assert np.isfinite(estimate.positions[~hidden]).all()
    assert np.isnan(estimate.positions[hidden]).all()
    assert np.abs(estimate.poses[:, :2]).max() < 30.0


ABSURD = [(1e300, 200.0, 50.0), (700.0, np.inf, 50.0), (700.0, 200.0, -np.inf), (700.0, 1e7, 80.0)]


def test_absurd_boxes_are_not_used() -> None:
    sequence, hidden = see(walk(5), CAMERAS[0], 1.0), np.zeros((8, 6), np.bool_)
    boxes = np.array(sequence.observations)
    for frame, box in enumerate(ABSURD, 3):
        boxes[frame, 2], hidden[frame, 2] = box, True
    spoiled, clean = (answer(one) for one in (replace(sequence, observations=boxes), without(sequence, hidden)))
    np.testing.assert_array_equal(spoiled.poses, clean.poses)
    np.testing.assert_array_equal(spoiled.positions[~hidden], clean.positions[~hidden])
    assert is_credible(spoiled.positions).all()


def test_a_network_that_loses_its_mind_stays_where_it_is() -> None:
    estimate = answer(see(walk(6), CAMERAS[0], 1.0), weights=first(trust=np.nan))
    np.testing.assert_array_equal(estimate.poses, estimate.poses[[0, 1, 1, 1, 1, 1, 1, 1]])
    assert is_credible(estimate.positions).all()
    assert estimate.converged.tolist() == [True] * 2 + [False] * 6


@pytest.mark.parametrize(("spread", "sure"), [(2.0, False), (-4.0, True)])
def test_converged_and_covariances_are_those_of_the_spread(spread: float, sure: bool) -> None:
    weights = first(**{"pose_spread": spread, "place_spread.out": spread})
    for name in ("pose_spread.weights", "place_spread.out.weights"):
        weights[name][:] = 0.0
    estimate = answer(see(walk(7), CAMERAS[0], 1.0), weights=weights)
    assert (estimate.converged[2:] == sure).all()
    variance = np.exp(2.0 * spread)
    np.testing.assert_allclose(estimate.pose_covariances[2:], np.tile(variance * np.eye(3), (6, 1, 1)), rtol=1e-5)
    np.testing.assert_allclose(
        estimate.position_covariances[2:], np.tile(variance * np.eye(2), (6, 6, 1, 1)), rtol=1e-5, atol=1e-9
    )
    assert not estimate.pose_covariances[:2].any()


def test_odometry_holds_the_pose() -> None:
    truth = walk(8, frames=12, wobble=0.05)
    odometry = measured(truth, 0.002**2 * np.eye(3))
    estimate, alone = (answer(see(truth, CAMERAS[0], 2.0, odometry=one), "cold-start") for one in (odometry, None))
    assert np.abs(estimate.poses - truth.poses).max() < 0.1
    assert unsure(estimate)[-1] < 0.2 * unsure(alone)[-1]


def unsure(estimate: Estimate) -> FloatArray:
    """[T] standard deviations of the observer's place, in m."""
    return np.asarray(np.sqrt(np.trace(estimate.pose_covariances[:, :2, :2], axis1=1, axis2=2)))


def test_after_a_cold_start_nobody_grows_surer_of_where_it_is() -> None:
    """Windows of the training are short; how far all drift together is unknown for longer, of people's places, too."""
    sequence = see(walk(12, frames=60), CAMERAS[0], 1.0)
    estimate = answer(sequence, "cold-start")
    assert (np.diff(unsure(estimate)) >= 0.0).all()
    assert unsure(estimate)[-1] > 5.0
    assert np.nanmin(np.trace(estimate.position_covariances[-1], axis1=1, axis2=2)) > 0.5 * unsure(estimate)[-1] ** 2
    assert not estimate.converged[-1]


def test_odometry_alone_says_how_sure_a_pose_is_after_a_cold_start() -> None:
    std, truth = 0.02, walk(12, frames=40)
    sequence = see(truth, CAMERAS[0], 1.0, odometry=measured(truth, std**2 * np.eye(3)))
    estimate = answer(sequence, "cold-start")
    assert (np.diff(unsure(estimate)) >= 0.0).all()
    np.testing.assert_allclose(np.sqrt(estimate.pose_covariances[:, 2, 2]), std * np.sqrt(np.arange(40)), atol=1e-9)


def test_odometry_that_comes_and_goes_loses_no_more_than_its_gaps() -> None:
    truth = walk(12, frames=60)

    def spread(missing: slice) -> FloatArray:
        odometry = measured(truth, 0.02**2 * np.eye(3), missing=missing)
        estimate = answer(see(truth, CAMERAS[0], 1.0, odometry=odometry), "cold-start")
        sigma = np.sqrt(np.diagonal(estimate.pose_covariances, axis1=1, axis2=2))
        assert (np.diff(sigma, axis=0) >= -1e-9).all(), "nothing makes a pose surer"
        return sigma

    now_and_then, for_long = spread(slice(10, None, 10)), spread(slice(30, None))
    assert now_and_then[-1, :2].max() < 0.5 * for_long[-1, :2].max()


def test_the_surer_of_network_and_odometry_counts() -> None:
    for variance, wanted in ((1e-6, 2e-6), (1e6, 2.0)):
        certainty = Certainty(0.1)
        certainty.cold = False
        certainty.follow(np.zeros(3), np.full(3, 0.1), np.zeros(3), variance * np.eye(3), sure=False)
        assert np.trace(certainty.pose[:2, :2]) == pytest.approx(wanted, rel=0.1)


def test_protocols_on_a_dataset(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(scenes=1, sequences=3, seed=3))
    dataset, found = Dataset(tmp_path / "data"), {}
    for protocol in PROTOCOLS:
        submission = solve(dataset, "vb-former", protocol, tmp_path / protocol, covariance=True)
        result = score(submission, dataset.folder)
        found[protocol] = tuple(round(float(result.summaries[name].mean), 4) for name in ("dx", "dt"))
    for protocol, golden in GOLDEN.items():
        assert found[protocol] == pytest.approx(golden, rel=0.02, abs=1e-3), found
