"""Tables of positions give validated scenes, whatever names their columns; bad ones, one error with file and line."""

import numpy as np
import pytest

from tests.fuzz.trajectories import SPLINES
from tests.lib.recorded_walks import WALK, read, text_of, walk_in_pixels
from vbbench.errors import FileError
from vbbench.generation.generator import Options
from vbbench_generators.recordings.loading import detect_format, load_scenes
from vbbench_generators.recordings.recipe import get_recipe


@pytest.mark.parametrize("separator", [" ", "\t", ",", ", ", "   "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_trajnet_separators_comments_and_order(write, separator, end):
    rows = ["# frame id x y", "20.0 7.0 1 -2", "", "10 7 0.5 -1", "20 3 4.5e0 0", "30 3 5 0"]
    scene = read(write(end.join(row if "#" in row else separator.join(row.split(" ")) for row in rows)))
    assert (scene.name, scene.dt, scene.people.tolist()) == ("tracks", 0.4, [3, 7])
    assert np.isnan(scene.heights).all()
    nan = [np.nan, np.nan]
    np.testing.assert_array_equal(scene.positions, [[nan, [0.5, -1]], [[4.5, 0], [1, -2]], [[5, 0], nan]])


@pytest.mark.parametrize(
    ("text", "present"),
    [
        ("0 1 0 0\n10 1 .5 0\n40 2 0 0\n50 2 .5 0\n", [1, 1, 0, 0, 1, 1]),
        ("0 1 0 0\n10 1 .5 0\n43 2 0 0\n53 2 .5 0\n", [1, 1, 0, 0, 0, 1, 1]),
        ("-10 0 0 0\n0 0 .5 0\n", [1, 1]),
        ("1700000000 0 0 0\n1700000001 0 .5 0\n", [1, 1]),
    ],
    ids=["frames with nobody stay", "at another phase after nobody was there", "below zero", "far away"],
)
def test_frames_begin_anywhere_and_may_have_nobody(write, text, present):
    assert read(write(text)).present.sum(axis=1).tolist() == present


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        ("", None, "empty"),
        ("\n# only a comment\n\n", None, "empty"),
        ("0 1 0 0\n10 1 .5\n", 2, "3 columns with"),
        ("0 1 0\n10 1 .5\n", 1, "3 columns with"),
        ("frame id left y\n" + WALK, 1, "has no column x"),
        ("frame id x pos_x y\n0 1 0 0 0\n", 1, "'x' and 'pos_x' could both be the x"),
        ("frame id x y\n", None, "names columns and holds no row"),
        ("frame id x y v\n0 1 0 0\n", 2, "4 columns, the first line names 5"),
        ("frame,id,x_px,y_px\n0,1,0,0\n", 2, "a homography is needed"),
        ("frame,id,x_m,y_cm\n0,1,0,0\n", 2, "must both be"),
        ("time,id,x,y\n0,1,0,0\n.5,1,.5,0\n1,1,1,0\n", 2, "write --dt 0.5"),
        ("t id x y\n0 1 0 0\n.4 1 .5 0\n.8 1 1 0\n1 2 0 0\n", 5, "time 1 is not"),
        (WALK + "30 1 1.5m 0\n", 4, "x is '1.5m'; write a number"),
        ("0 1 0 0\n\n# note\n10 1 0 oops\n", 4, "y is 'oops'"),
        (WALK + "30 1 nan 0\n", 4, "nan; write a finite number"),
        ("0 1 0 0\n10.5 1 .5 0\n", 2, "frame is 10.5, not an integer; name a column of times 'time'"),
        ("0 1 0 0\n10 1.25 .5 0\n", 2, "id is 1.25, not an integer"),
        ("0 1 0 0\n10 -1 .5 0\n", 2, "id is -1"),
        ("0 1e12 0 0\n", 1, "id is 1000000000000"),
        ("0 1 0 0\n10 1 2e6 0\n", 2, r"\(2e\+06, 0\) m is more than 1,000 km from the origin"),
        (WALK + "10 1 .6 0\n", 4, "frame 10 twice .also on line 2"),
        (WALK + "40 1 2 0\n50 1 2 1\n", 4, "frame 40 follows frame 20"),
        (WALK + "5 2 0 0\n15 2 .5 0\n", 4, "frame 5 is 5 from frame"),
        ("0 1 0 0\n1 1 .5 0\n100000001 2 0 0\n100000002 2 .5 0\n", None, "too many"),
        ("0 9 0 0\n10 9 .5 0\n30 9 1 0\n0 1 0 0\n10 1 .5 0\n30 1 1 0\n", 3, "frame 30 follows"),
    ],
)
def test_bad_trajnet(write, text, line, problem):
    path = write(text)
    with pytest.raises(FileError, match=problem) as caught:
        read(path)
    assert (caught.value.path, caught.value.line) == (path, line)
    assert str(caught.value).startswith(f"{path}, line {line}:" if line else f"{path}:")


