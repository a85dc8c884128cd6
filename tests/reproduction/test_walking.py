"""How people walk around an observer: spreads, examples picked by them, and what goes with them."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from vbbench.geometry import FloatArray
from vbbench.pictures.plotting import style
from vbbench.reproduction.walking import (
    WINDOW,
    FrameSample,
    directional_spread,
    pick_examples,
    spreads,
)
from vbbench.scoring.block_bootstrap import Timeline


def heading(*degrees: float) -> FloatArray:
    """Velocities [1, K, 2] of 1 m/s."""
    angle = np.radians(degrees)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[None]


@pytest.mark.parametrize(
    ("velocity", "directions", "lines"),
    [
        (heading(30, 30, 30), 0.0, 0.0),
        (heading(30, 210), 1.0, 0.0),
        (heading(0, 90), 1.0 - np.sqrt(0.5), 1.0),
        (heading(0, 90, 180, 270), 1.0, 1.0),
        (np.concatenate([heading(30, 30), 0.1 * heading(120, 0), heading(90) * np.nan], axis=1), 0.0, 0.0),
    ],
)
def test_spreads_of_directions_and_of_lines(velocity: FloatArray, directions: float, lines: float) -> None:
    spread, of_lines = spreads(velocity)
    assert (spread[0], of_lines[0]) == pytest.approx((directions, lines), abs=1e-12)


def test_nobody_who_moves_has_no_spread() -> None:
    spread, _ = spreads(np.zeros((1, 3, 2)))
    assert np.isnan(spread[0])
    assert np.isnan(directional_spread(np.full((1, 2), np.nan))[0])


def walking(sequence: int, velocity: FloatArray, frames: int = WINDOW + 3) -> dict[str, Any]:
    """A sequence in which an observer and the people of ``velocity`` [1, K, 2] walk on."""
    spread, lines = (np.repeat(values, frames) for values in spreads(velocity))
    people = np.full(frames, velocity.shape[1] - 1)
    numbers = {"sequence": np.full(frames, sequence), "frame": np.arange(2, frames + 2), "people": people}
    return {**numbers, "spread": spread, "lines": lines}


def joined(walks: list[dict[str, Any]]) -> dict[str, Any]:
    return {name: np.concatenate([walk[name] for walk in walks]) for name in walks[0]}


def test_the_rule_finds_parallel_and_crossing_walks_with_few_and_with_more_people() -> None:
    walks = [
        walking(0, heading(0, 20, 50, 70)),
        walking(1, heading(0, 1, 2, 3)),  # few, parallel
        walking(2, heading(0, 90, 180, 265)),  # few, crossing
        walking(3, heading(0, 180, 0, 180)),  # opposite ways of one line do not cross
        walking(4, heading(0, 0, 1, 2, 3, 4, 5)),  # more, parallel
        walking(5, heading(0, 60, 120, 180, 240, 300, 90)),  # more, crossing
        walking(6, heading(*range(0, 360, 20))),  # too many for a picture
        walking(7, heading(0, 0, 0, 0), frames=WINDOW - 1),  # too short
    ]
    found = pick_examples(joined(walks))
    assert [(one.title, one.sequence) for one in found] == [
        ("3 people, parallel", 1),
        ("3 people, crossing", 2),
        ("5 to 12 people, parallel", 4),
        ("5 to 12 people, crossing", 5),
    ]
    assert found[0].frames == range(2, 2 + WINDOW)
    assert pick_examples(walks[7]) == []


def test_where_no_stretch_has_three_people_throughout_the_sparsest_counts() -> None:
    mixed = walking(0, heading(0, 10, 20, 30))
    people = np.where(np.arange(len(mixed["people"])) % 2, 3, 4)
    found = pick_examples({**mixed, "people": people})
    assert [one.title for one in found] == ["3 to 4 people, parallel", "3 to 4 people, crossing"]


def test_pictures_have_the_walk_from_left_to_right() -> None:
    path = np.array([[5.0, 5.0], [6.0, 7.0], [5.0, 9.0]])
    np.testing.assert_allclose(style.along_path(path)(path), [[0, 0], [2, -1], [4, 0]], atol=1e-12)


def sample(sequences: int = 60, frames: int = 20) -> FrameSample:
    first = 5 * np.arange(sequences)
    timeline = Timeline.of(np.zeros(sequences, np.int64), first, first + frames - 1)
    sequence = np.repeat(np.arange(sequences), frames)
    return FrameSample(sequence=sequence, timeline=timeline)


def test_ranks_are_correlated_with_an_interval() -> None:
    rng = np.random.default_rng(0)
    frames = sample()
    people = rng.integers(3, 9, len(frames.sequence)).astype(np.float64)
    entropy = -2.0 * people + rng.normal(0.0, 1.0, len(people))
    found = frames.rank_correlation(people, entropy)
    assert found.value == pytest.approx(pd.Series(people).corr(pd.Series(entropy), method="spearman"))
    assert found.low < found.value < found.high < -0.7


def test_what_never_varies_has_no_correlation_and_no_interval() -> None:
    frames = sample(sequences=3, frames=2)
    found = frames.rank_correlation(np.arange(6.0), np.ones(6))
    assert np.isnan([found.value, found.low, found.high]).all()
