"""The split jrdb: the sample, the official layout, the robot's motion from its bag."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.lib.jrdb_recording import Files, Robot, each_label, edit, recording
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation.datasets import write_dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.geometry import motion_between, relative_to_world, world_to_relative, wrap_angle
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_generators.footage.jrdb import CAMERA, direction_errors
from vbbench_generators.footage.jrdb.split import STANDING, find_recordings, jrdb, read_recording

SAMPLE = "bytes-cafe-2019-02-07_0"
rosbags = pytest.mark.extra("rosbags")


@pytest.fixture(scope="module")
def files() -> Files:
    return recording(robot=Robot(gyro_offset=0.12, picture_offset=-0.08))


@pytest.fixture
def root(files: Files, tmp_path: Path) -> Path:
    return files.write(tmp_path / "jrdb")


@pytest.fixture
def sample(data_folder: Path) -> Path:
    path = data_folder / "jrdb" / f"{SAMPLE}.csv"
    if not path.is_file():
        pytest.skip("no JRDB sample: see docs/jrdb.md")
    return path


def made(folder, source, **asked):
    return write_dataset(jrdb.plan(Options(source=source, footage=FootageOptions(**asked))), folder)


def read(source, **asked):
    """The recordings, and what is said of the first of them."""
    found = jrdb.recordings(Options(source=source, footage=FootageOptions(**asked)))
    return found, found.calibration["recordings"][0]


def poses_in_scene(dataset, sequence):
    """[T, 3] the true poses from where the recording began, in m and rad."""
    return dataset.world(sequence).poses_in_scene(dataset.truth(sequence).poses)


def people_of(dataset, sequence):
    """[K] the labelled person behind each track, who is the same in every frame."""
    return dataset.track_persons(sequence).max(axis=0)


def test_the_panorama_runs_clockwise_from_behind_to_023_rad(sample):
    """REAL figures: .023 rad (1.4826 times the median deviation), nothing systematic; rows to 5 % of a box's height."""
    (found,) = find_recordings(sample)
    there = read_recording(found)
    beside = direction_errors(there)
    assert len(beside) == 6547
    assert abs(np.median(beside)) < 0.006
    assert 1.4826 * np.median(np.abs(beside - np.median(beside))) == pytest.approx(0.023, abs=0.001)
    boxes, places = there.boxes, np.stack([-there.places[..., 1], there.places[..., 0]], axis=-1)
    heights = np.broadcast_to(there.heights, boxes.shape[:2])
    expected = CAMERA.project_unbounded(places, heights)
    tall = np.abs(boxes[..., 2] / expected[..., 2] - 1.0) < 0.07
    rows = ((boxes[..., 1] - expected[..., 1]) / boxes[..., 2])[tall]
    assert np.median(np.abs(rows)) < 0.03
    assert abs(np.median(rows)) < 0.02


def test_the_sample_is_a_dataset_whose_robot_stands(sample, tmp_path, recwarn):
    dataset = made(tmp_path / "d", sample)
    assert not [one for one in recwarn if "overlap people" in str(one.message)]
    assert (len(dataset), dataset.info.truth, dataset.info.dt) == (8, "whole", pytest.approx(0.4))
    sequence = dataset.sequence(0)
    np.testing.assert_allclose(poses_in_scene(dataset, sequence), 0.0, atol=1e-9)
    assert sequence.given.odometry is None
    verify(tmp_path / "d")
    with pytest.raises(VbbenchError, match="boxes are 6 frames of 15 Hz apart; use `every` 6 or a multiple"):
        made(tmp_path / "e", sample, every=4)


