"""Split kitti with boxes of detectors and trackers: three formats, linked, matched, counted; mismatches are refused."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.generators.test_kitti import recordings_of_kitti  # noqa: F401
from tests.lib.kitti_files import FRAMES, Drive, boxes_of, write_kitti
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.scoring import score
from vbbench.sequence import NOBODY
from vbbench.solving import solve
from vbbench_generators.footage.kitti.split import kitti
from vbbench_generators.footage.split import Recordings

Box = tuple[int, int, float, float, float, float]


def detections(boxes: list[Box], score: float = 5.0) -> str:
    """KITTI's frames and corners, as lidar detectors write them."""
    rows = (
        f"{f},1,{left},{top},{right},{bottom},{score},1.7,0.5,0.6,1,2,3,0,0" for f, _, left, top, right, bottom in boxes
    )
    return "\n".join(rows) + "\n"


def mot(boxes: list[Box], *, linked: bool, score: float = 0.9) -> str:
    """MOTChallenge's frames and corners, from 1."""
    rows = (
        f"{f + 1},{track if linked else -1},{left + 1},{top + 1},{right - left},{bottom - top},{score}"
        for f, track, left, top, right, bottom in boxes
    )
    return "\n".join(rows) + "\n"


def results(boxes: list[Box], *, linked: bool, score: float = 0.9) -> str:
    """What trackers write for KITTI's evaluation."""
    rows = (
        f"{f} {track if linked else -1} Pedestrian -1 -1 -10 {left} {top} {right} {bottom} "
        f"-1 -1 -1 -1000 -1000 -1000 -10 {score}"
        for f, track, left, top, right, bottom in boxes
    )
    return "\n".join(rows) + "\n"


@pytest.fixture
def training(tmp_path: Path) -> Path:
    return write_kitti(tmp_path / "training")


LABELLED = boxes_of(Drive().labels())


def read(training: Path, text: str, **asked: Any) -> Recordings:
    folder = training.parent / "boxes"
    folder.mkdir(exist_ok=True)
    (folder / "0003.txt").write_text(text)
    return kitti.recordings(Options(source=training, footage=FootageOptions(boxes=folder, **asked)))


def figures(recordings: Recordings) -> dict[str, Any]:
    assert recordings.calibration is not None
    found: dict[str, Any] = recordings.calibration["sequences"]["0003"]["boxes"]
    return found


@pytest.mark.parametrize(
    "text", [mot(LABELLED, linked=True), results(LABELLED, linked=True)], ids=["MOTChallenge", "KITTI results"]
)
def test_a_trackers_boxes_are_those_of_the_people_they_are_on(training: Path, text: str) -> None:
    recordings = read(training, text)
    (one,) = recordings.footage
    assert one.tracks.tolist() == [10, 11, 12, 13, 14]
    assert one.persons is not None
    seen = ~np.isnan(one.boxes[..., 2])
    np.testing.assert_array_equal(one.persons, np.where(seen, one.tracks, NOBODY))
    assert figures(recordings)["tracked"] == {
        "labelled": len(LABELLED), "found": len(LABELLED), "recall": 1.0, "precision": 1.0, "overlap": 1.0
    }  # fmt: skip
    labelled = kitti.recordings(Options(source=training)).footage[0]
    np.testing.assert_allclose(one.boxes, labelled.boxes, atol=1e-9)


@pytest.mark.parametrize(
    "text",
    [detections(LABELLED), mot(LABELLED, linked=False), results(LABELLED, linked=False)],
    ids=["detections", "MOTChallenge", "KITTI results"],
)
def test_detections_are_linked_at_full_frame_rate(training: Path, text: str) -> None:
    (one,) = read(training, text).footage
    assert one.frames == FRAMES
    assert one.persons is not None
    for column in range(len(one.tracks)):
        people = one.persons[:, column]
        assert np.bincount(people[people != NOBODY]).max() > 0.9 * (people != NOBODY).sum()  # two cross at the start
    assert set(one.persons[one.persons != NOBODY].tolist()) == {10, 11, 12, 13, 14}
    scores = one.visible[~np.isnan(one.visible)]
    assert (scores == pytest.approx(1.0 / (1.0 + np.exp(-5.0)))) or (scores == pytest.approx(0.9))


