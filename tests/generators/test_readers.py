"""Readers give validated scenes, and bad files one error with file and line."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.fuzz.trajectories import SPLINES
from vbbench.errors import FileError, VbbenchWarning
from vbbench.generation.generator import Options
from vbbench.scene import Scene
from vbbench_generators.recordings.loading import SceneFile, detect_format, get_reader, load_scenes
from vbbench_generators.recordings.readers.tracks import read_homography, to_ground
from vbbench_generators.recordings.readers.vsp import polyline, smooth_curve
from vbbench_generators.recordings.recipe import get_recipe

Write = Callable[..., Path]

WALK = "0 1 0.0 0.0\n10 1 0.5 0.0\n20 1 1.0 0.0\n"
CENTIMETRES = np.diag([0.01, 0.01, 1.0])


def read(path: Path, form: str = "trajnet", **facts: Any) -> Scene:
    return get_reader(form).read(SceneFile(path=path, **{"dt": 0.4, **facts}))


@pytest.mark.parametrize("separator", [" ", "\t", ",", ", ", "   "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_trajnet_separators_comments_and_order(write: Write, separator: str, end: str) -> None:
    rows = ["# frame id x y", "20.0 7.0 1 -2", "", "10 7 0.5 -1", "20 3 4.5e0 0", "30 3 5 0"]
    path = write(end.join(separator.join(row.split(" ")) if "#" not in row else row for row in rows))
    scene = read(path)
    assert scene.name == "tracks"
    assert scene.dt == 0.4
    assert scene.people.tolist() == [3, 7]
    assert np.isnan(scene.heights).all()
    nan = [np.nan, np.nan]
    np.testing.assert_array_equal(scene.positions, [[nan, [0.5, -1]], [[4.5, 0], [1, -2]], [[5, 0], nan]])


def test_frames_with_nobody_stay(write: Write) -> None:
    scene = read(write("0 1 0 0\n10 1 .5 0\n40 2 0 0\n50 2 .5 0\n"))
    assert scene.present.sum(axis=1).tolist() == [1, 1, 0, 0, 1, 1]


def test_recording_may_go_on_at_another_phase_after_nobody_was_there(write: Write) -> None:
    scene = read(write("0 1 0 0\n10 1 .5 0\n43 2 0 0\n53 2 .5 0\n"))
    assert scene.present.sum(axis=1).tolist() == [1, 1, 0, 0, 0, 1, 1]


def test_frames_may_start_below_zero_and_far_away(write: Write) -> None:
    assert read(write("-10 0 0 0\n0 0 .5 0\n")).frames == 2
    assert read(write("1700000000 0 0 0\n1700000001 0 .5 0\n")).frames == 2


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        pytest.param("", None, "empty", id="empty file"),
        pytest.param("\n# only a comment\n\n", None, "empty", id="no rows"),
        pytest.param("0 1 0 0\n10 1 .5\n", 2, "3 columns with", id="missing column"),
        pytest.param("0 1 0\n10 1 .5\n", 1, "3 columns with", id="column missing everywhere"),
        pytest.param("frame id left y\n" + WALK, 1, "has no column x", id="incomplete header"),
        pytest.param(
            "frame id x pos_x y\n0 1 0 0 0\n", 1, "'x' and 'pos_x' could both be the x", id="two columns of x"
        ),
        pytest.param("frame id x y\n", None, "names columns and holds no row", id="header alone"),
        pytest.param(
            "frame id x y v\n0 1 0 0\n", 2, "4 columns, the first line names 5", id="fewer columns than names"
        ),
        pytest.param("frame,id,x_px,y_px\n0,1,0,0\n", 2, "a homography is needed", id="pixels by name"),
        pytest.param("frame,id,x_m,y_cm\n0,1,0,0\n", 2, "must both be", id="two units"),
        pytest.param("time,id,x,y\n0,1,0,0\n.5,1,.5,0\n1,1,1,0\n", 2, "write --dt 0.5", id="another dt"),
        pytest.param("t id x y\n0 1 0 0\n.4 1 .5 0\n.8 1 1 0\n1 2 0 0\n", 5, "time 1 is not", id="odd time"),
        pytest.param(WALK + "30 1 1.5m 0\n", 4, "x is '1.5m'; write a number", id="text in a number"),
        pytest.param("0 1 0 0\n\n# note\n10 1 0 oops\n", 4, "y is 'oops'", id="blank lines are counted"),
        pytest.param(WALK + "30 1 nan 0\n", 4, "nan; write a finite number", id="nan"),
        pytest.param(
            "0 1 0 0\n10.5 1 .5 0\n",
            2,
            "frame is 10.5, not an integer; name a column of times 'time'",
            id="half a frame",
        ),
        pytest.param("0 1 0 0\n10 1.25 .5 0\n", 2, "id is 1.25, not an integer", id="fraction of a person"),
        pytest.param("0 1 0 0\n10 -1 .5 0\n", 2, "id is -1", id="negative id"),
        pytest.param("0 1e12 0 0\n", 1, "id is 1000000000000", id="huge id"),
        pytest.param(WALK + "10 1 .6 0\n", 4, "frame 10 twice .also on line 2", id="duplicate"),
        pytest.param(WALK + "40 1 2 0\n50 1 2 1\n", 4, "frame 40 follows frame 20", id="gap in a track"),
        pytest.param(WALK + "5 2 0 0\n15 2 .5 0\n", 4, "frame 5 is 5 from frame", id="person off the step"),
        pytest.param("0 1 0 0\n1 1 .5 0\n100000001 2 0 0\n100000002 2 .5 0\n", None, "too many", id="far too long"),
    ],
)
def test_bad_trajnet(write: Write, text: str, line: int | None, problem: str) -> None:
    path = write(text)
    with pytest.raises(FileError, match=problem) as caught:
        read(path)
    assert caught.value.path == path
    assert caught.value.line == line
    assert str(caught.value).startswith(f"{path}, line {line}:" if line else f"{path}:")


def test_first_of_several_faults_is_named(write: Write) -> None:
    text = "0 9 0 0\n10 9 .5 0\n30 9 1 0\n0 1 0 0\n10 1 .5 0\n30 1 1 0\n"
    with pytest.raises(FileError) as caught:
        read(write(text))
    assert caught.value.line == 3


def test_wrong_frame_step_is_an_error(write: Write) -> None:
    with pytest.raises(FileError, match="but the step is 5"):
        read(write(WALK), frame_step=5)


def test_files_that_are_none(tmp_path: Path) -> None:
    (tmp_path / "picture.txt").write_bytes(b"\x89PNG\r\n\xff\xfe")
    for name, problem in [
        ("nowhere.txt", "cannot be read"),
        (".", "cannot be read"),
        ("picture.txt", "not a text file"),
    ]:
        with pytest.raises(FileError, match=problem):
            read(tmp_path / name)


@pytest.mark.parametrize(
    ("step_length", "cause"),
    [
        (2.0, r"dt = 4\): 0.5 m/s; or positions are feet: 1.52"),
        (50.0, "pixels.*centimetres: 1.25 m/s"),
        (0.01, "stand"),
    ],
)
def test_implausible_speed_is_a_warning_that_names_the_cause(write: Write, step_length: float, cause: str) -> None:
    path = write("".join(f"{10 * n} 1 {n * step_length} 0\n" for n in range(9)))
    with pytest.warns(VbbenchWarning, match=f"tracks.txt: the median walking speed.*{cause}"):
        assert read(path).frames == 9


def test_homography_makes_metres(write: Write) -> None:
    scene = read(write("0 1 100 50\n10 1 150 50\n"), homography=CENTIMETRES)
    np.testing.assert_allclose(scene.positions[:, 0], [[1.0, 0.5], [1.5, 0.5]])


def test_point_on_the_horizon(write: Write) -> None:
    tilted = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, -0.01, 1.0]])
    with pytest.raises(FileError, match="horizon") as caught:
        read(write("0 1 1 1\n10 1 5 100\n"), homography=tilted)
    assert caught.value.line == 2


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        ("1 0 0\n0 1 0\n", 2, "3 rows of 3 numbers, not 2"),
        ("1 0 0\n0 1 0\n0 0 1\n0 0 1\n", 4, "not 4"),
        ("1 0\n0 1\n", 1, "2 columns with blanks between, wanted 3: h1 h2 h3"),
        ("1 0 0\n0 one 0\n0 0 1\n", 2, "'one'; write a number"),
        ("1 0 0\n2 0 0\n0 0 1\n", None, "singular"),
        ("", None, "empty"),
    ],
)
def test_bad_homography(write: Write, text: str, line: int | None, problem: str) -> None:
    with pytest.raises(FileError, match=problem) as caught:
        read_homography(write(text, "H.txt"))
    assert caught.value.line == line


TILTED = np.array([[1.1e-2, 8e-4, -1.2], [4e-4, -1.3e-2, 9.1], [1e-5, -3e-4, 1.0]])


def _pixels(people: int = 4, frames: int = 12) -> list[tuple[int, int, float, float]]:
    """Rows (frame, id, x, y) of people who walk at 1.2 m/s, in pixels of the picture that `TILTED` maps to metres."""
    rng = np.random.default_rng(1)
    start, way = rng.uniform(1.0, 8.0, (people, 2)), rng.normal(0.0, 1.0, (people, 2))
    way *= 1.2 * 0.4 / np.linalg.norm(way, axis=1, keepdims=True)
    frame, person = (array.ravel() for array in np.mgrid[:frames, :people])
    pixels = to_ground(start[person] + frame[:, None] * way[person], np.linalg.inv(TILTED))
    return [
        (10 * f, p + 1, *place) for f, p, place in zip(frame.tolist(), person.tolist(), pixels.tolist(), strict=True)
    ]


def _text(rows: list[tuple]) -> str:
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        (np.linalg.inv(TILTED), "with its inverse at 1.2 m/s: give the inverse, the matrix that maps the picture"),
        (TILTED.T, "with its transpose at 1.2 m/s"),
        (np.linalg.inv(TILTED).T, "with its inverse of the transpose at 1.2 m/s"),
    ],
)
def test_a_homography_of_another_direction_is_named(write: Write, given: np.ndarray, named: str) -> None:
    path = write(_text(_pixels()))
    with pytest.raises(FileError, match=r"with this homography people walk at [\d.,e+-]+ m/s, " + named):
        read(path, homography=given)
    assert read(path, homography=TILTED).frames == 12


def test_people_of_different_speeds_show_the_direction_of_a_homography(write: Write) -> None:
    rng, (start, way) = np.random.default_rng(2), np.random.default_rng(3).normal(0.0, 1.0, (2, 9, 2))
    frame, person = (array.ravel() for array in np.mgrid[:12, :9])
    places = start[person] + 5.0 + 0.2 * frame[:, None] * way[person] + rng.normal(0.0, 0.005, (len(frame), 2))
    pixels = to_ground(places, np.linalg.inv(TILTED))
    rows = [(10 * f, p + 1, *at) for f, p, at in zip(frame.tolist(), person.tolist(), pixels.tolist(), strict=True)]
    with pytest.raises(FileError, match="with its inverse at"):
        read(write(_text(rows)), homography=np.linalg.inv(TILTED))
    turned = write(_text([(f, p, y, x) for f, p, x, y in rows]))
    with pytest.warns(VbbenchWarning, match=r"vary by .*with the columns of places swapped.*\(row, column\)"):
        read(turned, homography=TILTED)
    assert read(write(_text(rows)), homography=TILTED).frames == 12


def test_a_homography_stands_in_brackets_or_in_one_line(write: Write) -> None:
    for text in (str(TILTED.tolist()), str(TILTED), " ".join(map(str, TILTED.ravel().tolist()))):
        np.testing.assert_allclose(read_homography(write(text, "H.txt")), TILTED)


def test_a_homography_that_only_scales_and_one_for_metres_are_named(write: Write) -> None:
    metres = to_ground(np.array([row[2:] for row in _pixels()]), TILTED)
    rows = [(frame, person, *place) for (frame, person, *_), place in zip(_pixels(), metres.tolist(), strict=True)]
    with pytest.raises(FileError, match=r"without the homography people walk at 1.2 m/s.*metres already"):
        read(write(_text(rows)), homography=TILTED)
    pixels = write(_text([(frame, person, 50.0 * x, 50.0 * y) for frame, person, x, y in rows]))
    with pytest.raises(FileError, match=r"with its inverse at 1\.2 m/s"):
        read(pixels, homography=np.diag([50.0, 50.0, 1.0]))
    assert read(pixels, homography=np.diag([0.02, 0.02, 1.0])).frames == 12


def test_the_cause_of_a_speed_is_not_a_homography_where_there_is_one(write: Write) -> None:
    path, centimetres = write(_text(_pixels())), np.diag([100.0, 100.0, 1.0]) @ TILTED
    with pytest.warns(VbbenchWarning, match="the homography maps to centimetres: 1.2 m/s") as caught:
        read(path, homography=centimetres)
    assert "homography is needed" not in str(caught[0].message)
    with pytest.warns(VbbenchWarning, match=r"rows of a person are 10 apart \(dt = 0.4\): 1.2 m/s"):
        read(path, dt=0.04, homography=TILTED)
    with pytest.warns(VbbenchWarning, match="a homography is needed"):
        read(path)


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
def test_columns_are_read_by_their_names(tmp_path: Path, head: str, encoding: str) -> None:
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


def test_a_frame_rate_in_a_comment_must_be_that_of_dt(write: Write) -> None:
    path = write("# framerate: 25.00\n# id frame x/m y/m\n" + "".join(f"1 {n} {n / 25} 0\n" for n in range(20)))
    with pytest.raises(FileError, match=r"has 25 frames a second by its comment, and --dt is 0\.4; write --dt 0\.04"):
        read(path)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("scene,frame,id,x,y\na,0,1,0,0\nb,0,2,1,1\n", r"rows of 2 films \('a', 'b'\)"),
        ('{"track": {"f": 0, "p": 1, "x": 0.5, "y": 1.0}}\n', "is JSON; write lines of frame, id, x, y"),
    ],
)
def test_two_scenes_and_json_are_named(write: Write, text: str, problem: str) -> None:
    with pytest.raises(FileError, match=problem):
        load_scenes(get_recipe("custom"), Options(source=write(text), dt=0.4))


def test_swapped_frames_and_ids_are_named(write: Write) -> None:
    rows = [(frame, person, x / 60, y / 60) for frame, person, x, y in _pixels()]
    assert read(write(_text(rows))).frames == 12
    swapped = _text([(person, frame, x, y) for frame, person, x, y in rows])
    with pytest.raises(FileError, match=r"seem to be swapped: people move by \d.* if the columns are id frame x y"):
        read(write(swapped))
    assert read(write("# id frame x y\n" + swapped)).frames == 12


def test_obsmat_takes_x_and_y(write: Write) -> None:
    path = write(" 7.8e+02 1e+00 8.5 0 3.6 1 0 2\r\n 7.86e+02 1 9.0 0 3.7 1 0 2\r\n", "obsmat.txt")
    scene = read(path, "obsmat", frame_step=6)
    np.testing.assert_array_equal(scene.positions[:, 0], [[8.5, 3.6], [9.0, 3.7]])


@pytest.mark.parametrize(
    ("text", "line"), [("1 1 0 0 0 0 0\n", 1), ("1 1 0 0 0 0 0 0\n7 1 0 0 x 0 0 0\n", 2), (WALK, 1)]
)
def test_bad_obsmat(write: Write, text: str, line: int) -> None:
    with pytest.raises(FileError) as caught:
        read(write(text), "obsmat")
    assert caught.value.line == line


def test_vsp_is_interpolated_between_key_points(write: Write) -> None:
    scene = read(write(SPLINES, "a.vsp"), "vsp", frame_step=10, homography=CENTIMETRES)
    assert scene.people.tolist() == [1, 2]
    np.testing.assert_allclose(scene.positions[:, 0], [[0, 0], [0.5, 0], [1, 0], [1, 1 / 3]])
    np.testing.assert_allclose(scene.positions[:, 1], [[np.nan] * 2, [0, 0.15], [0, 0.4], [0, 0.65]])


def _replace(line: int, text: str) -> str:
    rows = SPLINES.split("\n")
    rows[line - 1] = text
    return "\n".join(rows)


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        pytest.param("", None, "empty", id="empty file"),
        pytest.param("0 - the number of splines\n", 1, "no spline", id="no splines"),
        pytest.param(_replace(1, "many splines"), 1, "the number of splines' should stand", id="no header"),
        pytest.param(_replace(2, "4 - Num of control points"), 6, "columns, not 4", id="count too large"),
        pytest.param(
            _replace(2, "2 - Num of control points"), 5, "Num of control points' should", id="count too small"
        ),
        pytest.param(_replace(2, "0 - Num of control points"), 2, "0 control points", id="no control points"),
        pytest.param(_replace(1, "3 - the number of splines"), 9, "should stand here", id="splines missing"),
        pytest.param("\n".join(SPLINES.split("\n")[:7]), 6, "2 control points has 1", id="cut in a spline"),
        pytest.param("\n".join(SPLINES.split("\n")[:5]), 5, "ends where", id="cut between splines"),
        pytest.param(_replace(4, "100.0 0.0 20 - (2D point, m_id)"), 4, "3 columns, not 4", id="missing column"),
        pytest.param(_replace(4, "100.0 zero 20 90 - (2D point, m_id)"), 4, "y is 'zero'", id="text in a number"),
        pytest.param(_replace(4, "100.0 inf 20 90 - (2D point, m_id)"), 4, "finite", id="not finite"),
        pytest.param(_replace(4, "100.0 0 20.5 90 - (2D point, m_id)"), 4, "frame is 20.5", id="fraction of a frame"),
        pytest.param(_replace(4, "100.0 0 0 90 - (2D point, m_id)"), 4, "does not come after 0", id="frame twice"),
    ],
)
def test_bad_vsp(write: Write, text: str, line: int | None, problem: str) -> None:
    path = write(text, "a.vsp")
    with pytest.raises(FileError, match=problem) as caught:
        read(path, "vsp", frame_step=10, homography=CENTIMETRES)
    assert caught.value.path == path
    assert caught.value.line == line


def test_vsp_without_a_sample(write: Write) -> None:
    text = "1 - the number of splines\n2 - Num of control points\n0 0 1 0 - (2D)\n1 1 9 0 - (2D)\n"
    with pytest.raises(FileError, match="no person is annotated"):
        read(write(text), "vsp", frame_step=10, homography=CENTIMETRES)


def test_smooth_curve_passes_key_points_and_stays_between_them() -> None:
    key_times = np.array([0.0, 10.0, 30.0, 1000.0, 1030.0])
    keys = np.array([[0.0, 0], [1, 0.2], [2, 0.1], [2.01, 0.1], [4, 0.5]])
    times = np.linspace(0, 1030, 4000)
    curve = smooth_curve(times, key_times, keys)
    np.testing.assert_allclose(smooth_curve(key_times, key_times, keys), keys, atol=1e-12)
    assert np.diff(curve[:, 0]).min() >= -1e-12
    assert np.abs(curve - polyline(times, key_times, keys)).max() < 0.3
    np.testing.assert_array_equal(smooth_curve(times[:3], key_times[:1], keys[:1]), np.zeros((3, 2)))


@pytest.mark.parametrize(
    ("text", "found"),
    [("# mine\n" + WALK, "trajnet"), ("0,1,2,3\n", "trajnet"), ("1 1 0 0 0 0 0 0\r\n", "obsmat"), (SPLINES, "vsp")],
)
def test_detect_format(write: Write, text: str, found: str) -> None:
    assert detect_format(write(text)) == found


@pytest.mark.parametrize("name", ["students001", "students003"])
def test_vsp_gives_the_published_students(data_folder: Path, name: str) -> None:
    """Wherever the spline annotation has a person, the published text has the same place to the millimetre."""
    homography = read_homography(data_folder / "ucy/students003_H.txt")
    made = read(data_folder / f"ucy/{name}.vsp", "vsp", frame_step=10, homography=homography)
    published = read(data_folder / f"ucy/{name}.txt", frame_step=10)
    np.testing.assert_array_equal(made.people, published.people)
    both = made.present & published.present
    assert both[made.present].all()
    # The text rounds each person's first and last key frame to the nearest sample: up to two more rows each.
    assert (published.present & ~made.present).sum() <= 2 * len(made.people)
    assert np.abs(made.positions[both] - published.positions[both]).max() < 1e-3
