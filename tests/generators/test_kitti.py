"""Split kitti: poses, places and boxes from the official files; every fault named by file and row."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.lib.kitti_files import FRAMES, Drive, write_kitti
from vbbench.cli import main
from vbbench.errors import FileError, SourceMissingError, VbbenchError, VbbenchWarning
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import describe
from vbbench.files.generate_command import generate_command
from vbbench.files.verification import verify
from vbbench.generation.datasets import write_dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.geometry import relative_to_world, world_to_relative
from vbbench_generators.footage.kitti.labels import WALKERS, read_labels
from vbbench_generators.footage.kitti.split import KittiSplit, kitti
from vbbench_generators.footage.split import Recordings


def read(source: Path | None, **asked: Any) -> Recordings:
    return kitti.recordings(Options(source=source, footage=FootageOptions(**asked)))


def straightened(positions: Any, poses: Any) -> Any:
    """Positions as seen from the first pose: the same whatever the world's axes are."""
    return world_to_relative(positions, np.broadcast_to(poses[0], (len(positions), 3)))


def test_poses_and_places_are_those_that_the_files_were_made_from(tmp_path: Path) -> None:
    drive = Drive()
    (one,) = read(write_kitti(tmp_path / "training", drive=drive)).footage
    assert one.poses is not None
    assert one.scene is not None
    np.testing.assert_allclose(
        one.poses[:, :2] - one.poses[0, :2], (drive.poses() - drive.poses()[0])[:, :2], atol=1e-4
    )
    np.testing.assert_allclose(one.poses[:, 2], drive.poses()[:, 2], atol=1e-6)
    np.testing.assert_allclose(one.scene.positions, drive.people, atol=1e-3)
    np.testing.assert_allclose(one.scene.heights, 1.7)
    assert (one.name, one.dt, one.frames, one.tracks.tolist()) == ("0003", 0.1, FRAMES, [10, 11, 12, 13, 14])


def test_boxes_are_where_a_level_camera_sees_people_but_for_its_sway(tmp_path: Path) -> None:
    (one,) = read(write_kitti(tmp_path / "training", drive=Drive(sway=0.0))).footage
    assert one.poses is not None
    assert one.scene is not None
    heights = np.broadcast_to(one.scene.heights, one.visible.shape)
    again = one.camera.project(world_to_relative(one.scene.positions, one.poses), heights)
    seen = ~np.isnan(one.boxes[..., 2]) & ~np.isnan(again[..., 2])
    cut = np.abs(one.boxes[..., 1] + 0.5 * one.boxes[..., 2] - 375.0) < 1.0
    assert seen.sum() > 300
    np.testing.assert_allclose(one.boxes[seen & ~cut], again[seen & ~cut], atol=1.5)


def test_some_places_that_are_not_in_their_boxes_are_told_of(tmp_path: Path) -> None:
    lines = [aside(line) if n % 40 == 7 else line for n, line in enumerate(Drive().labels())]
    training = write_kitti(tmp_path / "training", label_02=lines)
    with pytest.warns(
        VbbenchWarning, match=r"line \d+: the labelled place is at .* px, outside its box, as are \d\.\d% of"
    ):
        read(training)


def aside(line: str) -> str:
    """A label whose place is 20 m to the right."""
    cells = line.split(" ")
    cells[13] = str(float(cells[13]) + 20.0)
    return " ".join(cells)


def test_one_label_without_a_place_costs_no_height(tmp_path: Path) -> None:
    lines = Drive().labels()
    first = next(n for n, line in enumerate(lines) if line.split()[2] in WALKERS)
    lines[first] = " ".join([*lines[first].split()[:13], "-1000", "-1000", "-1000", *lines[first].split()[16:]])
    (one,) = read(write_kitti(tmp_path / "training", label_02=lines)).footage
    assert one.scene is not None
    assert np.isfinite(one.scene.heights).all()