@pytest.mark.slow
def test_a_recording_without_a_bag_is_relative_and_its_places_are_those_around_the_robot(files, root, tmp_path):
    dataset = made(tmp_path / "d", root, every=1)
    assert dataset.info.truth == "relative"
    assert "dx_rel" in str(dataset.info.caution)
    expected = world_to_relative(files.positions, files.drive.poses(files.frames))
    for sequence in dataset.sequences():
        truth, people = dataset.relative_truth(sequence), people_of(dataset, sequence) - 1
        places = expected[sequence.first_frame : sequence.first_frame + sequence.frames, people]
        seen = sequence.observed
        np.testing.assert_allclose(truth[seen], places[seen], atol=1e-9)
        again = CAMERA.project(places, np.broadcast_to(files.heights[people], places.shape[:2]))
        np.testing.assert_allclose(sequence.observations[seen], again[seen], atol=1e-6)
    answer = solve(dataset, "tests.lib.made_footage:Still", "cold-start", tmp_path / "a")
    metrics = score(answer, tmp_path / "d").values()["metrics"]
    assert [name for name, figure in metrics.items() if figure["mean"] is not None] == ["dx_rel"]


@pytest.mark.parametrize("place", ["", "train_dataset_with_activity", "train_dataset"])
def test_the_folder_may_be_the_one_above(files, tmp_path, place):
    files.write(tmp_path / "jrdb" / place)
    assert [one.name for one in find_recordings(tmp_path / "jrdb")] == [files.name]


def test_hidden_people_are_not_seen_and_partly_hidden_ones_are_marked(files, root):
    def hide(values):
        for label in each_label(values):
            if label["label_id"] == "pedestrian:1":
                label["attributes"]["occlusion"] = "Fully_occluded"
            elif label["label_id"] == "pedestrian:3":
                label |= {"label_id": "car:3", "box": [1, 1, 5, 5]}

    files.edit(root, "labels_2d", hide)
    (one,) = read(root)[0].footage
    assert {1, 3}.isdisjoint(one.tracks)
    assert 2 in one.tracks
    assert set(np.unique(one.visible[one.observed])) == {0.75, 1.0}


@pytest.mark.slow
def test_interpolated_boxes_can_be_left_out(root, tmp_path):
    """In the made-up recording these are the boxes of all odd frames."""
    whole, by_hand = made(tmp_path / "d", root, every=2), made(tmp_path / "e", root, every=2, interpolated=False)
    assert whole.info.id != by_hand.info.id
    np.testing.assert_array_equal(whole.sequence(0).observations, by_hand.sequence(0).observations)
    assert len(made(tmp_path / "f", root, every=6)) > 0
    with pytest.raises(VbbenchError, match="use `every` 2 or a multiple"):
        made(tmp_path / "g", root, every=3, interpolated=False)


def test_boxes_by_hand_need_not_begin_with_the_first_picture(files, root):
    def later(values):
        for frame, labels in enumerate(values["labels"].values()):
            for label in labels:
                label["attributes"]["interpolated"] = frame % 6 != 3

    files.edit(root, "labels_2d", later)
    assert read(root, interpolated=False)[0].footage[0].observed.any()


def test_pictures_are_named_where_they_are(files, tmp_path):
    root = files.write(tmp_path / "jrdb{x}")
    (root / "images/image_stitched" / files.name).mkdir(parents=True)
    (one,) = read(root)[0].footage
    assert one.pictures.path(7) == root.resolve() / "images/image_stitched" / files.name / "000007.jpg"


def test_a_missing_frame_is_a_gap_and_not_a_leap_in_time(files, root, tmp_path):
    for kind in ("pictures", "clouds"):
        files.edit(root, kind, lambda values: values["data"].pop(30))
    for kind, name in (("labels_2d", "000030.jpg"), ("labels_3d", "000030.pcd")):
        files.edit(root, kind, lambda values, name=name: values["labels"].pop(name))  # type: ignore[misc]
    dataset = made(tmp_path / "d", root, every=1)
    bounds = [(one.first_frame, one.first_frame + one.frames) for one in dataset.sequences()]
    assert bounds[0] == (0, 30)
    assert bounds[1][0] == 31


