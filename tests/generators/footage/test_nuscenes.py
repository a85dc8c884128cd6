"""Faults in tables of nuScenes: one error that names file, row and repair."""

import json
import re
import shutil
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.lib.cars import Drive, write_tables
from vbbench.errors import FileError, SourceMissingError, VbbenchError
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench_generators.footage.nuscenes import TABLES, nuscenes

SCENE = "scene-0001"
VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(-(2**70), 2**70), st.floats(), st.text(max_size=5)),
    lambda one: st.one_of(st.lists(one, max_size=4), st.dictionaries(st.text(max_size=3), one, max_size=2)),
    max_leaves=5,
)


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    return write_tables(tmp_path_factory.mktemp("nuscenes") / "v1.0-mini", {SCENE: Drive(frames=21, ground=0.0)})


def edited(tables, folder, name, change):
    shutil.copytree(tables, folder / tables.name)
    path = folder / tables.name / f"{name}.json"
    rows = json.loads(path.read_text())
    change(rows)
    path.write_text(json.dumps(rows, indent=0))
    return path


def setting(row, column, value):
    return lambda rows: rows[row % len(rows)].__setitem__(column, value)


def read(folder):
    return nuscenes.read(folder, None, ("panorama", "CAM_FRONT"))


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("sample_annotation", setting(3, "size", [0.6, 0.7]), "row 3: 'size' has not 3 numbers"),
        ("sample_annotation", setting(3, "size", [0.6, 0.7, 9.0]), "row 3: no person is so large or small"),
        ("sample_annotation", setting(3, "rotation", [0, 0, 0, 2]), r"row 3: 'rotation' \(w, x, y, z\) is no rotation"),
        ("sample_annotation", setting(3, "translation", [0, 0, None]), "row 3: 'translation' has not 3 numbers"),
        ("sample_annotation", setting(3, "sample_token", "?"), "row 3: 'sample_token' is no token of sample.json"),
        ("sample_annotation", lambda rows: rows.append(rows[4]), "row 30: its 'instance_token' has another cuboid"),
        ("sample_annotation", lambda rows: rows[5].pop("num_lidar_pts"), "row 5: has no 'num_lidar_pts'"),
        ("sample", setting(1, "timestamp", 1_530_000_000_000_001), "row 1: its time is not 0.5 s or more after"),
        ("sample_data", lambda rows: rows.pop(0), r"has no key frame of the sample in row 0 of sample.json"),
        ("sample_data", setting(2, "width", "wide"), "is no table of nuScenes"),
        ("ego_pose", setting(0, "rotation", [9, 0, 0, 0]), "row 0: 'rotation'"),
        ("calibrated_sensor", setting(0, "camera_intrinsic", [[1]]), "row 0: 'camera_intrinsic' has not 3 x 3"),
        ("calibrated_sensor", setting(0, "camera_intrinsic", [[-1, 0, 0]] * 3), "row 0: focal"),
    ],
)
def test_one_wrong_value_is_named_with_its_row(tables, tmp_path, name, change, said):
    path = edited(tables, tmp_path, name, change)
    with pytest.raises(FileError, match=rf"^{re.escape(str(path))}: {said}.*unpack the metadata again"):
        read(tmp_path)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_that_is_missing_or_damaged_is_named(tables, tmp_path, name):
    path = edited(tables, tmp_path, name, lambda rows: rows)
    content = path.read_text()
    for damage in (
        content[:-5],
        "",
        "{}",
        "[null]",
        content.replace('"token"', '"token', 1).replace('_token"', "_token", 1),
    ):
        path.write_text(damage)
        with pytest.raises(FileError, match=rf"^{re.escape(str(path))}: is no .*unpack the metadata again"):
            read(tmp_path)
    path.unlink()
    with pytest.raises(VbbenchError, match=f"{name}.json: is missing|holds no scene.json"):
        read(tmp_path)


def test_people_who_sit_and_others_than_people_on_foot_do_not_count(tables, tmp_path):
    path = edited(tables, tmp_path, "attribute", lambda rows: rows.append({"token": "sits", "name": SITS}))
    rows = json.loads((path.parent / "sample_annotation.json").read_text())
    for row in rows:
        row["attribute_tokens"] = ["sits"] if row["instance_token"].endswith("p0") else []
        row["visibility_token"] = "1" if row["instance_token"].endswith("p1") else "4"
    (path.parent / "sample_annotation.json").write_text(json.dumps(rows))
    cuboids = nuscenes.read(tmp_path, None, ("panorama",))[0].cuboids
    assert len(np.unique(cuboids.person)) == 5
    assert len(np.unique(cuboids.person[cuboids.visible > 0.0])) == 3
    assert set(np.unique(cuboids.visible)) == {0.0, 0.9}


SITS = "pedestrian.sitting_lying_down"


def test_several_versions_or_none_have_to_be_named(tables, tmp_path):
    with pytest.raises(SourceMissingError, match=r"holds no scene.json; name the folder that holds v1.0-trainval"):
        read(tmp_path)
    shutil.copytree(tables, tmp_path / "v1.0-mini")
    shutil.copytree(tables, tmp_path / "v1.0-trainval")
    with pytest.raises(FileError, match=r"holds v1.0-mini, v1.0-trainval; name one of them"):
        read(tmp_path)
    with pytest.raises(VbbenchError, match="name with --source the folder that holds"):
        nuscenes.plan(Options())
    wanted = FootageOptions(sequences=("scene-0002",))
    with pytest.raises(VbbenchError, match=r"no recording of nuscenes is called 'scene-0002'; did you mean"):
        nuscenes.plan(Options(source=tmp_path / "v1.0-mini", footage=wanted))


def test_a_skipped_key_frame_is_not_bridged(tables, tmp_path):
    path = edited(tables, tmp_path, "sample", lambda rows: rows.pop(2))
    gone = f"{SCENE}-10"
    for name in ("sample_data", "sample_annotation"):
        rows = json.loads((path.parent / f"{name}.json").read_text())
        kept = [row for row in rows if row["sample_token"] != gone]
        (path.parent / f"{name}.json").write_text(json.dumps(kept))
    cuboids = nuscenes.read(tmp_path, None, ("panorama",))[0].cuboids
    assert sorted(np.unique(cuboids.frame)) == [*range(6), *range(15, 21)]


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_whatever_is_in_a_row_is_read_or_refused_by_one_error(tables, tmp_path_factory, data):
    name = data.draw(st.sampled_from(sorted(TABLES)))
    column = data.draw(st.sampled_from(sorted(TABLES[name])))
    change = setting(data.draw(st.integers(0, 40)), column, data.draw(VALUES))
    folder = tmp_path_factory.mktemp("fuzz")
    edited(tables, folder, name, change)
    with suppress(VbbenchError):
        read(folder)
    shutil.rmtree(folder)
