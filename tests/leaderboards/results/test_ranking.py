"""Ranks: what the paired bootstrap settles, what stays open, and what must hold whatever the figures are."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.lib.board_results import result
from vbbench.geometry import FloatArray
from vbbench_leaderboards.results.ranking import LEVEL, Ranking, holm, rank

RNG = np.random.default_rng(7)
EASY = RNG.gamma(4.0, 0.02, 60)


def ranked(**figures: Any) -> Ranking:
    """The ranking by Δx of solvers with these figures."""
    return rank([result(name, values) for name, values in figures.items()])["dx"]


def places(ranking: Ranking) -> dict[str, tuple[int, int, int]]:
    return {name: (place.rank, place.best, place.worst) for name, place in ranking.places.items()}


def test_clear_differences_give_clear_ranks() -> None:
    assert places(ranked(a=EASY, b=EASY + 0.01, c=EASY + 0.02)) == {"a": (1, 1, 1), "b": (2, 2, 2), "c": (3, 3, 3)}


def test_identical_solvers_share_a_rank_and_their_interval() -> None:
    found = ranked(a=EASY, b=EASY, c=EASY + 0.05)
    assert places(found) == {"a": (1, 1, 2), "b": (1, 1, 2), "c": (3, 3, 3)}
    assert next(pair for pair in found.pairs if (pair.a, pair.b) == ("a", "b")).p == 1.0


def test_who_is_between_two_may_share_with_both() -> None:
    noise = RNG.normal(0.0, 0.04, len(EASY))
    found = ranked(a=EASY, between=EASY + 0.004 + noise - noise.mean(), c=EASY + 0.008)
    assert places(found) == {"a": (1, 1, 2), "between": (1, 1, 3), "c": (2, 2, 3)}


def test_sequences_without_a_figure_are_left_out_of_a_pair() -> None:
    gaps = EASY + 0.01
    gaps[:20] = np.nan
    pair = ranked(a=EASY, b=gaps).pairs[0]
    assert pair.difference == pytest.approx(-0.01)
    assert pair.better == "a"


def test_solvers_that_share_no_sequence_are_not_compared() -> None:
    first, last = EASY.copy(), EASY.copy() + 1.0
    first[30:], last[:30] = np.nan, np.nan
    found = ranked(a=first, b=last)
    assert found.pairs[0].p == 1.0
    assert np.isnan(found.pairs[0].difference)
    assert {place.rank for place in found.places.values()} == {1}


def test_errors_in_clumps_do_not_pay() -> None:
    """Wild in two sequences of sixty: so uncertain that nobody is significantly better, and yet not first."""
    wild = EASY - 0.001 + 1.9 * (np.arange(len(EASY)) < 2)
    assert places(ranked(a=EASY, b=EASY + 0.005, wild=wild)) == {"a": (1, 1, 2), "b": (2, 2, 3), "wild": (2, 2, 3)}
    found = ranked(a=EASY, wild=wild)
    assert LEVEL < found.pairs[0].p < 0.5
    assert places(found) == {"a": (1, 1, 2), "wild": (1, 1, 2)}


def test_no_rank_is_above_that_of_a_smaller_mean() -> None:
    for _ in range(20):
        figures = {name: EASY + RNG.gamma(0.1, 0.2, len(EASY)) for name in "abcdef"}
        found = ranked(**figures)
        by_mean = sorted(figures, key=lambda name: float(figures[name].mean()))
        ranks = [found.places[name].rank for name in by_mean]
        assert ranks == sorted(ranks)


def test_holm_golden() -> None:
    np.testing.assert_allclose(holm(np.array([0.01, 0.04, 0.03, 0.005])), [0.03, 0.06, 0.06, 0.02])


THREE_COLUMNS = arrays(float, (3, 12), elements=st.floats(0.0, 10.0, width=32))


@given(THREE_COLUMNS)
@settings(max_examples=25, deadline=None)
def test_the_order_of_the_solvers_changes_nothing(figures: FloatArray) -> None:
    one = ranked(a=figures[0], b=figures[1], c=figures[2])
    other = ranked(c=figures[2], b=figures[1], a=figures[0])
    turned = {(pair.b, pair.a): pair for pair in other.pairs}
    for pair in one.pairs:
        mirrored = turned[pair.a, pair.b]
        assert mirrored.difference == pytest.approx(-pair.difference, abs=1e-9)
        assert mirrored.p == pytest.approx(pair.p)
    assert places(one) == places(other)


@given(THREE_COLUMNS, st.floats(0.0, 5.0))
@settings(max_examples=25, deadline=None)
def test_who_gets_worse_in_every_sequence_never_rises(figures: FloatArray, more: float) -> None:
    before = ranked(a=figures[0], b=figures[1]).places["a"]
    after = ranked(a=figures[0] + more, b=figures[1]).places["a"]
    assert after.best >= before.best
    assert after.worst >= before.worst


@given(THREE_COLUMNS)
@settings(max_examples=25, deadline=None)
def test_places_lie_within_the_board(figures: FloatArray) -> None:
    found = ranked(a=figures[0], b=figures[1], c=figures[2])
    for place in found.places.values():
        assert 1 <= place.best == place.rank <= place.worst <= 3
    assert min(place.rank for place in found.places.values()) == 1
    assert all((pair.better is not None) == (pair.p < LEVEL) for pair in found.pairs)


@given(arrays(float, st.integers(1, 12), elements=st.floats(0.0, 1.0)))
def test_holm_raises_and_keeps_the_order(p: FloatArray) -> None:
    corrected = holm(p)
    assert np.all((corrected >= p) & (corrected <= 1.0))
    assert np.all(np.diff(corrected[np.argsort(p, kind="stable")]) >= 0)
