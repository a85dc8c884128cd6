"""The joint solvers with too few people to tell where the observer is: they stay near, and say so."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays

from tests.sparse_crowd import GAP, one_by_one, sparse_crowd
from tests.test_bounded import ASTRAY, GAPS, pose_errors, solve, solved_over_a_gap, unannounced
from vbbench.geometry import BoolArray
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.lost import PATIENCE, beyond_patience, seconds_after, seconds_lost

JOINT = [MapCausal, MapBatch]
LATER = 0.4
NOBODY = np.zeros((1, 4), np.bool_)


def these(people: int) -> BoolArray:
    """[4] of whom the first are seen."""
    return np.arange(4) < people


@pytest.mark.parametrize(
    ("seen", "placed", "before", "after"),
    [
        (2, 0, 0.4, 0.0),  # two keep an observer in place
        (2, 0, PATIENCE, 0.0),
        (2, 0, PATIENCE + 0.1, PATIENCE + 0.5),  # but do not find one who is lost
        (4, 2, PATIENCE + 0.1, PATIENCE + 0.5),
        (4, 3, PATIENCE + 0.1, 0.0),  # three who are given do
        (1, 1, 0.0, 0.4),
        (0, 0, 1.0, 1.4),
    ],
)
def test_people_keep_and_find_an_observer(seen: int, placed: int, before: float, after: float) -> None:
    found = seconds_after(before, these(seen), these(placed)[None], False, LATER)
    assert found == pytest.approx(after)


def test_a_given_pose_finds_an_observer_and_odometry_keeps_the_time_from_passing() -> None:
    assert seconds_after(9.0, these(0), NOBODY, True, LATER) == 0.0
    assert seconds_after(9.0, these(0), NOBODY, False, 0.0) == 9.0


def test_places_given_long_ago_find_nobody() -> None:
    placed = np.zeros((30, 4), np.bool_)
    placed[5] = True
    assert seconds_after(9.0, these(4), placed[:10], False, LATER) == 0.0
    assert seconds_after(9.0, these(4), placed, False, LATER) == pytest.approx(9.4)


@given(arrays(np.bool_, (12, 3)), arrays(np.bool_, (12, 3)), arrays(np.bool_, 12))
def test_frames_that_are_known_again_were_lost_for_half_as_long(
    seen: BoolArray, placed: BoolArray, posed: BoolArray
) -> None:
    whole = seconds_lost(seen, placed, posed, np.full(12, LATER))
    since, alone = 0.0, np.zeros(12)
    for t in range(12):
        since = seconds_after(since, seen[t], placed[: t + 1], bool(posed[t]), LATER)
        alone[t] = since
    found = np.append(np.flatnonzero(alone == 0.0), 12)
    for first, last in zip(np.append(-1, found[:-1]) + 1, found, strict=True):
        longest = alone[last - 1] if last > first else 0.0
        np.testing.assert_allclose(whole[first:last], alone[first:last] if last == 12 else 0.5 * longest)
    assert np.all(whole[posed] == 0.0)
    assert np.all(beyond_patience(whole) == whole * (whole > PATIENCE))


@pytest.mark.parametrize("solver", JOINT)
def test_a_gap_is_announced_and_arrivals_end_it(solver: type[Any]) -> None:
    estimate, std, truth = solved_over_a_gap(solver)
    assert estimate.converged is not None
    middle, after = 20 + GAP // 2, 20 + GAP + 6
    assert estimate.converged[2:20].all()
    assert not estimate.converged[middle]
    assert std[middle] > 1.0
    assert estimate.converged[after:].all()
    assert std[after:].max() < 1.0
    assert not unannounced(estimate, truth).any()


@pytest.mark.slow
@pytest.mark.parametrize("solver", JOINT)
@pytest.mark.parametrize("together", [1, 2, 3])
def test_nothing_far_off_is_unannounced(solver: type[Any], together: int) -> None:
    """A walk through gaps with few people between them: poses are up to 10 m off, and before they did not say so."""
    shown = one_by_one(240, GAPS, together=together, stay=10)
    far: int = 0
    for seed in range(4):
        for speed in (0.0, 1.3):
            case = sparse_crowd(seed, shown, speed=speed)
            estimate = solve(solver(), case)
            errors = pose_errors(estimate, case[1])
            assert errors.max() < 15.0
            assert not unannounced(estimate, case[1]).any()
            far += int(np.count_nonzero(errors > ASTRAY))
    assert far > 0 or (solver is MapBatch and together == 1)
