"""What keeps worlds that boxes alone tell of from shrinking, against matrices that are written out."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.rough_crowd import drive, made_drive, made_window, photograph
from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, IntArray, world_to_relative
from vbbench.sequence import Given
from vbbench.solver import Frame, Problem
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


def test_exact_boxes_of_people_who_stand_do_not_blow_the_world_up() -> None:
    """There is no noise that would pull it together: it was 1.7 times as large after a window, and sure of itself."""
    rng, camera, frames, people = np.random.default_rng(0), PanoramaCamera(), 25, 12
    angles, reach = rng.uniform(0.0, 2.0 * np.pi, people), rng.uniform(3.0, 9.0, people)
    places = reach[:, None] * np.column_stack((np.cos(angles), np.sin(angles)))
    problem = Problem(
        camera=camera,
        dt=0.4,
        tracks=np.arange(people),
        height_mean=1.75,
        height_std=0.22,
        pixel_std=2.0,
        tilt_std=0.03,
        mount_height_std=0.16,
    )
    boxes = camera.project(world_to_relative(places[None], np.zeros((1, 3))), rng.normal(1.75, 0.09, (1, people)))[0]
    solver, poses = MapCausal(), np.full((3, 3), np.nan)
    solver.start(problem)
    for index in range(frames):
        poses[:] = np.nan
        if index < 3:
            poses[2 - index] = 0.0
        given = Given(poses=poses.copy(), positions=np.full((3, people, 2), np.nan))
        answer = solver.step(Frame(index=index, observations=boxes.copy(), given=given))
    size = np.linalg.norm(answer.positions - answer.pose[:2], axis=1) / reach
    assert np.median(size) == pytest.approx(1.0, abs=0.15)
