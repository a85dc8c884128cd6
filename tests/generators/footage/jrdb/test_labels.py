"""The split jrdb and files that cannot be: one line that names file and place and says what to do."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.lib.jrdb_recording import KINDS, Files, Robot, each_label, recording
from vbbench.cli import main
from vbbench.errors import VbbenchWarning
from vbbench.generation import generate
from vbbench.generation.generator import Options

rosbags = pytest.mark.extra("rosbags")


@pytest.fixture(scope="module")
def files() -> Files:
    return recording(robot=Robot(seconds=12.0))


@pytest.fixture
def root(files: Files, tmp_path: Path) -> Path:
    return files.write(tmp_path / "jrdb")


def refusal(capsys: pytest.CaptureFixture[str], tmp_path: Path, source: Path, *options: object) -> str:
    """The one line that `vbbench generate jrdb` says and does nothing."""
    out = tmp_path / "out"
    assert main(["generate", "jrdb", "--source", str(source), "--out", str(out), *map(str, options)]) == 2
    assert not out.exists()
    (line,) = capsys.readouterr().err.splitlines()
    return line


def first_label(values):
    return each_label(values)[0]


def jump(values, seconds, first=0):
    for row in values["data"][first:]:
        for sensor in row.get("cameras") or row["pointclouds"]:
            sensor["timestamp"] += seconds


def turned_labels(values):
    """3-D labels in the axes of a camera: x right, y down, z forward."""
    for box in (label["box"] for label in each_label(values)):
        box["cx"], box["cy"], box["cz"] = -box["cy"], -box["cz"], box["cx"]


def farther_places(values):
    """In feet."""
    for box in (label["box"] for label in each_label(values)):
        box["cx"], box["cy"] = 3.28 * box["cx"], 3.28 * box["cy"]


def lower_boxes(values):
    """Of pictures that are five times as high."""
    for label in each_label(values):
        label["box"][1] *= 5.0


def hidden_people(values):
    for label in each_label(values):
        label["attributes"]["occlusion"] = "Fully_occluded"


def slower(values):
    """Pictures at 11 Hz."""
    for number, row in enumerate(values["data"]):
        row["cameras"][0]["timestamp"] += number * (1 / 11 - 1 / 15)


LABELS_2D, LABELS_3D, TIMES, CLOUDS = KINDS


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "change", "said"),
    [
        (TIMES, lambda v: jump(v, 30.0, 50), "clock jumps by +30.0"),
        (TIMES, lambda v: jump(v, -3.0, 50), "clock jumps by -2.93"),
        (CLOUDS, lambda v: jump(v, 9.0, 50), "frames_pc.json: the clock jumps by +9.0"),
        (TIMES, lambda v: v.pop("data"), "has no list 'data' with an object for each frame"),
        (TIMES, lambda v: v["data"][4].pop("cameras"), "entry 5 of 'data': key 'cameras' is None, not a list of s"),
        (TIMES, lambda v: v["data"][4]["cameras"][0].update(timestamp="soon"), "entry 5 of 'data': key 'timestamp' is"),
        (TIMES, lambda v: v["data"][4]["cameras"][0].update(url="a.jpg"), "url is 'a.jpg', not …/000000.jpg or .pcd"),
        (TIMES, lambda v: v["data"].append(v["data"][3]), "frames: a frame stands there twice"),
        (TIMES, lambda v: v["data"].pop(40), "picture 000040.jpg is labelled, but has no time stamp"),
        (CLOUDS, lambda v: v["data"][0].pop("pointclouds"), "entry 1 of 'data': key 'pointclouds' is None"),
        (LABELS_2D, lambda v: v.pop("labels"), "has no object 'labels'"),
        (LABELS_2D, lambda v: v["labels"].update(x=[]), "key 'x' of 'labels' is not the name of a frame, such as 000"),
        (LABELS_2D, lambda v: first_label(v).pop("label_id"), "000000.jpg, label 1: has no text 'label_id'"),
        (LABELS_2D, lambda v: first_label(v).update(attributes=5), "label 1: key 'attributes' is 5, not an object"),
        (LABELS_2D, lambda v: v["labels"].update({"000001.jpg": 5}), "000001.jpg is 5, not a list of labels"),
        (LABELS_2D, hidden_people, "holds no box of a visible person"),
        (TIMES, slower, "which is no multiple of 1/15 s"),
        (LABELS_2D, lambda v: first_label(v).update(label_id="pedestrian:x"), "not 'pedestrian:NUMBER'"),
        (LABELS_2D, lambda v: first_label(v).update(box=[1, 2, 3]), "'box' is [1, 2, 3], not [left, top, width, he"),
        (LABELS_2D, lambda v: first_label(v).update(box=[1, 2, 3, 0]), "its box is 3 px wide and 0 px high"),
        (LABELS_2D, lambda v: first_label(v).update(box=[1, 2, 3, 1e9]), "height is 1000000000.0, not a number up to"),
        (LABELS_2D, lambda v: first_label(v)["attributes"].update(occlusion="Fully_visable"), "mean 'Fully_visible'?"),
        (LABELS_2D, lambda v: v["labels"]["000000.jpg"].append(first_label(v)), "stands there twice"),
        (LABELS_3D, lambda v: first_label(v)["box"].pop("cx"), "label 1: key 'cx' is missing in its box of cy,"),
        (LABELS_3D, lambda v: first_label(v).update(box=[1, 2, 3, 4]), "not an object with cx, cy, cz, l, w, h, rot_z"),
        (LABELS_3D, lambda v: first_label(v)["box"].update(h=-1.7), "label 1: h is -1.7; people are up to 4 m tall"),
        (LABELS_3D, farther_places, "times as far away as boxes so high say (median): they and"),
        (LABELS_2D, lower_boxes, "as are "),
        (LABELS_3D, turned_labels, "they must be in the robot's frame, x forward, y left"),
        (LABELS_3D, lambda v: v.update(labels={}), "only 0 boxes"),
    ],
)
def test_what_files_cannot_hold(files, root, tmp_path, capsys, kind, change, said):
    files.edit(root, kind, change)
    line = refusal(capsys, tmp_path, root)
    assert said in line
    assert files.name in line


@pytest.mark.parametrize(
    ("kind", "said"),
    [(TIMES, "the file is missing; download JRDB's timestamps"), (CLOUDS, "the file is"), (LABELS_3D, "the file is")],
)
def test_what_is_missing(files, root, tmp_path, capsys, kind, said):
    path = files.path(root, kind)
    path.unlink()
    assert f"{path}: {said}" in refusal(capsys, tmp_path, root)


def test_what_is_no_folder_of_jrdb(tmp_path, root, capsys):
    assert "holds no labels/labels_2d_stitched" in refusal(capsys, tmp_path, tmp_path)
    assert "there is no such file or folder" in refusal(capsys, tmp_path, tmp_path / "nowhere")
    assert main(["generate", "jrdb", "--out", str(tmp_path / "out")]) == 2
    line = capsys.readouterr().err
    assert "name with --source the folder" in line
    assert "https://jrdb.erc.monash.edu" in line
    (root / "labels/labels_2d_stitched").rename(root / "labels/old")
    (root / "labels/labels_2d_stitched").mkdir()
    assert "holds no NAME.json" in refusal(capsys, tmp_path, root)


def test_what_is_not_read(root, tmp_path, capsys, files):
    assert "did you mean" in refusal(capsys, tmp_path, root, "--sequences", files.name + "0")
    assert f"{files.name}.txt: is missing" in refusal(capsys, tmp_path, root, "--options", f"boxes={tmp_path}")
    line = refusal(capsys, tmp_path, root, "--options", f"bags={tmp_path}")
    assert f"holds neither {files.name}.bag nor {files.name}.json" in line


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("0,1,2\n", "line 1: 3 columns with commas between, wanted 12: frame,id,x,y,h,w,l,rot_z,left,top"),
        ("0,1,1,1,1.7,1,1,0,5,5,5,x\n", "line 1: height is 'x'; write a number"),
        ("0,1,1,1,1.7,1,1,0,5,5,5,9\n", "stamps 1 of the labelled frames; two at least are wanted"),
        ("\n\n" + "0,1,1,1,1.7,1,1,0,5,5,5,9\n" * 2, "line 4: id 1 stands in frame 0 twice"),
        ("0.5,1,1,1,1.7,1,1,0,5,5,5,9\n", "line 1: 0.5 is no frame: those are whole numbers from 0"),
        ("0,1e12,1,1,1.7,1,1,0,5,5,5,9\n", "line 1: 1e+12 is no id"),
        ("0,1,4000,1,1.7,1,1,0,5,5,5,9\n", "line 1: the place is 4000 m away"),
        ("0,1,1,1,1700,1,1,0,5,5,5,9\n", "line 1: h is 1700; people are up to 4 m tall"),
        ("0,1,1,1,1.7,1,1,0,5,5,5,0\n", "line 1: its box is 5 px wide and 0 px high"),
        ("0,1,1,1,1.7,1,1,0,5e6,5,5,9\n", "line 1: the box reaches 5e+06 px"),
    ],
)
def test_what_the_sample_cannot_hold(tmp_path, capsys, text, said):
    path = tmp_path / "sample.csv"
    path.write_text(text)
    assert said in refusal(capsys, tmp_path, path)


def test_boxes_beside_the_picture_and_without_a_place_are_told(files, root, tmp_path):
    files.edit(root, LABELS_2D, one_box_below)
    files.edit(root, LABELS_3D, places_at_first)
    with pytest.warns(VbbenchWarning) as told:
        generate("jrdb", tmp_path / "out", Options(source=root), jobs=1)
    stray, few = (str(one.message) for one in told)
    assert "is in row 2000 of 480, as are 1 of" in stray
    assert "these are removed" in stray
    assert re.search(r"only \d+ of \d+ boxes of .* have a labelled place", few)


def one_box_below(values):
    first_label(values)["box"][1] = 2000.0 - 0.5 * first_label(values)["box"][3]


def places_at_first(values):
    for name in list(values["labels"])[20:]:
        values["labels"][name] = []


@rosbags
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"jump": 20.0}, "clock of segway/feedback/wheel_odometry jumps by +20.020 s after message"),
        ({"jump": -4.0}, "clock of segway/feedback/wheel_odometry jumps by -3.980 s after message"),
        ({"wheels": "odom"}, "has no message of segway/feedback/wheel_odometry or segway/odometry/local_filtered"),
        ({"messages": False}, "is an empty bag: it holds no message"),
    ],
)
def test_what_bags_cannot_hold(files, root, tmp_path, capsys, changes, said):
    bags = files.write_bag(tmp_path / "bags", **changes)
    line = refusal(capsys, tmp_path, root, "--options", f"bags={bags}")
    assert said in line
    assert f"{files.name}.bag" in line


@rosbags
def test_bags_of_other_times_and_broken_ones(files, root, tmp_path, capsys):
    path = files.write_bag(tmp_path / "bags") / f"{files.name}.bag"
    whole = path.read_bytes()
    rng = np.random.default_rng(0)
    for broken in (b"", b"no bag at all", whole[: len(whole) // 2], whole[:20000] + rng.bytes(40000) + whole[60000:]):
        path.write_bytes(broken)
        assert "is no whole ROS 1 bag" in refusal(capsys, tmp_path, root, "--options", f"bags={path.parent}")
    path.write_bytes(whole)
    for kind in (TIMES, CLOUDS):
        files.edit(root, kind, lambda values: jump(values, 86400.0))
    assert "is it the bag of another recording?" in refusal(capsys, tmp_path, root, "--options", f"bags={path.parent}")
