"""Figures of neighbouring fields: the same as TrackEval's, and what known errors must give."""

from itertools import pairwise

import numpy as np
import pytest

from benchmarks.literature import Frame, hota_and_idf1, segment_errors
from benchmarks.separation import sequences_needed


def wandering(seed: int) -> list[Frame]:
    """People who are not all found, and two of whom get new ids every eight frames."""
    rng = np.random.default_rng(seed)
    people = np.cumsum(rng.normal(0, 0.3, (20, 6, 2)), axis=0) + 3 * rng.normal(size=(6, 2))
    frames = []
    for number, places in enumerate(people):
        here, found = rng.random(6) < 0.9, rng.random(6) < 0.8
        tracks = np.arange(6) + number // 8 * (np.arange(6) < 2) * 10
        where = places[found] + rng.normal(0, 0.5, (found.sum(), 2))
        frames.append(Frame(people=np.flatnonzero(here), places=places[here], tracks=tracks[found], found=where))
    return frames


@pytest.mark.parametrize(
    ("seed", "hota", "idf1"),
    [(0, 0.50190123, 0.65137615), (1, 0.4024392, 0.61538462), (2, 0.45748555, 0.61611374)],
)
def test_hota_and_idf1_are_those_of_trackeval(seed: int, hota: float, idf1: float) -> None:
    """TrackEval 1.3.0 of these similarities."""
    assert hota_and_idf1(wandering(seed)) == pytest.approx((hota, idf1), abs=1e-8)


def test_perfect_tracks_score_1_and_a_switch_of_ids_halves_idf1() -> None:
    rng = np.random.default_rng(0)
    ids = np.arange(4)
    frames = [Frame(people=ids, places=p, tracks=ids, found=p) for p in 5 * rng.normal(size=(10, 4, 2))]
    assert hota_and_idf1(frames) == pytest.approx((1.0, 1.0))
    late = [
        Frame(people=one.people, places=one.places, tracks=ids + 9 * (n >= 5), found=one.found)
        for n, one in enumerate(frames)
    ]
    assert hota_and_idf1(late) == pytest.approx((np.sqrt(0.5), 0.5))


def test_a_path_too_long_by_a_twentieth_drifts_by_5_per_cent() -> None:
    true = np.stack([np.linspace(0.0, 30.0, 121), np.zeros(121), np.zeros(121)], axis=-1)
    found = list(segment_errors(true, true * [1.05, 1.0, 1.0]))
    assert {length for length, _, _ in found} == {5.0, 10.0, 20.0}
    assert [off / length for length, off, _ in found] == pytest.approx([0.05] * len(found))
    turned = true + np.linspace(0.0, 0.3, 121)[:, None] * [0.0, 0.0, 1.0]
    assert [turn / length for length, _, turn in segment_errors(true, turned)] == pytest.approx([0.01] * len(found))


def test_smaller_differences_need_more_sequences() -> None:
    noise = np.random.default_rng(0).normal(0.0, 0.3, 400)
    needed = [sequences_needed(noise - noise.mean() + mean) for mean in (0.3, 0.1, 0.05)]
    assert all(few is not None and many is not None and few < many for few, many in pairwise(needed))
    assert needed[1] in (80, 120)  # by the normal approximation 71
    assert sequences_needed(noise - noise.mean()) is None
