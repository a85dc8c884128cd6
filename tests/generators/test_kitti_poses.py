"""Where KITTI's camera was: by oxts, or by anybody's poses, whichever keep parked cars in their places."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.generators.test_kitti import read, straightened
from tests.lib.kitti_files import FRAMES, Drive, write_kitti
from vbbench.errors import FileError, VbbenchWarning
from vbbench_generators.footage.kitti.labels import WALKERS


def test_poses_of_others_are_the_same_way_in_the_axes_of_the_first_picture(tmp_path: Path) -> None:
    drive = Drive(sway=0.0)
    training = write_kitti(tmp_path / "training", drive=drive)
    by_oxts, by_poses = read(training), read(training, poses=tmp_path / "poses")
    assert by_poses.definition["poses"] == {"0003": "poses"}
    for recordings in (by_oxts, by_poses):
        (one,) = recordings.footage
        assert one.poses is not None
        assert one.scene is not None
        expected = straightened(drive.people, drive.poses())
        np.testing.assert_allclose(straightened(one.scene.positions, one.poses), expected, atol=1e-3)
        turn = np.unwrap(one.poses[:, 2]) - one.poses[0, 2]
        np.testing.assert_allclose(turn, np.unwrap(drive.poses()[:, 2]) - drive.poses()[0, 2], atol=1e-5)
    assert np.abs(by_poses.footage[0].poses[0]).max() < 0.1  # type: ignore[index]


@pytest.mark.parametrize("worse", ["oxts", "poses"])
def test_the_poses_that_keep_parked_cars_in_place_are_taken_and_both_figures_told(tmp_path: Path, worse: str) -> None:
    drive, drifting = Drive(), Drive()
    drifting.motions[:, :2, 3] += np.linspace(0.0, 1.5, FRAMES)[:, None] * [0.6, 0.8]
    lines = {"oxts": drifting.oxts(), "poses": drifting.pose_lines()}[worse]
    training = write_kitti(tmp_path / "training", drive=drive, **{worse: lines})
    recordings = read(training, poses=tmp_path / "poses")
    better = {"oxts": "poses", "poses": "oxts"}[worse]
    assert recordings.definition["poses"] == {"0003": better}
    assert recordings.calibration is not None
    figures = recordings.calibration["sequences"]["0003"]["parked_cars"]
    assert figures[worse]["moved"][0] == pytest.approx(1.2, abs=0.1)  # of 1.5 m, between two fifths of the way
    assert figures[better]["moved"][0] < 0.01
    said = {"oxts": "oxts", "poses": "your files"}
    pattern = rf"poses from {said[better]}: parked cars \(1\) move 0.00 m .* 1.2\d m by {said[worse]}"
    assert re.search(pattern, recordings.calibration["summary"])


def test_cars_that_drive_are_not_taken_for_parked_ones(tmp_path: Path) -> None:
    drive = Drive()
    drive.car = drive.car + np.linspace(0.0, 20.0, FRAMES)[:, None, None] * np.array([0.0, 1.0])
    recordings = read(write_kitti(tmp_path / "training", drive=drive))
    assert "no parked car to check them by" in str(recordings.calibration)


def without_the_car(drive: Drive) -> list[str]:
    return [line for line in drive.labels() if line.split()[2] in WALKERS]


def scaled(line: str) -> str:
    """A pose whose place is a tenth."""
    cells = [float(cell) for cell in line.split()]
    cells[3::4] = [0.1 * cell for cell in cells[3::4]]
    return " ".join(map(str, cells))


def test_poses_that_move_otherwise_than_oxts_are_told_of(tmp_path: Path) -> None:
    drive = Drive()
    lines = {"label_02": without_the_car(drive), "poses": [scaled(line) for line in drive.pose_lines()]}
    training = write_kitti(tmp_path / "training", drive=drive, **lines)
    with pytest.warns(VbbenchWarning, match=r"0003.txt: in a second these poses and those of oxts move 3\.\d\d m and"):
        read(training, poses=tmp_path / "poses")


def test_oxts_may_be_missing_where_poses_are_given(tmp_path: Path) -> None:
    training = write_kitti(tmp_path / "training")
    (training / "oxts" / "0003.txt").unlink()
    assert read(training, poses=tmp_path / "poses").definition["poses"] == {"0003": "poses"}
    with pytest.raises(FileError, match=r"oxts/0003.txt: is missing; it holds GPS/IMU"):
        read(training)


def test_poses_of_another_length_than_oxts_are_refused(tmp_path: Path) -> None:
    short = [line for line in Drive().labels() if int(line.split()[0]) < 100]
    training = write_kitti(tmp_path / "training", label_02=short, poses=Drive().pose_lines()[:110])
    with pytest.raises(FileError, match=r"poses/0003.txt: has 110 lines, and 0003.txt of oxts 120: every frame needs"):
        read(training, poses=tmp_path / "poses")
