"""MOTChallenge text: the way out and back, whom tracks are matched to, and every way a file can be bad."""

import configparser
import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.lib.make_dataset import Crowd, write_dataset
from tests.lib.mot_text import read_mot
from vbbench.boxes import cut_to_picture, observations_of, overlaps, rectangles
from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.box_rows import BoxRows
from vbbench.exchange.matching import match_boxes, match_tracks
from vbbench.exchange.mot import PIXEL_STD, export_mot, import_mot, write_mot
from vbbench.files.dataset import Dataset
from vbbench.files.tables import file_sha256
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.pictures.rendering import Backend
from vbbench.scoring import score
from vbbench.sequence import NOBODY
from vbbench.solving import solve
from vbbench_generators.tiers.tracking import get_tracking

FROM_ONE = np.array([1.0, 1.0, 0.0, 0.0])
GOOD = "2,7,101,51,20,60,1,1,0.5"


@pytest.fixture(scope="module", params=["panorama", "perspective"])
def dataset(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    camera = PanoramaCamera() if request.param == "panorama" else PerspectiveCamera()
    return generate("demo", tmp_path_factory.mktemp("mot") / "demo", Options(camera=camera, limit=5))


@pytest.fixture(scope="module")
def files(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return export_mot(dataset, tmp_path_factory.mktemp("mot") / "files")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "sequence-000000.txt"


def by_track(sequence: Any) -> dict[int, Any]:
    return {int(track): sequence.observations[:, k] for k, track in enumerate(sequence.tracks)}


def fullest(dataset: Dataset) -> int:
    return max(range(len(dataset)), key=lambda number: dataset.sequence(number).observed.sum())


@given(
    boxes=arrays(np.float64, st.tuples(st.integers(1, 9), st.just(4)), elements=st.floats(0.1, 2000)),
    visible=st.floats(0.01, 1),
    linked=st.booleans(),
)
def test_boxes_come_back(tmp_path_factory, boxes, visible, linked):
    path, count = tmp_path_factory.mktemp("trip") / "gt.txt", len(boxes)
    numbers = np.arange(count)
    rows = BoxRows(
        frame=numbers,
        track=numbers if linked else np.full(count, -1),
        boxes=boxes,
        path=path,
        scores=np.full(count, 0.5),
        visible=np.full(count, visible),
        lines=numbers + 1,
    )
    write_mot(path, rows)
    back = read_mot(path, count)
    np.testing.assert_allclose(back.boxes, boxes, atol=1e-9)
    for name in ("frame", "track", "scores", "lines"):
        np.testing.assert_array_equal(getattr(back, name), getattr(rows, name))
    np.testing.assert_allclose(back.visible, visible if linked else np.nan, rtol=1e-5)


def test_frames_and_boxes_are_written_from_one(file):
    row = {"frame": [0], "track": [3], "boxes": [[0.0, 10.0, 5.0, 6.0]], "scores": [1], "visible": [1]}
    write_mot(file, BoxRows(path=file, lines=np.ones(1), **{name: np.array(values) for name, values in row.items()}))
    assert file.read_text() == "1,3,1.0,11.0,5.0,6.0,1,1,1\n"


@pytest.mark.parametrize(
    ("line", "counts"),
    [
        ("1,7,1,1,20,60", True),
        ("1,7,1,1,20,60,0.3", True),
        ("1,7,1,1,20,60,0,-1,-1,-1", True),
        ("1, 7, 1, 1, 20, 60, 1, -1, -1", True),
        ("1,7,1,1,20,60,0,1,1", False),
        ("1,7,1,1,20,60,1,1,0", False),
    ],
)
def test_what_the_evaluation_of_motchallenge_leaves_out_is_left_out(file, line, counts):
    file.write_text(f"# made by hand\n\n{line}\n")
    assert len(read_mot(file, 1).frame) == counts


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("3,7,1,1,20", "5 columns with commas between, wanted 6 to 10"),
        ("3 7 1 1 20 60", "1 columns"),
        ("3,7,1,1,20,60,1,1,1,1,1", "11 columns"),
        ("3,1.5,1,1,20,60", "id 1.5 is not a whole number"),
        ("3,-2,1,1,20,60", "id -2 is not a whole number"),
        ("3,7,1,1,0,60", "the box is 0 x 60 px"),
        ("2,7,1,1,20,60", "id 7 already has a box in this frame, in line 1"),
    ],
)
def test_a_bad_line_is_named(file, line, problem):
    file.write_text(f"{GOOD}\n\n{line}\n")
    with pytest.raises(FileError, match=problem) as caught:
        read_mot(file, 9)
    assert (caught.value.line, caught.value.path) == (3, file)


