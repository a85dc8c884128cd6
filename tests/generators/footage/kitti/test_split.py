"""Split kitti: poses and places from the official files, poses checked by parked cars, and boxes of trackers."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.lib.kitti_files import FRAMES, Drive, boxes_of, mot, write_kitti
from vbbench.cli import main
from vbbench.errors import FileError, SourceMissingError, VbbenchError, VbbenchWarning
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import describe
from vbbench.files.generate_command import generate_command
from vbbench.files.verification import verify
from vbbench.generation.datasets import write_dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.geometry import world_to_relative
from vbbench.sequence import NOBODY
from vbbench_generators.footage.kitti import WALKERS
from vbbench_generators.footage.kitti.split import KittiSplit, kitti

LABELLED = boxes_of(Drive().labels())


def read(source, **asked):
    return kitti.recordings(Options(source=source, footage=FootageOptions(**asked)))


def found_in(training, text, **asked):
    """Recordings with the boxes of a detector or tracker, and what is said of these."""
    folder = training.parent / "boxes"
    folder.mkdir(exist_ok=True)
    (folder / "0003.txt").write_text(text)
    recordings = read(training, boxes=folder, **asked)
    return recordings, recordings.calibration["sequences"]["0003"]["boxes"]


@pytest.fixture
def training(tmp_path):
    return write_kitti(tmp_path / "training")


def test_the_folder_may_be_training_its_parent_or_in_the_data_folder(tmp_path, no_data):
    with pytest.raises(SourceMissingError, match=r"name with --source the folder with training/label_02.*cvlibs"):
        read(None)
    training = write_kitti(no_data / "kitti" / "training")
    first, second, third = (read(place).definition["files"] for place in (training, training.parent, None))
    assert first == second == third
    assert [name for name, _ in first] == ["labels/0003", "calibration/0003", "oxts/0003"]
    with pytest.raises(FileError, match="holds no label_02"):
        read(tmp_path / "nothing")
    (training / "label_02" / "0003.txt").unlink()
    with pytest.raises(FileError, match="label_02: holds no labels; they are called 0000"):
        read(training)


def test_the_command_in_a_dataset_names_all_that_was_read(training, tmp_path):
    out, poses = tmp_path / "d", f"--poses {tmp_path / 'poses'}"
    asked = ["--source", str(training), *poses.split(), "--cyclists"]
    assert main(["generate", "kitti", *asked, "--out", str(out)]) == 0
    dataset = Dataset(out)
    assert (dataset.info.dt, dataset.info.truth, len(dataset)) == (pytest.approx(0.4), "whole", 1)
    assert dataset.info.height_mean == pytest.approx(1.72 * 1.03, abs=0.005)
    assert "as written" in verify(out)
    assert "parked cars (1) move" in describe(dataset.info)
    command = generate_command(json.loads((out / "dataset.json").read_text("utf-8")), str(tmp_path / "again"))
    assert "--poses FOLDER --cyclists" in command
    command = command.replace("--source FOLDER", f"--source {training}").replace("--poses FOLDER", poses)
    assert main(command.split()[1:]) == 0
    assert Dataset(tmp_path / "again").info.id == dataset.info.id


def test_classes_are_people_on_foot_and_seated_and_cyclists_if_asked_for(tmp_path):
    lines = Drive().labels()
    for track, kind in {10: "Person", 11: "Person_sitting", 12: "Cyclist"}.items():
        lines = [re.sub(rf"^(\d+ {track}) Pedestrian", rf"\1 {kind}", line) for line in lines]
    training = write_kitti(tmp_path / "training", label_02=lines)
    on_foot, every = read(training), read(training, cyclists=True)
    assert on_foot.footage[0].tracks.tolist() == [10, 11, 13, 14]
    assert every.footage[0].tracks.tolist() == [10, 11, 12, 13, 14]
    assert on_foot.definition != every.definition


def test_pictures_are_shown_and_give_the_size(tmp_path):
    training = write_kitti(tmp_path / "{odd}" / "training")
    folder = training / "image_02" / "0003"
    folder.mkdir(parents=True)
    Image.new("RGB", (1250, 380)).save(folder / "000000.png")
    dataset = write_dataset(kitti.plan(Options(source=training)), tmp_path / "d")
    first = dataset.sequence(0).first_frame
    assert dataset.info.pictures[0].path(3) == folder.absolute() / f"{4 * 3 + first * 4:06d}.png"
    assert dataset.info.camera.picture_size == (1250, 380)
    (folder / "000000.png").write_text("no picture")
    with pytest.raises(FileError, match=r"000000.png: is no picture"):
        read(training)


def test_without_pictures_the_size_follows_from_the_focal_length_or_holds_all_boxes(training):
    assert read(training).footage[0].camera.picture_size == (1242, 375)
    path = training / "calib" / "0003.txt"
    path.write_text(path.read_text().replace("721.5377", "721.9"))
    width, height = read(training).footage[0].camera.picture_size
    assert 500 < width <= 1242
    assert 200 < height <= 375


def test_names_of_sequences_are_known_and_the_nearest_is_suggested(training, tmp_path):
    write_kitti(training, name="0015")
    assert [one.name for one in read(training).footage] == ["0003", "0015"]
    assert [one.name for one in read(training, sequences=("0015",)).footage] == ["0015"]
    with pytest.raises(VbbenchError, match=r"is called '0051'; did you mean '0015'\?"):
        read(training, sequences=("0051",))
    with pytest.raises(VbbenchError, match="is one file; name a folder with a file for each sequence"):
        read(training, poses=tmp_path / "poses" / "0003.txt")
    (tmp_path / "poses" / "0015.txt").unlink()
    with pytest.raises(FileError, match=r"0015.txt: is missing"):
        read(training, poses=tmp_path / "poses")


def test_what_is_said_of_many_sequences_is_short(tmp_path):
    for number in range(12):
        write_kitti(tmp_path / "training", name=f"{number:04d}")
    calibration = read(tmp_path / "training").calibration
    assert calibration["summary"].startswith("poses of 12 sequences; in 12 parked cars check them, and move 0.00 m")
    assert len(calibration["sequences"]) == 12
    json.dumps(calibration)


@pytest.mark.parametrize("source", ["oxts", "poses"])
def test_poses_and_places_are_those_that_the_files_were_made_from(tmp_path, source):
    """Poses of other programs are the same way in the axes of the first picture."""
    drive = Drive(sway=0.0)
    training = write_kitti(tmp_path / "training", drive=drive)
    recordings = read(training, poses=None if source == "oxts" else tmp_path / "poses")
    (one,) = recordings.footage
    assert recordings.definition["poses"] == {"0003": source}
    assert (one.name, one.dt, one.frames, one.tracks.tolist()) == ("0003", 0.1, FRAMES, [10, 11, 12, 13, 14])
    np.testing.assert_allclose(
        straightened(one.poses, one.poses), straightened(drive.poses(), drive.poses()), atol=1e-4
    )
    expected = straightened(drive.people, drive.poses())
    np.testing.assert_allclose(straightened(one.scene.positions, one.poses), expected, atol=1e-3)
    turned = [np.unwrap(poses[:, 2]) - poses[0, 2] for poses in (one.poses, drive.poses())]
    np.testing.assert_allclose(*turned, atol=1e-5)
    np.testing.assert_allclose(one.scene.heights, 1.7)
    if source == "oxts":
        np.testing.assert_allclose(one.poses[:, 2], drive.poses()[:, 2], atol=1e-6)
        return
    assert np.abs(one.poses[0]).max() < 0.1


def straightened(places, poses):
    """Places [T, (K,) 2 or 3] as seen from the first pose: the same whatever the world's axes are."""
    places = places[..., :2].reshape(len(poses), -1, 2)
    return world_to_relative(places, np.broadcast_to(poses[0], (len(poses), 3)))


