"""Bootstrap and summaries."""

import numpy as np
import pytest

from vbbench.scoring.statistics import bootstrap_means, mean_of_groups, summarise, two_sided_p


def test_bootstrap_spread_is_the_standard_error():
    values = np.random.default_rng(0).normal(3, 2, (400, 1))
    means = bootstrap_means(values, 4000)
    assert means.shape == (4000, 1)
    assert means.mean() == pytest.approx(values.mean(), abs=0.01)
    assert means.std() == pytest.approx(values.std() / np.sqrt(400), rel=0.05)


def test_bootstrap_repeats_and_seed_0_is_a_seed():
    values = np.arange(12.0)[:, None]
    assert np.array_equal(bootstrap_means(values, 50, seed=0), bootstrap_means(values, 50, seed=0))
    assert not np.array_equal(bootstrap_means(values, 50, seed=0), bootstrap_means(values, 50, seed=1))


def test_blocks_do_not_change_the_draws(monkeypatch):
    values = np.random.default_rng(0).normal(size=(30, 2))
    whole = bootstrap_means(values, 100)
    monkeypatch.setattr("vbbench.scoring.statistics._DRAWS_AT_ONCE", 90)
    np.testing.assert_allclose(bootstrap_means(values, 100), whole)


def test_sequences_without_a_figure_do_not_count():
    values = np.array([[1.0], [np.nan], [1.0]])
    means = bootstrap_means(values, 200)
    assert np.nanmin(means) == np.nanmax(means) == 1.0


def test_p_values():
    assert two_sided_p(np.zeros((99, 1))) == [1.0]
    assert two_sided_p(np.ones((99, 1))) == [0.02]
    assert two_sided_p(-np.ones((99, 1))) == [0.02]


def test_mean_of_groups():
    means = mean_of_groups(np.array([0, 0, 2]), np.array([1.0, 3.0, 5.0]), 4)
    np.testing.assert_array_equal(means, [2.0, np.nan, 5.0, np.nan])


def test_a_metric_without_figures_is_null_in_json():
    summary = summarise({"dx": np.full(3, np.nan)}, {"dx": np.full(9, np.nan)})["dx"]
    assert summary.to_dict()["mean"] is None
    assert summary.to_dict()["ci95"] == [None, None]
