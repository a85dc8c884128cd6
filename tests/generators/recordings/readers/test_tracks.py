"""Checks of recorded walks: their speed, and the homography that makes metres of pixels."""

import numpy as np
import pytest

from tests.lib.recorded_walks import CENTIMETRES, TILTED, read, rows_in_pixels, text_of, walk_in_pixels
from vbbench.errors import FileError, VbbenchWarning
from vbbench_generators.recordings.readers.tracks import read_homography, to_ground


@pytest.mark.parametrize(
    ("step_length", "cause"),
    [
        (2.0, r"dt = 4\): 0.5 m/s; or positions are feet: 1.52"),
        (50.0, "pixels.*centimetres: 1.25 m/s"),
        (0.01, "stand"),
    ],
)
def test_implausible_speed_is_a_warning_that_names_the_cause(write, step_length, cause):
    path = write("".join(f"{10 * n} 1 {n * step_length} 0\n" for n in range(9)))
    with pytest.warns(VbbenchWarning, match=f"tracks.txt: the median walking speed.*{cause}"):
        assert read(path).frames == 9


def test_homography_makes_metres(write):
    scene = read(write("0 1 100 50\n10 1 150 50\n"), homography=CENTIMETRES)
    np.testing.assert_allclose(scene.positions[:, 0], [[1.0, 0.5], [1.5, 0.5]])


def test_metres_by_name_take_no_homography(write):
    with pytest.raises(FileError, match="x and y are in m already: remove `homography`"):
        read(write("frame id x_m y_m\n0 1 1 1\n"), homography=CENTIMETRES)


def test_point_on_the_horizon(write):
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
def test_bad_homography(write, text, line, problem):
    with pytest.raises(FileError, match=problem) as caught:
        read_homography(write(text, "H.txt"))
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("given", "named"),
    [
        (np.linalg.inv(TILTED), "with its inverse at 1.2 m/s: give the inverse, the matrix that maps the picture"),
        (TILTED.T, "with its transpose at 1.2 m/s"),
        (np.linalg.inv(TILTED).T, "with its inverse of the transpose at 1.2 m/s"),
    ],
)
def test_a_homography_of_another_direction_is_named(write, given, named):
    path = write(text_of(walk_in_pixels()))
    with pytest.raises(FileError, match=r"with this homography people walk at [\d.,e+-]+ m/s, " + named):
        read(path, homography=given)
    assert read(path, homography=TILTED).frames == 12


def test_people_of_different_speeds_show_the_direction_of_a_homography(write):
    rng, (start, way) = np.random.default_rng(2), np.random.default_rng(3).normal(0.0, 1.0, (2, 9, 2))
    frame, person = (array.ravel() for array in np.mgrid[:12, :9])
    places = start[person] + 5.0 + 0.2 * frame[:, None] * way[person] + rng.normal(0.0, 0.005, (len(frame), 2))
    rows = rows_in_pixels(frame, person, places)
    with pytest.raises(FileError, match="with its inverse at"):
        read(write(text_of(rows)), homography=np.linalg.inv(TILTED))
    turned = write(text_of([(f, p, y, x) for f, p, x, y in rows]))
    with pytest.warns(VbbenchWarning, match=r"vary by .*with the columns of places swapped.*\(row, column\)"):
        read(turned, homography=TILTED)
    assert read(write(text_of(rows)), homography=TILTED).frames == 12


def test_a_homography_stands_in_brackets_or_in_one_line(write):
    for text in (str(TILTED.tolist()), str(TILTED), " ".join(map(str, TILTED.ravel().tolist()))):
        np.testing.assert_allclose(read_homography(write(text, "H.txt")), TILTED)


def test_a_homography_that_only_scales_and_one_for_metres_are_named(write):
    rows = np.array(walk_in_pixels())
    rows[:, 2:] = to_ground(rows[:, 2:], TILTED)
    with pytest.raises(FileError, match=r"without the homography people walk at 1.2 m/s.*metres already"):
        read(write(text_of(rows.tolist())), homography=TILTED)
    pixels = write(text_of((rows * [1.0, 1.0, 50.0, 50.0]).tolist()))
    with pytest.raises(FileError, match=r"with its inverse at 1\.2 m/s"):
        read(pixels, homography=np.diag([50.0, 50.0, 1.0]))
    assert read(pixels, homography=np.diag([0.02, 0.02, 1.0])).frames == 12


def test_the_cause_of_a_speed_is_not_a_homography_where_there_is_one(write):
    path, centimetres = write(text_of(walk_in_pixels())), np.diag([100.0, 100.0, 1.0]) @ TILTED
    with pytest.warns(VbbenchWarning, match="the homography maps to centimetres: 1.2 m/s") as caught:
        read(path, homography=centimetres)
    assert "homography is needed" not in str(caught[0].message)
    with pytest.warns(VbbenchWarning, match=r"rows of a person are 10 apart \(dt = 0.4\): 1.2 m/s"):
        read(path, dt=0.04, homography=TILTED)
    with pytest.warns(VbbenchWarning, match="a homography is needed"):
        read(path)
