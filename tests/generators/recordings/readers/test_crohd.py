"""CroHD: the same heads from folder and archive, every fault named by file and line, and the splits made of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.lib.crohd_files import SEQINFO, crowd, pack, write_recording
from vbbench.cli import main
from vbbench.errors import FileError, SourceMissingError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.tables import file_sha256
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.generation.sources import Source
from vbbench_generators.recordings.loading import load_scenes
from vbbench_generators.recordings.readers.crohd import find_recording, parse_seqinfo, read_heads
from vbbench_generators.recordings.recipe import get_recipe

GOOD = "2,7,101,51,20,30,1,1,0.5"
WALKS = "1,1,10,20,8,9,1,1,1\n2,1,12,20,8,9,1,1,1\n1,2,50,60,8,9,1,1,1\n2,2,52,60,8,9,1,1,1\n"
ARCHIVE = get_recipe("shibuya01").source[0]


def heads_at(place, name="HT21-03"):
    return read_heads(find_recording(name, ARCHIVE, place, split="shibuya01"))


def same(one, other):
    assert (one.name, one.dt, one.size) == (other.name, other.dt, other.size)
    for name in ("frame", "track", "boxes", "visible"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_what_was_written_is_read(tmp_path):
    heads = heads_at(write_recording(tmp_path / "mine"))
    np.testing.assert_allclose(heads.boxes, crowd().boxes, atol=1e-9)
    same(heads, replace(crowd(), name="HT21-03", boxes=heads.boxes))


def test_frames_and_boxes_count_from_0_and_facts_are_those_of_seqinfo(tmp_path):
    info = SEQINFO.replace("frameRate=25", "FRAMERATE = 12.5").replace("1920", "800").replace("1080", "600")
    heads = heads_at(write_recording(tmp_path / "mine", WALKS, info="\ufeff; made by hand\r\n" + info))
    assert (heads.name, heads.dt, heads.size) == ("HT21-03", 0.08, (800, 600))
    assert heads.track.tolist() == [1, 1, 2, 2]
    assert heads.frame.tolist() == [0, 1, 0, 1]
    assert heads.boxes[0].tolist() == [9, 19, 8, 9]


def test_folder_parent_and_archive_are_the_same(tmp_path):
    folder = write_recording(tmp_path / "a" / "labels" / "train" / "HT21-03")
    write_recording(tmp_path / "a" / "labels" / "train" / "HT21-04", WALKS, name="HT21-04")
    packed = pack(tmp_path / "x.zip", {"HT21/train/HT21-03": folder, "HT21/train/HT21-04": folder})
    places = (folder, tmp_path / "a", packed)
    read = [find_recording("HT21-03", ARCHIVE, place, split="shibuya01") for place in places]
    assert len({tuple(file.content for file in files.values()) for files in read}) == 1
    for files in read:
        same(read_heads(files), heads_at(folder))
    assert len(heads_at(tmp_path / "a", "HT21-04")) == 4


@pytest.mark.parametrize(
    "line",
    [
        *("1,9,1,1,5,5,0,1,1", "1,9,1,1,5,5,1,2,1", "1,9,1,1,5,5,1,3,1", "1,9,1,1,5,5,1,4,1", "1,9,1,1,5,5,1,1,0"),
        *("1,9,1,1,5,5,1,1,-1", "999,1,1,1,0,-5,1,3,7", "1,1,1,1,5,5,1,2,1"),
    ],
)
def test_rows_that_do_not_count_are_left_out_whatever_they_say(tmp_path, line):
    heads = heads_at(write_recording(tmp_path / "a", f"{WALKS}{line}\n"))
    assert heads.track.tolist() == [1, 1, 2, 2]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("3,7,1,1,20", "5 columns with commas between, wanted 9: frame,id,left"),
        ("3,7,1,1,20,60,1,3,inf", "visibility is inf"),
        ("0,7,1,1,20,60,1,1,1", "0 is no frame of the sequence: its frames are 1 to 90"),
        ("91,7,1,1,20,60,1,1,1", "91 is no frame of the sequence"),
        ("3,-1,1,1,20,60,1,1,1", "the id is missing here, other boxes have one"),
        ("3,7,1,1,0,60,1,1,1", "the box is 0 x 60 px"),
        ("2,7,1,1,20,60,1,1,1", "id 7 already has a box in this frame, in line 1; remove one of them"),
    ],
)
@pytest.mark.parametrize("packed", [False, True])
def test_a_bad_line_is_named(tmp_path, line, problem, packed):
    folder = write_recording(tmp_path / "HT21-03", f"{GOOD}\n{GOOD.replace('7', '8', 1)}\n{line}\n")
    place = pack(tmp_path / "labels.zip", {"train/HT21-03": folder}) if packed else folder
    within = place / "train/HT21-03" if packed else place
    with pytest.raises(FileError, match=problem) as caught:
        heads_at(place)
    assert (caught.value.line, caught.value.path) == (3, within / "gt/gt.txt")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        *(
            (text, "holds no crowd")
            for text in ("", "\n\n", "1,1,1,1,5,5,0,1,1\n", "1,1,1,1,5,5,1,1,1\n2,1,1,1,5,5,1,1,1\n")
        ),
        ("1,-1,1,1,5,5,1,1,1\n2,-1,1,1,5,5,1,1,1\n", "id is -1: these are detections; tracks of heads are wanted"),
    ],
)
def test_no_crowd(tmp_path, text, problem):
    with pytest.raises(FileError, match=problem):
        heads_at(write_recording(tmp_path / "mine", text))


def test_a_recording_too_large_for_a_scene(tmp_path):
    text = "".join(f"{frame},{track},1,1,5,5,1,1,1\n" for track in range(101) for frame in (1, 1_000_000))
    with pytest.raises(FileError, match="1,000,000 frames of 101 people from 202 rows are too many"):
        heads_at(write_recording(tmp_path / "mine", text, info=SEQINFO.replace("=90", "=1000000")))


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("name={name}\n", "", "key 'name' is missing"),
        ("frameRate=25\n", "", "key 'frameRate' is missing; lines are"),
        ("frameRate=25", "frameRate=", "key 'frameRate' is missing"),
        ("frameRate=25", "frameRate=fast", "frameRate is 'fast', not a number of pictures a second"),
        ("frameRate=25", "frameRate=0", "frameRate is '0'"),
        ("frameRate=25", "frameRate=nan", "frameRate is 'nan'"),
        ("seqLength=90", "seqLength=90.5", "seqLength is '90.5', not a whole number"),
        ("seqLength=90", "seqLength=99999999999", "seqLength is '99999999999', not a whole number from 1 to 1000000"),
        ("imWidth=1920", "imWidth=-1", "imWidth is '-1'"),
        ("imHeight=1080", "imHeight=0", "imHeight is '0'"),
        ("name=", "title=", "key 'name' is missing; lines are 'key=value'"),
    ],
)
def test_a_bad_seqinfo(old, new, problem):
    assert old in SEQINFO
    with pytest.raises(FileError, match=problem) as caught:
        parse_seqinfo(Path("seqinfo.ini"), SEQINFO.replace(old, new, 1).encode())
    assert "\n" not in str(caught.value)


def test_a_seqinfo_that_is_no_text():
    with pytest.raises(FileError, match="begins as UTF-16 text and does not go on so"):
        parse_seqinfo(Path("seqinfo.ini"), b"\xff\xfe\x00")


def test_what_cannot_be_found(tmp_path):
    folder = write_recording(tmp_path / "b" / "HT21-03")
    with pytest.raises(VbbenchError, match="there is no such file or folder"):
        heads_at(tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match=r"holds neither HT21-03 .* nor HT21Labels\.zip"):
        heads_at(tmp_path / "empty")
    with pytest.raises(FileError, match="holds no HT21-04"):
        heads_at(pack(tmp_path / "x.zip", {"HT21-03": folder}), "HT21-04")
    with pytest.raises(FileError, match="is another recording: shibuya01 is made from HT21-03"):
        heads_at(write_recording(tmp_path / "HT21-04"))
    (folder / "gt" / "gt.txt").unlink()
    with pytest.raises(FileError, match=r"gt\.txt: cannot be read"):
        heads_at(tmp_path / "b")


def test_a_recording_that_is_there_twice(tmp_path):
    for name in ("one", "two"):
        folder = write_recording(tmp_path / name / "HT21-03")
    with pytest.raises(FileError, match="more than once: one/HT21-03, two/HT21-03; name one of them"):
        heads_at(tmp_path)
    with pytest.raises(FileError, match="more than once"):
        heads_at(pack(tmp_path / "x.zip", {"a/HT21-03": folder, "b/HT21-03": folder}))


def test_the_published_archive_is_taken_from_the_data_folder_if_it_is_whole(no_data, tmp_path):
    with pytest.raises(SourceMissingError, match="vbbench fetch shibuya01"):
        load_scenes(get_recipe("shibuya01"), Options(source=None))
    folder = write_recording(tmp_path / "made" / "HT21-03")
    (no_data / "crohd").mkdir()
    packed = pack(no_data / "crohd" / "HT21Labels.zip", {"train/HT21-03": folder})
    for place in (None, no_data):
        with pytest.raises(FileError, match="its SHA-256 is"):
            find_recording("HT21-03", ARCHIVE, place, split="shibuya01")
    told = replace(ARCHIVE, sha256=file_sha256(packed))
    for place in (None, no_data):
        same(read_heads(find_recording("HT21-03", told, place, split="shibuya01")), heads_at(folder))


def test_both_splits_are_fetched_at_once(monkeypatch, capsys):
    wanted: list[Source] = []
    monkeypatch.setattr("vbbench.generation.generator.fetch", lambda sources: wanted.extend(sources) or [Path("x.zip")])
    assert main(["fetch", "shibuya01", "shibuya02"]) == 0
    assert wanted == [ARCHIVE]
    assert capsys.readouterr().out == "x.zip\n"
    assert (ARCHIVE.size, ARCHIVE.sha256[:8]) == (53_547_421, "824e94f1")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_recording(tmp_path_factory.mktemp("crohd") / "HT21-03")


@pytest.fixture(scope="module")
def dataset(recording, tmp_path_factory):
    return generate("shibuya01", tmp_path_factory.mktemp("made") / "s", Options(source=recording))


@pytest.mark.slow
def test_every_track_observes_once_and_all_others_are_seen(dataset):
    heads = crowd()
    tracks, frames = np.unique(heads.track, return_counts=True)
    tracks = tracks[frames >= 2]
    assert dataset.rows["observer"].tolist() == tracks.tolist()
    assert dataset.info.dt == pytest.approx(0.04)
    assert dataset.info.scenes == ("HT21-03",)
    for sequence in dataset.sequences():
        there = heads.frame[heads.track == sequence.observer]
        assert (sequence.first_frame, sequence.frames) == (there[0], there[-1] - there[0] + 1)
    assert "sequences are as written" in verify(dataset.folder)


def test_the_dataset_says_how_its_metres_were_found(dataset):
    info = Dataset(dataset.folder).info
    assert info.calibration["pseudo_metric"]
    height = info.calibration["camera_height"]
    assert height["low"] < 12.0 < height["high"]
    assert info.caution
    assert "pseudo-metric" in info.caution
    assert info.definition["recording"] == "HT21-03"
    assert info.definition["frame_step"] == 1
    assert [name for name, _ in info.definition["files"]] == ["HT21-03/seqinfo.ini", "HT21-03/gt/gt.txt"]
    assert replace(info, calibration=None).id == info.id


def test_dt_is_that_of_the_recording(recording):
    with pytest.raises(VbbenchError, match=r"`dt` is for the split 'custom'; here seqinfo\.ini has"):
        load_scenes(get_recipe("shibuya01"), Options(source=recording, dt=0.4))


def test_fewer_frames_where_a_recipe_says_so(recording):
    recipe = get_recipe("shibuya01")
    every = load_scenes(recipe, Options(source=recording)).scenes[0]
    fifth = load_scenes(replace(recipe, frame_step=5), Options(source=recording)).scenes[0]
    assert fifth.dt == pytest.approx(0.2)
    np.testing.assert_array_equal(fifth.positions, every.positions[::5][:, np.isin(every.people, fifth.people)])