def test_the_folder_may_be_training_its_parent_or_in_the_data_folder(tmp_path: Path, no_data: Path) -> None:
    with pytest.raises(SourceMissingError, match=r"name with --source the folder with training/label_02.*cvlibs"):
        read(None)
    training = write_kitti(no_data / "kitti" / "training")
    read_ones = [read(place).definition["files"] for place in (training, training.parent, None)]
    assert read_ones[0] == read_ones[1] == read_ones[2]
    assert [name for name, _ in read_ones[0]] == ["labels/0003", "calibration/0003", "oxts/0003"]
    with pytest.raises(FileError, match="holds no label_02"):
        read(tmp_path / "nothing")


def test_sequences_are_as_long_as_is_asked(tmp_path: Path, capsys: Any) -> None:
    training = write_kitti(tmp_path / "training")
    asked = ["generate", "kitti", "--source", str(training), "--every", "2", "--options"]
    for longest, frames in ((25, [25, 25, 10]), (60, [60])):
        assert main([*asked, f"longest={longest}", "--out", str(tmp_path / str(longest))]) == 0
        made = Dataset(tmp_path / str(longest))
        assert [one.frames for one in made.sequences()] == frames
        facts = json.loads((made.folder / "dataset.json").read_text("utf-8"))
        assert f"--every 2 --longest {longest} --out again" in generate_command(facts, "again")
    assert main([*asked, "longest=3", "--out", str(tmp_path / "none")]) == 2
    assert "longest must be" in capsys.readouterr().err


def test_the_command_in_a_dataset_names_all_that_was_read(tmp_path: Path) -> None:
    training, out = write_kitti(tmp_path / "training"), tmp_path / "d"
    poses = f"--poses {tmp_path / 'poses'}"
    asked = ["--source", str(training), *poses.split(), "--cyclists"]
    assert main(["generate", "kitti", *asked, "--out", str(out)]) == 0
    facts = json.loads((out / "dataset.json").read_text("utf-8"))
    command = generate_command(facts, str(tmp_path / "again"))
    assert "--poses FOLDER --cyclists" in command
    command = command.replace("--source FOLDER", f"--source {training}").replace("--poses FOLDER", poses)
    assert main(command.split()[1:]) == 0
    assert Dataset(tmp_path / "again").info.id == Dataset(out).info.id


def test_a_dataset_is_made_solved_and_every_4th_frame_kept(tmp_path: Path, capsys: Any) -> None:
    training = write_kitti(tmp_path / "training")
    out = tmp_path / "d"
    assert main(["generate", "kitti", "--source", str(training), "--out", str(out)]) == 0
    dataset = Dataset(out)
    assert (dataset.info.dt, dataset.info.truth, len(dataset)) == (pytest.approx(0.4), "whole", 1)
    assert dataset.info.height_mean == pytest.approx(1.72 * 1.03, abs=0.005)
    assert "as written" in verify(out)
    assert "parked cars (1) move" in describe(dataset.info)
    assert main(["solve", str(out), "--solver", "cv", "--protocol", "rollout", "--out", str(tmp_path / "a")]) == 0
    assert main(["score", str(tmp_path / "a"), "--dataset", str(out), "--json"]) == 0


def test_classes_are_people_on_foot_and_seated_and_cyclists_if_asked_for(tmp_path: Path) -> None:
    lines = Drive().labels()
    kinds = {10: "Person", 11: "Person_sitting", 12: "Cyclist"}
    for track, kind in kinds.items():
        lines = [re.sub(rf"^(\d+ {track}) Pedestrian", rf"\1 {kind}", line) for line in lines]
    training = write_kitti(tmp_path / "training", label_02=lines)
    assert read(training).footage[0].tracks.tolist() == [10, 11, 13, 14]
    assert read(training, cyclists=True).footage[0].tracks.tolist() == [10, 11, 12, 13, 14]
    assert read(training).definition != read(training, cyclists=True).definition