def test_wrong_frame_step_is_an_error(write):
    with pytest.raises(FileError, match="but the step is 5"):
        read(write(WALK), frame_step=5)


def test_files_that_are_none(tmp_path):
    (tmp_path / "picture.txt").write_bytes(b"\x89PNG\r\n\xff\xfe")
    for name, problem in (("nowhere.txt", "cannot be read"), (".", "cannot be read"), ("picture.txt", "not a text")):
        with pytest.raises(FileError, match=problem):
            read(tmp_path / name)


@pytest.mark.parametrize(
    "head",
    [
        "# id frame x/m y/m",
        "# framerate: 2.50 fps\n# id frame x/m y/m",
        "# framerate: 25.00\n# id frame x/m y/m",
        "trackId,frame,xCenter,yCenter",
        "# columns: id frame x y",
        "id frame x y",
        "track_id,frame_index,pos_x,pos_y",
        "ped_id;Frame;X [m];Y [m]",
        '"id"\t"frame"\t"x"\t"y"',
        "id frame x_cm y_cm",
        "id time_ms x y",
        "id frame x_feet y_feet",
        "id timestamp x y",
        "id frame vx x vy y z class",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_columns_are_read_by_their_names(tmp_path, head, encoding):
    mark = next((mark for mark in ";\t," if mark in head), " ")
    scale, per_frame = (
        100 if "_cm" in head else 1 / 0.3048 if "_feet" in head else 1,
        400 if "time_ms" in head else 0.4 if "timestamp" in head else 10,
    )
    rows = [
        (person, frame * per_frame, scale * 0.5 * frame, -scale * person) for person in (3, 7) for frame in range(4)
    ]
    if "class" in head:
        rows = [(person, frame, 0.1, x, 0, y, 1.7, "walker") for person, frame, x, y in rows]
    text = "\n".join([head, *(mark.join(str(cell) for cell in row) for row in rows)])
    (tmp_path / "tracks.txt").write_text(text.replace(".", ",") if mark in ";\t" else text, encoding)
    assert detect_format(tmp_path / "tracks.txt") == "trajnet"
    scene = read(tmp_path / "tracks.txt")
    assert scene.people.tolist() == [3, 7]
    np.testing.assert_allclose(scene.positions[:, 1], [[0.5 * frame, -7] for frame in range(4)])


def test_a_frame_rate_in_a_comment_must_be_that_of_dt(write):
    path = write("# framerate: 25.00\n# id frame x/m y/m\n" + "".join(f"1 {n} {n / 25} 0\n" for n in range(20)))
    with pytest.raises(FileError, match=r"has 25 frames a second by its comment, and --dt is 0\.4; write --dt 0\.04"):
        read(path)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("scene,frame,id,x,y\na,0,1,0,0\nb,0,2,1,1\n", r"rows of 2 films \('a', 'b'\)"),
        ('{"track": {"f": 0, "p": 1, "x": 0.5, "y": 1.0}}\n', "is JSON; write lines of frame, id, x, y"),
        ("1 2 3\n", "has 3 columns; known are 4 columns"),
        ("# nothing\n", "is empty: it holds no row of numbers"),
    ],
)
def test_a_file_of_no_known_format_is_refused(write, text, problem):
    with pytest.raises(FileError, match=problem):
        load_scenes(get_recipe("custom"), Options(source=write(text), dt=0.4))


def test_swapped_frames_and_ids_are_named(write):
    rows = [(frame, person, x / 60, y / 60) for frame, person, x, y in walk_in_pixels()]
    assert read(write(text_of(rows))).frames == 12
    swapped = text_of([(person, frame, x, y) for frame, person, x, y in rows])
    with pytest.raises(FileError, match=r"seem to be swapped: people move by \d.* if the columns are id frame x y"):
        read(write(swapped))
    assert read(write("# id frame x y\n" + swapped)).frames == 12


def test_obsmat_takes_x_and_y(write):
    path = write(" 7.8e+02 1e+00 8.5 0 3.6 1 0 2\r\n 7.86e+02 1 9.0 0 3.7 1 0 2\r\n", "obsmat.txt")
    scene = read(path, "obsmat", frame_step=6)
    np.testing.assert_array_equal(scene.positions[:, 0], [[8.5, 3.6], [9.0, 3.7]])


@pytest.mark.parametrize(
    ("text", "line"), [("1 1 0 0 0 0 0\n", 1), ("1 1 0 0 0 0 0 0\n7 1 0 0 x 0 0 0\n", 2), (WALK, 1)]
)
def test_bad_obsmat(write, text, line):
    with pytest.raises(FileError) as caught:
        read(write(text), "obsmat")
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("text", "found"),
    [("# mine\n" + WALK, "trajnet"), ("0,1,2,3\n", "trajnet"), ("1 1 0 0 0 0 0 0\r\n", "obsmat"), (SPLINES, "vsp")],
)
def test_detect_format(write, text, found):
    assert detect_format(write(text)) == found