def strayed(boxes: list[Box], track: int, frames: int) -> list[Box]:
    """The boxes, those of a track in the first frames 300 px to the right of the person."""
    return [
        (f, t, left + 300.0, top, right + 300.0, bottom)
        if t == track and f < frames
        else (f, t, left, top, right, bottom)
        for f, t, left, top, right, bottom in boxes
    ]


def test_false_alarms_stay_in_tracks_of_people_and_tracks_of_nobody_are_left_out_and_counted(training: Path) -> None:
    stranger = [(f, 99, 30.0 + f, 300.0, 60.0 + f, 360.0) for f in range(30)]
    recordings = read(training, mot([*strayed(LABELLED, 10, 5), *stranger], linked=True))
    (one,) = recordings.footage
    assert 99 not in one.tracks.tolist()
    assert one.persons is not None
    assert (one.persons[:5, 0] == NOBODY).all()
    assert not np.isnan(one.boxes[:5, 0]).any()
    assert figures(recordings)["dropped"] == 30
    assert "30 boxes of tracks of nobody removed" in str(recordings.calibration)


def test_detections_of_less_than_even_odds_do_not_count(training: Path) -> None:
    twice = detections(LABELLED) + detections([(f, t, 500.0, 10.0, 520.0, 60.0) for f, t, *_ in LABELLED], -0.5)
    assert figures(read(training, twice))["detected"]["found"] == len(LABELLED)


def with_class(text: str, number: int) -> str:
    return "".join(f"{line},{number},-1\n" for line in text.splitlines())


def test_whoever_knows_says_which_class_is_people(training: Path) -> None:
    text = with_class(mot(LABELLED, linked=True), 7)
    with pytest.raises(FileError, match=r"600 of class 7; people are class 0 in COCO.* `person_class`"):
        read(training, text)
    recordings = read(training, text, person_class="7")
    assert figures(recordings)["detected"]["recall"] == 1.0
    assert recordings.definition["person_class"] == "7"


def test_types_of_detections_are_those_of_the_people_who_count(training: Path) -> None:
    text = detections(LABELLED)
    cyclists = re.sub(r"^(\d+),1,", r"\1,3,", text, flags=re.MULTILINE)
    with pytest.raises(FileError, match="holds no box of a person with a sufficient score"):
        read(training, cyclists)
    assert figures(read(training, cyclists, cyclists=True))["detected"]["recall"] == 1.0


def test_a_dataset_with_false_alarms_is_solved_and_scored(training: Path, tmp_path: Path) -> None:
    folder = tmp_path / "boxes"
    folder.mkdir()
    (folder / "0003.txt").write_text(mot(strayed(LABELLED, 10, 20), linked=True))
    dataset = generate("kitti", tmp_path / "d", Options(source=training, footage=FootageOptions(boxes=folder, every=1)))
    assert "as written" in verify(tmp_path / "d")
    assert dataset.info.pixel_std == 5.0
    assert dataset.info.definition["least_overlap"] == 0.3
    sequence = dataset.sequence(0)
    strangers = np.isnan(dataset.truth(sequence).positions[..., 0]) & sequence.observed
    assert strangers.sum() == 20
    values = score(solve(dataset, "cv", "sequential", tmp_path / "a"), tmp_path / "d").values()["metrics"]
    assert np.isfinite(values["dx"]["mean"])


SHIFTED = [(f, t, left + 700.0, top, right + 700.0, bottom) for f, t, left, top, right, bottom in LABELLED]
CORNERS = [(f, t, left, top, left + right, top + bottom) for f, t, left, top, right, bottom in LABELLED]
HALVED = [(f, t, *(0.3 * edge for edge in edges)) for f, t, *edges in LABELLED]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            detections(LABELLED).replace(",0\n0", "\n0", 2).replace("\n", ",0\n", 1),
            r"0003.txt, line 2: 14 columns with commas between, wanted",
        ),
        (detections(LABELLED).replace("0,1,", "0,one,", 1), r"line 1: type is 'one'; write a number"),
        (detections([(FRAMES, 1, 1.0, 1.0, 9.0, 9.0)]), r"line 1: frame 120, counted from 0, is beyond the"),
        (detections([(0, 1, 9.0, 1.0, 9.0, 9.0)]), r"line 1: the box is 0 x 8 px; remove it"),
        (mot(LABELLED[:5], linked=True) + mot(LABELLED[5:9], linked=False), r"line 6: the id is missing here"),
        (detections(SHIFTED), r"600 boxes is outside the picture of 1242 x 375 px.*write the size of the picture"),
        (mot(CORNERS, linked=True), r"width and height seem to be the right and lower borders of boxes"),
        (mot(HALVED, linked=True), r"0003.txt: only 0 of 600 boxes are on people, of whom there are 600 \(recall 0"),
        ("", r"0003.txt: holds no box"),
    ],
)
def test_boxes_that_cannot_be_are_refused_with_file_and_row(training: Path, text: str, message: str) -> None:
    with pytest.raises(FileError, match=message) as caught:
        read(training, text)
    assert "\n" not in str(caught.value)


