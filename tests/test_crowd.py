"""The demo crowd: reproducible, plausible, and with arrivals and departures."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vbbench.scene import Scene
from vbbench_generators.crowd import HALF_SIDE, make_crowd

DT = 0.4


@pytest.fixture(scope="module", params=[(12, 0), (30, 1), (45, 2)], ids=lambda p: f"{p[0]} people")
def crowd(request: pytest.FixtureRequest) -> tuple[int, Scene]:
    people, index = request.param
    return people, make_crowd(0, index, people, 80, DT)


def speeds(scene: Scene) -> np.ndarray:
    pace = np.linalg.norm(np.diff(scene.positions, axis=0), axis=-1) / scene.dt
    return pace[np.isfinite(pace)]


def nearest_neighbours(scene: Scene) -> np.ndarray:
    apart = np.linalg.norm(scene.positions[:, :, None] - scene.positions[:, None], axis=-1)
    k = np.arange(apart.shape[1])
    apart[:, k, k] = np.nan
    return np.nan_to_num(apart, nan=np.inf).min(axis=-1)[scene.present]


def test_the_square_is_always_full(crowd):
    people, scene = crowd
    assert np.all(scene.present.sum(axis=1) == people)
    assert np.nanmax(np.abs(scene.positions)) <= HALF_SIDE


def test_people_come_and_go_and_nobody_comes_back(crowd):
    people, scene = crowd
    assert len(scene.people) > 2 * people
    changes = np.abs(np.diff(scene.present.astype(int), axis=0)).sum(axis=0)
    assert changes.max() <= 2
    first_seen = scene.present.argmax(axis=0)
    assert np.all(np.diff(first_seen) >= 0)


def test_speeds_are_those_of_pedestrians(crowd):
    _, scene = crowd
    pace = speeds(scene)
    assert 1.1 < np.median(pace) < 1.5
    assert np.percentile(pace, 1) > 0.4
    assert pace.max() < 2.5


def test_people_keep_apart(crowd):
    _, scene = crowd
    gaps = nearest_neighbours(scene)
    assert np.mean(gaps < 0.3) < 0.001
    assert np.percentile(gaps, 1) > 0.45


def test_paths_are_not_straight_lines(crowd):
    _, scene = crowd
    change = np.linalg.norm(np.diff(scene.positions, 2, axis=0), axis=-1)
    assert np.nanmedian(change) > 0.01


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32), st.integers(0, 1000), st.integers(1, 12), st.sampled_from([0.1, 0.25, 0.4]))
def test_the_scene_follows_from_seed_and_index(seed, index, people, dt):
    scene, again = (make_crowd(seed, index, people, 6, dt) for _ in range(2))
    np.testing.assert_array_equal(scene.positions, again.positions)
    np.testing.assert_array_equal(scene.people, np.arange(len(scene.people)))
    assert scene.frames == 6
    other = make_crowd(seed, index + 1, people, 6, dt)
    assert not np.array_equal(scene.positions[0, :people], other.positions[0, :people])


def test_seed_zero_is_a_seed():
    a, b = make_crowd(0, 0, 5, 4, DT), make_crowd(0, 0, 5, 4, DT)
    np.testing.assert_array_equal(a.positions, b.positions)
