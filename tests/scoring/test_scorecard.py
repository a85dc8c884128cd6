"""Summaries of a split: what counts at most, what has failed, and what is not known."""

import json
from dataclasses import replace

import numpy as np
import pytest

from vbbench.protocol import PROTOCOLS, get_protocol
from vbbench.scoring.block_bootstrap import Timeline
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import Summary, mean_of_groups, summarise

APART = Timeline.of(np.arange(40), np.zeros(40, int), np.full(40, 19))
CAPPED = get_protocol("sequential")


def summary(figures: object, metric: str = "dx") -> Summary:
    values = {metric: np.asarray(figures, float)}
    return summarise(APART, CAPPED, values, values)[metric]


def test_one_runaway_does_not_decide_the_headline() -> None:
    figures = np.full(40, 0.1)
    figures[3] = 7800.0
    found = summary(figures)
    assert found.capped == pytest.approx((39 * 0.1 + 2.0) / 40)
    assert found.failure_rate == pytest.approx(1 / 40)
    assert found.mean > 195
    assert found.median == 0.1
    assert 0 < found.capped_ci95[0] < found.capped < found.capped_ci95[1] <= 2.0
    assert found.ci95[1] <= 7800.0


def test_failures_are_above_the_limit_and_not_at_it() -> None:
    assert summary(np.linspace(0.95, 1.0, 40)).failure_rate == 0.0
    assert summary(np.full(40, 1.001)).failure_rate == 1.0


def test_metrics_without_a_cap_or_a_limit() -> None:
    assert np.isnan(summary(np.full(40, 2.0), "dr").failure_rate)
    assert summary(np.full(40, 2.0), "dr").capped == 0.5
    assert summary(np.full(40, 9.0), "another").capped == 9.0


@pytest.mark.parametrize("name", PROTOCOLS)
def test_every_protocol_caps_every_metric(name: str) -> None:
    protocol = get_protocol(name)
    assert protocol.id == f"{name}/2"
    assert protocol.caps == {metric: 0.5 if "rad" in METRICS[metric].unit else 2.0 for metric in METRICS}
    assert protocol.failures == {"dx_rel": 1.0, "dx": 1.0, "dt": 1.0}


def test_caps_are_the_protocols() -> None:
    values = {"dx": np.full(40, 9.0)}
    own = replace(CAPPED, caps={"dx": 3.0}, failures={"dx": 10.0})
    found = summarise(APART, own, values, values)["dx"]
    assert (found.capped, found.failure_rate) == (3.0, 0.0)


def test_mean_of_groups() -> None:
    means = mean_of_groups(np.array([0, 0, 2]), np.array([1.0, 3.0, 5.0]), 4)
    np.testing.assert_array_equal(means, [2.0, np.nan, 5.0, np.nan])


def test_what_is_not_known_is_null_in_json() -> None:
    told = json.loads(json.dumps(summary(np.full(40, np.nan)).to_dict()))
    assert told.pop("blocks") > 0
    assert {key for key, value in told.items() if value not in (None, [None, None])} == set()
