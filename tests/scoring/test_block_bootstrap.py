"""Means over sequences that share time, and how sure they are."""

from dataclasses import replace

import numpy as np
import pytest

from vbbench.geometry import FloatArray, IntArray
from vbbench.scoring.block_bootstrap import (
    Timeline,
    autocorrelation,
    block_means,
    block_shares,
    optimal_length,
    residuals,
)

RANDOM = np.random.default_rng(5)
ONE_SCENE = np.zeros(200, int)
FIRST = RANDOM.integers(0, 1970, 200)


def timeline(scene: IntArray = ONE_SCENE, first: IntArray = FIRST, frames: int = 30) -> Timeline:
    return Timeline.of(scene, first, first + frames - 1)


def apart(count: int, frames: int = 20) -> Timeline:
    """Every sequence in a scene of its own."""
    return timeline(np.arange(count), np.zeros(count, int), frames)


def slow(middle: FloatArray, frames: float) -> FloatArray:
    """[N, 1] figures that change slowly with time."""
    alike = np.exp(-np.abs(middle[:, None] - middle) / frames) + 1e-9 * np.eye(len(middle))
    return (np.linalg.cholesky(alike) @ RANDOM.normal(size=len(middle)))[:, None]


def test_scenes_follow_one_another_and_none_is_longer_than_its_sequences() -> None:
    line = Timeline.of(np.array([7, 7, 2]), np.array([100, 130, 5]), np.array([109, 149, 24]))
    assert line.total == 20 + 50
    np.testing.assert_array_equal(line.middle, [20 + 5, 20 + 40, 10])
    assert (line.longest_scene, line.longest, line.typical) == (50, 20, 50 / 3)


def test_the_variance_is_that_of_drawn_blocks() -> None:
    line, block, draws = timeline(), 2000 / 20, 20_000
    values = slow(line.middle, 40.0)
    e = residuals(values)[:, 0]
    starts = RANDOM.uniform(0, line.total, (draws, 1, 1))
    sums = np.concatenate([((line.middle - part) % line.total < block) @ e for part in np.array_split(starts, 40)])
    drawn = line.total / block * np.mean(sums**2)
    assert e @ block_shares(line, line.middle, block) @ e == pytest.approx(drawn, rel=0.05)


def test_of_sequences_in_scenes_of_their_own_it_is_the_usual_interval() -> None:
    values = RANDOM.gamma(4.0, 1.0, (400, 1))
    found = block_means(apart(400), values)
    assert found.error[0] == pytest.approx(values.std() / 20, rel=0.15)
    assert found.degrees[0] > 100
    assert found.interval()[0] == pytest.approx(values.mean() + 1.96 * values.std() / 20 * np.array([-1, 1]), rel=0.02)


def test_shared_time_makes_intervals_wider() -> None:
    values = slow(timeline().middle, 40.0)
    shared, alone = block_means(timeline(), values), block_means(apart(200), values)
    assert shared.error > 2 * alone.error
    assert shared.degrees < alone.degrees


def test_a_block_is_no_shorter_than_the_longest_sequence_nor_than_figures_stay_alike() -> None:
    assert timeline(frames=30).block_length(RANDOM.normal(size=(200, 1))) >= 0.1 * timeline().longest_scene
    assert timeline(frames=700).block_length(RANDOM.normal(size=(200, 1))) >= 700
    line = timeline()
    lengths = [np.mean([line.block_length(slow(line.middle, far)) for _ in range(10)]) for far in (10.0, 60.0, 200.0)]
    assert lengths[0] < lengths[1] < lengths[2]


def test_float32_changes_no_block() -> None:
    values = RANDOM.gamma(2.0, 0.1, (200, 3))
    assert timeline().block_length(values) == timeline().block_length(values.astype(np.float32).astype(float))


def test_the_rule_golden() -> None:
    """Of an autoregression of .5 Σ|k|ρ^|k| is 4 and Σρ^|k| is 3, which gives (1.5 · (4/3)² n)^(1/3)."""
    correlation = 0.5 ** np.arange(200.0)
    assert optimal_length(correlation, 10_000) == pytest.approx((1.5 * (4 / 3) ** 2 * 10_000) ** (1 / 3), rel=0.1)
    assert optimal_length(np.eye(1, 50)[0], 1000) == 1.0


def test_scenes_are_not_alike_because_they_are_neighbours() -> None:
    series, scene = np.tile([1.0, 1.0, -1.0, -1.0], 50)[:, None], np.repeat(np.arange(100), 2)
    assert autocorrelation(series, scene)[1] == pytest.approx(0.5)
    assert not autocorrelation(series, scene)[2:].any()


@pytest.mark.parametrize(("count", "frames"), [(200, 1500), (4, 20)])
def test_too_little_for_an_interval(count: int, frames: int) -> None:
    found = block_means(timeline(ONE_SCENE[:count], FIRST[:count], frames), RANDOM.normal(size=(count, 1)))
    assert np.isfinite(found.mean).all()
    assert np.isnan(found.interval()).all()
    assert np.isnan(found.positive_interval(np.ones(1))).all()
    assert np.isnan(replace(found, mean=np.zeros(1)).positive_interval(np.ones(1))).all()
    assert np.isnan(found.p_values()).all()


def test_p_value_and_interval_agree() -> None:
    values = RANDOM.normal(size=(200, 50)) + np.linspace(-0.3, 0.3, 50)
    found = block_means(timeline(), values)
    outside = (found.interval() > 0).all(axis=1) | (found.interval() < 0).all(axis=1)
    np.testing.assert_array_equal(found.p_values() < 0.05, outside)


def test_no_difference_and_the_same_difference_everywhere() -> None:
    found = block_means(apart(30), np.stack([np.zeros(30), np.full(30, 0.5)], axis=1))
    np.testing.assert_allclose(found.p_values(), [1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.interval(), [[0, 0], [0.5, 0.5]], atol=1e-12)


def test_intervals_of_errors_stay_above_zero_and_below_the_cap() -> None:
    values = np.zeros((9, 2))
    values[0], values[1:] = [1e6, 2.0], [0.1, 1.9]
    low, high = block_means(apart(9), values).positive_interval(np.array([np.inf, 2.0])).T
    assert (low > 0).all()
    assert np.isfinite(high).all()
    assert high[1] <= 2.0


def test_sequences_without_a_figure_do_not_count() -> None:
    values = RANDOM.normal(size=(200, 1))
    gaps = np.concatenate([values, values], axis=1)
    gaps[::4, 1] = np.nan
    kept = np.arange(200) % 4 > 0
    fewer = Timeline.of(ONE_SCENE[kept], FIRST[kept], FIRST[kept] + 29)
    found, alone = block_means(timeline(), gaps, 200.0), block_means(fewer, values[kept], 200.0)
    assert (found.mean[1], found.error[1]) == pytest.approx((alone.mean[0], alone.error[0]), rel=0.02)
    assert np.isnan(block_means(timeline(), np.full((200, 1), np.nan)).mean).all()


def test_many_sequences_are_taken_together_with_their_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    values = slow(timeline().middle, 40.0)
    one = block_means(timeline(), values)
    monkeypatch.setattr("vbbench.scoring.block_bootstrap._MOST", 100)
    other = block_means(timeline(), values)
    assert other.error[0] == pytest.approx(one.error[0], rel=0.1)
    assert other.degrees[0] == pytest.approx(one.degrees[0], rel=0.1)
