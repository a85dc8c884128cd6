"""The split jrdb: the sample, the official layout, the robot's motion from its bag."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.jrdb_recording import Files, Robot, edit, recording
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation.datasets import write_dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray, IntArray, motion_between, relative_to_world, world_to_relative, wrap_angle
from vbbench.scoring import score
from vbbench.sequence import Sequence
from vbbench.solving import solve
from vbbench_generators.footage.jrdb.recording import CAMERA, direction_errors
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


def made(folder: Path, source: Path, **asked: Any) -> Dataset:
    return write_dataset(jrdb.plan(Options(source=source, footage=FootageOptions(**asked))), folder)


def poses_in_scene(dataset: Dataset, sequence: Sequence) -> FloatArray:
    """[T, 3] the true poses from where the recording began, in m and rad."""
    return dataset.world(sequence).poses_in_scene(dataset.truth(sequence).poses)


def people_of(dataset: Dataset, sequence: Sequence) -> IntArray:
    """[K] the labelled person behind each track, who is the same in every frame."""
    return dataset.track_persons(sequence).max(axis=0)


def test_the_panorama_runs_clockwise_from_behind_to_023_rad(sample: Path) -> None:
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


def test_the_sample_is_a_dataset_whose_robot_stands(sample: Path, tmp_path: Path) -> None:
    dataset = made(tmp_path / "d", sample)
    assert (len(dataset), dataset.info.truth, dataset.info.dt) == (8, "whole", pytest.approx(0.4))
    assert dataset.info.counts is not None
    sequence = dataset.sequence(0)
    np.testing.assert_allclose(poses_in_scene(dataset, sequence), 0.0, atol=1e-9)
    assert sequence.given.odometry is None
    verify(tmp_path / "d")
    with pytest.raises(VbbenchError, match="boxes are 6 frames of 15 Hz apart; use `every` 6 or a multiple"):
        made(tmp_path / "e", sample, every=4)


@pytest.mark.slow
def test_a_recording_without_a_bag_is_relative_and_its_places_are_those_around_the_robot(
    files: Files, root: Path, tmp_path: Path
) -> None:
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
    answer = solve(dataset, "tests.generators.test_footage:Still", "cold-start", tmp_path / "a")
    metrics = score(answer, tmp_path / "d").values()["metrics"]
    assert [name for name, figure in metrics.items() if figure["mean"] is not None] == ["dx_rel"]


@pytest.mark.parametrize("place", ["", "train_dataset_with_activity", "train_dataset"])
def test_the_folder_may_be_the_one_above(files: Files, tmp_path: Path, place: str) -> None:
    files.write(tmp_path / "jrdb" / place)
    assert [one.name for one in find_recordings(tmp_path / "jrdb")] == [files.name]


def test_hidden_people_are_not_seen_and_partly_hidden_ones_are_marked(files: Files, root: Path, tmp_path: Path) -> None:
    def hide(values: dict[str, Any]) -> None:
        for labels in values["labels"].values():
            for label in labels:
                if label["label_id"] == "pedestrian:1":
                    label["attributes"]["occlusion"] = "Fully_occluded"
            labels.append({"label_id": "car:3", "box": [1, 1, 5, 5]})

    files.edit(root, "labels_2d", hide)
    (sequence, *_) = (dataset := made(tmp_path / "d", root)).sequences()
    assert 1 not in people_of(dataset, sequence)
    assert 2 in people_of(dataset, sequence)
    assert set(np.unique(sequence.visible[sequence.observed])) == {0.75, 1.0}


@pytest.mark.slow
def test_interpolated_boxes_can_be_left_out(root: Path, tmp_path: Path) -> None:
    """In the made-up recording these are the boxes of all odd frames."""
    whole, by_hand = made(tmp_path / "d", root, every=2), made(tmp_path / "e", root, every=2, interpolated=False)
    assert whole.info.id != by_hand.info.id
    np.testing.assert_array_equal(whole.sequence(0).observations, by_hand.sequence(0).observations)
    assert len(made(tmp_path / "f", root, every=6)) > 0
    with pytest.raises(VbbenchError, match="use `every` 2 or a multiple"):
        made(tmp_path / "g", root, every=3, interpolated=False)


def test_boxes_by_hand_need_not_begin_with_the_first_picture(files: Files, root: Path, tmp_path: Path) -> None:
    def later(values: dict[str, Any]) -> None:
        for frame, labels in enumerate(values["labels"].values()):
            for label in labels:
                label["attributes"]["interpolated"] = frame % 6 != 3

    files.edit(root, "labels_2d", later)
    assert made(tmp_path / "d", root, interpolated=False).sequence(0).observed.any()


def test_pictures_are_named_where_they_are(files: Files, tmp_path: Path) -> None:
    root = files.write(tmp_path / "jrdb{x}")
    (root / "images/image_stitched" / files.name).mkdir(parents=True)
    dataset = made(tmp_path / "d", root)
    pictures = dataset.info.pictures[0]
    assert pictures is not None
    first = dataset.sequence(0).first_frame * 6
    assert pictures.path(1) == root.resolve() / "images/image_stitched" / files.name / f"{first + 6:06d}.jpg"


def test_a_missing_frame_is_a_gap_and_not_a_leap_in_time(files: Files, root: Path, tmp_path: Path) -> None:
    for kind in ("pictures", "clouds"):
        files.edit(root, kind, lambda values: values["data"].pop(30))
    for kind, name in (("labels_2d", "000030.jpg"), ("labels_3d", "000030.pcd")):
        files.edit(root, kind, lambda values, name=name: values["labels"].pop(name))  # type: ignore[misc]
    dataset = made(tmp_path / "d", root, every=1)
    bounds = [(one.first_frame, one.first_frame + one.frames) for one in dataset.sequences()]
    assert bounds[0] == (0, 30)
    assert bounds[1][0] == 31


@pytest.mark.slow
def test_recordings_that_stand_have_poses_and_others_take_them_away(files: Files, root: Path, tmp_path: Path) -> None:
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
def test_from_boxes_and_bag_to_scores(files: Files, root: Path, tmp_path: Path, capsys: Any) -> None:
    """The whole way on the command line: truth to 3 % of the way, though clocks differ by .1 s and wheels slip."""
    bags = files.write_bag(tmp_path / "bags")
    out = tmp_path / "d"
    asked = ["--source", str(root), "--options", f"bags={bags}", "--every", "6"]
    assert main(["generate", "jrdb", *asked, "--out", str(out)]) == 0
    assert "m driven, the end known to" in capsys.readouterr().out
    dataset = Dataset(out)
    verify(out)
    assert dataset.info.truth == "whole"
    assert dataset.info.calibration is not None
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
        told, poses = dataset.truth(sequence).positions, dataset.truth(sequence).poses
        np.testing.assert_allclose(
            told[sequence.observed], relative_to_world(places, poses)[sequence.observed], atol=1e-6
        )
        odometry = sequence.given.odometry
        assert odometry is not None
        moved = world_to_relative(truth[frames[1:], None, :2], truth[frames[:-1]])[:, 0]
        np.testing.assert_allclose(odometry.motions[1:, 0], moved[:, 1], atol=0.06)
        np.testing.assert_allclose(odometry.motions[1:, 2], wrap_angle(np.diff(truth[frames, 2])), atol=0.05)
        assert (np.linalg.eigvalsh(odometry.covariances[1:]) > 0.0).all()
    for solver, protocol in (("cv", "sequential"), ("tests.generators.test_footage:Still", "cold-start")):
        answer = tmp_path / protocol
        figures = score(solve(dataset, solver, protocol, answer), out).values()["metrics"]
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
def test_bags_differ(files: Files, root: Path, tmp_path: Path, changes: dict[str, Any]) -> None:
    bags = files.write_bag(tmp_path / "bags", **changes)
    dataset = made(tmp_path / "d", root, bags=bags)
    truth = files.drive.poses(files.frames)[::6]
    poses = np.concatenate([poses_in_scene(dataset, one) for one in dataset.sequences()])
    frames = np.concatenate([one.first_frame + np.arange(one.frames) for one in dataset.sequences()])
    limit = 0.1 if changes.get("imu", "") is None else 0.03
    assert np.linalg.norm(poses[:, :2] - truth[frames, :2], axis=1).max() < limit * files.drive.distance


@pytest.mark.parametrize("place", ["odometry", "odometry/train", "../odometry/test", "../processed/odometry_train"])
def test_odometry_as_json_next_to_the_labels_is_the_robots_way(files: Files, tmp_path: Path, place: str) -> None:
    root = files.write(tmp_path / "train_dataset")
    files.write_odometry(root / place)
    (one,) = jrdb.recordings(Options(source=root)).footage
    truth = files.drive.poses(files.frames)
    assert one.known == "whole"
    assert one.poses is not None
    np.testing.assert_allclose(one.poses[:, :2], truth[:, :2], atol=0.01)
    np.testing.assert_allclose(wrap_angle(one.poses[:, 2] - truth[:, 2]), 0.0, atol=0.01)
    assert one.odometry is not None
    np.testing.assert_allclose(one.odometry.motions[1:], motion_between(truth[:-1], truth[1:]), atol=0.01)


def test_a_folder_of_bags_may_hold_odometry_as_json(files: Files, root: Path, tmp_path: Path) -> None:
    folder = files.write_odometry(tmp_path / "elsewhere/train").parent
    assert made(tmp_path / "d", root, bags=folder).info.truth == "whole"


def test_odometry_a_second_late_is_named(files: Files, root: Path, tmp_path: Path) -> None:
    path = files.write_odometry(tmp_path / "odometry") / f"{files.name}.json"

    def delay(values: dict[str, Any]) -> None:
        names, poses = list(values["odometry"]), list(values["odometry"].values())
        values["odometry"] = dict(zip(names, poses[:1] * 15 + poses[:-15], strict=True))

    edit(path, delay)
    with pytest.warns(VbbenchWarning, match=r"people turn around the robot -(0\.9|1\.0)\d s after its poses"):
        made(tmp_path / "d", root, bags=path)


def later_clouds(values: dict[str, Any]) -> None:
    for row in values["data"]:
        row["pointclouds"][0]["timestamp"] += 1.0


def later_places(values: dict[str, Any]) -> None:
    labels = values["labels"]
    names = sorted(labels)
    values["labels"] = {name: labels[old] for name, old in zip(names[15:], names, strict=False)}


@pytest.mark.parametrize(
    ("kind", "change"),
    [("clouds", later_clouds), ("labels_3d", later_places)],
    ids=["by their time stamps", "by their frames"],
)
def test_places_a_second_late_are_named(files: Files, root: Path, kind: str, change: Any) -> None:
    files.edit(root, kind, change)
    with pytest.warns(VbbenchWarning, match=r"boxes overlap people 15 frames later by 0.90, now by 0.\d\d"):
        jrdb.recordings(Options(source=root))


def test_the_samples_places_are_of_its_frames(sample: Path, recwarn: pytest.WarningsRecorder) -> None:
    jrdb.recordings(Options(source=sample))
    assert not [one for one in recwarn if "overlap people" in str(one.message)]


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
def test_what_odometry_cannot_hold(files: Files, root: Path, tmp_path: Path, change: Any, said: str) -> None:
    path = files.write_odometry(tmp_path / "odometry") / f"{files.name}.json"
    edit(path, lambda values: change(values["odometry"]))
    with pytest.raises(FileError, match=said):
        jrdb.recordings(Options(source=root, footage=FootageOptions(bags=path)))


def test_results_of_two_trackers_are_paired_by_direction(files: Files, tmp_path: Path) -> None:
    """People who stand in the same direction cannot be distinguished; all others have their own places."""
    found = jrdb.recordings(Options(source=files.write_results(tmp_path / "tracks")))
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
def test_what_results_cannot_hold(files: Files, tmp_path: Path, folder: str, row: str, said: str) -> None:
    root = files.write_results(tmp_path / "tracks")
    (root / folder / f"{files.name}.txt").write_text(row)
    with pytest.raises(FileError, match=said):
        jrdb.recordings(Options(source=root))


def test_results_of_real_trackers(data_folder: Path) -> None:
    """REAL: seven recordings of the test set; half of the boxes and more have a place, .01 to .03 rad beside it."""
    root = data_folder / "jrdb_tracks"
    if not root.is_dir():
        pytest.skip("no results of trackers on JRDB: see docs/jrdb.md")
    found = jrdb.recordings(Options(source=root, footage=FootageOptions(sequences=("0000", "0010"))))
    assert [one.known for one in found.footage] == ["relative", "relative"]
    assert found.calibration is not None
    for one, facts in zip(found.footage, found.calibration["recordings"], strict=True):
        assert facts["columns_beside_places"] < 0.03
        assert (~np.isnan(one.positions()[0][..., 0])).sum() > 0.5 * one.observed.sum()


@rosbags
def test_drivers_that_were_started_again_change_nothing(files: Files, root: Path, tmp_path: Path) -> None:
    once, twice = (
        made(tmp_path / name, root, bags=files.write_bag(tmp_path / f"{name}-bags", restarted=name == "twice"))
        for name in ("once", "twice")
    )
    for one, other in zip(once.sequences(), twice.sequences(), strict=True):
        np.testing.assert_array_equal(twice.truth(other).poses, once.truth(one).poses)
        odometry, same = one.given.odometry, other.given.odometry
        assert odometry is not None
        assert same is not None
        assert np.isnan(odometry.motions[0]).all()  # it leads from a frame that is not shown
        np.testing.assert_array_equal(same.motions, odometry.motions)


@rosbags
def test_what_the_wheels_say_is_not_the_truth_itself(files: Files, root: Path, tmp_path: Path) -> None:
    (one, *_) = (dataset := made(tmp_path / "d", root, bags=files.write_bag(tmp_path / "bags"))).sequences()
    assert one.given.odometry is not None
    turned = wrap_angle(np.diff(dataset.truth(one).poses[:, 2]))
    assert np.abs(one.given.odometry.motions[1:, 2] - turned).max() > 1e-3


def test_boxes_of_every_third_picture_are_linked_though_scores_are_unknown(
    root: Path, files: Files, tmp_path: Path
) -> None:
    """Boxes as JRDB has them, some of them across the seam."""
    labelled = read_recording(find_recordings(root)[0])
    slot, column = np.nonzero(~np.isnan(labelled.boxes[..., 2]))
    kept = (slot % 3 == 0) | (slot == 40)  # and one picture more
    slot, column = slot[kept], column[kept]
    frames = labelled.grid.frames[np.searchsorted(labelled.grid.slots, slot)]
    boxes = labelled.rectangles[slot, column] + np.array([1.0, 1.0, 0.0, 0.0])
    boxes[:, 0] += np.where(boxes[:, 0] < 0.5 * CAMERA.width, CAMERA.width, 0.0) * (column % 2)
    unknown = np.full(len(slot), -1)
    np.savetxt(
        tmp_path / f"{files.name}.txt",
        np.column_stack([frames + 1, unknown, boxes, unknown]),
        delimiter=",",
        fmt="%.3f",
    )
    facts = (made(tmp_path / "d", root, boxes=tmp_path).info.calibration or {})["recordings"][0]
    assert facts["detected"]["recall"] == 1.0
    assert facts["tracked"]["recall"] > 0.9
    assert facts["tracked"]["precision"] > 0.99


def test_results_of_a_tracker_on_labelled_pictures(root: Path, files: Files, tmp_path: Path) -> None:
    """Frames count from 0 in them, and boxes have widths and heights where KITTI has the far corner."""
    boxes = files.write_results(tmp_path / "results") / "tracks_2d"
    facts = (jrdb.recordings(Options(source=root, footage=FootageOptions(boxes=boxes))).calibration or {})["recordings"]
    assert facts[0]["tracked"] == {**facts[0]["tracked"], "recall": 1.0, "precision": 1.0, "overlap": 1.0}
