"""Faults in logs of Argoverse 2: one error that names file, row and repair."""

import re
import shutil
from contextlib import suppress

import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyarrow import feather

from tests.lib.cars import LOG, Drive, write_log
from vbbench.errors import FileError, SourceMissingError, VbbenchError, VbbenchWarning
from vbbench.generation.generator import Options
from vbbench_generators.footage.argoverse2 import argoverse2, read_log

ANNOTATIONS, POSES = "annotations.feather", "city_SE3_egovehicle.feather"
LENSES, MOUNTS = "calibration/intrinsics.feather", "calibration/egovehicle_SE3_sensor.feather"
COLUMNS = {
    ANNOTATIONS: ("timestamp_ns", "track_uuid", "category", "height_m", "qw", "tx_m", "num_interior_pts"),
    POSES: ("timestamp_ns", "qz", "ty_m"),
    LENSES: ("sensor_name", "fx_px", "width_px", "k1"),
    MOUNTS: ("sensor_name", "qx", "tz_m"),
}
CELLS = st.one_of(
    st.none(),
    st.integers(-(2**62), 2**62),
    st.floats(allow_nan=True, allow_infinity=True),
    st.text(max_size=5),
    st.booleans(),
)


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("log") / LOG, Drive(frames=12))


def changed(log, folder, file, column, row, value):
    """A copy of the log with another value in one cell; the whole column is of its kind."""
    shutil.copytree(log, folder)
    table = feather.read_table(folder / file)
    values = table[column].to_pylist()
    kinds = type(values[0]), type(None)
    values[row % len(values)] = value
    if type(value) not in kinds:
        values = [value] * len(values)
    place = table.column_names.index(column)
    feather.write_feather(table.set_column(place, column, pa.array(values)), folder / file, compression="uncompressed")
    return folder


@pytest.mark.parametrize(
    ("file", "column", "row", "value", "said"),
    [
        (ANNOTATIONS, "height_m", 9, -1.0, "row 9: no person is so large or small"),
        (ANNOTATIONS, "height_m", 9, float("nan"), "row 9: 'height_m' is .*nan.*, which is impossible"),
        (ANNOTATIONS, "height_m", 9, "tall", "column 'height_m' has string in place of numbers"),
        (ANNOTATIONS, "qw", 9, 3.0, "row 9: qw, qx, qy, qz are no rotation"),
        (ANNOTATIONS, "category", 9, None, "row 9: 'category' is empty"),
        (ANNOTATIONS, "track_uuid", 9, "person-9", "row 9: its 'track_uuid' has another cuboid in the same sweep"),
        (ANNOTATIONS, "timestamp_ns", 9, 0, "row [0-9]+: is [0-9]+ s after the first"),
        (ANNOTATIONS, "timestamp_ns", 9, 315_970_000_055_000_000, "row 9: its time is not that of a sweep"),
        (ANNOTATIONS, "timestamp_ns", 9, 0.5, "has time stamps of float64 in place of whole ns"),
        (MOUNTS, "sensor_name", 0, "front", "has no row of the camera 'ring_front'"),
        (POSES, "timestamp_ns", 9, 0.5, "has poses from 0.5 to 0.5 ns, but row 77 of annotations.feather"),
        (POSES, "qz", 3, 9.0, "row 3: qw, qx, qy, qz are no rotation"),
        (LENSES, "fx_px", 0, -5.0, "row 0: focal.*"),
    ],
)
def test_one_wrong_cell_is_named_with_its_row(log, tmp_path, file, column, row, value, said):
    folder = changed(log, tmp_path / LOG, file, column, row, value)
    with pytest.raises(FileError, match=rf"^{re.escape(str(folder / file))}: {said}.*download the log again"):
        read_log(folder, ("panorama", "ring_front"))


@pytest.mark.parametrize("file", COLUMNS)
def test_a_file_that_is_missing_or_damaged_is_named(log, tmp_path, file):
    shutil.copytree(log, tmp_path / LOG)
    path = tmp_path / LOG / file
    content = path.read_bytes()
    for damage, said in ((content[: len(content) // 2], "is no Feather table"), (b"", "is no Feather table")):
        path.write_bytes(damage)
        with pytest.raises(FileError, match=rf"^{re.escape(str(path))}: {said}.*download the log again"):
            read_log(tmp_path / LOG, ("panorama",))
    table = feather.read_table(log / file)
    column = COLUMNS[file][0]
    feather.write_feather(table.drop_columns([column]), path)
    with pytest.raises(FileError, match=f"has no column '{column}', but "):
        read_log(tmp_path / LOG, ("panorama",))
    path.unlink()
    with pytest.raises(FileError, match="is missing; download the log again"):
        read_log(tmp_path / LOG, ("panorama",))


def test_calibration_next_to_the_log_is_used_with_a_warning(log, tmp_path):
    shutil.copytree(log, tmp_path / LOG)
    (tmp_path / LOG / "calibration").rename(tmp_path / "calibration_of_another_car")
    with pytest.warns(VbbenchWarning, match="has no calibration; .*calibration_of_another_car is used"):
        read_log(tmp_path / LOG, ("panorama",))
    shutil.copytree(tmp_path / "calibration_of_another_car", tmp_path / "calibration_of_a_third")
    with pytest.raises(FileError, match="calibration: is missing; download the log again"):
        read_log(tmp_path / LOG, ("panorama",))


def test_a_folder_without_logs_is_refused(log, tmp_path):
    with pytest.raises(
        SourceMissingError, match=r"holds no annotations.feather, nor do its folders; name the folder of logs"
    ):
        argoverse2.plan(Options(source=tmp_path))
    with pytest.raises(VbbenchError, match="name with --source the folder of logs"):
        argoverse2.plan(Options())
    shutil.copytree(log, tmp_path / "train" / LOG)
    shutil.copytree(log, tmp_path / "val" / LOG)
    with pytest.raises(FileError, match="is the same log as "):
        argoverse2.plan(Options(source=tmp_path))


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_whatever_is_in_a_cell_is_read_or_refused_by_one_error(log, tmp_path_factory, data):
    file = data.draw(st.sampled_from(sorted(COLUMNS)))
    column = data.draw(st.sampled_from(COLUMNS[file]))
    folder = tmp_path_factory.mktemp("fuzz") / LOG
    changed(log, folder, file, column, data.draw(st.integers(0, 80)), data.draw(CELLS))
    with suppress(VbbenchError):
        read_log(folder, ("panorama", "ring_front"))
    shutil.rmtree(folder)
