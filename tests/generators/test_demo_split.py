"""The demo split's crowd: reproducible, with arrivals and departures, and nobody recorded outside the square."""

import numpy as np
import pytest

from vbbench.scene import Scene
from vbbench_generators.crowds.sim import HALF_SIDE, PEOPLE, record_plaza


@pytest.fixture(scope="module")
def scene() -> Scene:
    return record_plaza(0, 0, PEOPLE, 80)


def test_only_the_square_is_recorded(scene: Scene) -> None:
    assert np.nanmax(np.abs(scene.positions)) <= HALF_SIDE
    present = scene.present.sum(axis=1)
    assert 5 <= present.min() <= present.max() <= PEOPLE


def test_people_come_and_go_and_nobody_comes_back(scene: Scene) -> None:
    assert len(scene.people) > PEOPLE
    changes = np.abs(np.diff(scene.present.astype(int), axis=0)).sum(axis=0)
    assert changes.max() <= 2
    assert scene.present.any(axis=0).all()
    first_seen = scene.present.argmax(axis=0)
    assert np.all(np.diff(first_seen) >= 0)


def test_nobody_jumps(scene: Scene) -> None:
    ways = np.linalg.norm(np.diff(scene.positions, axis=0), axis=-1)
    assert np.nanmax(ways) <= 1.3 * (1.34 + 3 * 0.26) * scene.dt + 1e-9


def test_a_scene_follows_from_seed_and_index() -> None:
    scenes = [record_plaza(seed, index, 10, 6).positions for seed, index in ((0, 0), (0, 0), (0, 1), (1, 0))]
    np.testing.assert_array_equal(scenes[0], scenes[1])
    for other in scenes[2:]:
        assert scenes[0].shape != other.shape or not np.array_equal(scenes[0], other, equal_nan=True)
