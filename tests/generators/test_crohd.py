"""CroHD: the same heads from folder and archive, every fault named by file and line, and the splits made of them."""

import json
import random
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest

from tests.lib.crohd_files import SEQINFO, crowd, crowd_text, lines_of, pack, write_recording
from vbbench.cli import main
from vbbench.errors import FileError, SourceMissingError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import describe, summary_json
from vbbench.files.tables import file_sha256
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.catalogue import fetch_splits
from vbbench.generation.generator import Options
from vbbench.generation.sources import Source
from vbbench.scene import Scene
from vbbench_generators.lifting.heads import HeadBoxes
from vbbench_generators.recordings.loading import every_frame, load_scenes
from vbbench_generators.recordings.readers.crohd import find_recording, parse_seqinfo, read_heads
from vbbench_generators.recordings.recipe import get_recipe
from vbbench_generators.splits import shibuya01

GOOD = "2,7,101,51,20,30,1,1,0.5"
WALKS = "1,1,10,20,8,9,1,1,1\n2,1,12,20,8,9,1,1,1\n1,2,50,60,8,9,1,1,1\n2,2,52,60,8,9,1,1,1\n"
ARCHIVE = get_recipe("shibuya01").source[0]


def heads_at(place: Path, name: str = "HT21-03") -> HeadBoxes:
    return read_heads(find_recording(name, ARCHIVE, place, split="shibuya01"))


def same(one: HeadBoxes, other: HeadBoxes) -> None:
    assert (one.name, one.dt, one.size) == (other.name, other.dt, other.size)
    for name in ("frame", "track", "boxes", "visible"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_what_was_written_is_read(tmp_path: Path) -> None:
    heads = heads_at(write_recording(tmp_path / "mine"))
    np.testing.assert_allclose(heads.boxes, crowd().boxes, atol=1e-9)
    same(heads, replace(crowd(), name="HT21-03", boxes=heads.boxes))


def test_frames_and_boxes_count_from_0_and_facts_are_those_of_seqinfo(tmp_path: Path) -> None:
    info = SEQINFO.replace("frameRate=25", "FRAMERATE = 12.5").replace("1920", "800").replace("1080", "600")
    heads = heads_at(write_recording(tmp_path / "mine", WALKS, info="\ufeff; made by hand\r\n" + info))
    assert (heads.name, heads.dt, heads.size) == ("HT21-03", 0.08, (800, 600))
    assert heads.track.tolist() == [1, 1, 2, 2]
    assert heads.frame.tolist() == [0, 1, 0, 1]
    assert heads.boxes[0].tolist() == [9, 19, 8, 9]


def test_folder_parent_and_archive_are_the_same(tmp_path: Path) -> None:
    folder = write_recording(tmp_path / "a" / "labels" / "train" / "HT21-03")
    write_recording(tmp_path / "a" / "labels" / "train" / "HT21-04", WALKS, name="HT21-04")
    packed = pack(tmp_path / "x.zip", {"HT21/train/HT21-03": folder, "HT21/train/HT21-04": folder})
    places = (folder, tmp_path / "a", packed)
    read = [find_recording("HT21-03", ARCHIVE, place, split="shibuya01") for place in places]
    assert len({tuple(files.sums) for files in read}) == 1
    for files in read:
        same(read_heads(files), heads_at(folder))
    assert len(heads_at(tmp_path / "a", "HT21-04")) == 4


@pytest.mark.parametrize("dressed", [lambda text: text.replace("\n", "\r\n"), lambda text: text.replace(",", ", ")])
def test_other_line_ends_and_spaces_do_not_matter(tmp_path: Path, dressed: Callable[[str], str]) -> None:
    same(heads_at(write_recording(tmp_path / "b", dressed(WALKS))), heads_at(write_recording(tmp_path / "a", WALKS)))


def test_the_order_of_lines_and_gaps_between_them_do_not_matter(tmp_path: Path) -> None:
    lines = lines_of(crowd())
    random.Random(0).shuffle(lines)
    text = "# heads\n\n" + "\n\n".join(lines)
    same(heads_at(write_recording(tmp_path / "b", text)), heads_at(write_recording(tmp_path / "a")))


@pytest.mark.parametrize(
    "line",
    [
        *("1,9,1,1,5,5,0,1,1", "1,9,1,1,5,5,1,2,1", "1,9,1,1,5,5,1,3,1", "1,9,1,1,5,5,1,4,1", "1,9,1,1,5,5,1,1,0"),
        *("1,9,1,1,5,5,1,1,-1", "999,1,1,1,0,-5,1,3,7", "1,1,1,1,5,5,1,2,1"),
    ],
)
def test_rows_that_do_not_count_are_left_out_whatever_they_say(tmp_path: Path, line: str) -> None:
    heads = heads_at(write_recording(tmp_path / "a", f"{WALKS}{line}\n"))
    assert heads.track.tolist() == [1, 1, 2, 2]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("3,7,1,1,20", "5 columns with commas between, wanted 9: frame,id,left"),
        ("3,7,1,1,20,60,1,1,1,1", "10 columns"),
        ("3 7 1 1 20 60 1 1 1", "1 columns"),
        ("3,7,left,1,20,60,1,1,1", "left is 'left'; write a number"),
        ("3,7,,1,20,60,1,1,1", "left is ''; write a number"),
        ("3,7,nan,1,20,60,1,1,1", "left is nan; write a finite number"),
        ("3,7,1,1,20,60,1,3,inf", "visibility is inf"),
        ("0,7,1,1,20,60,1,1,1", "frame 0 is not in the sequence; its frames are 1 to 90"),
        ("91,7,1,1,20,60,1,1,1", "frame 91 is not in the sequence"),
        ("2.5,7,1,1,20,60,1,1,1", "frame 2.5 is not in the sequence"),
        ("3,1.5,1,1,20,60,1,1,1", "id 1.5 is not a whole number"),
        ("3,-1,1,1,20,60,1,1,1", "the id is missing here, other boxes have one"),
        ("3,7,1,1,0,60,1,1,1", "the box is 0 x 60 px"),
        ("3,7,1,1,20,-60,1,1,1", "the box is 20 x -60 px"),
        ("3,7,1,1,20,60,1,1,1.5", "visibility is 1.5"),
        ("2,7,1,1,20,60,1,1,1", "id 7 already has a box in this frame, in line 1; remove one of them"),
    ],
)
@pytest.mark.parametrize("packed", [False, True])
def test_a_bad_line_is_named(tmp_path: Path, line: str, problem: str, packed: bool) -> None:
    folder = write_recording(tmp_path / "HT21-03", f"{GOOD}\n{GOOD.replace('7', '8', 1)}\n{line}\n")
    place = pack(tmp_path / "labels.zip", {"train/HT21-03": folder}) if packed else folder
    within = place / "train/HT21-03" if packed else place
    with pytest.raises(FileError, match=problem) as caught:
        heads_at(place)
    assert (caught.value.line, caught.value.path) == (3, within / "gt/gt.txt")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "\n\n", "1,1,1,1,5,5,0,1,1\n", "1,1,1,1,5,5,1,1,1\n2,1,1,1,5,5,1,1,1\n"])
