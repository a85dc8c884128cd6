"""Files of KITTI: labels and calibration, boxes in three formats; every fault is named by file and row."""

import re

import numpy as np
import pytest

from tests.generators.footage.kitti.test_split import LABELLED, found_in, read, training
from tests.lib.kitti_files import FRAMES, Drive, detections, mot, results, write_kitti
from vbbench.errors import FileError, VbbenchWarning
from vbbench.geometry import world_to_relative
from vbbench.sequence import NOBODY

__all__ = ["training"]


def edited(tmp_path, pattern, by):
    """A recording with another text in its labels."""
    lines = [re.sub(pattern, by, line) for line in Drive().labels()]
    return write_kitti(tmp_path / "training", label_02=lines)


def test_boxes_are_where_a_level_camera_sees_people_but_for_its_sway(tmp_path):
    (one,) = read(write_kitti(tmp_path / "training", drive=Drive(sway=0.0))).footage
    heights = np.broadcast_to(one.scene.heights, one.visible.shape)
    again = one.camera.project(world_to_relative(one.scene.positions, one.poses), heights)
    cut = np.abs(one.boxes[..., 1] + 0.5 * one.boxes[..., 2] - 375.0) < 1.0
    seen = ~np.isnan(one.boxes[..., 2]) & ~np.isnan(again[..., 2]) & ~cut
    assert seen.sum() > 200
    np.testing.assert_allclose(one.boxes[seen], again[seen], atol=1.5)


def test_some_places_that_are_not_in_their_boxes_are_named(tmp_path):
    """As of labels whose place is 20 m to the right."""
    lines = [line.split(" ") for line in Drive().labels()]
    for cells in lines[7::40]:
        cells[13] = str(float(cells[13]) + 20.0)
    training = write_kitti(tmp_path / "training", label_02=[" ".join(cells) for cells in lines])
    message = r"line \d+: the labelled place is at .* px, outside its box, as are \d\.\d% of"
    with pytest.warns(VbbenchWarning, match=message):
        read(training)


def test_what_is_hidden_or_cut_is_less_visible(tmp_path):
    lines = Drive().labels()
    for track, level in {10: "1 2", 11: "0 1", 12: "2 0", 13: "0 3"}.items():
        lines = [re.sub(rf"^(0 {track} Pedestrian) 0 0", rf"\1 {level}", line) for line in lines]
    (one,) = read(write_kitti(tmp_path / "training", label_02=lines)).footage
    assert one.visible[0] == pytest.approx([0.3 * 0.75, 0.7, 0.5, 0.5, 1.0])


@pytest.mark.parametrize("frame", ["0", r"\d+"])
def test_people_without_a_place_have_boxes_and_no_truth(tmp_path, frame):
    unknown = r"\1 -1 -1 -1 -1000 -1000 -1000 -10"
    (one,) = read(edited(tmp_path, rf"^({frame} 10 Pedestrian( \S+){{7}}) .*", unknown)).footage
    placed = ~np.isnan(one.scene.positions[..., 0])
    assert not placed[0, 0]
    assert placed[0, 1:].all()
    assert placed[:, 0].any() == np.isfinite(one.scene.heights[0]) == (frame == "0")
    assert not np.isnan(one.boxes[0, 0]).any()


PLACE = r"(.* Pedestrian.*) (\S+) (\S+) (\S+) -1.5"