@pytest.mark.slow
def test_recordings_that_stand_have_poses_and_others_take_them_away(files, root, tmp_path):
    assert SAMPLE in STANDING
    for kind in ("2d_stitched", "3d"):
        folder = root / f"labels/labels_{kind}"
        shutil.copy(folder / f"{files.name}.json", folder / f"{SAMPLE}.json")
    shutil.copytree(root / "timestamps" / files.name, root / "timestamps" / SAMPLE)
    mixed = made(tmp_path / "d", root)
    assert mixed.info.truth == "relative"
    assert f"it is known of {SAMPLE}: name these with --sequences" in str(mixed.info.caution)
    assert len(mixed.info.scenes) == 2
    assert made(tmp_path / "e", root, sequences=(SAMPLE,)).info.truth == "whole"


@rosbags
def test_from_boxes_and_bag_to_scores(files, root, tmp_path, capsys):
    """The whole way on the command line: truth to 3 % of the way, though clocks differ by .1 s and wheels slip."""
    bags = files.write_bag(tmp_path / "bags")
    out = tmp_path / "d"
    asked = ["--source", str(root), "--options", f"bags={bags}", "--every", "6"]
    assert main(["generate", "jrdb", *asked, "--out", str(out)]) == 0
    assert "m driven, the end known to" in capsys.readouterr().out
    dataset = Dataset(out)
    verify(out)
    assert dataset.info.truth == "whole"
    offsets = dataset.info.calibration["recordings"][0]["clock_offsets"]
    assert offsets["gyro"] == pytest.approx(0.12, abs=0.015)
    assert offsets["pictures"] == pytest.approx(-0.08, abs=0.015)
    truth = files.drive.poses(files.frames)
    for sequence in dataset.sequences():
        frames = 6 * np.arange(sequence.first_frame, sequence.first_frame + sequence.frames)
        away = poses_in_scene(dataset, sequence)[:, :2] - truth[frames, :2]
        assert np.linalg.norm(away, axis=1).max() < 0.03 * files.drive.distance
        people = people_of(dataset, sequence) - 1
        places = world_to_relative(files.positions[frames], truth[frames])[:, people]
        found, seen = dataset.truth(sequence), sequence.observed
        np.testing.assert_allclose(found.positions[seen], relative_to_world(places, found.poses)[seen], atol=1e-6)
        odometry, moved = sequence.given.odometry, motion_between(truth[frames[:-1]], truth[frames[1:]])
        np.testing.assert_allclose(odometry.motions[1:, 0], moved[:, 0], atol=0.06)
        np.testing.assert_allclose(odometry.motions[1:, 2], wrap_angle(moved[:, 2]), atol=0.05)
        assert (np.linalg.eigvalsh(odometry.covariances[1:]) > 0.0).all()
    for solver, protocol in (("cv", "sequential"), ("tests.lib.made_footage:Still", "cold-start")):
        figures = score(solve(dataset, solver, protocol, tmp_path / protocol), out).values()["metrics"]
        assert figures["dx"]["mean"] is not None
        assert figures["dt"]["mean"] is not None


@pytest.mark.slow
@rosbags
@pytest.mark.parametrize(
    "changes",
    [
        {"wheels": "/segway/odometry/local_filtered", "imu": None},
        {"poses_only": True},
        {"upside_down": True},
        {"imu": "segway/feedback/ext_imu"},
    ],
    ids=["filtered odometry alone", "poses without speeds", "IMU upside down", "the other IMU"],
)
def test_bags_differ(files, root, tmp_path, changes):
    (one,) = read(root, bags=files.write_bag(tmp_path / "bags", **changes))[0].footage
    away = one.poses[:, :2] - files.drive.poses(files.frames)[:, :2]
    limit = 0.1 if changes.get("imu", "") is None else 0.03
    assert np.linalg.norm(away, axis=1).max() < limit * files.drive.distance