def test_a_sequence_is_told_as_motchallenge_does(dataset, files):
    text = configparser.ConfigParser()
    text.optionxform = str  # type: ignore[assignment, method-assign]
    text.read(files / "sequence-000002" / "seqinfo.ini")
    facts = dict(text["Sequence"])
    width, height = (1440, 480) if dataset.info.camera.kind == "panorama" else (1280, 720)
    assert facts == {
        "name": "sequence-000002",
        "imDir": "img1",
        "frameRate": "2.5",
        "seqLength": str(dataset.sequence(2).frames),
        "imWidth": str(width),
        "imHeight": str(height),
        "imExt": ".png",
    }
    assert len(list(files.iterdir())) == len(dataset)


def test_detections_are_the_same_boxes_without_tracks(dataset, files):
    number = fullest(dataset)
    frames, folder = dataset.sequence(number).frames, files / f"sequence-{number:06d}"
    tracks, found = read_mot(folder / "gt" / "gt.txt", frames), read_mot(folder / "det" / "det.txt", frames)
    assert len(tracks.frame) == dataset.sequence(number).observed.sum() > 0
    np.testing.assert_array_equal(found.boxes, tracks.boxes)
    assert set(found.track.tolist()) == {-1}


def test_pictures_are_rendered_without_any_mark(dataset, tmp_path):
    backend = Backend(name="tests.lib.flat_renderer:FlatRenderer")
    out = export_mot(dataset, tmp_path / "files", sequence=1, backend=backend)
    pictures = sorted((out / "sequence-000001" / "img1").iterdir())
    assert [path.name for path in pictures[:2]] == ["000001.png", "000002.png"]
    assert len(pictures) == dataset.sequence(1).frames
    assert cv2.imread(str(pictures[0])).shape[:2] == (
        (480, 1440) if dataset.info.camera.kind == "panorama" else (720, 1280)
    )


def test_what_was_exported_comes_back(dataset, files, tmp_path):
    made = import_mot(files, dataset, tmp_path / "back")
    assert made.info.tier == "tracked"
    assert made.info.id != dataset.info.id
    assert "sequences are as written" in verify(made.folder)
    for before, after in zip(dataset.sequences(), made.sequences(), strict=True):
        old, new = by_track(before), by_track(after)
        short = [track for track, boxes in old.items() if np.isfinite(boxes[:, 2]).sum() < 3]
        assert set(old) - set(new) == set(short)
        for track, boxes in new.items():
            np.testing.assert_allclose(boxes, old[track], atol=1e-9)
        real, people = made.track_persons(after), dataset.track_persons(before)[0]
        expected = np.broadcast_to(people[np.searchsorted(before.tracks, after.tracks)], real.shape)
        assert np.all(real[after.observed] == expected[after.observed])
        np.testing.assert_array_equal(made.truth(after).poses, dataset.truth(before).poses)


@pytest.mark.slow
def test_the_new_dataset_is_solved_and_scored(dataset, files, tmp_path):
    made = import_mot(files, dataset, tmp_path / "back")
    one, other = (
        score(solve(data, "cv", "one-step", tmp_path / name), data.folder).values()["metrics"]["dx"]["mean"]
        for name, data in (("made", made), ("before", dataset))
    )
    assert one == pytest.approx(other, rel=0.2)


def test_a_switch_a_break_and_a_false_alarm_are_told_apart(dataset, tmp_path):
    sequence = dataset.sequence(fullest(dataset))
    column = int(sequence.observed.sum(axis=0).argmax())
    person, boxes = (
        int(dataset.track_persons(sequence)[0, column]),
        rectangles(sequence.observations[:, column]) + FROM_ONE,
    )
    seen = np.flatnonzero(sequence.observed[:, column])
    half = len(seen) // 2
    lines = [(t, 100 if t < seen[half] else 200, *boxes[t]) for t in seen]
    lines += [(t, 300, 3.0, 3.0, 9.0, 20.0) for t in seen]
    lines += [(seen[0], 200, 3.0, 30.0, 9.0, 20.0)]
    text = "".join(f"{t + 1},{','.join(map(str, row))},1,-1,-1,-1\n" for t, *row in lines)
    (tmp_path / f"sequence-{sequence.index:06d}.txt").write_text(text)
    with pytest.warns(VbbenchWarning, match=f"only {len(seen)} of {2 * len(seen) + 1} boxes match a person"):
        made = import_mot(tmp_path, dataset, tmp_path / "made", least_matched=0.4)
    after, expected = made.sequence(0), [100, 200]
    assert after.tracks.tolist() == expected
    persons = made.track_persons(after)
    assert set(persons[seen[:half], 0].tolist()) == {person}
    assert set(persons[seen[half:], 1].tolist()) == {person}
    assert persons[seen[0], 1] == NOBODY
    assert after.observed[seen[0], 1]
    given = np.flatnonzero(~np.isnan(after.given.positions[:, 1, 0]))
    assert given.tolist() == seen[half : half + 2].tolist()
    assert np.isnan(made.truth(after).positions[seen[0], 1]).all()