@pytest.mark.parametrize(
    ("folder", "line", "pattern", "by", "message"),
    [
        ("label_02", 4, r" -1.5$", "", r"label_02/0003.txt, line 4: 16 columns with blanks between, wanted"),
        ("label_02", 4, "Pedestrian", "Pedestrain", r"line 4: class is 'Pedestrain'; did you mean 'Pedestrian"),
        ("label_02", 3, r" 1\.7 ", " tall ", r"line 3: height is 'tall'; write a number"),
        ("label_02", 2, "^0 ", "0.5 ", r"line 2: 0.5 is no frame: those are whole numbers"),
        ("label_02", 2, "^0 11", "0 10", r"line 2: track 10 has a box in frame 0 already, in line 1"),
        ("label_02", 2, "trian 0 0", "trian 0 7", r"line 2: occluded is 7; levels are 0 to 3"),
        ("label_02", 2, r"(rian 0 0 0.1) \S+", r"\1 1300", r"line 2: the box is -\S+ x \S+ px"),
        (
            "label_02",
            2,
            r"(0.1 \S+ \S+) \S+",
            r"\1 1300",
            "2: the box .* pictures of 1242 x 375 px, as KITTI's are",
        ),
        ("label_02", None, PLACE, r"\1 \4 \2 \3 -1.5", r"line 1: the labelled place is .* as are \d+% of \d+: x, y, z"),
        ("label_02", 3, r" 1\.7 ", " 17 ", r"line 3: the height is 17 m, which no person's is"),
        ("label_02", 2, PLACE, r"\1 5e8 \3 \4 -1.5", r"line 2: the place is 5e\+08"),
        ("label_02", 2, PLACE, r"\1 \2 \3 -\4 -1.5", r"line 2: z is -\S+ m, behind the cam"),
        ("oxts", 42, "^49", "50", r"line 42: the camera is 1\d\d,\d+ m from where the line before has it"),
        ("oxts", 7, r"^((\S+ ){5})\S+", r"\1 90", r"line 7: yaw is 90 rad, more than a full turn; is it in deg"),
        ("oxts", 7, " 0.5 $", "", r"oxts/0003.txt, line 7: 29 columns with blanks between, wanted 30: lat l"),
        ("oxts", 7, "^49", "149", r"line 7: lat is 149.*°; the map ends at 85°"),
        ("calib", 2, r"\S+$", "", r"line 2: R_rect has 8 numbers, not 9"),
        ("calib", 2, r"R_rect \S+", "R_rect 0.1", r"line 2: R_rect is no rotation"),
        ("calib", 1, "721.5377", "0", r"line 1: P2 has focal lengths 0 and 0 px; they are above 0"),
        ("calib", 1, "721.5377", "90000", r"0003.txt: P2 has focal lengths 90000 and 90000 px, for pictures"),
        ("poses", 9, r"\S+$", "1000", r"poses/0003.txt, line 9: the camera is \S+ m from where the line before"),
        ("poses", 9, r" \S+$", "", r"poses/0003.txt, line 9: 11 columns with blanks between, wanted 12"),
        ("poses", 9, r"^\S+", "3", r"poses/0003.txt, line 9: columns .* are no rotation"),
        ("oxts", -3, "", "", r"oxts/0003.txt, line 117: has 117 lines, but labels go on to frame 119"),
        ("oxts", -FRAMES, "", "", r"oxts/0003.txt: is empty; it should hold GPS/IMU"),
        ("calib", -1, "", "", r"calib/0003.txt: lacks Tr_imu_velo; download"),
        ("poses", -70, "", "", r"poses/0003.txt, line 50: has 50 lines, but labels go on to frame 119"),
    ],
)
def test_faults_are_named_on_one_line_with_file_and_row(training, folder, line, pattern, by, message):
    """Of another text in a line, or in all; without the last lines where there are less than none."""
    path = (training.parent if folder == "poses" else training) / folder / "0003.txt"
    lines = path.read_text().splitlines()
    changed = [re.sub(pattern, by, text) if line in (None, n) else text for n, text in enumerate(lines, 1)]
    path.write_text("\n".join(lines[:line] if line and line < 0 else changed) + "\n")
    with pytest.raises(FileError, match=message) as caught:
        read(training, poses=training.parent / "poses" if folder == "poses" else None)
    assert "\n" not in str(caught.value)


NAMES = "x_center_norm,y_center_norm,width_norm,height_norm,tracker_id,frame_idx,label\n"
SHARES = NAMES + "".join(
    f"{(left + right) / 2484},{(top + bottom) / 750},{(right - left) / 1242},{(bottom - top) / 375},{t},{f},Ped\n"
    for f, t, left, top, right, bottom in LABELLED
)


@pytest.mark.parametrize("text", [mot(LABELLED), results(LABELLED), SHARES], ids=["MOTChallenge", "results", "shares"])
def test_a_trackers_boxes_are_those_of_the_people_they_are_on(training, text):
    recordings, figures = found_in(training, text)
    (one,) = recordings.footage
    assert one.tracks.tolist() == [10, 11, 12, 13, 14]
    np.testing.assert_array_equal(one.persons, np.where(one.observed, one.tracks, NOBODY))
    count = len(LABELLED)
    assert figures["tracked"] == {"labelled": count, "found": count, "recall": 1.0, "precision": 1.0, "overlap": 1.0}
    np.testing.assert_allclose(one.boxes, read(training).footage[0].boxes, atol=1e-9)