def test_what_is_hidden_or_cut_is_less_visible(tmp_path: Path) -> None:
    lines = Drive().labels()
    levels = {(0, 10): "1 2", (0, 11): "0 1", (0, 12): "2 0", (0, 13): "0 3"}
    for (frame, track), level in levels.items():
        lines = [re.sub(rf"^({frame} {track} Pedestrian) 0 0", rf"\1 {level}", line) for line in lines]
    (one,) = read(write_kitti(tmp_path / "training", label_02=lines)).footage
    assert one.visible[0] == pytest.approx([0.3 * 0.75, 0.7, 0.5, 0.5, 1.0])


def test_people_without_a_place_have_boxes_and_no_truth(tmp_path: Path) -> None:
    unknown = r"\1 -1 -1 -1 -1000 -1000 -1000 -10"
    lines = [re.sub(r"^(\d+ 10 Pedestrian( \S+){7}) .*", unknown, line) for line in Drive().labels()]
    (one,) = read(write_kitti(tmp_path / "training", label_02=lines)).footage
    positions, _ = one.positions()
    assert np.isnan(positions[:, 0]).all()
    assert not np.isnan(one.boxes[:, 0]).all()
    assert not np.isnan(positions[0, 1:]).any()


def test_pictures_are_shown_and_give_the_size(tmp_path: Path) -> None:
    training = write_kitti(tmp_path / "{odd}" / "training")
    folder = training / "image_02" / "0003"
    folder.mkdir(parents=True)
    Image.new("RGB", (1250, 380)).save(folder / "000000.png")
    dataset = write_dataset(kitti.plan(Options(source=training)), tmp_path / "d")
    pictures = dataset.info.pictures[0]
    assert pictures is not None
    assert pictures.path(3) == folder.absolute() / f"{4 * 3 + dataset.sequence(0).first_frame * 4:06d}.png"
    assert dataset.info.camera.picture_size == (1250, 380)
    (folder / "000000.png").write_text("no picture")
    with pytest.raises(FileError, match=r"000000.png: is no picture"):
        read(training)


def test_without_pictures_the_size_follows_from_the_focal_length_or_holds_all_boxes(tmp_path: Path) -> None:
    training = write_kitti(tmp_path / "training")
    assert read(training).footage[0].camera.picture_size == (1242, 375)
    path = training / "calib" / "0003.txt"
    path.write_text(path.read_text().replace("721.5377", "721.9"))
    width, height = read(training).footage[0].camera.picture_size
    assert 500 < width <= 1242
    assert 200 < height <= 375


Change = Callable[[list[str]], list[str]]


def changed(pattern: str, by: str, line: int | None = None) -> Change:
    def change(lines: list[str]) -> list[str]:
        return [re.sub(pattern, by, text) if line in (None, number) else text for number, text in enumerate(lines, 1)]

    return change