def test_no_crowd(tmp_path: Path, text: str) -> None:
    with pytest.raises(FileError, match="holds no crowd"):
        heads_at(write_recording(tmp_path / "mine", text))


def test_a_recording_too_large_for_a_scene(tmp_path: Path) -> None:
    text = "".join(f"{frame},{track},1,1,5,5,1,1,1\n" for track in range(101) for frame in (1, 1_000_000))
    with pytest.raises(FileError, match="1,000,000 frames of 101 people from 202 rows are too many"):
        heads_at(write_recording(tmp_path / "mine", text, info=SEQINFO.replace("=90", "=1000000")))


def test_no_text_at_all(tmp_path: Path) -> None:
    folder = write_recording(tmp_path / "mine")
    (folder / "gt" / "gt.txt").write_bytes(bytes(range(256)) * 100)
    with pytest.raises(FileError, match="line 1: "):
        heads_at(folder)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("name={name}\n", "", "key 'name' is missing"),
        ("frameRate=25\n", "", "key 'frameRate' is missing in its section"),
        ("frameRate=25", "frameRate=", "key 'frameRate' is missing"),
        ("frameRate=25", "frameRate=fast", "frameRate is 'fast', not a number of pictures a second"),
        ("frameRate=25", "frameRate=0", "frameRate is '0'"),
        ("frameRate=25", "frameRate=nan", "frameRate is 'nan'"),
        ("frameRate=25", "frameRate=inf", "frameRate is 'inf'"),
        ("seqLength=90", "seqLength=90.5", "seqLength is '90.5', not a whole number"),
        ("seqLength=90", "seqLength=99999999999", "seqLength is '99999999999', not a whole number from 1 to 1000000"),
        ("imWidth=1920", "imWidth=-1", "imWidth is '-1'"),
        ("imHeight=1080", "imHeight=0", "imHeight is '0'"),
        ("[Sequence]\n", "", "line 1: is not an ini file"),
        ("[Sequence]", "[Recording]", r"key 'name' is missing in its section \[Sequence\]"),
        ("imDir", "frameRate=30\nimDir", "line 5: is not an ini file"),
    ],
)
def test_a_bad_seqinfo(old: str, new: str, problem: str) -> None:
    assert old in SEQINFO
    with pytest.raises(FileError, match=problem) as caught:
        parse_seqinfo(Path("seqinfo.ini"), SEQINFO.replace(old, new, 1).encode())
    assert "\n" not in str(caught.value)