def test_imported_boxes_are_told_to_be_as_noisy_as_those_of_the_tracker_that_comes_along():
    settings = get_tracking()
    assert {"perspective": settings.perspective_std, "panorama": settings.panorama_std} == PIXEL_STD


def test_results_beside_the_exported_folders_are_what_counts(dataset, files, tmp_path):
    folder = shutil.copytree(files, tmp_path / "files")
    shutil.copy(files / "sequence-000003" / "gt" / "gt.txt", folder / "sequence-000003.txt")
    made = import_mot(folder, dataset, tmp_path / "made")
    assert len(made) == 1
    assert made.info.definition["files"] == {"3": file_sha256(folder / "sequence-000003.txt")}
    assert made.info.definition["dataset"] == dataset.info.id
    assert made.sequence(0).observer == dataset.sequence(3).observer
    np.testing.assert_array_equal(made.truth(made.sequence(0)).poses, dataset.truth(dataset.sequence(3)).poses)


@pytest.mark.slow
def test_another_file_is_another_dataset_and_the_same_file_the_same(dataset, files, tmp_path):
    first = import_mot(files, dataset, tmp_path / "a").info.id
    assert import_mot(files, dataset, tmp_path / "b").info.id == first
    with pytest.raises(VbbenchError, match=r"set .overwrite"):
        import_mot(files, dataset, tmp_path / "a")
    folder = shutil.copytree(files, tmp_path / "files")
    path = folder / f"sequence-{fullest(dataset):06d}" / "gt" / "gt.txt"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))
    assert import_mot(folder, dataset, tmp_path / "a", overwrite=True).info.id != first


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("sequence-000000.txt", "1,-1,1,1,20,60,1,-1,-1,-1\n", "line 1: id is -1: these are detections"),
        ("sequence-000000.txt", "1,1,1,1,2,6\n", "no track matches a person in 3 frames"),
        ("sequence-000000.txt", "", "no track matches a person in 3 frames"),
        ("sequence-000000.csv", "frame,id,x1,y1,x2,y2\n", "no track matches a person in 3 frames"),
        ("sequence-000000.json", "[]", "no track matches a person in 3 frames"),
        ("sequence-000900.txt", GOOD, "belongs to no sequence"),
        ("MOT17-02.txt", GOOD, "belongs to no sequence"),
        ("notes.md", "", "holds no tracks; files are called sequence-000000.txt"),
    ],
)
def test_files_that_are_of_no_use_are_refused(dataset, tmp_path, name, text, problem):
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / name).write_text(text)
    with pytest.raises(FileError, match=problem):
        import_mot(tmp_path / "files", dataset, tmp_path / "made")
    assert not (tmp_path / "made").exists()


def rewritten(files: Path, number: int, folder: Path, line: Any) -> Path:
    """The boxes of one sequence with every line changed by a function of its cells."""
    rows = (files / f"sequence-{number:06d}" / "gt" / "gt.txt").read_text().splitlines()
    folder.mkdir()
    text = "".join(f"{line(*row.split(',')[:6])}\n" for row in rows)
    (folder / f"sequence-{number:06d}.txt").write_text(text)
    return folder


def test_boxes_of_another_picture_are_refused_with_numbers(dataset, files, tmp_path):
    number = fullest(dataset)
    count, size = dataset.sequence(number).observed.sum(), dataset.info.camera.picture_size
    half = rewritten(
        files, number, tmp_path / "half", lambda *row: ",".join([*row[:2], *(str(float(cell) / 2) for cell in row[2:])])
    )
    with pytest.raises(
        FileError, match=rf"of {count} boxes match a person; .* {size[0]} x {size[1]}, and numbered|no tra"
    ):
        import_mot(half, dataset, tmp_path / "made")
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize("least", [0.5, 0.0], ids=["refused", "warned of"])
def test_boxes_of_other_frames_are_named(dataset, files, tmp_path, least):
    number = fullest(dataset)
    early = rewritten(files, number, tmp_path / "early", lambda frame, *row: ",".join([f"{int(frame) - 1}", *row]))
    path = early / f"sequence-{number:06d}.txt"
    path.write_text("".join(line for line in path.read_text().splitlines(keepends=True) if not line.startswith("0,")))
    said = f"{path.name}: boxes overlap people one frame later by 1.00, now by 0..*do frames count from 0 or from 1"
    with pytest.warns(VbbenchWarning, match=said) if least == 0.0 else pytest.raises(FileError, match=said):
        import_mot(early, dataset, tmp_path / "made", least_matched=least)


