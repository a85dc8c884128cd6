"""Recordings of heads: the surveillance camera, who is hidden, how boxes are drawn, and the folder that comes of it."""

import configparser
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.lib.head_crowds import make_crowd, square
from tests.lib.mot_text import read_mot
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.exchange.heads import (
    HEAD_HEIGHT,
    KEY_EVERY,
    LEAST_VISIBLE,
    HeadOptions,
    Heads,
    SurveillanceCamera,
    camera_of,
    draw_boxes,
    export_heads,
    see_heads,
    visible_fractions,
)
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options

OPTIONS = HeadOptions(camera_height=6.0)
CAMERA = camera_of(HeadOptions())
NO_SCREENS = np.empty((0, 4))
STATION = np.array([0.0, 0.0, np.pi / 2])


@pytest.fixture(scope="module")
def crowd(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return make_crowd(tmp_path_factory.mktemp("heads"), square())


@pytest.fixture(scope="module")
def folder(crowd: Dataset) -> Path:
    return export_heads(crowd, crowd.folder.parent / "HT21-99", OPTIONS)


def heads_at(*ground: tuple[float, float], camera: SurveillanceCamera = CAMERA) -> Heads:
    """People 1.70 m tall at (right, forward) m, in one frame."""
    positions = np.array(ground)[None]
    heights = np.full(len(ground), 1.70)
    return see_heads(positions, heights, camera, STATION, dt=0.04)


def shares(heads: Heads, screens: np.ndarray = NO_SCREENS) -> list[float]:
    by_person = heads.sorted_by("person")
    return visible_fractions(by_person, np.full(len(heads), HEAD_HEIGHT), CAMERA, screens).tolist()


def table(folder: Path) -> dict[str, np.ndarray]:
    rows = pq.read_table(folder / "truth.parquet")
    return {name: rows.column(name).to_numpy() for name in rows.column_names}


@given(point=st.tuples(st.floats(-20, 20), st.floats(5, 80), st.floats(0, 2)), tilt=st.floats(1, 60))
def test_the_camera_is_a_rotated_pinhole(point, tilt):
    camera = camera_of(HeadOptions(tilt=tilt))
    sin, cos = np.sin(camera.tilt), np.cos(camera.tilt)
    axes = np.array([[1, 0, 0], [0, -sin, -cos], [0, cos, -sin]])  # right, down and ahead of the camera
    x, y, z = axes @ (np.array(point) - [0, 0, 13.0])
    expected = [960 + camera.focal * x / z, 540 + camera.focal * y / z, z]
    np.testing.assert_allclose(camera.project(np.array(point)), expected, rtol=1e-9)


def test_boxes_are_as_wrong_as_asked_and_straight_between_key_frames():
    frames, rng = np.arange(400), np.random.default_rng(0)
    paths = np.stack([np.linspace(-10, 10, 400)[:, None] * rng.uniform(-1, 1, 200), np.full((400, 200), 25.0)], axis=-1)
    heads = see_heads(paths, np.full(200, 1.7), CAMERA, STATION, dt=0.04)
    boxes = draw_boxes(heads, 0.12, np.random.default_rng(1))
    errors = boxes[:, 2:] / heads.sizes - 1.0
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(0.12, rel=0.03)
    assert abs(errors.mean()) < 0.01
    centres = (boxes[:, :2] + boxes[:, 2:] / 2.0 - heads.places) / heads.sizes
    assert np.sqrt(np.mean(centres**2)) == pytest.approx(0.06, rel=0.03)
    one = heads.track == 1
    bends = np.flatnonzero(np.abs(np.diff(boxes[one], 2, axis=0)).max(axis=1) > 1e-9) + 1
    assert set(frames[bends] % KEY_EVERY) == {0}


def test_the_nearer_hides_the_farther():
    assert shares(heads_at((0, 30), (0, 40))) == [1.0, 1.0]
    assert shares(heads_at((0, 45), (0, 45.05))) == [1.0, 0.0]  # the head before
    tall = see_heads(np.array([[[0.0, 45.0], [0.0, 46.0]]]), np.array([2.0, 1.6]), CAMERA, STATION, dt=0.04)
    shown = visible_fractions(tall, np.array([1.88, 1.48]), CAMERA, NO_SCREENS)
    assert shown[0] == 1.0
    assert shown[1] < 0.8


def test_the_folder_is_one_of_head_tracking_21(folder, crowd):
    info = configparser.ConfigParser()
    info.read(folder / "seqinfo.ini")
    assert dict(info["Sequence"])["framerate"] == "25"
    assert {name: info["Sequence"][name] for name in ("name", "seqLength", "imWidth", "imHeight")} == {
        "name": "HT21-99",
        "seqLength": "150",
        "imWidth": "1920",
        "imHeight": "1080",
    }
    rows = np.loadtxt(folder / "gt" / "gt.txt", delimiter=",")
    assert rows.shape[1] == 9
    assert (rows[:, 0].min(), rows[:, 0].max()) == (1, 150)
    assert set(rows[:, 7]) == {1, 2, 3, 4}
    assert ((rows[:, 8] == 0) | (rows[:, 8] >= LEAST_VISIBLE)).all()
    assert (rows[:, 8] == 0).any()


def test_what_counts_is_in_the_truth_beside(folder, crowd):
    truth, facts = table(folder), json.loads((folder / "truth.json").read_text("utf-8"))
    rows = read_mot(folder / "gt" / "gt.txt", 150)
    shown = truth["visible"] > 0
    order, same = np.lexsort([rows.frame, rows.track]), np.lexsort([truth["frame"][shown], truth["track"][shown]])
    for name, counted in (("frame", rows.frame), ("track", rows.track)):
        np.testing.assert_array_equal(counted[order], truth[name][shown][same])
    boxes = rows.boxes[order]
    apart = boxes[:, :2] + boxes[:, 2:] / 2 - np.stack([truth["u"], truth["v"]], axis=1)[shown][same]
    assert np.abs(apart).max() < truth["size"].max()
    people, positions, _ = crowd.scene(0)
    world = positions[truth["frame"], np.searchsorted(people, truth["person"])]
    np.testing.assert_array_equal(world, np.stack([truth["x"], truth["y"]], axis=1))
    assert (facts["boxes"], facts["tracks"]) == (len(shown), truth["track"].max())
    assert facts["hidden"] == np.sum(~shown)
    assert facts["camera"]["horizon"] == pytest.approx(camera_of(OPTIONS).horizon)
    assert facts["box_error"] == pytest.approx(0.12, rel=0.1)


def test_the_same_seed_gives_the_same_bytes(folder, crowd, tmp_path):
    again = export_heads(crowd, tmp_path / "HT21-99", OPTIONS)
    for name in ("seqinfo.ini", "gt/gt.txt", "truth.json", "truth.parquet"):
        assert (again / name).read_bytes() == (folder / name).read_bytes()
    other = export_heads(crowd, tmp_path / "other", OPTIONS, seed=1)
    assert (other / "gt" / "gt.txt").read_bytes() != (folder / "gt" / "gt.txt").read_bytes()


def test_the_camera_faces_a_direction(crowd, tmp_path):
    turned = table(export_heads(crowd, tmp_path / "turned", replace(OPTIONS, facing=180.0)))
    assert np.mean(turned["right"]) == pytest.approx(0.0, abs=2.0)
    assert np.corrcoef(turned["forward"], -turned["x"])[0, 1] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"tilt": 0.0}, "tilt must be 1 to 89 degrees, not 0"),
        ({"fov": 151.0}, "fov must be 1 to 150 degrees, not 151"),
        ({"camera_height": 2.0}, "camera_height must be 2.58 to 1,000 m, not 2"),
        ({"camera_height": np.inf}, "camera_height must be 2.58 to 1,000 m, not inf"),
        ({"box_noise": 0.5}, "box_noise must be 0 to 0.4, not 0.5"),
        ({"facing": np.nan}, "facing must be -360 to 360 degrees, not nan"),
    ],
)
def test_options_out_of_range_are_named(crowd, tmp_path, options, problem):
    with pytest.raises(VbbenchError, match=re.escape(problem)):
        export_heads(crowd, tmp_path / "x", HeadOptions(**options))
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--heads", "--frames"], "--heads writes no pictures: remove --frames"),
        (["--heads", "--sequence", "4"], "has sequences 0 to 0, not 4"),
    ],
)
def test_mistakes_are_one_line(crowd, tmp_path, capsys, arguments, problem):
    assert main(["export", "mot", str(crowd.folder), "--out", str(tmp_path / "x"), *arguments]) == 2
    message = capsys.readouterr().err
    assert problem in message
    assert message.count("\n") == 1
    assert not (tmp_path / "x").exists()


def test_the_command_says_where_the_folder_is_and_asks_for_one_of_several_sequences(crowd, tmp_path, capsys):
    out = tmp_path / "HT21-99"
    assert main(["export", "mot", str(crowd.folder), "--heads", "--sequence", "0", "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    generate("demo", tmp_path / "demo", Options(limit=2))
    assert main(["export", "mot", str(tmp_path / "demo"), "--heads", "--out", str(tmp_path / "x")]) == 2
    assert "has 2 sequences; choose the one to record" in capsys.readouterr().err