def test_a_seqinfo_that_is_no_text() -> None:
    with pytest.raises(FileError, match="is not a text file"):
        parse_seqinfo(Path("seqinfo.ini"), b"\xff\xfe\x00")


def test_what_cannot_be_found(tmp_path: Path) -> None:
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


def test_a_recording_that_is_there_twice(tmp_path: Path) -> None:
    for name in ("one", "two"):
        folder = write_recording(tmp_path / name / "HT21-03")
    with pytest.raises(FileError, match="more than once: one/HT21-03, two/HT21-03; name one of them"):
        heads_at(tmp_path)
    with pytest.raises(FileError, match="more than once"):
        heads_at(pack(tmp_path / "x.zip", {"a/HT21-03": folder, "b/HT21-03": folder}))


def test_an_archive_that_means_harm_is_refused(tmp_path: Path) -> None:
    folder = write_recording(tmp_path / "HT21-03")
    with pytest.raises(FileError, match="climbs out of the archive"):
        heads_at(pack(tmp_path / "x.zip", {"train/HT21-03": folder, "../HT21-05": folder}))


def test_the_published_archive_is_taken_from_the_data_folder_if_it_is_whole(no_data: Path, tmp_path: Path) -> None:
    with pytest.raises(SourceMissingError, match="vbbench fetch shibuya01"):
        load_scenes(get_recipe("shibuya01"), None, seed=0)
    folder = write_recording(tmp_path / "made" / "HT21-03")
    (no_data / "crohd").mkdir()
    packed = pack(no_data / "crohd" / "HT21Labels.zip", {"train/HT21-03": folder})
    for place in (None, no_data):
        with pytest.raises(FileError, match="its SHA-256 is"):
            find_recording("HT21-03", ARCHIVE, place, split="shibuya01")
    told = replace(ARCHIVE, sha256=file_sha256(packed))
    for place in (None, no_data):
        same(read_heads(find_recording("HT21-03", told, place, split="shibuya01")), heads_at(folder))


def test_both_splits_are_fetched_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted: list[Source] = []
    monkeypatch.setattr("vbbench.generation.catalogue.fetch", wanted.extend)
    fetch_splits(["shibuya01", "shibuya02"])
    assert wanted == [ARCHIVE]
    assert (ARCHIVE.size, ARCHIVE.sha256[:8]) == (53_547_421, "824e94f1")


@pytest.fixture
def published(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """An archive on a server, which the split shibuya01 is made from."""
    served = tmp_path / "served"
    folder = write_recording(tmp_path / "made" / "HT21-03")
    served.mkdir()
    packed = pack(served / "HT21Labels.zip", {"train/HT21-03": folder})
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(QuietHandler, directory=str(served))) as server:
        url = f"http://127.0.0.1:{server.server_port}/HT21Labels.zip"
        source = replace(ARCHIVE, url=url, sha256=file_sha256(packed), size=packed.stat().st_size)
        monkeypatch.setitem(shibuya01.__dict__, "recipe", replace(get_recipe("shibuya01"), source=(source,)))
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield
        server.shutdown()
        thread.join()


class QuietHandler(SimpleHTTPRequestHandler):
    def log_message(self, *args: object) -> None:
        """Keep the test output clean."""