def test_people_are_class_0_of_coco_or_as_stated(dataset, files, tmp_path):
    number = fullest(dataset)
    plain = rewritten(files, number, tmp_path / "plain", lambda *row: ",".join(row))
    expected = import_mot(plain, dataset, tmp_path / "a").sequence(0).observations
    coco = rewritten(files, number, tmp_path / "coco", lambda *row: ",".join([*row, "0.9", "0", "-1"]))
    path = next(coco.iterdir())
    path.write_text(path.read_text() + "1,900,1,1,20,60,0.9,2,-1\n")
    with pytest.warns(VbbenchWarning, match="boxes are dropped: 1 of class 2"):
        made = import_mot(coco, dataset, tmp_path / "b")
    np.testing.assert_array_equal(made.sequence(0).observations, expected)
    other = rewritten(files, number, tmp_path / "other", lambda *row: ",".join([*row, "0.9", "7", "-1"]))
    with pytest.raises(FileError, match="`person_class`"):
        import_mot(other, dataset, tmp_path / "c")
    made = import_mot(other, dataset, tmp_path / "c", person_class="7")
    np.testing.assert_array_equal(made.sequence(0).observations, expected)
    assert made.info.definition["person_class"] == "7"


def test_pictures_of_another_size_or_rate_are_refused(dataset, files, tmp_path):
    folder = shutil.copytree(files, tmp_path / "files")
    info = folder / "sequence-000001" / "seqinfo.ini"
    width, height = dataset.info.camera.picture_size
    right = info.read_text()
    info.write_text(right.replace("frameRate=2.5", "frameRate=25"))
    with pytest.raises(FileError, match=r"its frameRate is 25, the dataset's 2.5"):
        import_mot(folder, dataset, tmp_path / "made")
    info.write_text(right.replace(f"imWidth={width}", "imWidth=1920"))
    with pytest.raises(FileError, match=f"have 1920 x {height} px, the dataset's {width} x {height}"):
        import_mot(folder, dataset, tmp_path / "made")


def test_a_line_of_names_time_stamps_and_gaps_are_read(dataset, files, tmp_path):
    number, dt = fullest(dataset), dataset.info.dt
    plain = rewritten(files, number, tmp_path / "plain", lambda *row: ",".join(row))
    timed = rewritten(
        files, number, tmp_path / "timed", lambda *row: ",".join([f"{(int(row[0]) - 1) * dt + 0.03:.3f}", *row[1:]])
    )
    path = next(timed.iterdir())
    path.write_text("time,id,bb_left,bb_top,bb_width,bb_height\n" + path.read_text())
    one, other = (import_mot(folder, dataset, tmp_path / f"{folder.name}-made") for folder in (plain, timed))
    np.testing.assert_array_equal(one.sequence(0).observations, other.sequence(0).observations)
    head, *rows = path.read_text().splitlines()
    cells = [row.split(",", 1) for row in rows]
    path.write_text("\n".join([head, *(f"{float(time) + 0.4 * dt:.3f},{rest}" for time, rest in cells)]))
    with pytest.raises(FileError, match="lies between two frames; frame n is at n x"):
        import_mot(timed, dataset, tmp_path / "made")
    path.write_text("id,frame,left\n1,1,1\n")
    with pytest.raises(FileError, match="has no column top or bottom or v"):
        import_mot(timed, dataset, tmp_path / "made")
    turned = rewritten(
        files, number, tmp_path / "turned", lambda *row: ",".join([*row[:2], row[4], row[3], row[2], row[5]])
    )
    path = next(turned.iterdir())
    path.write_text("frame,track_id,w,y,x,h\n" + path.read_text())
    again = import_mot(turned, dataset, tmp_path / "turned-made")
    np.testing.assert_array_equal(again.sequence(0).observations, one.sequence(0).observations)
    with pytest.raises(VbbenchError, match="least_matched is a share"):
        import_mot(plain, dataset, tmp_path / "made", least_matched=2.0)