def test_boxes_of_another_sequence_are_refused_by_what_they_match(training: Path) -> None:
    later = [((f + 60) % FRAMES, t, *rest) for f, t, *rest in LABELLED]
    shifted = [(f, t, left, top - 120.0, right, bottom - 120.0) for f, t, left, top, right, bottom in later]
    with pytest.raises(FileError, match=r"only \d+ of 600 boxes are on people.* are they of this sequence"):
        read(training, mot(shifted, linked=True))


def test_a_real_detectors_recall_precision_and_overlap(recordings_of_kitti: Path) -> None:  # noqa: F811
    from vbbench_generators.footage.kitti.split import KittiSplit

    asked = FootageOptions(boxes=recordings_of_kitti / "detections", sequences=("0019",))
    found = KittiSplit(classes=("Pedestrian",)).recordings(Options(source=recordings_of_kitti, footage=asked))
    assert found.calibration is not None
    boxes = found.calibration["sequences"]["0019"]["boxes"]
    detected = [boxes["detected"][name] for name in ("recall", "precision", "overlap")]
    assert detected == pytest.approx([0.80, 0.74, 0.66], abs=0.01)
    assert boxes["tracked"]["recall"] > 0.75


def test_few_matched_boxes_are_warned_of(training: Path) -> None:
    with pytest.warns(VbbenchWarning, match=r"0003.txt: only 180 of 600 labelled boxes .* \(recall 0.3"):
        read(training, mot([box for box in LABELLED if box[0] < 36], linked=True))


def test_false_alarms_where_nobody_is_are_left_out_without_complaint(training: Path) -> None:
    nobody = [line for line in Drive().labels() if "Pedestrian" not in line]
    write_kitti(training, label_02=nobody)
    recordings = read(training, detections(LABELLED))
    assert len(recordings.footage[0].tracks) == 0
    assert figures(recordings)["tracked"]["labelled"] == 0
    with pytest.raises(VbbenchError, match="frames in a row"):
        generate("kitti", training.parent / "d", Options(source=training))


def test_boxes_may_be_named_columns_of_shares(training: Path) -> None:
    rows = "".join(
        f"{(left + right) / 2484},{(top + bottom) / 750},{(right - left) / 1242},{(bottom - top) / 375},{t},{f},Ped\n"
        for f, t, left, top, right, bottom in LABELLED
    )
    head = "x_center_norm,y_center_norm,width_norm,height_norm,tracker_id,frame_idx,label\n"
    folder = training.parent / "boxes"
    folder.mkdir()
    (folder / "0003.csv").write_text(head + rows)
    asked = FootageOptions(boxes=folder)
    found = kitti.recordings(Options(source=training, footage=asked))
    assert figures(found)["tracked"]["overlap"] == 1.0


def test_classes_of_trackers_are_left_out_and_counted(training: Path) -> None:
    bicycles = [(f, 50 + t, *edges) for f, t, *edges in LABELLED[:99]]
    text = with_class(mot(LABELLED, linked=True), 1) + with_class(mot(bicycles, linked=True), 3)
    with pytest.warns(VbbenchWarning, match="99 of 699 boxes are dropped: 99 of class 3"):
        recordings = read(training, text)
    assert figures(recordings)["detected"]["found"] == len(LABELLED)


def test_boxes_of_other_frames_are_named(training: Path) -> None:
    """As where a text counts from 0 and has no boxes in frame 0; one file may be named alone."""
    boxes = training.parent / "boxes.txt"
    boxes.write_text(mot([(f - 1, *rest) for f, *rest in LABELLED if f > 0], linked=True))
    with pytest.warns(VbbenchWarning, match=r"boxes.txt: boxes overlap people one frame later by 1.00, now by 0.\d\d"):
        kitti.recordings(Options(source=training, footage=FootageOptions(boxes=boxes)))