@pytest.mark.parametrize(
    "text",
    [detections(LABELLED), mot(LABELLED, linked=False), results(LABELLED, linked=False)],
    ids=["detections", "MOTChallenge", "results"],
)
def test_detections_are_linked_at_full_frame_rate(training, text):
    (one,) = found_in(training, text)[0].footage
    assert one.frames == FRAMES
    for people in one.persons.T:
        assert np.bincount(people[people != NOBODY]).max() > 0.9 * (people != NOBODY).sum()  # two cross at the start
    assert set(one.persons[one.persons != NOBODY].tolist()) == {10, 11, 12, 13, 14}
    scores = one.visible[~np.isnan(one.visible)]
    assert (scores == pytest.approx(1.0 / (1.0 + np.exp(-5.0)))) or (scores == pytest.approx(0.9))


def test_detections_of_less_than_even_odds_do_not_count(training):
    unsure = detections([(f, t, 500.0, 10.0, 520.0, 60.0) for f, t, *_ in LABELLED], -0.5)
    assert found_in(training, detections(LABELLED) + unsure)[1]["detected"]["found"] == len(LABELLED)


def test_the_class_of_people_may_be_named(training):
    text = mot(LABELLED, end=",7,-1")
    with pytest.raises(FileError, match=r"600 of class 7; people are class 0 in COCO.* `person_class`"):
        found_in(training, text)
    recordings, figures = found_in(training, text, person_class="7")
    assert figures["detected"]["recall"] == 1.0
    assert recordings.definition["person_class"] == "7"


def test_types_of_detections_are_those_of_the_people_who_count(training):
    cyclists = re.sub(r"^(\d+),1,", r"\1,3,", detections(LABELLED), flags=re.MULTILINE)
    with pytest.raises(FileError, match="holds no box of a person with a sufficient score"):
        found_in(training, cyclists)
    assert found_in(training, cyclists, cyclists=True)[1]["detected"]["recall"] == 1.0


def test_classes_of_trackers_are_removed_and_counted(training):
    bicycles = [(f, 50 + t, *edges) for f, t, *edges in LABELLED[:99]]
    with pytest.warns(VbbenchWarning, match="99 of 699 boxes are dropped: 99 of class 3"):
        _, figures = found_in(training, mot(LABELLED, end=",1,-1") + mot(bicycles, end=",3,-1"))
    assert figures["detected"]["found"] == len(LABELLED)


SHIFTED = [(f, t, left + 700.0, top, right + 700.0, bottom) for f, t, left, top, right, bottom in LABELLED]
CORNERS = [(f, t, left, top, left + right, top + bottom) for f, t, left, top, right, bottom in LABELLED]
HALVED = [(f, t, *(0.3 * edge for edge in edges)) for f, t, *edges in LABELLED]
LATER = [((f + 60) % FRAMES, t, a, top - 120.0, b, bottom - 120.0) for f, t, a, top, b, bottom in LABELLED]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (detections(LABELLED[:1]) + detections(LABELLED[1:]).replace(",0\n", "\n", 1), "2: 14 columns with commas"),
        (detections(LABELLED).replace("0,1,", "0,one,", 1), r"line 1: type is 'one'; write a number"),
        (detections([(FRAMES, 1, 1.0, 1.0, 9.0, 9.0)]), r"line 1: frame 120, counted from 0, is beyond the"),
        (detections([(0, 1, 9.0, 1.0, 9.0, 9.0)]), r"line 1: the box is 0 x 8 px; remove it"),
        (mot(LABELLED[:5]) + mot(LABELLED[5:9], linked=False), r"line 6: the id is missing here"),
        (results(LABELLED[:5]) + results(LABELLED[5:9], linked=False), r"line 6: id is -1, but other rows have ids"),
        (detections(SHIFTED), r"600 boxes is outside the picture of 1242 x 375 px.*write the size of the picture"),
        (mot(CORNERS), r"width and height seem to be the right and lower borders of boxes"),
        (mot(HALVED), r"0003.txt: only 0 of 600 boxes are on people, of whom there are 600 \(recall 0"),
        (mot(LATER), r"only \d+ of 600 boxes are on people.* are they of this sequence"),
        ("", r"0003.txt: holds no box"),
    ],
)
def test_boxes_that_cannot_be_are_refused_with_file_and_row(training, text, message):
    with pytest.raises(FileError, match=message) as caught:
        found_in(training, text)
    assert "\n" not in str(caught.value)
