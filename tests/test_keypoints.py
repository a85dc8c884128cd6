"""The five-point method against an independent one, its figures, and the study and its command as a user sees them."""

import csv
import io
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.cli.test_cli import run
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.reproduction.keypoints.figure import NAME, keypoints_csv, keypoints_report, keypoints_values
from vbbench.reproduction.keypoints.five_point import ANY_DISTANCE, OPENCVS, Method, five_point
from vbbench.reproduction.keypoints.people import People, measured_lines
from vbbench.reproduction.keypoints.picture import drawn_lines
from vbbench.reproduction.keypoints.study import (
    FIVE_POINT,
    FROM_TRUTH,
    LEAST_SQUARES,
    Keypoints,
    KeypointsStudy,
    measure_keypoints,
    rotation_errors,
    translation_errors,
)
from vbbench.reproduction.keypoints.views import Setting, Views, draw_views
from vbbench.reproduction.making import Making

PEOPLE = People(splits=("demo", "hotel"), solvers=("vb-cv",), tiers=("noisy",), protocols=("one-step",), every=4)
STUDY = KeypointsStudy(distances=(2.0, 6.0, 20.0), trials=12, people=PEOPLE)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("keypoints") / "figure"


@pytest.fixture(scope="module")
def found(out: Path) -> Keypoints:
    """Without any recording on the machine."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(out.with_name("cache")))
        patch.setenv("VBBENCH_DATA", str(out.with_name("data")))
        return measure_keypoints(STUDY, out)


def written(folder: Path) -> dict[str, int]:
    return {str(path): path.stat().st_mtime_ns for path in folder.rglob("*.parquet")}


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
    poses = five_point(views, Method(threshold=1e-7, reach=ANY_DISTANCE), 0)
    assert translation_errors(views, poses, views.lengths).max() < 1e-6
    assert rotation_errors(views, poses).max() < 1e-6
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
    assert not poses.answered.any()
    np.testing.assert_allclose(translation_errors(views, poses, views.lengths), views.lengths)


@pytest.mark.slow
def test_figures(found: Keypoints) -> None:
    """Golden: mean errors in m of 12 trials at 2, 6 and 20 m; OpenCV's versions may differ in which sample is best."""
    means = {name: errors.translation.mean(axis=1) for name, errors in found.errors.items()}
    np.testing.assert_allclose(means[FIVE_POINT], GOLDEN[FIVE_POINT], rtol=0.1)
    np.testing.assert_allclose(means[LEAST_SQUARES], GOLDEN[LEAST_SQUARES], rtol=0.1)
    np.testing.assert_allclose(means[FROM_TRUTH], GOLDEN[FROM_TRUTH], rtol=0.02)
    assert means[FIVE_POINT][0] < 0.1
    assert found.unanswered == 0


GOLDEN = {
    FIVE_POINT: (0.0235, 0.0584, 0.264),
    LEAST_SQUARES: (0.00656, 0.01533, 0.0813),
    FROM_TRUTH: (0.00492, 0.01533, 0.0812),
}


@pytest.mark.slow
def test_trials_do_not_depend_on_processes(found: Keypoints, tmp_path: Path, no_data: Path) -> None:
    study = KeypointsStudy(distances=(2.0, 6.0), trials=12, people=People(splits=(), solvers=("cv",)))
    again = measure_keypoints(study, tmp_path / "out", Making(jobs=2))
    for name, errors in again.errors.items():
        np.testing.assert_array_equal(errors.translation, found.errors[name].translation[:2])
        np.testing.assert_array_equal(errors.rotation, found.errors[name].rotation[:2])


def test_people_who_are_missing_are_said_to_be(found: Keypoints) -> None:
    (ours,) = (line for line in found.lines if not line.is_papers)
    assert (ours.split, ours.tier, ours.solver, ours.protocol) == ("demo", "noisy", "vb-cv", "one-step")
    assert 0.0 < ours.translation.value < 1.0
    assert ours.sequences > 0
    hotel, kitti = found.missing
    assert "vbbench fetch hotel" in hotel
    assert "kitti, footage: " in kitti
    facts = keypoints_report(found).facts
    assert facts[-1].splitlines() == [f"- missing: {one}" for one in found.missing]


def test_a_folder_that_is_named_must_hold_kitti(tmp_path: Path) -> None:
    with pytest.raises(VbbenchError):
        measured_lines(People(splits=(), kitti=tmp_path / "nothing"), tmp_path / "out", Making())


def test_the_report_says_what_was_found(found: Keypoints) -> None:
    report = keypoints_report(found)
    distances, lines, readings = report.tables
    mean = found.errors[FIVE_POINT].translation.mean(axis=1)
    assert [row[0] for row in distances.rows] == ["2", "6", "20"]
    assert [row[1] for row in distances.rows] == [f"{one:.3f}" for one in mean]
    assert len(lines.rows) == len(found.lines) == 8
    assert {len(row) for row in lines.rows} == {len(lines.head)}
    assert len(readings.rows) == 1 + len(found.readings)
    assert {len(row) for table in report.tables for row in table.rows} <= {len(table.head) for table in report.tables}
    assert f"a mean error of {mean[0]:.3f} m at 2 m (wanted: at most 0.1), {mean[1]:.3f} m at 6 m" in report.markdown
    values = json.loads(json.dumps(keypoints_values(found), allow_nan=False))
    assert values["estimators"][FIVE_POINT]["translation"]["mean"] == pytest.approx(mean.tolist())
    assert len(values["lines"]) == len(found.lines)


def test_every_error_is_in_the_csv(found: Keypoints) -> None:
    rows = list(csv.DictReader(io.StringIO(keypoints_csv(found))))
    assert len(rows) == 3 * 3 * 12
    own = [float(row["translation"]) for row in rows if (row["estimator"], row["distance"]) == (FIVE_POINT, "6.0")]
    np.testing.assert_allclose(own, found.errors[FIVE_POINT].translation[1], rtol=1e-5)


def test_pictures_have_a_box_a_distance_and_every_line(found: Keypoints) -> None:
    pictures = keypoints_report(found).pictures
    upper, lower = pictures[""].axes
    for axes, kind in ((upper, "translation"), (lower, "rotation")):
        medians = np.median(getattr(found.errors[FIVE_POINT], kind), axis=1)
        drawn = [line.get_ydata() for line in axes.lines if len(line.get_ydata()) == 2]
        for median in medians:
            assert any(np.allclose(ends, median) for ends in drawn)
        assert len(axes.texts) == len(drawn_lines(found)) == 5
    names = [label.get_text() for label in pictures["readings"].axes[0].get_yticklabels()]
    assert names == [one.reading.name for one in found.readings]


@pytest.mark.slow
def test_what_is_there_is_used_again(found: Keypoints, out: Path, no_data: Path) -> None:
    before = written(out)
    again = measure_keypoints(STUDY, out)
    assert written(out) == before != {}
    assert again.lines == found.lines


@pytest.mark.slow
def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], no_data: Path) -> None:
    place = tmp_path / "out"
    asked = ["--trials", 2, "--split", "demo", "--tier", "ideal", "--solver", "cv", "--every", 12]
    command = ["reproduce", "figure-keypoints", "--out", place, *asked]
    status, printed, _ = run(capsys, *command)
    assert status == 0
    assert printed.startswith((place / f"{NAME}.md").read_text("utf-8"))
    for ending in (".png", "-readings.png", ".csv", ".json"):
        assert (place / f"{NAME}{ending}").stat().st_size > 1000
    status, _, said = run(capsys, *command, "--focal", 0)
    assert status == 2
    assert "focal" in said
