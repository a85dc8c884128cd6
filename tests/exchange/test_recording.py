"""Recordings of the user's own: every kind of file that is read, split ``own``, and what is said of bad files."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

from tests.lib.own_recording import (
    CAMERA_TOML,
    HEAD,
    make_walk,
    write_csv,
    write_folder,
    write_mot,
    write_people,
    write_tum,
)
from vbbench.camera import EquirectangularCamera, PanoramaCamera, PerspectiveCamera
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.box_rows import time_frames
from vbbench.exchange.mot import import_mot
from vbbench.exchange.own.camera_file import read_camera
from vbbench.exchange.own.recording import ASSUMED_NOISE, box_noise, files_in, read_recording
from vbbench.exchange.text_tables import Rows
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import describe
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.datasets import stream
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_generators.footage.own import own

GOOD = "".join(f"{t},{k},{300 + 9 * k + t},320,30,90\n" for t in range(8) for k in range(4))


def read(folder: Path):
    return read_recording(files_in(folder))


def test_every_kind_of_box_file_has_figures_of(folder, walk):
    expected = read(folder).footage
    assert (expected.frames, expected.dt, expected.tracks.tolist()) == (60, 0.1, list(range(1, 9)))
    seen = np.isfinite(walk.boxes[..., 0])
    np.testing.assert_allclose(expected.boxes[seen][:, 2], walk.boxes[seen][:, 3], atol=1e-4)
    np.testing.assert_allclose(
        expected.boxes[seen][:, 0], (walk.boxes[..., 0] + walk.boxes[..., 2] / 2)[seen], atol=1e-3
    )
    (folder / "boxes.csv").unlink()
    write_mot(folder / "gt" / "gt.txt", walk)
    np.testing.assert_allclose(read(folder).footage.boxes, expected.boxes, atol=1e-3)
    lines = [f"{t},{k},{x + w / 2:.6f},{y + h / 2:.6f},{h:.6f}\n" for t, k, (x, y, w, h) in walk.rows]
    (folder / "boxes.csv").write_text("frame,id,u,v,l\n" + "".join(reversed(lines)))
    np.testing.assert_allclose(read(folder).footage.boxes, expected.boxes, atol=1e-3)
    write_csv(folder / "boxes.csv", walk, begin=1.7e9)
    np.testing.assert_allclose(read(folder).footage.boxes, expected.boxes, atol=1e-3)
    assert read(folder).rows.timeline.times[:2].tolist() == [1.7e9, pytest.approx(1.7e9 + 0.1)]


def test_how_long_a_frame_lasts_is_told_by_all_time_stamps(tmp_path):
    stamps = 0.4 * np.arange(24) + np.where(np.arange(24) < 1, -0.1, 0.0) + np.where(np.arange(24) > 22, 0.1, 0.0)
    frame, timeline = time_frames(Rows(path=tmp_path / "boxes.csv", lines=np.arange(24)), stamps, None)
    assert frame.tolist() == list(range(24))
    assert timeline.dt == pytest.approx(0.4, rel=0.01)  # the first and the last alone say .409


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("mount_height = 0", "mount_height, the camera's height over the ground, must be 0.05 to 100 m, not 0"),
        ("focal = 4.2", "a focal length of 4.2 px lets 1280 px span 179°, which no camera does"),
        ("focal = 70000", "span 1.05°"),
        ("cy = 3605", "cy = 3605 is far outside the 720 rows of the picture; their middle is 360"),
        ("cx = -9999", "cx = -9999 is far outside the 1280 columns"),
        ("fx = 700", "focal and fx are the same quantity"),
        ("focl = 700", "unknown key 'focl'; did you mean 'focal'"),
        ("model = 'fisheye'", "no camera is called 'fisheye'.* stands under .distortion."),
        ("dt = 0.1", "dt and fps are the same quantity"),
        ("pitch = 30", r"pitch must be -1\.2 to 1\.2 rad \(degrees x 0\.01745\), not 30"),
        ("focal = 84.9", r"\(often .* is it a field of view in degrees\? then fov = 84\.9"),
        ("[distortion]\nk7 = 1.0", "unknown key 'k7'"),
        ("vfov = 54", "unknown key 'vfov'; fov is from left to right, vertical_fov from top to bottom.* of a diagonal"),
        ("[distortion]\nmodel = 'fisheye'\np1 = 0.1", "fisheye model has k1 to k4 only, not p1"),
        ("fov = 90", "focal and fov are the same quantity"),
        ("focal = 700\nvertical_fov = 90", "focal and vertical_fov are the same quantity"),
        ("focal = 1.0e3\nmodel = 'panorama'\nfov = 360", "fov, the field of view, must be 3 to 150 degrees, not 360"),
        ("cx = 0.5\ncy = 0.5", "are shares of the picture; write px"),
        ("mount_height = 160", r"must be 0\.05 to 100 m, not 160"),
        ("carried_by = 'car'", "carried_by cannot be 'car'; known: unknown, person, vehicle, robot"),
        ("box_edge = 45", "box_edge must be 0 to 1 m, not 45"),
        ("[parameters]\nzoom = 2.0", "camera model 'perspective' has no 'zoom'"),
    ],
)
def test_a_camera_nobody_has_is_refused(tmp_path, line, problem):
    path = tmp_path / "camera.toml"
    key = line.partition(" =")[0]
    kept = [row for row in CAMERA_TOML.splitlines() if not row.startswith(f"{key} =")]
    path.write_text("\n".join([*kept, line]))
    with pytest.raises(FileError, match=problem):
        read_camera(path)


def test_a_pitch_in_degrees_is_named_before_another_picture(tmp_path):
    folder = write_folder(tmp_path / "walk", make_walk(20), camera=CAMERA_TOML + "pitch = -1.0\n")
    (note,) = read_recording(files_in(folder)).notes
    assert "boxes fit so many degrees: write pitch = -0.01745" in note


def test_what_is_left_out_of_a_camera_file_is_said(tmp_path):
    path = tmp_path / "camera.toml"
    for key in ("mount_height", "width", "height", "focal"):
        path.write_text("\n".join(row for row in CAMERA_TOML.splitlines() if not row.startswith(f"{key} =")))
        with pytest.raises(FileError, match=f"{key}.*missing|focal length is missing"):
            read_camera(path)
    path.write_text("model = 'panorama'\nwidth = 3760\nheight = 480\ncy = 209.4\nfocal = 482.9\nmount_height = 0.76\n")
    assert read_camera(path).camera == PanoramaCamera(width=3760, cy=209.4, focal=482.9, mount_height=0.76)
    path.write_text("width = 640\nheight = 480\nfx = 500\nfy = 510\ncx = 300\npitch = 0.1\nmount_height = 1.2\n")
    expected = PerspectiveCamera(
        width=640, height=480, focal=500.0, vertical_focal=510.0, cx=300.0, cy=240.0, pitch=0.1, mount_height=1.2
    )
    assert read_camera(path).camera == expected


def test_a_field_of_view_is_a_focal_length(tmp_path):
    path, sized = tmp_path / "camera.toml", "width = 640\nheight = 480\nmount_height = 1.2\n"
    path.write_text(f"{sized}fov = 90\n")
    assert read_camera(path).camera.focal == pytest.approx(320.0)
    path.write_text(f"{sized}vertical_fov = 60\n")
    assert read_camera(path).camera.focal == pytest.approx(240.0 / np.tan(np.radians(30.0)))
    path.write_text(f"{sized}fov = 90\nvertical_fov = 60\n")
    np.testing.assert_allclose(np.diag(read_camera(path).camera.intrinsics), [320.0, 240.0 * 3**0.5, 1.0])
    for wrong, problem in (
        ("fov = 1.57", "must be 3 to 150 degrees"),
        ("fov = 90\n[distortion]\nk1 = 0.1\np1 = 0.0", "of a lens with"),
    ):
        path.write_text(f"{sized}{wrong}\n")
        with pytest.raises(FileError, match=problem):
            read_camera(path)


def test_a_picture_of_360_degrees_is_a_cylinder_or_a_sphere(tmp_path):
    path, sized = tmp_path / "camera.toml", "width = 3840\nheight = 1920\nmount_height = 1.5\n"
    sphere = EquirectangularCamera(width=3840, height=1920, focal=1920 / np.pi, cy=960.0, mount_height=1.5)
    for text in (sized, sized.replace("height = 1920\n", "cy = 960\n"), f"{sized}cy = 960\n"):
        path.write_text(f"model = 'equirectangular'\n{text}")
        assert (read_camera(path).camera, read_camera(path).notes) == (sphere, ())
        path.write_text(f"model = 'panorama'\n{text}")
        (note,) = read_camera(path).notes
        assert 'model = "equirectangular"' in note
    level = sized.replace("height = 1920", "cy = 0")
    for text in (sized.replace("1920", "480"), f"{sized}focal = 1200.0\n", f"{sized}cy = 700\n", level):
        path.write_text(f"model = 'panorama'\n{text}")
        assert read_camera(path).notes == ()
    path.write_text(f"model = 'equirectangular'\n{sized}".replace("1920", "1080"))
    with pytest.raises(FileError, match=r"write focal .*611.2 if rows were cut off, 343.8 if the picture was scaled"):
        read_camera(path)
    path.write_text("model = 'panorama'\nwidth = 3840\nmount_height = 1.5\n")
    with pytest.raises(FileError, match="write cy, the row of the horizon in px, or height"):
        read_camera(path)


@pytest.mark.parametrize(
    ("lines", "note"),
    [
        ("cx = 960\ncy = 540", "the middle of a picture of 1920 x 1080 px, not of 1280 x 720"),
        ("cx = 320\ncy = 180", "the middle of a picture of 640 x 360 px"),
        ("cx = 360\ncy = 640", "the middle of a picture of 720 x 1280 px"),
        ("cx = 1500\ncy = 360", "cx = 1500 is outside the 1280 columns"),
        ("focal = 300", "the picture spans 130° without"),
        ("cx = 660\ncy = 340", None),
        ("cx = 640\ncy = 120", None),
    ],
)
def test_a_calibration_of_another_picture_is_noticed(lines, note, tmp_path):
    kept = [row for row in CAMERA_TOML.splitlines() if not (row.startswith("focal") and "focal" in lines)]
    (tmp_path / "camera.toml").write_text("\n".join([*kept, lines]))
    found = read_camera(tmp_path / "camera.toml").notes
    assert found == () if note is None else any(note in one for one in found)


def test_the_camera_file_of_the_manual_is_read(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "own.md").read_text("utf-8")
    block = re.findall(r"^## camera.toml\n\n((?:    .*\n|\n)+)", page, flags=re.M)[0]
    (tmp_path / "camera.toml").write_text(re.sub("^    ", "", block, flags=re.M))
    facts = read_camera(tmp_path / "camera.toml").facts
    assert (facts.width, facts.focal, facts.seconds) == (1242, 721.5, 0.1)
    assert facts.distortion is not None
    assert (facts.distortion.k1, facts.odometry.turn) == (-0.37, 0.05)
    assert (facts.carried_by, facts.box_edge) == ("vehicle", 0.45)


def test_what_carries_the_camera_and_the_edge_of_boxes_reach_solvers(tmp_path, walk):
    text = 'carried_by = "robot"\nbox_edge = 0.45\n' + CAMERA_TOML
    write_folder(tmp_path / "all" / "one", walk, camera=text)
    dataset = generate("own", tmp_path / "d", Options(source=tmp_path / "all"))
    problem = dataset.problem(dataset.sequence(0))
    assert (problem.carried_by, problem.box_edge) == ("robot", 0.45)
    assert "near edge 0.45 m, carried by a robot" in describe(dataset.info)
    write_folder(tmp_path / "all" / "two", walk, camera=text.replace("robot", "person"))
    with pytest.raises(VbbenchError, match="camera files differ in carried_by; make a dataset of each recording"):
        generate("own", tmp_path / "e", Options(source=tmp_path / "all"))


def test_boxes_that_cannot_be_of_this_picture_are_refused_or_told_of(folder, walk):
    small = CAMERA_TOML.replace("1280", "640").replace("= 720", "= 360").replace("700.0", "350.0")
    (folder / "camera.toml").write_text(small)
    with pytest.raises(FileError, match=r"the middle of \d+ of 480 boxes is outside the picture of 640 x 360 px"):
        read(folder)
    (folder / "camera.toml").write_text(
        CAMERA_TOML.replace("1280", "3840").replace("= 720", "= 2160").replace("700", "2100")
    )
    assert any("fill only the upper left" in note for note in read(folder).notes)
    (folder / "camera.toml").write_text(CAMERA_TOML)
    text = (folder / "boxes.csv").read_text()
    (folder / "boxes.csv").write_text(text + "3,99,1300,300,30,90\n")
    assert any(note.startswith("1 of 481 boxes are dropped") for note in read(folder).notes)
    (folder / "boxes.csv").write_text(HEAD + "".join(f"{t},1,.4,.4,.1,.3\n" for t in range(9)))
    with pytest.raises(FileError, match="shares of the picture"):
        read(folder)
    (folder / "boxes.csv").write_text(
        HEAD + "".join(f"{t},{k},{300 + 49 * k + t},320,{330 + 49 * k + t},410\n" for t in range(8) for k in range(4))
    )
    with pytest.raises(FileError, match="seem to be the right and lower borders of boxes; subtract left and top"):
        read(folder)
    (folder / "boxes.csv").write_text(HEAD + "".join(f"{t},1,{600 + t % 2},380,610,470\n" for t in range(30)))
    assert len(read(folder).footage.tracks) == 1
    (folder / "boxes.csv").write_bytes((HEAD + GOOD).replace("\n", "\r").encode())
    assert len(read(folder).footage.tracks) == 4
    (folder / "boxes.csv").write_text(HEAD + GOOD + "40,1,300,320,30,90\n")
    assert any(
        "32 of 41 frames have no box (the longest gap is 3.2 s, from frame 8)" in note for note in read(folder).notes
    )
    (folder / "seqinfo.ini").write_text("[Sequence]\nimWidth=1920\nimHeight=1080\n")
    with pytest.raises(FileError, match=r"its pictures have 1920 x 1080 px, the given camera's 1280 x 720"):
        read(folder)
    (folder / "seqinfo.ini").write_text("[Sequence]\nimWidth=1280.5\nimHeight=720\n")
    with pytest.raises(FileError, match=r"seqinfo.ini: imWidth is '1280.5', not a whole number from 1 to 100000"):
        read(folder)
    (folder / "seqinfo.ini").write_text("[Sequence]\nframeRate=fast\n")
    with pytest.raises(FileError, match=r"seqinfo.ini: frameRate is 'fast', not a number of pictures a second"):
        read(folder)
    (folder / "seqinfo.ini").write_text("[Sequence]\nframeRa" + " " * 40_000)
    assert len(read(folder).footage.tracks) == 4


@pytest.mark.parametrize("boxes", ["gt.txt", "gt/gt.txt"])
def test_the_frame_rate_of_seqinfo_counts_or_contradicts(tmp_path, walk, boxes):
    """It lies beside the boxes or above their folder; 29.97 frames a second are 30."""
    (tmp_path / "camera.toml").write_text(CAMERA_TOML.replace("fps = 10\n", ""))
    write_mot(tmp_path / boxes, walk)
    (tmp_path / "seqinfo.ini").write_text("[Sequence]\nframeRate=29.97\nimWidth=1280\nimHeight=720\n")
    assert read(tmp_path).footage.dt == pytest.approx(1.0 / 29.97)
    assert read_recording(files_in(tmp_path), dt=1.0 / 30.0).footage.dt == pytest.approx(1.0 / 30.0)
    with pytest.raises(FileError, match=r"seqinfo.ini: its frameRate is 29.97, the given camera's 10; write"):
        read_recording(files_in(tmp_path), dt=0.1)
    (tmp_path / "camera.toml").write_text(CAMERA_TOML)
    with pytest.raises(FileError, match=r"its frameRate is 29.97, the given camera's 10"):
        read(tmp_path)


def test_a_frame_rate_as_time_of_a_frame_is_asked_about(folder):
    (folder / "camera.toml").write_text(CAMERA_TOML.replace("fps = 10", "dt = 10"))
    assert "a frame is said to last 10 s: is it the frame rate? Then write fps = 10" in read(folder).notes


def test_boxes_without_ids_are_linked(folder, walk):
    (folder / "boxes.csv").unlink()
    write_mot(folder / "det.txt", walk, linked=False)
    recording = read(folder)
    assert any("the tracker links" in note for note in recording.notes)
    assert 8 <= len(recording.footage.tracks) <= 12
    assert np.isfinite(recording.footage.boxes[..., 2]).sum() > 0.9 * len(walk.rows)


def test_noise_is_measured_from_boxes(folder):
    assert read(folder).pixel_std == pytest.approx(1.0, abs=0.25)
    loud = make_walk(noise=6.0)
    write_csv(folder / "boxes.csv", loud)
    assert read(folder).pixel_std == pytest.approx(6.0, rel=0.25)
    (folder / "camera.toml").write_text(f"pixel_std = 3.0\n{CAMERA_TOML}")
    assert read(folder).pixel_std == 3.0
    assert box_noise(np.full((9, 2, 3), np.nan), 640.0, None) == ASSUMED_NOISE


def read_split(source: Path, **asked) -> str:
    """The id of the dataset."""
    return own.plan(Options(source=source, footage=FootageOptions(**asked))).info.id


def test_a_stream_of_footage_ends_where_nobody_knows_where_people_are(folder):
    options = Options(source=folder)
    plan = own.plan(options)
    assert not plan.scenes
    made = [data.sequence.index for data in stream("own", options)]
    assert made == list(range(len(plan)))


def test_detections_whose_clock_goes_back_are_told_of(folder, walk):
    lines = write_csv(folder / "boxes.csv", walk, begin=50.0).read_text().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    late = [[f"{float(time) - 3.0 * (n >= 240):.4f}", "", *box] for n, (time, _, *box) in enumerate(rows)]
    (folder / "boxes.csv").write_text("\n".join([lines[0], *(",".join(row) for row in late)]) + "\n")
    notes = " ".join(read(folder).notes)
    assert "boxes.csv, line 242: the clock goes back by 2.9 s; boxes of one time are taken for one frame" in notes
    (folder / "boxes.csv").unlink()
    (folder / "det.txt").write_text("".join(",".join([time, "-1", *box, "0.9"]) + "\n" for time, _, *box in late))
    assert "det.txt, line 241: the clock goes back by 2.9 s" in " ".join(read(folder).notes)


def test_a_folder_of_boxes_without_a_camera_is_told_of_and_one_is_read_once(tmp_path, walk):
    for name in ("one", "two"):
        write_folder(tmp_path / "all" / name, walk)
    (tmp_path / "all" / "two" / "camera.toml").unlink()
    asked = Options(source=tmp_path / "all", footage=FootageOptions(sequences=("one", "one")))
    with pytest.warns(VbbenchWarning, match="two skipped: boxes without camera.toml"):
        assert len(generate("own", tmp_path / "d", asked)) == 1


def test_the_split_reads_one_folder_or_several(tmp_path, walk, capsys):
    write_folder(tmp_path / "all" / "one", walk)
    write_folder(tmp_path / "all" / "two", make_walk(seed=1), camera=CAMERA_TOML.replace("1.5", "1.2"))
    dataset = generate("own", tmp_path / "d", Options(source=tmp_path / "all"))
    assert [camera.mount_height for camera in dataset.info.cameras] == [1.5, 1.2]
    assert dataset.info.scenes == ("one", "two")
    chosen = Options(source=tmp_path / "all", footage=FootageOptions(sequences=("two",), every=2))
    two = generate("own", tmp_path / "e", chosen)
    assert (len(two), two.info.dt, two.info.truth) == (1, pytest.approx(0.2), "none")
    with pytest.raises(VbbenchError, match="no recording is called 'three'"):
        generate("own", tmp_path / "f", Options(source=tmp_path / "all", footage=FootageOptions(sequences=("three",))))
    write_folder(tmp_path / "mixed" / "one", walk)
    write_folder(tmp_path / "mixed" / "slow", walk, camera=CAMERA_TOML.replace("fps = 10", "fps = 2"))
    with pytest.raises(VbbenchError, match=r"own: one takes 0.1 s a frame but slow takes 0.5 s a frame; .*--sequences"):
        generate("own", tmp_path / "f", Options(source=tmp_path / "mixed"))
    alone = tmp_path / "all" / "one"
    assert read_split(alone, sequences=("one",)) == read_split(alone)
    with pytest.raises(VbbenchError, match="no recording is called 'xyz'; known: one"):
        read_split(alone, sequences=("xyz",))
    with pytest.raises(VbbenchError, match="name the folder of your recording with --source"):
        generate("own", tmp_path / "f", Options())
    with pytest.raises(FileError, match=r"holds no camera.toml"):
        generate("own", tmp_path / "f", Options(source=tmp_path))
    (tmp_path / "all" / "one" / "boxes.csv").unlink()
    with pytest.raises(FileError, match=r"holds no boxes; write boxes.csv"):
        generate("own", tmp_path / "f", Options(source=tmp_path / "all"))
    boxes = write_csv(tmp_path / "other.csv", walk)
    given = Options(source=tmp_path / "all" / "one", footage=FootageOptions(boxes=boxes))
    assert len(generate("own", tmp_path / "f", given)) == 1
    assert main(["splits"]) == 0
    assert "own: Your own recording" in capsys.readouterr().out


@pytest.mark.parametrize("posed", [True, False])
def test_frames_after_the_last_person_are_part_of_the_scene(tmp_path, walk, posed):
    """Every fourth frame ends with nobody in view, and places were measured up to frame 40 only."""
    folder = write_folder(tmp_path / "walk", walk)
    boxes = (folder / "boxes.csv").read_text().splitlines(keepends=True)
    last = "57,1," + boxes[1].split(",", 2)[2]
    (folder / "boxes.csv").write_text(
        "".join(row for row in boxes if row[0] == "f" or int(row.split(",")[0]) < 52) + last
    )
    if posed:
        write_tum(folder / "poses.txt", walk)
    people = write_people(folder / "people.csv", walk, relative=not posed).read_text().splitlines(keepends=True)
    (folder / "people.csv").write_text("".join(row for row in people if row[0] == "f" or int(row.split(",")[0]) < 40))
    with pytest.warns(VbbenchWarning, match="77% of 417 boxes have a person"):
        dataset = generate("own", tmp_path / "d", Options(source=folder, footage=FootageOptions(every=4)))
    sequence = dataset.sequence(0)
    assert (sequence.frames, sequence.observed.any(axis=1).sum()) == (15, 13)
    assert "are as written" in verify(tmp_path / "d")
    assert np.isnan(dataset.relative_truth(sequence)[10:]).all()
    solver, protocol = ("vb-cv", "one-step") if posed else ("map-causal", "cold-start")
    solve(dataset, solver, protocol, tmp_path / "s")
    assert score(tmp_path / "s", tmp_path / "d").frames == 11


def test_a_trackers_boxes_are_not_matched_where_people_are_not_known(folder, tmp_path):
    dataset = generate("own", tmp_path / "d", Options(source=folder))
    (tmp_path / "files").mkdir()
    with pytest.raises(VbbenchError, match="not everybody's place was measured; make it again with --boxes"):
        import_mot(tmp_path / "files", dataset, tmp_path / "made")


def test_what_does_not_look_right_is_a_warning_of_the_split(folder, tmp_path):
    (folder / "boxes.csv").write_text((folder / "boxes.csv").read_text() + "3,99,1300,300,30,90\n")
    with pytest.warns(VbbenchWarning, match="walk: 1 of 481 boxes are dropped"):
        generate("own", tmp_path / "d", Options(source=folder))
    assert Dataset(tmp_path / "d").info.calibration["notes"]["walk"][0].startswith("1 of 481")


@pytest.mark.parametrize("linked", [True, False], ids=["with ids", "detections"])
@pytest.mark.parametrize("posed", [True, False], ids=["with poses", "without"])
@pytest.mark.parametrize(("late", "words"), [(2, "2 frames later"), (-5, "5 frames earlier")])
def test_people_of_other_frames_are_named(tmp_path, late, words, posed, linked):
    walk = make_walk(across=1.0)
    folder = write_folder(tmp_path / "walk", walk)
    if not linked:
        (folder / "boxes.csv").unlink()
        write_mot(folder / "det.txt", walk, linked=False)
    if posed:
        write_tum(folder / "poses.txt", walk)
    head, *rows = write_people(folder / "people.csv", walk, relative=not posed).read_text().splitlines()
    cells = [row.split(",", 1) for row in rows]
    late += not linked  # det.txt counts from 1
    moved = [f"{int(frame) + late},{rest}" for frame, rest in cells if int(frame) + late >= 0]
    (folder / "people.csv").write_text("\n".join([head, *moved]))
    with pytest.warns(VbbenchWarning, match=rf"people.csv: boxes overlap people {words} by 0.\d\d, now by 0.\d\d"):
        generate("own", tmp_path / "d", Options(source=folder))


def test_a_clean_recording_warns_of_nothing(folder, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        generate("own", tmp_path / "d", Options(source=folder))
