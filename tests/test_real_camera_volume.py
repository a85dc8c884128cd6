"""What keeps worlds that boxes alone tell of from shrinking, against matrices that are written out."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.rough_crowd import drive, made_drive, made_window, photograph
from vbbench.geometry import FloatArray, IntArray
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.optimiser.banded import BAND
from vbbench_baselines.joint_map.real_camera import smoothing
from vbbench_baselines.joint_map.real_camera.cues import CUES
from vbbench_baselines.joint_map.real_camera.elimination import Person
from vbbench_baselines.joint_map.real_camera.joint import Seen, linearise
from vbbench_baselines.joint_map.real_camera.volume import told_of
from vbbench_baselines.joint_map.real_camera.window import Window


def dense(person: Person) -> tuple[FloatArray, FloatArray]:
    """A and B [2n, 2n] of a person."""
    n = len(person.pull)
    lower = np.zeros((n, n))
    for j in range(n):
        lower[j, j] = 1.0 / person.lower[j, 0]
        for d in range(1, min(BAND, n - 1 - j) + 1):
            lower[j + d, j] = person.lower[j, d]
    boxes = np.zeros((n, n))
    for i, frame in enumerate(person.found.frame):
        for j in range(CUES):
            slopes = np.zeros((2, n))
            slopes[0, 2 * frame : 2 * frame + 2] = person.found.by_place[i, j]
            boxes += person.white.diagonal[i, j] * np.outer(slopes[0], slopes[0])
            if i > 0:
                before = person.found.frame[i - 1]
                slopes[1, 2 * before : 2 * before + 2] = person.found.by_place[i - 1, j]
                both = person.white.beside[i, j] * np.outer(slopes[0], slopes[1])
                boxes += both + both.T
    return lower @ lower.T, boxes


def test_a_box_tells_as_much_of_its_place_as_written_out_matrices_say() -> None:
    window = made_window()
    for person in linearise(window.point, window.seen, window.model, 0.0).people:
        whole, boxes = dense(person)
        told = told_of(person)
        parts = np.diag(np.linalg.solve(whole, boxes)).reshape(-1, 2).sum(axis=1)
        np.testing.assert_allclose(told, parts, rtol=1e-8, atol=1e-10)
        assert (told > -1e-9).all()
        assert (told < 2.0).all()


def test_it_is_how_the_logarithm_of_the_determinant_falls_with_the_size_of_the_world() -> None:
    window = made_window()
    for person in linearise(window.point, window.seen, window.model, 0.0).people:
        whole, boxes = dense(person)
        walk = whole - boxes
        ends = [0.5 * np.linalg.slogdet(walk + np.exp(-2.0 * size) * boxes)[1] for size in (1e-4, -1e-4)]
        assert -told_of(person).sum() == pytest.approx((ends[0] - ends[1]) / 2e-4, rel=1e-4)


def nothing_told(seen: Callable[..., tuple[Seen, IntArray]]) -> Callable[..., tuple[Seen, IntArray]]:
    """What is ``seen`` of a window, without the term."""

    def without(*asked: Any, **options: Any) -> tuple[Seen, IntArray]:
        whole, columns = seen(*asked, **options)
        return whole._replace(told=np.zeros_like(whole.told)), columns

    return without


@pytest.mark.parametrize("make", [MapCausal, MapBatch])
def test_after_a_cold_start_the_world_does_not_shrink(make: Callable[[], Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Distances of people who change their speeds, as a share of the true ones, with the term and without."""
    drives = [
        made_drive(truth, photograph(truth, seed=seed))
        for seed in range(6)
        for truth in [drive(seed, frames=30, people=20, wander=0.02)]
    ]

    def share() -> float:
        found = []
        for made in drives:
            sides = (made.solved(make, "cold-start"), made.truth)
            reach, true = (np.linalg.norm(side.positions - side.poses[:, None, :2], axis=-1)[12:] for side in sides)
            found.append(np.nanmedian(reach / true))
        return float(np.mean(found))

    kept = share()
    if make is MapBatch:
        monkeypatch.setattr(smoothing, "_with_told", lambda point, seen, model: (point, seen))
    monkeypatch.setattr(Window, "seen", nothing_told(Window.seen))
    assert share() < kept - 0.02
    assert kept == pytest.approx(1.0, abs=0.05)
