"""Static points seen by two cameras: what is drawn, the five-point method, crossings."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vbbench.camera import make_camera
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.reproduction.keypoints import (
    Curve,
    Poses,
    Setting,
    Views,
    draw_views,
    five_point,
    paper_lines,
)

PLAIN = Setting()
EXACT = replace(PLAIN, noise=0.0)


def triangulated(views: Views) -> FloatArray:
    """[N, P, 3] the points, from exact views, by the cross product of their rays."""
    inverse = np.linalg.inv(views.camera.intrinsics).T
    first, second = (
        np.concatenate([seen, np.ones_like(seen[..., :1])], axis=-1) @ inverse for seen in (views.first, views.second)
    )
    second = np.einsum("nji,npj->npi", views.rotation, second)
    across = np.cross(first, second)
    depth = np.sum(np.cross(views.centre[:, None], second) * across, axis=-1) / np.sum(across**2, axis=-1)
    return np.asarray(depth[..., None] * first)


def test_points_fill_the_voxel_as_far_as_both_cameras_see_it() -> None:
    views = draw_views(EXACT, 12.0, 200, 0)
    points = triangulated(views)[views.lengths > 0.1]
    right, down, forward = np.moveaxis(points, -1, 0)
    assert forward.min() == pytest.approx(12.0, abs=0.1)
    assert forward.max() == pytest.approx(22.0, abs=0.1)
    assert abs(right).max() == pytest.approx(10.0, abs=0.1)
    assert abs(down).max() == pytest.approx(2.5, abs=0.1)
    for seen in (views.first, views.second):
        assert np.all((seen >= 0.0) & (seen < (1280, 720)))


def test_motions_are_on_the_ground_and_uniform_up_to_their_bounds() -> None:
    views = draw_views(PLAIN, 30.0, 400, 1)
    turned = Rotation.from_matrix(views.rotation).as_rotvec()
    assert np.abs(turned[:, [0, 2]]).max() < 1e-12
    assert not views.centre[:, 1].any()
    for values, bounds in ((np.abs(turned[:, 1]), 0.2), (views.lengths, 1.0)):
        assert values.max() <= bounds + 1e-12
        np.testing.assert_allclose(
            np.quantile(values, (0.25, 0.5, 0.75)), bounds * np.array((0.25, 0.5, 0.75)), atol=0.1
        )


def test_noise_is_uniform_and_changes_nothing_else() -> None:
    noisy, clean = draw_views(PLAIN, 6.0, 40, 2), draw_views(EXACT, 6.0, 40, 2)
    np.testing.assert_array_equal(noisy.rotation, clean.rotation)
    np.testing.assert_array_equal(noisy.centre, clean.centre)
    moved = np.stack([noisy.first - clean.first, noisy.second - clean.second])
    assert np.abs(moved).max() <= 1.0
    assert moved.std() == pytest.approx(1.0 / np.sqrt(3.0), rel=0.02)
    assert not np.array_equal(noisy.first, draw_views(PLAIN, 6.0, 40, 3).first)


def test_a_camera_that_sees_nothing_is_a_mistake() -> None:
    camera = make_camera("perspective", width=4, height=4, focal=50_000.0, cx=2.0, cy=2.0)
    with pytest.raises(VbbenchError, match="does not see the voxel at 2 m; give one with a wider field of view"):
        draw_views(replace(PLAIN, camera=camera), 2.0, 2, 0)


def test_errors_are_angles_and_lengths() -> None:
    clean = draw_views(EXACT, 6.0, 3, 0)
    for angle in (0.0, 1e-6, 0.3, np.pi):
        turned = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix() @ clean.rotation
        poses = Poses(rotation=turned, direction=-clean.centre / clean.lengths[:, None])
        np.testing.assert_allclose(clean.rotation_errors(poses), angle, atol=1e-9)
        np.testing.assert_allclose(clean.translation_errors(poses), 2.0 * clean.lengths)


def test_crossings_are_interpolated() -> None:
    def curve(*means: float) -> Curve:
        return Curve(distances=np.array([2.0, 4.0, 8.0]), means=np.array(means))

    assert curve(0.1, 0.2, 0.6).rises_over(0.3) == pytest.approx(5.0)
    assert curve(0.1, 0.2, 0.6).rises_over(0.05) == 2.0
    assert curve(0.1, 0.2, 0.6).rises_over(0.7) == np.inf
    assert curve(0.1, 0.5, 0.3).rises_over(0.25) == pytest.approx(3.0)  # as 0.1, 0.4, 0.4
    assert curve(0.1, 0.5, 0.3).rises_over(0.45) == np.inf


def test_the_papers_lines_are_quoted() -> None:
    lines = {(line.split, line.tier): line.translation.value for line in paper_lines()}
    assert lines["hotel", "ideal"] == 0.062
    assert lines["street", "tracked"] == 0.101
    assert len(lines) == len(paper_lines()) == 7


def by_eight_points(views: Views) -> tuple[FloatArray, FloatArray]:
    """The oracle, linear in E (Longuet-Higgins): R [3, 3] and direction [3] of exact views of one trial."""
    inverse = np.linalg.inv(views.camera.intrinsics).T
    first, second = (
        np.column_stack([seen[0], np.ones(len(seen[0]))]) @ inverse for seen in (views.first, views.second)
    )
    products = (second[:, :, None] * first[:, None, :]).reshape(len(first), 9)
    left, _, right = np.linalg.svd(np.linalg.svd(products)[2][-1].reshape(3, 3))
    left, right = left * np.linalg.det(left), right * np.linalg.det(right)
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    best, most = (np.eye(3), np.zeros(3)), -1
    for turn in (left @ quarter @ right, left @ quarter.T @ right):
        for shift in (left[:, 2], -left[:, 2]):
            turned = first @ turn.T  # λ₂ second = λ₁ turned + shift, both λ above 0
            across = np.cross(turned, second)
            ahead = np.sum(np.cross(second, shift) * across, axis=1) / np.sum(across**2, axis=1)
            other = np.sum(np.cross(turned, shift) * across, axis=1) / np.sum(across**2, axis=1)
            if (count := int(np.sum((ahead > 0.0) & (other > 0.0)))) > most:
                best, most = (turn, -turn.T @ shift), count
    return best


def test_nearly_exact_points_give_the_true_pose() -> None:
    views = draw_views(Setting(noise=1e-6), 6.0, 12, 0)
    poses = five_point(views, 0)
    errors = views.translation_errors(poses)
    found = np.flatnonzero(errors < 1e-4)
    assert len(found) >= 10  # a sample of five points has several matrices, and another one may explain most points
    assert errors.max() < 0.05
    for trial in found:
        parts = {name: value[trial : trial + 1] for name, value in vars(views).items() if name != "camera"}
        rotation, direction = by_eight_points(Views(camera=views.camera, **parts))
        np.testing.assert_allclose(poses.rotation[trial], rotation, atol=1e-3)
        np.testing.assert_allclose(poses.direction[trial], direction, atol=1e-2)


def test_the_answer_is_the_same_every_time() -> None:
    views = draw_views(Setting(), 20.0, 8, 0)
    poses = five_point(views, 0)
    cv2.setRNGSeed(7)
    np.testing.assert_array_equal(five_point(views, 0).direction, poses.direction)


def test_too_few_points_have_no_answer() -> None:
    views = draw_views(Setting(points=4), 6.0, 3, 0)
    poses = five_point(views, 0)
    assert not poses.direction.any()
    np.testing.assert_allclose(views.translation_errors(poses), views.lengths)