@pytest.mark.parametrize("place", ["odometry", "odometry/train", "../odometry/test", "../processed/odometry_train"])
def test_odometry_as_json_next_to_the_labels_is_the_robots_way(files, tmp_path, place):
    root = files.write(tmp_path / "train_dataset")
    files.write_odometry(root / place)
    (one,) = read(root)[0].footage
    truth = files.drive.poses(files.frames)
    assert one.known == "whole"
    np.testing.assert_allclose(one.poses[:, :2], truth[:, :2], atol=0.01)
    np.testing.assert_allclose(wrap_angle(one.poses[:, 2] - truth[:, 2]), 0.0, atol=0.01)
    np.testing.assert_allclose(one.odometry.motions[1:], motion_between(truth[:-1], truth[1:]), atol=0.01)


def late_odometry(values):
    names, poses = list(values["odometry"]), list(values["odometry"].values())
    values["odometry"] = dict(zip(names, poses[:1] * 15 + poses[:-15], strict=True))


def test_odometry_a_second_late_is_named(files, root, tmp_path):
    folder = files.write_odometry(tmp_path / "elsewhere/train")
    edit(folder / f"{files.name}.json", late_odometry)
    with pytest.warns(VbbenchWarning, match=r"people turn around the robot -(0\.9|1\.0)\d s after its poses"):
        found, _ = read(root, bags=folder.parent)
    assert found.footage[0].known == "whole"


def later_clouds(values):
    for row in values["data"]:
        row["pointclouds"][0]["timestamp"] += 1.0


def later_places(values):
    labels = values["labels"]
    names = sorted(labels)
    values["labels"] = {name: labels[old] for name, old in zip(names[15:], names, strict=False)}


@pytest.mark.parametrize(
    ("kind", "change"),
    [("clouds", later_clouds), ("labels_3d", later_places)],
    ids=["by their time stamps", "by their frames"],
)
def test_places_a_second_late_are_named(files, root, kind, change):
    files.edit(root, kind, change)
    with pytest.warns(VbbenchWarning, match=r"boxes overlap people 15 frames later by 0.90, now by 0.\d\d"):
        read(root)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda v: v["000002.pcd"]["position"].pop("y"), "000002.pcd is .*'position' with numbers x, y, z"),
        (lambda v: v["000000.pcd"]["orientation"].update(w=7.0), "000000.pcd: the orientation's .* have length"),
        (lambda v: v.update({"7": v["000000.pcd"]}), "key '7' of 'odometry' is not the name of a frame"),
        (lambda v: [one["orientation"].update(x=1.0, z=0.0, w=0.0) for one in v.values()], "is not upright"),
        (dict.clear, "has poses of 0 of the point clouds"),
        (lambda v: [one["position"].update(x=1000.0 * one["position"]["x"]) for one in v.values()], "are in m"),
        (lambda v: [one["orientation"].update(z=-one["orientation"]["z"]) for one in v.values()], "the other way"),
    ],
)
def test_what_odometry_cannot_hold(files, root, tmp_path, change, said):
    path = files.write_odometry(tmp_path / "odometry") / f"{files.name}.json"
    edit(path, lambda values: change(values["odometry"]))
    with pytest.raises(FileError, match=said):
        read(root, bags=path)


def test_results_of_two_trackers_are_paired_by_direction(files, tmp_path):
    """People who stand in the same direction cannot be distinguished; all others have their own places."""
    found, _ = read(files.write_results(tmp_path / "tracks"))
    (one,) = found.footage
    assert one.known == "relative"
    assert "results of two trackers" in str(found.caution)
    expected = world_to_relative(files.positions, files.drive.poses(files.frames))[:, one.tracks - 1]
    away = np.linalg.norm(one.positions()[0] - expected, axis=-1)[one.observed]
    assert (away < 1e-4).mean() > 0.9
    assert set(np.unique(one.visible[one.observed])) == {0.75}


