"""UCY's spline annotation: between key points, and what it cannot hold."""

import numpy as np
import pytest

from tests.fuzz.trajectories import SPLINES
from tests.lib.recorded_walks import CENTIMETRES, read
from vbbench.errors import FileError
from vbbench_generators.recordings.readers.tracks import read_homography
from vbbench_generators.recordings.readers.vsp import polyline, smooth_curve


def test_vsp_is_interpolated_between_key_points(write):
    scene = read(write(SPLINES, "a.vsp"), "vsp", frame_step=10, homography=CENTIMETRES)
    assert scene.people.tolist() == [1, 2]
    np.testing.assert_allclose(scene.positions[:, 0], [[0, 0], [0.5, 0], [1, 0], [1, 1 / 3]])
    np.testing.assert_allclose(scene.positions[:, 1], [[np.nan] * 2, [0, 0.15], [0, 0.4], [0, 0.65]])
    curved = read(write(SPLINES, "a.vsp"), "vsp", frame_step=10, homography=CENTIMETRES, smooth=True)
    assert np.nanmax(np.abs(curved.positions - scene.positions)) > 0.01


def replaced(line, text):
    rows = SPLINES.split("\n")
    rows[line - 1] = text
    return "\n".join(rows)


ALONE = "1 - the number of splines\n2 - Num of control points\n0 0 {} 0 - (2D)\n1 1 {} 0 - (2D)\n"


def begun(lines):
    return "\n".join(SPLINES.split("\n")[:lines])


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        ("", None, "empty"),
        ("0 - the number of splines\n", 1, "no spline"),
        (replaced(1, "many splines"), 1, "the number of splines' should stand"),
        (replaced(2, "4 - Num of control points"), 6, "columns, not 4"),
        (replaced(2, "2 - Num of control points"), 5, "Num of control points' should"),
        (replaced(2, "0 - Num of control points"), 2, "0 control points"),
        (replaced(1, "3 - the number of splines"), 9, "should stand here"),
        (begun(7), 6, "2 control points has 1"),
        (begun(5), 5, "ends where"),
        (replaced(4, "100.0 0.0 20 - (2D point, m_id)"), 4, "3 columns, not 4"),
        (replaced(4, "100.0 zero 20 90 - (2D point, m_id)"), 4, "y is 'zero'"),
        (replaced(4, "100.0 inf 20 90 - (2D point, m_id)"), 4, "finite"),
        (replaced(4, "100.0 0 20.5 90 - (2D point, m_id)"), 4, "frame is 20.5"),
        (replaced(4, "100.0 0 0 90 - (2D point, m_id)"), 4, "does not come after 0"),
        (ALONE.format(0, 4000000), 3, "a spline goes from frame 0 to 4000000"),
        (ALONE.format(1, 9), None, "no person is annotated at a multiple of 10 frames"),
    ],
)
def test_bad_vsp(write, text, line, problem):
    path = write(text, "a.vsp")
    with pytest.raises(FileError, match=problem) as caught:
        read(path, "vsp", frame_step=10, homography=CENTIMETRES)
    assert caught.value.path == path
    assert caught.value.line == line


def test_smooth_curve_passes_key_points_and_stays_between_them():
    key_times = np.array([0.0, 10.0, 30.0, 1000.0, 1030.0])
    keys = np.array([[0.0, 0], [1, 0.2], [2, 0.1], [2.01, 0.1], [4, 0.5]])
    times = np.linspace(0, 1030, 4000)
    curve = smooth_curve(times, key_times, keys)
    np.testing.assert_allclose(smooth_curve(key_times, key_times, keys), keys, atol=1e-12)
    assert np.diff(curve[:, 0]).min() >= -1e-12
    assert np.abs(curve - polyline(times, key_times, keys)).max() < 0.3
    np.testing.assert_array_equal(smooth_curve(times[:3], key_times[:1], keys[:1]), np.zeros((3, 2)))


@pytest.mark.parametrize("name", ["students001", "students003"])
def test_vsp_gives_the_published_students(data_folder, name):
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
