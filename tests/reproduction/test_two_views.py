"""Static points seen by two cameras: what is drawn, the five-point method, least squares, its bound, crossings."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from vbbench.camera import PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.paper import the_paper
from vbbench.reproduction.agreement import Estimate
from vbbench.reproduction.keypoints import DISTANCES, Curve, KeypointsStudy, all_readings, paper_lines
from vbbench.reproduction.two_views import (
    OPENCVS,
    Method,
    Poses,
    Setting,
    Views,
    better_fit,
    bound,
    draw_views,
    five_point,
    pinhole,
    refined,
    sampson,
)

PLAIN = Setting()
EXACT = replace(PLAIN, noise=0.0)


def one_trial(views: Views, trial: int) -> Views:
    here = slice(trial, trial + 1)
    parts = {name: value[here] for name, value in vars(views).items() if name != "camera"}
    return Views(camera=views.camera, **parts)


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


def test_the_study_is_the_papers() -> None:
    study, paper = KeypointsStudy(), the_paper().keypoints
    assert study.trials == paper.trials == 100
    assert (study.distances[0], study.distances[-1]) == paper.distances == (2.0, 40.0)
    assert study.distances == DISTANCES
    setting = study.setting
    assert sorted(setting.voxel) == sorted(paper.voxel) == [5.0, 10.0, 20.0]
    assert (setting.points, setting.rotation, setting.translation, setting.noise) == (100, 0.2, 1.0, 1.0)


@pytest.mark.parametrize("from_centre", [False, True])
def test_points_fill_the_voxel_as_far_as_both_cameras_see_it(from_centre: bool) -> None:
    views = draw_views(replace(EXACT, from_centre=from_centre), 12.0, 200, 0)
    points = triangulated(views)[views.lengths > 0.1]
    right, down, forward = np.moveaxis(points, -1, 0)
    nearest = 12.0 - (5.0 if from_centre else 0.0)
    assert forward.min() == pytest.approx(nearest, abs=0.1)
    assert forward.max() == pytest.approx(nearest + 10.0, abs=0.1)
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
    space = draw_views(replace(PLAIN, in_space=True, at_bound=True), 30.0, 50, 1)
    np.testing.assert_allclose(space.lengths, 1.0)
    np.testing.assert_allclose(Rotation.from_matrix(space.rotation).magnitude(), 0.2)
    assert np.abs(space.centre[:, 1]).max() > 0.5


def test_noise_is_uniform_and_changes_nothing_else() -> None:
    noisy, clean = draw_views(PLAIN, 6.0, 40, 2), draw_views(EXACT, 6.0, 40, 2)
    np.testing.assert_array_equal(noisy.rotation, clean.rotation)
    np.testing.assert_array_equal(noisy.centre, clean.centre)
    moved = np.stack([noisy.first - clean.first, noisy.second - clean.second])
    assert np.abs(moved).max() <= 1.0
    assert moved.std() == pytest.approx(1.0 / np.sqrt(3.0), rel=0.02)
    assert not np.array_equal(noisy.first, draw_views(PLAIN, 6.0, 40, 3).first)


def test_which_points_count() -> None:
    seen, front, everywhere = (
        draw_views(replace(EXACT, counted=counted, from_centre=counted == "all"), 2.0, 30, 0)
        for counted in ("seen", "in front", "all")
    )
    known = ~np.isnan(seen.first[..., 0])
    assert 10 < known.sum(axis=1).min() < known.sum(axis=1).max() < 100
    inside = np.all((front.first >= 0.0) & (front.first < (1280, 720)), axis=-1)
    assert 0.2 < inside.mean() < 0.8
    assert not np.isnan(everywhere.first).any()
    assert np.abs(sampson(everywhere, everywhere.truth)).max() < 1e-6  # mirrored points lie on their lines, too


def test_a_camera_that_sees_nothing_is_a_mistake() -> None:
    with pytest.raises(VbbenchError, match="does not see the voxel at 2 m; give one with a wider field of view"):
        draw_views(replace(PLAIN, camera=pinhole(4, 4, 50_000.0)), 2.0, 2, 0)
    with pytest.raises(VbbenchError, match="focal"):
        pinhole(640, 480, 0.0)


def test_sampsons_distance_is_how_far_pixels_must_move() -> None:
    """The oracle: the four coordinates of every pair moved as little as possible so that their rays meet."""
    views = one_trial(draw_views(replace(PLAIN, points=6), 8.0, 3, 0), 1)
    camera = views.camera.intrinsics

    def moved(points: FloatArray) -> FloatArray:
        first = points.reshape(-1, 3)
        both = (first, (first - views.centre[0]) @ views.rotation[0].T)
        pixels = [(one @ camera.T)[:, :2] / one[:, 2:] for one in both]
        return np.concatenate([pixels[0] - views.first[0], pixels[1] - views.second[0]], axis=1)

    start = triangulated(draw_views(replace(EXACT, points=6), 8.0, 3, 0))[1]
    best = least_squares(lambda points: moved(points).ravel(), start.ravel(), xtol=1e-14, ftol=1e-14)
    distances = np.linalg.norm(moved(best.x), axis=1)
    np.testing.assert_allclose(np.abs(sampson(views, views.truth))[0], distances, rtol=0.01, atol=1e-4)


def moved_pose(own: Views, values: FloatArray) -> Poses:
    """The true pose of one trial, turned by three numbers, its direction moved by two."""
    axes = np.linalg.svd(own.truth.direction)[2]
    direction = own.truth.direction[0] + values[3:] @ axes[1:]
    turned = own.rotation[0] @ Rotation.from_rotvec(values[:3]).as_matrix()
    return Poses(rotation=turned[None], direction=(direction / np.linalg.norm(direction))[None])


@pytest.mark.parametrize("distance", [4.0, 12.0])
def test_least_squares_finds_what_scipy_finds(distance: float) -> None:
    views = draw_views(replace(PLAIN, points=40), distance, 6, 0)
    found = refined(views, views.truth)
    for trial in range(6):
        own = one_trial(views, trial)
        best = least_squares(lambda values, own=own: sampson(own, moved_pose(own, values))[0], np.zeros(5), method="lm")
        assert np.sum(sampson(views, found)[trial] ** 2) == pytest.approx(2.0 * best.cost, rel=1e-6)
        np.testing.assert_allclose(found.direction[trial], moved_pose(own, best.x).direction[0], atol=1e-4)


def test_near_points_are_used_up_to_the_bound() -> None:
    little = replace(PLAIN, noise=0.1)
    views = draw_views(little, 5.0, 120, 0)
    errors = views.translation_errors(refined(views, views.truth), views.lengths)
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(bound(little, 5.0, 120, 0), rel=0.15)
    assert bound(replace(PLAIN, noise=0.05), 5.0, 120, 0) == pytest.approx(0.5 * bound(little, 5.0, 120, 0))


def test_exact_views_are_solved_exactly_from_nearby() -> None:
    clean = draw_views(EXACT, 6.0, 20, 0)
    turn = Rotation.from_rotvec([0.002, -0.003, 0.001]).as_matrix()
    start = Poses(rotation=clean.rotation @ turn, direction=clean.truth.direction @ turn)
    found = refined(clean, start)
    assert clean.translation_errors(found, clean.lengths).max() < 1e-6
    assert clean.rotation_errors(found).max() < 1e-6
    chosen = better_fit(clean, start, found)
    np.testing.assert_array_equal(chosen.direction, found.direction)


def test_errors_are_angles_and_lengths() -> None:
    clean = draw_views(EXACT, 6.0, 3, 0)
    for angle in (0.0, 1e-6, 0.3, np.pi):
        turned = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix() @ clean.rotation
        poses = Poses(rotation=turned, direction=-clean.truth.direction)
        np.testing.assert_allclose(clean.rotation_errors(poses), angle, atol=1e-9)
        np.testing.assert_allclose(clean.translation_errors(poses, clean.lengths), 2.0 * clean.lengths)


def test_crossings_are_interpolated() -> None:
    def curve(*means: float) -> Curve:
        return Curve(distances=np.array([2.0, 4.0, 8.0]), errors=np.array(means)[:, None] + np.array([-0.01, 0.01]))

    assert curve(0.1, 0.2, 0.6).rises_over(0.3) == pytest.approx(5.0)
    assert curve(0.1, 0.2, 0.6).rises_over(0.05) == 2.0
    assert curve(0.1, 0.2, 0.6).rises_over(0.7) == np.inf
    assert curve(0.1, 0.5, 0.3).rises_over(0.25) == pytest.approx(3.0)  # as 0.1, 0.4, 0.4
    assert curve(0.1, 0.5, 0.3).rises_over(0.45) == np.inf


def test_intervals_cover_what_trials_and_people_leave_open() -> None:
    distances, random = np.arange(1.0, 9.0), np.random.default_rng(0)
    sure, unsure = Estimate(4.5, np.nan, np.nan), Estimate(4.5, 3.0, 6.75)
    exact = Curve(distances=distances, errors=np.repeat(distances[:, None], 5, axis=1))
    assert exact.crossing(sure) == Estimate(4.5, 4.5, 4.5)
    wide = exact.crossing(unsure)
    assert (wide.low, wide.high) == pytest.approx((3.0, 6.75), rel=0.05)
    hits = 0
    for repeat in range(40):
        noisy = Curve(distances=distances, errors=distances[:, None] + random.normal(0.0, 1.0, (8, 30)), seed=repeat)
        found = noisy.crossing(sure)
        hits += found.low <= 4.5 <= found.high
        assert found == noisy.crossing(sure)
    assert 33 <= hits <= 40


def test_the_papers_lines_are_quoted() -> None:
    lines = {(line.split, line.tier): line.translation.value for line in paper_lines()}
    assert lines["hotel", "ideal"] == 0.062
    assert lines["street", "tracked"] == 0.101
    assert len(lines) == len(paper_lines()) == 7


def test_every_reading_changes_something() -> None:
    main, *others = all_readings(PLAIN)
    assert main.setting == PLAIN
    kinds = {(repr(one.setting), one.method, one.unit_length) for one in (main, *others)}
    assert len(kinds) == len({one.name for one in (main, *others)}) == 1 + len(others)


def test_the_camera_is_the_one_of_the_other_splits() -> None:
    assert Setting().camera == PerspectiveCamera() == pinhole(1280, 720, 640.0)


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


@pytest.mark.parametrize("in_space", [False, True])
def test_exact_points_give_the_true_pose(in_space: bool) -> None:
    views = draw_views(Setting(in_space=in_space, noise=0.0), 6.0, 12, 0)
    poses = five_point(views, Method(threshold=1e-7, reach=1e9), 0)
    assert views.translation_errors(poses, views.lengths).max() < 1e-6
    assert views.rotation_errors(poses).max() < 1e-6
    for trial in range(12):
        parts = {name: value[trial : trial + 1] for name, value in vars(views).items() if name != "camera"}
        rotation, direction = by_eight_points(Views(camera=views.camera, **parts))
        np.testing.assert_allclose(poses.rotation[trial], rotation, atol=1e-6)
        np.testing.assert_allclose(poses.direction[trial], direction, atol=1e-6)


def test_opencv_is_called_as_it_is_and_gives_the_same_every_time() -> None:
    views = draw_views(Setting(), 20.0, 8, 0)
    poses = five_point(views, OPENCVS, 0)
    for trial, (first, second) in enumerate(zip(views.first, views.second, strict=True)):
        matrix, agree = cv2.findEssentialMat(first, second, views.camera.intrinsics)
        _, rotation, shift, _ = cv2.recoverPose(matrix, first, second, views.camera.intrinsics, mask=agree)
        np.testing.assert_allclose(poses.rotation[trial], rotation, atol=1e-12)
        np.testing.assert_allclose(poses.direction[trial], -(rotation.T @ shift)[:, 0], atol=1e-12)
    cv2.setRNGSeed(7)
    np.testing.assert_array_equal(five_point(views, OPENCVS, 0).direction, poses.direction)


def test_too_few_points_have_no_answer() -> None:
    views = draw_views(Setting(points=4), 6.0, 3, 0)
    poses = five_point(views, OPENCVS, 0)
    assert not poses.direction.any()
    np.testing.assert_allclose(views.translation_errors(poses, views.lengths), views.lengths)