def test_sequences_with_a_scene_each_keep_it(tmp_path):
    write_dataset(tmp_path / "tiny", Crowd(scenes=4, sequences=None, people=4, stay=(12, 16)))
    source = Dataset(tmp_path / "tiny")
    files = export_mot(source, tmp_path / "files")
    made = import_mot(files, source, tmp_path / "made")
    verify(made.folder)
    for before, after in zip(source.sequences(), made.sequences(), strict=True):
        np.testing.assert_array_equal(made.scene(after.scene)[0], source.scene(before.scene)[0])


def test_the_command_line_says_what_was_kept(dataset, files, tmp_path, capsys):
    assert main(["export", "mot", str(dataset.folder), "--out", str(tmp_path / "files"), "--sequence", "2"]) == 0
    assert main(["import", "mot", str(files), "--dataset", str(dataset.folder), "--out", str(tmp_path / "made")]) == 0
    shown = capsys.readouterr()
    assert shown.out.splitlines() == [str(tmp_path / "files"), str(tmp_path / "made")]
    assert "boxes kept: of tracks that match a person in 3 frames or more" in shown.err
    assert main(["import", "mot", str(tmp_path), "--dataset", str(dataset.folder), "--out", str(tmp_path / "x")]) == 2


def test_overlaps_are_those_of_areas():
    box = np.array([[0.0, 0.0, 10.0, 10.0]])
    others = np.array([[5.0, 0, 10, 10], [0, 0, 10, 10], [2, 2, 4, 4], [np.nan] * 4, [20, 0, 1, 1], [3, 3, 0, 0]])
    np.testing.assert_allclose(overlaps(box, others)[0], [1 / 3, 1, 0.16, 0, 0, 0])


@given(arrays(np.float64, (6, 4), elements=st.integers(0, 200).map(lambda n: n / 4)), st.floats(-200, 200))
def test_overlaps_are_symmetric_bounded_and_the_same_anywhere(boxes, shift):
    shared = overlaps(boxes[:3], boxes[3:])
    assert np.all((shared >= 0) & (shared <= 1 + 1e-12))
    np.testing.assert_allclose(overlaps(boxes[3:], boxes[:3]), shared.T, atol=1e-12)
    turned, once = boxes + np.array([shift, 0, 0, 0]), np.array([400.0, 0, 0, 0])
    np.testing.assert_allclose(overlaps(turned[:3], turned[3:] + once, 400.0), shared, atol=1e-6)


def test_boxes_meet_across_the_seam():
    boxes = np.array([[-5.0, 0, 10, 10]]), np.array([[1435.0, 0, 10, 10]])
    assert overlaps(*boxes)[0, 0] == 0
    assert overlaps(*boxes, 1440.0)[0, 0] == pytest.approx(1)
    assert match_boxes(*boxes, PanoramaCamera())[0].tolist() == [0]
    assert match_boxes(*boxes, PerspectiveCamera())[0].tolist() == []


def test_a_box_cut_by_the_picture_is_as_good_as_the_whole():
    whole, cut = np.array([[600.0, 300, 300, 900]]), np.array([[600.0, 300, 300, 420]])
    assert overlaps(whole, cut)[0, 0] < 0.5
    assert match_boxes(cut, whole, PerspectiveCamera())[1].tolist() == [0]
    np.testing.assert_array_equal(cut_to_picture(whole, PerspectiveCamera()), cut)


def test_as_much_as_possible_overlaps_and_nobody_is_taken_twice():
    true = np.array([[0.0, 0, 20, 60], [8, 0, 20, 60]])
    found = np.array([[5.0, 0, 20, 60], [-1, 0, 20, 60], [300, 0, 20, 60]])
    rows, columns = match_boxes(found, true, PanoramaCamera())
    assert list(zip(rows.tolist(), columns.tolist(), strict=True)) == [(0, 1), (1, 0)]
    tracks = match_tracks(np.stack([found, found * np.nan]), np.stack([true, true]), np.array([4, 9]), PanoramaCamera())
    assert tracks.tolist() == [[9, 4, NOBODY], [NOBODY] * 3]


@pytest.mark.parametrize("camera", [PanoramaCamera(), PerspectiveCamera()])
def test_rectangles_and_observations_are_one_another(camera):
    seen = np.array([[0.0, 200.0, 90.0], [700.0, 260.0, 30.0], [np.nan] * 3])
    np.testing.assert_allclose(observations_of(rectangles(seen), camera), seen)