@pytest.mark.parametrize("worse", ["oxts", "poses"])
def test_the_poses_that_keep_parked_cars_in_place_are_taken_and_both_figures_stated(tmp_path, worse):
    drive, drifting = Drive(), Drive()
    drifting.motions[:, :2, 3] += np.linspace(0.0, 1.5, FRAMES)[:, None] * [0.6, 0.8]
    lines = {"oxts": drifting.oxts(), "poses": drifting.pose_lines()}[worse]
    training = write_kitti(tmp_path / "training", drive=drive, **{worse: lines})
    recordings = read(training, poses=tmp_path / "poses")
    better = {"oxts": "poses", "poses": "oxts"}[worse]
    assert recordings.definition["poses"] == {"0003": better}
    figures = recordings.calibration["sequences"]["0003"]["parked_cars"]
    assert figures[worse]["moved"][0] == pytest.approx(1.2, abs=0.1)  # of 1.5 m, between two fifths of the way
    assert figures[better]["moved"][0] < 0.01
    names = {"oxts": "oxts", "poses": "your files"}
    pattern = rf"poses from {names[better]}: parked cars \(1\) move 0.00 m .* 1.2\d m by {names[worse]}"
    assert re.search(pattern, recordings.calibration["summary"])


def test_cars_that_drive_are_not_taken_for_parked_ones(tmp_path):
    drive = Drive()
    drive.car = drive.car + np.linspace(0.0, 20.0, FRAMES)[:, None, None] * np.array([0.0, 1.0])
    recordings = read(write_kitti(tmp_path / "training", drive=drive))
    assert "no parked car to check them by" in str(recordings.calibration)


