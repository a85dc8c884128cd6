"""Who hides whom, against a picture drawn pixel by pixel and for any crowd, and rounded boxes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.extensions.fisheye import Fisheye
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.generation import write_dataset
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_generators.splits import demo
from vbbench_generators.tiers.corruption import Hiding
from vbbench_generators.tiers.noise import Outline, Precision, see

CAMERAS: list[Camera] = [PerspectiveCamera(), PanoramaCamera()]
HERE = np.array([[0.0, 0.0, 0.0]])
FINE = 8  # cells a px of the picture made by hand


def crowd(seed: int, people: int) -> tuple[FloatArray, FloatArray]:
    """Positions [1, K, 2] around the camera, at 1.2 m to 15 m from it, and heights [K]."""
    rng = np.random.default_rng(seed)
    reach, angle = rng.uniform(1.2, 15.0, people), rng.uniform(-np.pi, np.pi, people)
    return np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=-1)[None], rng.normal(1.7, 0.1, people)


def ahead(*places: tuple[float, float]) -> FloatArray:
    """Positions [1, K, 2] from (right, forward) in m of a camera at the origin that looks along +x."""
    return np.array([[(forward, -right) for right, forward in places]])


def by_hand(positions: FloatArray, heights: FloatArray, camera: Camera) -> FloatArray:
    """[K] visible fractions from ids painted far to near, `FINE` cells a px; rows far beyond a panorama's picture."""
    x, y = positions[0].T
    flat = isinstance(camera, PerspectiveCamera)
    depth = x if flat else np.hypot(x, y)
    width = camera.width
    lines = (0.0, 720.0) if flat else (-100.0, 700.0)
    rows = np.arange(lines[0] + 0.25, lines[1], 0.5)[:, None]
    columns = ((np.arange(width * FINE) + 0.5) / FINE)[None]
    half, top = Outline().half, Outline().top
    order = [k for k in np.argsort(-depth) if depth[k] > 0.01]
    ids = np.full((len(rows), columns.shape[1]), -1, np.int16)
    alone = np.full(len(depth), np.nan)
    for k in order:
        scale = camera.focal / depth[k]
        middle = 640.0 - scale * y[k] if flat else (np.arctan2(-y[k], x[k]) + np.pi) * width / (2 * np.pi)
        feet = camera.cy + scale * camera.mount_height
        away = np.abs(columns - middle)
        away = away if flat else np.minimum(away, width - away)
        near = (away <= max(half) * heights[k] * scale)[0]
        mask = np.zeros((len(rows), near.sum()), bool)
        for h, t in zip(half, top, strict=True):
            mask |= (away[:, near] <= h * heights[k] * scale) & (rows >= feet - t * heights[k] * scale) & (rows <= feet)
        ids[:, near] = np.where(mask, k, ids[:, near])
        alone[k] = mask.sum()
    shown = np.bincount(ids[ids >= 0], minlength=len(depth))
    return np.divide(shown, alone, out=np.full(len(depth), np.nan), where=alone > 0)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10_000), people=st.integers(1, 14))
def test_the_same_as_a_picture_made_pixel_by_pixel(camera: Camera, seed: int, people: int) -> None:
    positions, heights = crowd(seed, people)
    found = see(positions, heights, HERE, camera).visible[0]
    wanted = by_hand(positions, heights, camera)
    both = ~np.isnan(wanted) & ~np.isnan(found)
    assert np.abs(found[both] - wanted[both]).max(initial=0.0) < 0.04
    slivers = np.isnan(wanted) != np.isnan(found)  # at the picture's border, less than a sample
    assert slivers.sum() <= 1


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), people=st.integers(1, 30))
def test_order_does_not_matter_and_company_never_helps(camera: Camera, seed: int, people: int) -> None:
    positions, heights = crowd(seed, people + 1)
    whole = see(positions, heights, HERE, camera)
    turned = see(positions[:, ::-1], heights[::-1], HERE, camera)
    np.testing.assert_array_equal(whole.visible, turned.visible[:, ::-1])
    np.testing.assert_array_equal(whole.boxes, turned.boxes[:, ::-1])
    fewer = see(positions[:, :-1], heights[:-1], HERE, camera).visible
    there = ~np.isnan(fewer)
    assert np.all(whole.visible[:, :-1][there] <= fewer[there])


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
def test_who_is_alone_shows_all_and_has_the_exact_box(camera: Camera) -> None:
    positions, heights = crowd(3, 200)
    for k in range(200):
        found = see(positions[:, [k]], heights[[k]], HERE, camera)
        relative = np.stack([-positions[0, k, 1], positions[0, k, 0]])
        box = camera.project(relative, heights[k])
        edge = 0.12 * box[2]
        inside = edge < box[0] < 1280 - edge and box[1] + box[2] / 2 < 720
        if np.isnan(box[2]) or (camera.kind == "perspective" and not inside):
            continue
        assert found.visible[0, 0] == 1.0
        np.testing.assert_allclose(found.boxes[0, 0], box, atol=1e-9)