@pytest.mark.parametrize(
    ("folder", "change", "message"),
    [
        ("label_02", changed(r" -1.5$", "", 4), r"label_02/0003.txt, line 4: 16 columns with blanks between, wanted"),
        (
            "label_02",
            changed(r"Pedestrian", "Pedestrain", 4),
            r"line 4: class is 'Pedestrain'; did you mean 'Pedestrian",
        ),
        ("label_02", changed(r" 1\.7 ", " tall ", 3), r"line 3: height is 'tall'; write a number"),
        ("label_02", changed(r"^0 ", "0.5 ", 2), r"line 2: 0.5 is no frame: those are whole numbers"),
        ("label_02", changed(r"^0 11", "0 10", 2), r"line 2: track 10 has a box in frame 0 already, in line 1"),
        ("label_02", changed(r"Pedestrian 0 0", "Pedestrian 0 7", 2), r"line 2: occluded is 7; levels are 0 to 3"),
        (
            "label_02",
            changed(r"(Pedestrian 0 0 0.1) (\S+) (\S+)", r"\1 1300 \3", 2),
            r"line 2: the box is -\S+ x \S+ px",
        ),
        (
            "label_02",
            changed(r"(Pedestrian 0 0 0.1 \S+ \S+) \S+", r"\1 1300", 2),
            r"line 2: the box .* reaches beyond pictures of 1242 x 375 px, as KITTI's are where the focal",
        ),
        (
            "label_02",
            changed(r"(.* Pedestrian.*) (\S+) (\S+) (\S+) -1.5", r"\1 \4 \2 \3 -1.5"),
            r"line 1: the labelled place is .*, outside its box, as are \d+% of \d+: x, y, z are right, down and forw",
        ),
        ("label_02", changed(r" 1\.7 ", " 17 ", 3), r"line 3: the height is 17 m, which no person's is"),
        (
            "label_02",
            changed(r"(.* Pedestrian.*) (\S+) (\S+) (\S+) -1.5", r"\1 5e8 \3 \4 -1.5", 2),
            r"line 2: the place is 5e\+08",
        ),
        (
            "label_02",
            changed(r"(.* Pedestrian.*) (\S+) -1.5", r"\1 -\2 -1.5", 2),
            r"line 2: z is -\S+ m, behind the cam",
        ),
        (
            "oxts",
            lambda lines: [re.sub("^49", "50", line) if n > 40 else line for n, line in enumerate(lines)],
            r"line 42: the camera is 1\d\d,\d+ m from where the line before has it",
        ),
        (
            "oxts",
            changed(r"^((\S+ ){5})\S+", r"\1 90", 7),
            r"line 7: yaw is 90 rad, more than a full turn; is it in deg",
        ),
        (
            "poses",
            changed(r"\S+$", "1000", 9),
            r"poses/0003.txt, line 9: the camera is \S+ m from where the line before",
        ),
        ("oxts", lambda lines: lines[:-3], r"oxts/0003.txt, line 117: has 117 lines, but labels go on to frame 119"),
        ("oxts", changed(r" 0.5 $", "", 7), r"oxts/0003.txt, line 7: 29 columns with blanks between, wanted 30: lat l"),
        ("oxts", changed(r"^49", "149", 7), r"line 7: lat is 149.*°; the map ends at 85°"),
        ("oxts", lambda lines: [], r"oxts/0003.txt: is empty; it should hold GPS/IMU"),
        ("calib", lambda lines: lines[:-1], r"calib/0003.txt: lacks Tr_imu_velo; download"),
        ("calib", changed(r"\S+$", "", 2), r"line 2: R_rect has 8 numbers, not 9"),
        ("calib", changed(r"R_rect \S+", "R_rect 0.1", 2), r"line 2: R_rect is no rotation"),
        ("calib", changed(r"721.5377", "0", 1), r"line 1: P2 has focal lengths 0 and 0 px; they are above 0"),
        ("calib", changed(r"721.5377", "90000", 1), r"0003.txt: P2 has focal lengths 90000 and 90000 px, for pictures"),
        ("poses", changed(r" \S+$", "", 9), r"poses/0003.txt, line 9: 11 columns with blanks between, wanted 12"),
        ("poses", changed(r"^\S+", "3", 9), r"poses/0003.txt, line 9: columns .* are no rotation"),
        ("poses", lambda lines: lines[:50], r"poses/0003.txt, line 50: has 50 lines, but labels go on to frame 119"),
    ],
)
def test_faults_are_told_on_one_line_with_file_and_row(
    tmp_path: Path, folder: str, change: Change, message: str
) -> None:
    training = write_kitti(tmp_path / "training")
    path = (tmp_path if folder == "poses" else training) / folder / "0003.txt"
    path.write_text("\n".join(change(path.read_text().splitlines())) + "\n")
    with pytest.raises(FileError, match=message) as caught:
        read(training, poses=tmp_path / "poses" if folder == "poses" else None)
    assert "\n" not in str(caught.value)


def test_names_of_sequences_are_known_and_the_nearest_is_suggested(tmp_path: Path) -> None:
    training = write_kitti(tmp_path / "training")
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