def test_poses_that_move_otherwise_than_oxts_are_named(tmp_path):
    drive = Drive()
    tenth = np.array([np.fromstring(line, sep=" ") for line in drive.pose_lines()])
    tenth[:, 3::4] *= 0.1
    without_car = [line for line in drive.labels() if line.split()[2] in WALKERS]
    lines = {"label_02": without_car, "poses": [" ".join(map(str, row)) for row in tenth.tolist()]}
    training = write_kitti(tmp_path / "training", drive=drive, **lines)
    with pytest.warns(VbbenchWarning, match=r"0003.txt: in a second these poses and those of oxts move 3\.\d\d m and"):
        read(training, poses=tmp_path / "poses")


def test_oxts_may_be_missing_where_poses_are_given(training, tmp_path):
    (training / "oxts" / "0003.txt").unlink()
    assert read(training, poses=tmp_path / "poses").definition["poses"] == {"0003": "poses"}
    with pytest.raises(FileError, match=r"oxts/0003.txt: is missing; it holds GPS/IMU"):
        read(training)


def test_poses_of_another_length_than_oxts_are_refused(tmp_path):
    short = [line for line in Drive().labels() if int(line.split()[0]) < 100]
    training = write_kitti(tmp_path / "training", label_02=short, poses=Drive().pose_lines()[:110])
    with pytest.raises(FileError, match=r"poses/0003.txt: has 110 lines, and 0003.txt of oxts 120: every frame needs"):
        read(training, poses=tmp_path / "poses")


def strayed(boxes, track, frames):
    """The boxes, those of a track in the first frames 300 px to the right of the person."""
    return [
        (f, t, left + 300.0 * (t == track and f < frames), top, right + 300.0 * (t == track and f < frames), bottom)
        for f, t, left, top, right, bottom in boxes
    ]


def test_false_alarms_stay_in_tracks_of_people_and_tracks_of_nobody_are_removed_and_counted(training):
    stranger = [(f, 99, 30.0 + f, 300.0, 60.0 + f, 360.0) for f in range(30)]
    recordings, figures = found_in(training, mot([*strayed(LABELLED, 10, 5), *stranger]))
    (one,) = recordings.footage
    assert 99 not in one.tracks.tolist()
    assert (one.persons[:5, 0] == NOBODY).all()
    assert not np.isnan(one.boxes[:5, 0]).any()
    assert figures["dropped"] == 30
    assert (recordings.pixel_std, recordings.definition["least_overlap"]) == (5.0, 0.3)
    assert "30 boxes of tracks of nobody removed" in str(recordings.calibration)