def test_the_nearer_hides_the_lower_part() -> None:
    camera = PerspectiveCamera()
    found = see(ahead((0.0, 4.0), (0.0, 8.0)), np.array([1.4, 1.8]), HERE, camera)
    assert found.visible[0, 0] == 1.0
    assert 0.0 < found.visible[0, 1] < 0.4
    u, v, length = found.boxes[0, 1]
    assert u == 640.0
    assert v - length / 2 == 360 + 80 * (1.6 - 1.8)  # the top is where it was
    assert v + length / 2 < 360 + 80 * 1.6  # the feet are hidden
    behind = see(ahead((0.0, 4.0), (0.0, 8.0)), np.array([1.9, 1.7]), HERE, camera)
    assert behind.visible[0, 1] == 0.0
    assert np.isnan(behind.boxes[0, 1]).all()


def test_half_hidden_from_one_side() -> None:
    alone = see(ahead((0.0, 8.0)), np.array([1.7]), HERE, PerspectiveCamera()).boxes[0, 0]
    found = see(ahead((0.24, 4.0), (0.0, 8.0)), np.array([1.9, 1.7]), HERE, PerspectiveCamera())
    assert 0.2 < found.visible[0, 1] < 0.9
    assert found.boxes[0, 1, 0] < alone[0]  # what is left is on the left
    assert found.boxes[0, 1, 2] == alone[2]  # from head to feet


def test_across_the_seam_of_the_panorama() -> None:
    camera, heights = PanoramaCamera(), np.array([1.7, 1.7, 1.75])
    places = np.array([[6.0, 0.0], [3.0, 0.25], [9.0, -0.2]])
    turns = np.array([0.0, 1.0, np.pi, -np.pi, np.pi + 0.02, np.pi - 0.03])
    poses = np.stack([np.zeros(6), np.zeros(6), turns], axis=-1)
    found = see(np.broadcast_to(places, (6, 3, 2)), heights, poses, camera)
    assert 0.1 < found.visible[0, 0] < 0.9
    np.testing.assert_allclose(found.visible, np.broadcast_to(found.visible[0], (6, 3)), atol=0.06)
    assert np.all((found.boxes[..., 0] >= 0) & (found.boxes[..., 0] < camera.width))


def test_borders_cut_people_off() -> None:
    found = see(ahead((0.0, 1.5), (4.0, 4.0)), np.array([1.7, 1.7]), HERE, PerspectiveCamera())
    np.testing.assert_allclose(found.visible, 1.0)  # of what is in the picture
    _, v, length = found.boxes[0, 0]
    assert v + length / 2 == 720.0
    assert found.boxes[0, 1, 0] < 1280.0  # u is that of the half in the picture
    behind = see(ahead((0.0, -3.0)), np.array([1.7]), HERE, PerspectiveCamera())
    assert np.isnan(behind.visible).all()


@pytest.mark.parametrize(
    ("half", "top"), [((), ()), ((0.1, 0.1), (1.0, 0.8)), ((0.1,), (0.9,)), ((0.1, 0.2), (1.0, 1.0))]
)
def test_outlines_that_cannot_be(half: tuple[float, ...], top: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="must"):
        Outline(half=half, top=top)


TILTED = [
    PerspectiveCamera(pitch=-0.2, roll=0.1, vertical_focal=500.0),
    PanoramaCamera(pitch=-0.1),
    Fisheye(pitch=-0.2),
]