def test_from_the_server_to_the_dataset(
    published: None, no_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fetch", "shibuya01"]) == 0
    assert capsys.readouterr().out == f"{no_data}/crohd/HT21Labels.zip\n"
    assert main(["generate", "shibuya01", "--limit", "2", "--out", str(tmp_path / "s")]) == 0
    assert "2 sequences" in capsys.readouterr().out
    assert [path.name for path in no_data.rglob("*")] == ["crohd", "HT21Labels.zip"]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_recording(tmp_path_factory.mktemp("crohd") / "HT21-03")


@pytest.fixture(scope="module")
def dataset(recording: Path, tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("shibuya01", tmp_path_factory.mktemp("made") / "s", Options(source=recording))


@pytest.mark.slow
def test_every_track_observes_once_and_all_others_are_seen(dataset: Dataset) -> None:
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


def test_the_dataset_says_how_its_metres_were_found(dataset: Dataset) -> None:
    info = Dataset(dataset.folder).info
    assert info.calibration is not None
    assert info.calibration["pseudo_metric"]
    height = info.calibration["camera_height"]
    assert height["low"] < 12.0 < height["high"]
    assert info.caution
    assert "pseudo-metric" in info.caution
    assert info.definition["recording"] == "HT21-03"
    assert info.definition["frame_step"] == 1
    assert [name for name, _ in info.definition["files"]] == ["HT21-03/seqinfo.ini", "HT21-03/gt/gt.txt"]
    assert replace(info, calibration=None).id == info.id


def test_info_stands_beside_the_paper(dataset: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    text = describe(dataset.info)
    assert "the paper: 806 sequences, mean 317 frames, people 1 / 523 / 770" in text
    assert "calibration: pseudo-metric, self-calibrated from head sizes" in text
    told = json.loads(summary_json(dataset.info))
    assert told["paper"] == {"sequences": 806, "frames": "317", "people": "1 / 523 / 770"}
    assert told["calibration"]["method"] in ("motion", "prior")
    assert main(["info", str(dataset.folder)]) == 0
    assert capsys.readouterr().out == text + "\n"


def test_boxes_are_rounded_as_the_recipe_says(dataset: Dataset) -> None:
    boxes = dataset.sequence(0).observations
    boxes = boxes[~np.isnan(boxes[..., 0])] * np.array([2.0**10, 2.0**10, 2.0**12])
    np.testing.assert_array_equal(boxes, np.round(boxes))


def test_folder_and_archive_make_the_same_dataset(dataset: Dataset, recording: Path, tmp_path: Path) -> None:
    packed = pack(tmp_path / "labels.zip", {"train/HT21-03": recording})
    other = generate("shibuya01", tmp_path / "other", Options(source=packed))
    assert other.info == dataset.info


def test_with_a_homography_metres_are_metres(recording: Path, tmp_path: Path) -> None:
    matrix = tmp_path / "H.txt"
    # u = 960 + 1600 x / Z, v as in tests/lib/lifting_crowd.py with its camera 12 m high, 30 degrees down.
    sin, cos, below = 0.5, np.sqrt(0.75), 12.0
    view = np.array([[1600, 960 * cos, 960 * below * sin], [0, 540 * cos - 1600 * sin, 1600 * below * cos], [0, 0, 0]])
    view[1, 2] += 540 * below * sin
    view[2] = [0, cos, below * sin]
    np.savetxt(matrix, np.linalg.inv(view))
    made = generate("shibuya01", tmp_path / "s", Options(source=recording, homography=matrix, limit=3))
    assert made.info.caution is None
    assert made.info.calibration is not None
    assert made.info.calibration["method"] == "homography"
    assert made.info.calibration["camera_height"]["value"] == pytest.approx(12.0, rel=1e-6)
    assert made.info.definition["files"][2][0] == "homography"
    assert "calibration: by the user's homography" in describe(made.info)


def test_dt_is_that_of_the_recording(recording: Path) -> None:
    with pytest.raises(VbbenchError, match=r"`dt` is for the split 'custom'; here seqinfo\.ini has"):
        load_scenes(get_recipe("shibuya01"), recording, seed=0, dt=0.4)


def test_fewer_frames_where_a_recipe_says_so(recording: Path) -> None:
    recipe = get_recipe("shibuya01")
    every = load_scenes(recipe, recording, seed=0).scenes[0]
    fifth = load_scenes(replace(recipe, frame_step=5), recording, seed=0).scenes[0]
    assert fifth.dt == pytest.approx(0.2)
    np.testing.assert_array_equal(fifth.positions, every.positions[::5][:, np.isin(every.people, fifth.people)])


def test_who_is_there_between_frames_only_is_left_out() -> None:
    positions = np.full((5, 2, 2), np.nan)
    positions[1:4, 0], positions[0:3, 1] = 0.0, 1.0
    scene = Scene(name="s", dt=0.1, people=np.array([3, 4]), positions=positions, heights=np.full(2, np.nan))
    assert every_frame(scene, 4).people.tolist() == [4]
    assert every_frame(scene, 1) is scene


def test_the_text_of_the_tests_is_that_of_the_crowd() -> None:
    assert crowd_text().count("\n") == len(crowd())