def test_spaces_line_ends_and_blank_lines_do_not_matter(tmp_path: Path) -> None:
    lines = Drive().labels()
    plain = read_labels(write_kitti(tmp_path / "a" / "training") / "label_02" / "0003.txt")
    for dressed in ("  ".join, lambda cells: " ".join(cells) + " \r", lambda cells: " ".join(cells) + "\n"):
        path = tmp_path / "0003.txt"
        path.write_text("\n".join(dressed(line.split()) for line in lines))
        again = read_labels(path)
        for name in ("frame", "track", "kind", "boxes", "places", "height"):
            np.testing.assert_array_equal(getattr(plain, name), getattr(again, name))
    assert len(plain.of(WALKERS)) > 300


@pytest.fixture
def recordings_of_kitti(data_folder: Path) -> Path:
    folder = data_folder / "kitti"
    if not (folder / "training" / "label_02" / "0019.txt").is_file():
        pytest.skip("no KITTI: put your download in the folder 'kitti' of $VBBENCH_DATA, see docs/kitti.md")
    return folder


def test_the_figures_of_real_recordings(recordings_of_kitti: Path) -> None:
    asked = FootageOptions(poses=recordings_of_kitti / "poses", sequences=("0015", "0017", "0019"))
    found = kitti.recordings(Options(source=recordings_of_kitti, footage=asked))
    assert found.definition["poses"] == {"0015": "oxts", "0017": "poses", "0019": "poses"}
    assert found.calibration is not None
    cars = {name: facts["parked_cars"] for name, facts in found.calibration["sequences"].items()}
    assert 0.15 < np.min(cars["0015"]["oxts"]["moved"]) < 0.2
    assert 0.3 < np.min(cars["0019"]["oxts"]["moved"]) < 0.35
    assert np.max(cars["0019"]["oxts"]["moved"]) > 3.0
    assert np.max(cars["0019"]["poses"]["moved"]) < 1.1
    sizes = {one.name: one.camera.picture_size for one in found.footage}
    assert sizes == {"0015": (1224, 370), "0017": (1224, 370), "0019": (1238, 374)}
    for one in found.footage:
        assert one.scene is not None
        assert 1.65 < np.median(one.scene.heights[one.scene.heights > 1.4]) < 1.85  # who is lower sits


def test_the_runs_of_pedestrians_in_0019(recordings_of_kitti: Path) -> None:
    asked = FootageOptions(poses=recordings_of_kitti / "poses", sequences=("0019",))
    plan = KittiSplit(classes=("Pedestrian",)).plan(Options(source=recordings_of_kitti, footage=asked))
    built = [plan.build(index) for index in range(len(plan))]
    way = [np.linalg.norm(one.truth.poses[-1, :2] - one.truth.poses[0, :2]) for one in built]
    people = [one.sequence.observed.sum(axis=1).mean() for one in built]
    assert (len(plan), round(float(np.mean(way))), round(float(np.mean(people)))) == (6, 24, 7)
    assert max(len(one.sequence.observations) for one in built) == 40


def test_labelled_places_project_into_their_boxes(recordings_of_kitti: Path) -> None:
    (one,) = kitti.recordings(Options(source=recordings_of_kitti, footage=FootageOptions(sequences=("0017",)))).footage
    assert one.scene is not None
    assert one.poses is not None
    relative = world_to_relative(one.scene.positions, one.poses)
    heights = np.broadcast_to(one.scene.heights, one.visible.shape)
    seen = (one.visible == 1.0) & (relative[..., 1] > 5.0)
    apart = (one.camera.project(relative, heights)[..., 0] - one.boxes[..., 0])[seen] / one.boxes[..., 2][seen]
    assert np.nanmedian(np.abs(apart)) < 0.06
    np.testing.assert_allclose(relative_to_world(relative, one.poses), one.scene.positions)


def test_what_is_said_of_many_sequences_is_short(tmp_path: Path) -> None:
    training = tmp_path / "training"
    for number in range(12):
        write_kitti(training, name=f"{number:04d}")
    calibration = read(training).calibration
    assert calibration is not None
    assert calibration["summary"].startswith("poses of 12 sequences; in 12 parked cars check them, and move 0.00 m")
    assert len(calibration["sequences"]) == 12
    json.dumps(calibration)


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