@pytest.mark.parametrize("camera", TILTED, ids=lambda camera: camera.kind)
def test_tilted_and_other_cameras_hide_people_too(camera: Camera) -> None:
    places, heights = ahead((0.0, 4.0), (0.1, 8.0), (2.0, 8.0)), np.array([1.7, 1.7, 1.7])
    found = see(places, heights, HERE, camera)
    assert found.visible[0, 0] == found.visible[0, 2] == 1.0
    assert found.visible[0, 1] < 0.3
    whole = camera.project(world_to_relative(places, HERE), heights)
    np.testing.assert_allclose(found.boxes[0, [0, 2]], whole[0, [0, 2]], atol=0.3)


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
def test_the_tier_is_the_ideal_one_with_people_hidden(camera: Camera) -> None:
    ideal, cut = (demo.plan(Options(camera=camera, tier=tier)) for tier in ("ideal", "occluded"))
    hiding = Hiding()
    fewer = shorter = 0
    for index in range(0, len(ideal), 9):
        whole, seen = ideal.build(index).sequence, cut.build(index).sequence
        column = np.searchsorted(whole.tracks, seen.tracks)
        assert np.array_equal(whole.tracks[column], seen.tracks)
        assert np.all(whole.observed[:, column][seen.observed])
        fewer += whole.observed.sum() - seen.observed.sum()
        assert np.nanmin(seen.visible) >= hiding.least_visible
        free = seen.visible == 1.0
        boxes = whole.observations[:, column]
        standing = boxes[..., 1] + boxes[..., 2] / 2 <= 720
        inside = (boxes[..., 0] > 0.15 * boxes[..., 2]) & (boxes[..., 0] < 1280 - 0.15 * boxes[..., 2])
        free &= (standing & inside) | (camera.kind == "panorama")
        np.testing.assert_allclose(seen.observations[free], boxes[free], atol=1e-9)
        less = (boxes - seen.observations)[seen.observed][:, 2]
        assert np.all(less >= -1e-9)
        shorter += np.count_nonzero(less > 1.0)
    assert fewer > 0
    assert shorter > 0


@pytest.mark.slow
@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: camera.kind)
def test_visible_fractions_are_those_of_pictures(camera: Camera) -> None:
    from benchmarks.calibrate_occlusion import differences, samples

    gap = np.abs(differences(samples(camera, sequences=1, every=80), Outline()))
    assert len(gap) > 50
    assert gap.mean() < 0.08


ROUNDED = Precision(u_bits=10, v_bits=10, l_bits=12)


def test_rounded_boxes_are_multiples_within_half_a_step_and_truth_is_untouched() -> None:
    exact = demo.plan(Options(limit=30))
    coarse = replace(exact, precision=ROUNDED)
    for index in range(len(exact)):
        a, b = exact.build(index), coarse.build(index)
        seen, steps = a.sequence.observed, np.array(ROUNDED.steps)
        np.testing.assert_array_equal(seen, b.sequence.observed)
        boxes = b.sequence.observations[seen]
        np.testing.assert_array_equal(boxes / steps, np.rint(boxes / steps))
        gap = boxes - a.sequence.observations[seen]
        gap[:, 0] = (gap[:, 0] + 720.0) % 1440.0 - 720.0
        assert (np.abs(gap) <= 0.5 * steps).all()
        np.testing.assert_array_equal(a.sequence.given.positions, b.sequence.given.positions)
        np.testing.assert_array_equal(a.truth.positions, b.truth.positions)


@pytest.mark.slow
def test_solvers_are_hardly_affected_by_rounding(tmp_path: Path) -> None:
    plan, figures = demo.plan(Options(limit=30)), []
    for name, precision in (("exact", None), ("rounded", ROUNDED)):
        dataset = write_dataset(replace(plan, precision=precision), tmp_path / name)
        solved = solve(dataset, "vb-cv", "one-step", tmp_path / f"{name} solved")
        figures.append(score(solved, dataset.folder).summaries)
    for metric in ("dt", "dx", "dx_rel"):
        assert abs(figures[0][metric].mean - figures[1][metric].mean) < 2e-4


def test_a_column_that_rounds_up_to_the_width_is_column_nought_and_no_box_vanishes() -> None:
    boxes = np.array([[1439.9999, 240.0, 10.0], [0.0, 0.0, 1e-9], [np.nan, np.nan, np.nan]])
    wanted = [[0.0, 240.0, 10.0], [0.0, 0.0, 2.0**-12], [np.nan] * 3]
    np.testing.assert_array_equal(ROUNDED.rounded(boxes, PanoramaCamera()), wanted)