def test_few_matched_boxes_are_warned_of(training):
    with pytest.warns(VbbenchWarning, match=r"0003.txt: only 180 of 600 labelled boxes .* \(recall 0.3"):
        found_in(training, mot([box for box in LABELLED if box[0] < 36]))


def test_false_alarms_where_nobody_is_are_removed_without_complaint(training):
    write_kitti(training, label_02=[line for line in Drive().labels() if "Pedestrian" not in line])
    recordings, figures = found_in(training, mot(LABELLED, linked=False))
    assert len(recordings.footage[0].tracks) == figures["tracked"]["labelled"] == 0
    with pytest.raises(VbbenchError, match="frames in a row"):
        kitti.plan(Options(source=training))


def test_boxes_of_other_frames_are_named(training):
    """As where a text counts from 0 and has no boxes in frame 0."""
    with pytest.warns(VbbenchWarning, match=r"0003.txt: boxes overlap people one frame later by 1.00, now by 0.\d\d"):
        found_in(training, mot([(f - 1, *rest) for f, *rest in LABELLED if f > 0]))


@pytest.fixture
def recordings_of_kitti(data_folder: Path) -> Path:
    folder = data_folder / "kitti"
    if not (folder / "training" / "label_02" / "0019.txt").is_file():
        pytest.skip("no KITTI: put your download in the folder 'kitti' of $VBBENCH_DATA, see docs/kitti.md")
    return folder


def test_the_figures_of_real_recordings(recordings_of_kitti):
    names = ("0015", "0017", "0019")
    found = read(recordings_of_kitti, poses=recordings_of_kitti / "poses", sequences=names)
    assert found.definition["poses"] == {"0015": "oxts", "0017": "poses", "0019": "poses"}
    cars = {name: facts["parked_cars"] for name, facts in found.calibration["sequences"].items()}
    assert 0.15 < np.min(cars["0015"]["oxts"]["moved"]) < 0.2
    assert 0.3 < np.min(cars["0019"]["oxts"]["moved"]) < 0.35
    assert np.max(cars["0019"]["oxts"]["moved"]) > 3.0
    assert np.max(cars["0019"]["poses"]["moved"]) < 1.1
    assert [one.camera.picture_size for one in found.footage] == [(1224, 370), (1224, 370), (1238, 374)]
    for one in found.footage:
        assert 1.65 < np.median(one.scene.heights[one.scene.heights > 1.4]) < 1.85  # who is lower sits


def test_the_runs_of_pedestrians_in_0019(recordings_of_kitti):
    asked = FootageOptions(poses=recordings_of_kitti / "poses", sequences=("0019",))
    plan = KittiSplit(classes=("Pedestrian",)).plan(Options(source=recordings_of_kitti, footage=asked))
    built = [plan.build(index) for index in range(len(plan))]
    way = [np.linalg.norm(one.truth.poses[-1, :2] - one.truth.poses[0, :2]) for one in built]
    people = [one.sequence.observed.sum(axis=1).mean() for one in built]
    assert (len(plan), round(float(np.mean(way))), round(float(np.mean(people)))) == (6, 24, 7)
    assert max(len(one.sequence.observations) for one in built) == 40


def test_a_real_detectors_recall_precision_and_overlap(recordings_of_kitti):
    asked = FootageOptions(boxes=recordings_of_kitti / "detections", sequences=("0019",))
    found = KittiSplit(classes=("Pedestrian",)).recordings(Options(source=recordings_of_kitti, footage=asked))
    boxes = found.calibration["sequences"]["0019"]["boxes"]
    detected = [boxes["detected"][name] for name in ("recall", "precision", "overlap")]
    assert detected == pytest.approx([0.80, 0.74, 0.66], abs=0.01)
    assert boxes["tracked"]["recall"] > 0.75
