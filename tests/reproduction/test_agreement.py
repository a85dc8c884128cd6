"""How equally two datasets rank: against numbers worked out by hand, and where one ranking is the other's by chance."""

import numpy as np
import pytest

from vbbench.geometry import FloatArray
from vbbench.reproduction.agreement import Errors, agreement, halves, ordered_equally, regret, separated, spearman
from vbbench.scoring.block_bootstrap import Timeline

NOBODY = np.zeros(4, bool)


def errors(values: FloatArray) -> Errors:
    """Sequences of 10 frames, one after the other in one scene."""
    first = 10 * np.arange(values.shape[1])
    return Errors(values=values, timeline=Timeline.of(np.zeros_like(first), first, first + 9))


def test_spearman_by_hand() -> None:
    made = np.array([[1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0], [4.0, 3.0, 2.0, 1.0], [1.0, 1.0, 3.0, 4.0]])
    real = np.array([[2.0, 4.0, 6.0, 8.0], [1.0, 3.0, 2.0, 4.0], [1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 3.0, 4.0]])
    # 1 − 6 Σd²/(n(n² − 1)): Σd² = 2 gives .8; ranks 1.5, 1.5, 3, 4 against 1, 2, 3, 4: 4.5/√(4.5·5)
    np.testing.assert_allclose(spearman(made, real), [1.0, 0.8, -1.0, 4.5 / (4.5 * 5.0) ** 0.5])
    assert np.isnan(spearman(np.ones((1, 4)), real[:1]))[0]


def test_only_the_pairs_asked_for_count_and_equals_are_no_order() -> None:
    made, real = np.array([[1.0, 2.0, 2.0]]), np.array([[1.0, 2.0, 3.0]])
    pairs = np.zeros((3, 3), bool)
    assert np.isnan(ordered_equally(made, real, pairs))[0]
    pairs[0, 1] = True
    assert ordered_equally(made, real, pairs)[0] == 1.0
    pairs[1, 2] = True
    assert ordered_equally(made, real, pairs)[0] == 0.5


def test_regret_is_that_of_the_winner() -> None:
    made = np.array([[1.0, 2.0, 3.0], [3.0, 2.0, 1.0]])
    real = np.array([[0.5, 0.4, 1.0], [0.5, 0.4, 1.0]])
    np.testing.assert_allclose(regret(made, real), [1.25, 2.5])


def test_pairs_are_separated_where_the_whole_interval_is_on_one_side() -> None:
    rng = np.random.default_rng(0)
    common = 2.0 + rng.normal(size=40)
    values = np.stack([common, common + 0.3 + 0.1 * rng.normal(size=40), common + rng.normal(size=40)])
    assert separated(errors(values)).tolist() == [[False, True, False], [False] * 3, [False] * 3]


def test_a_dataset_agrees_with_itself() -> None:
    values = np.random.default_rng(0).uniform(0.1, 1.0, (4, 12)) * np.array([[1.0], [2.0], [4.0], [8.0]])
    found = agreement(errors(values), errors(values), NOBODY)
    assert found["spearman"].value == found["spearman_without_feet"].value == found["pairs"].value == 1.0
    assert found["ratio"].value == found["regret"].value == pytest.approx(1.0)
    assert found["ratio"].low < 1.0 < found["ratio"].high
    assert errors(values).blocks > 2


def test_halves_are_the_odd_sequences_and_the_even_ones() -> None:
    real = np.tile([[1.0, 4.0], [2.0, 3.0], [3.0, 2.0], [4.0, 1.0]], (1, 5))
    assert halves(errors(real)) == -1.0


@pytest.mark.parametrize(
    ("real", "made", "ratio", "regret"),
    [
        ([1.0, 2.0, 3.0, 4.0], [2.0, 4.0, 1.5, 32.0], 2.0, 3.0),
        ([0.0, 0.1, 0.2, 0.4], [0.4, 0.2, 0.1, 0.0], 1.0, 0.4 / 1e-6),  # nobody is without error
    ],
)
def test_the_ratio_is_a_geometric_mean(real: list[float], made: list[float], ratio: float, regret: float) -> None:
    found = agreement(*(errors(np.outer(values, np.ones(8))) for values in (made, real)), NOBODY)
    assert (found["ratio"].value, found["regret"].value) == pytest.approx((ratio, regret))


def test_feet_are_left_out() -> None:
    real = np.array([[1.0], [2.0], [3.0], [4.0]]) + 0.01 * np.random.default_rng(0).normal(size=(4, 40))
    made = real.copy()
    made[0] = 9.0
    feet = np.array([True, False, False, False])
    found = agreement(errors(made), errors(real), feet)
    assert found["spearman"].value == pytest.approx(-0.2)
    assert found["spearman_without_feet"].value == 1.0
    assert separated(errors(real)).sum() == 6
    assert (found["pairs"].value, found["pairs_without_feet"].value) == (0.5, 1.0)


def test_blocks_hold_what_follows_in_time_and_all_sequences_alike() -> None:
    level = np.repeat(np.random.default_rng(0).normal(size=20), 5)
    found = errors(np.tile(level, (4, 1)))
    assert 3 <= found.blocks <= 14
    counts = found.counts(4000, seed=0)
    np.testing.assert_allclose(counts.mean(axis=0), 1.0, atol=0.1)
    correlation: FloatArray = np.asarray(np.corrcoef(counts.T))
    assert correlation[0, [1, 99]].min() > 0.5
    assert abs(correlation[0, 50]) < 0.5
