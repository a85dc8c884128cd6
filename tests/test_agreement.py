"""How alike two datasets rank: against numbers worked out by hand, and where one ranking is the other's by chance."""

import numpy as np
import pytest

from vbbench.geometry import FloatArray
from vbbench.reproduction.agreement import (
    Errors,
    agreement,
    alike,
    block_counts,
    number_of_blocks,
    regret,
    separated,
    spearman,
)

NOBODY = np.zeros(4, bool)


def errors(values: FloatArray, block: float = 10.0) -> Errors:
    """Sequences of 10 s, one after the other in one scene."""
    start = 10.0 * np.arange(values.shape[1])
    return Errors(values=values, scene=np.zeros(len(start), int), start=start, end=start + 10.0, block=block)


def test_spearman_by_hand() -> None:
    made = np.array([[1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0], [4.0, 3.0, 2.0, 1.0], [1.0, 1.0, 3.0, 4.0]])
    real = np.array([[2.0, 4.0, 6.0, 8.0], [1.0, 3.0, 2.0, 4.0], [1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0]])
    # 1 − 6 Σd²/(n(n² − 1)): Σd² = 2 gives .8; ranks 1.5, 1.5, 3, 4 against 1, 2, 3, 4: 4.5/√(4.5·5)
    np.testing.assert_allclose(spearman(made, real), [1.0, 0.8, -1.0, 4.5 / (4.5 * 5.0) ** 0.5])


def test_equal_figures_have_no_ranks() -> None:
    assert np.isnan(spearman(np.ones((1, 3)), np.array([[1.0, 2.0, 3.0]])))[0]


def test_only_the_pairs_asked_for_count_and_equals_are_no_order() -> None:
    made, real = np.array([[1.0, 2.0, 2.0]]), np.array([[1.0, 2.0, 3.0]])
    pairs = np.zeros((3, 3), bool)
    assert np.isnan(alike(made, real, pairs))[0]
    pairs[0, 1] = True
    assert alike(made, real, pairs)[0] == 1.0
    pairs[1, 2] = True
    assert alike(made, real, pairs)[0] == 0.5


def test_regret_is_that_of_the_winner() -> None:
    made = np.array([[1.0, 2.0, 3.0], [3.0, 2.0, 1.0]])
    real = np.array([[0.5, 0.4, 1.0], [0.5, 0.4, 1.0]])
    np.testing.assert_allclose(regret(made, real), [1.25, 2.5])


def test_pairs_are_separated_where_the_whole_interval_is_on_one_side() -> None:
    rng = np.random.default_rng(0)
    common = rng.normal(size=(1000, 1))
    drawn = np.concatenate([common, common + 1.0, common + rng.normal(size=(1000, 1))], axis=1)
    assert separated(drawn).tolist() == [[False, True, False], [False] * 3, [False] * 3]


def test_a_dataset_agrees_with_itself() -> None:
    values = np.random.default_rng(0).uniform(0.1, 1.0, (4, 12)) * np.array([[1.0], [2.0], [4.0], [8.0]])
    found = agreement(errors(values), errors(values), NOBODY)
    assert found.spearman.value == found.spearman_without_feet.value == found.alike.value == 1.0
    assert found.ratio.value == found.regret.value == pytest.approx(1.0)
    assert found.ratio.low < 1.0 < found.ratio.high
    assert found.blocks == (12, 12)


def test_the_ratio_is_a_geometric_mean() -> None:
    real = np.full((4, 3), 1.0) * np.array([[1.0], [2.0], [3.0], [4.0]])
    made = real * np.array([[2.0], [2.0], [0.5], [8.0]])
    assert agreement(errors(made), errors(real), NOBODY).ratio.value == pytest.approx(2.0)


def test_feet_are_left_out() -> None:
    real = np.full((4, 3), 1.0) * np.array([[1.0], [2.0], [3.0], [4.0]])
    made = real.copy()
    made[0] = 9.0
    feet = np.array([True, False, False, False])
    found = agreement(errors(made), errors(real), feet)
    assert found.spearman.value == pytest.approx(-0.2)
    assert found.spearman_without_feet.value == 1.0
    assert found.separated == 6
    assert (found.alike.value, found.alike_without_feet.value) == (0.5, 1.0)


def test_a_block_holds_what_follows_in_time_and_starts_anywhere() -> None:
    values = np.zeros((4, 8))
    counts = block_counts(errors(values, block=20.0), np.random.default_rng(0), 4000)
    assert number_of_blocks(errors(values, block=20.0)) == 4
    assert counts.sum(axis=1).min() == counts.sum(axis=1).max() == 8
    np.testing.assert_allclose(counts.mean(axis=0), 1.0, atol=0.05)
    neighbours = np.corrcoef(counts.T)[np.arange(8), (np.arange(8) + 1) % 8]
    assert neighbours.min() > 0.2


def test_scenes_lie_one_behind_the_other() -> None:
    one = errors(np.zeros((4, 4)))
    scene, start = np.array([0, 0, 1, 1]), one.start % 20.0 + 500.0
    again = Errors(values=one.values, scene=scene, start=start, end=start + 10.0, block=10.0)
    assert number_of_blocks(again) == number_of_blocks(one) == 4


def test_dependent_sequences_have_wider_intervals_in_blocks() -> None:
    rng = np.random.default_rng(0)
    level = np.repeat(rng.normal(size=20), 5)
    values = np.exp(0.5 * level + 0.05 * rng.normal(size=(4, 100)))
    widths = [np.ptp(np.quantile(errors(values, b).resampled(2000, 0)[:, 0], (0.025, 0.975))) for b in (10.0, 50.0)]
    assert widths[1] > 1.6 * widths[0]