@pytest.mark.parametrize(
    ("folder", "row", "said"),
    [
        ("tracks_2d", "0 1 Pedestrian 0 0 -1 5 5 0 9 -1 -1 -1 -1 -1 -1 -1 1", "line 1: its box is 0 px wide and 9"),
        ("tracks_2d", "0 1 Pedestrian 0 0 -1 5 5 9", "line 1: 9 columns with blanks between, wanted 18"),
        ("tracks_3d", "0 1 Pedestrian 0 0 -1 -1 -1 -1 -1 2000 1 2 .9 1.7 .5 0 1", "line 1: the place is 2000 m away"),
        ("tracks_3d", "0 1 Pedestrian 0 0 -1 -1 -1 -1 -1 1 1 2 .9 17 .5 0 1", "line 1: h is 17; people are up to"),
        ("tracks_3d", 2 * "0 1 Pedestrian 0 0 -1 -1 -1 -1 -1 1 1 2 .9 1.7 .5 0 1\n", "line 2: id 1 stands in frame 0"),
    ],
)
def test_what_results_cannot_hold(files, tmp_path, folder, row, said):
    root = files.write_results(tmp_path / "tracks")
    (root / folder / f"{files.name}.txt").write_text(row)
    with pytest.raises(FileError, match=said):
        read(root)


def test_results_of_real_trackers(data_folder):
    """REAL: seven recordings of the test set; half of the boxes and more have a place, .01 to .03 rad beside it."""
    root = data_folder / "jrdb_tracks"
    if not root.is_dir():
        pytest.skip("no results of trackers on JRDB: see docs/jrdb.md")
    found, _ = read(root, sequences=("0000", "0010"))
    assert [one.known for one in found.footage] == ["relative", "relative"]
    for one, facts in zip(found.footage, found.calibration["recordings"], strict=True):
        assert facts["columns_beside_places"] < 0.03
        assert (~np.isnan(one.positions()[0][..., 0])).sum() > 0.5 * one.observed.sum()


@rosbags
def test_drivers_that_were_started_again_change_nothing(files, root, tmp_path):
    (once,), (twice,) = (
        read(root, bags=files.write_bag(tmp_path / str(restarted), restarted=restarted))[0].footage
        for restarted in (False, True)
    )
    np.testing.assert_array_equal(twice.poses, once.poses)
    np.testing.assert_array_equal(twice.odometry.motions, once.odometry.motions)
    assert np.isnan(once.odometry.motions[0]).all()
    turned = wrap_angle(np.diff(once.poses[:, 2]))
    assert np.abs(once.odometry.motions[1:, 2] - turned).max() > 1e-3, "odometry is by the wheels alone"


def test_boxes_of_every_third_picture_are_linked_though_scores_are_unknown(root, files, tmp_path):
    """Boxes as JRDB has them, some of them across the seam."""
    labelled = read_recording(find_recordings(root)[0])
    slot, column = np.nonzero(~np.isnan(labelled.boxes[..., 2]))
    kept = (slot % 3 == 0) | (slot == 40)  # and one picture more
    slot, column = slot[kept], column[kept]
    frames = labelled.grid.frames[np.searchsorted(labelled.grid.slots, slot)]
    boxes = labelled.rectangles[slot, column] + np.array([1.0, 1.0, 0.0, 0.0])
    boxes[:, 0] += np.where(boxes[:, 0] < 0.5 * CAMERA.width, CAMERA.width, 0.0) * (column % 2)
    rows, path = np.insert(boxes, [0, 0, 4], -1, axis=1), tmp_path / f"{files.name}.txt"
    rows[:, 0] = frames + 1
    np.savetxt(path, rows, delimiter=",", fmt="%.3f")
    _, facts = read(root, boxes=path)
    assert facts["detected"]["recall"] == 1.0
    assert facts["tracked"]["recall"] > 0.9
    assert facts["tracked"]["precision"] > 0.99


def test_results_of_a_tracker_on_labelled_pictures(root, files, tmp_path):
    """Frames count from 0 in them, and boxes have widths and heights where KITTI has the far corner."""
    _, facts = read(root, boxes=files.write_results(tmp_path / "results") / "tracks_2d")
    assert facts["tracked"] == {**facts["tracked"], "recall": 1.0, "precision": 1.0, "overlap": 1.0}
