"""vbbench view: recordings are read back and compared with the truth and the metrics. Skipped without rerun."""

import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.answers import submit, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.camera import PerspectiveCamera
from vbbench.cli import main
from vbbench.files.dataset import Dataset
from vbbench.files.submission_tables import SubmittedEstimates
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.pictures.viewer import record_to_file
from vbbench.pictures.viewer.marks import Opened, how_to_open, open_viewer
from vbbench.protocol import scored_frames, scored_positions
from vbbench.scoring import score
from vbbench.scoring.metrics import position_error, relative_position_error, rotation_error, translation_error
from vbbench.solving import solve

reading = pytest.importorskip("rerun.chunk", reason="needs the extra viewer, new enough to read recordings")
pytestmark = pytest.mark.extra

SEQUENCE = 1
Entities = dict[str, dict[str, list[Any]]]


def read(path: Path) -> Entities:
    """Columns of everything in a recording that changes with time, by entity; and of what does not, as ``PATH*``."""
    found: Entities = defaultdict(lambda: defaultdict(list))
    for chunk in reading.RrdReader(path).stream():
        name = chunk.entity_path.lstrip("/").replace("\\", "") + ("*" if chunk.is_static else "")
        for column, values in chunk.to_record_batch().to_pydict().items():
            found[name][column] += values
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("view") / "crowd"
    write_dataset(folder, Crowd(people=8, caution="made up"))
    return folder


@pytest.fixture(scope="module")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("view") / "tracked"
    write_dataset(folder, Crowd(tier="tracked"))
    return Dataset(folder)


@pytest.fixture(scope="module")
def submission(folder: Path) -> Path:
    return submit(folder.parent / "noisy", folder, true_answers(folder, 0.1))


@pytest.fixture(scope="module")
def recording(folder: Path, submission: Path) -> Entities:
    return read(record_to_file(Dataset(folder), SEQUENCE, folder.parent / "crowd.rrd", submissions=[submission]))


def test_people_stand_where_they_are_with_their_height_and_colour(folder: Path, recording: Entities) -> None:
    dataset = Dataset(folder)
    sequence, people = dataset.sequence(SEQUENCE), recording["world/people"]
    assert people["frame"] == list(range(sequence.frames))
    seconds = [time.total_seconds() for time in people["time"]]
    np.testing.assert_allclose(seconds, np.arange(sequence.frames) * dataset.info.dt)
    truth = dataset.truth(sequence)
    colours = defaultdict(set)
    for frame in range(sequence.frames):
        seen = np.flatnonzero(sequence.observed[frame])
        expected = np.column_stack([truth.positions[frame, seen], truth.heights[seen] / 2])
        np.testing.assert_allclose(np.reshape(people["Ellipsoids3D:centers"][frame], (-1, 3)), expected, atol=1e-5)
        assert people["Ellipsoids3D:labels"][frame] == [str(track) for track in sequence.tracks[seen]]
        for track, colour in zip(sequence.tracks[seen], people["Ellipsoids3D:colors"][frame], strict=True):
            colours[track].add(colour)
    assert all(len(of_one) == 1 for of_one in colours.values())
    assert len(set.union(*colours.values())) == len(sequence.tracks)


def test_the_observer_moves_and_turns(folder: Path, recording: Entities) -> None:
    dataset = Dataset(folder)
    poses, observer = dataset.truth(dataset.sequence(SEQUENCE)).poses, recording["world/observer"]
    places = np.reshape(observer["Transform3D:translation"], (-1, 3))
    np.testing.assert_allclose(places[:, :2], poses[:, :2], atol=1e-5)
    turns = np.reshape(observer["Transform3D:quaternion"], (-1, 4))
    np.testing.assert_allclose(turns[:, 2:], np.stack([np.sin(poses[:, 2] / 2), np.cos(poses[:, 2] / 2)], 1), atol=1e-6)
    on_map = np.reshape(recording["map/observer"]["Arrows2D:origins"], (-1, 2))
    np.testing.assert_allclose(on_map, poses[:, :2] * (1, -1), atol=1e-5)


def test_errors_over_time_are_those_of_the_metrics(folder: Path, submission: Path, recording: Entities) -> None:
    dataset = Dataset(folder)
    sequence = dataset.sequence(SEQUENCE)
    truth, said = dataset.truth(sequence), SubmittedEstimates(dataset, submission).of(sequence)
    counted = scored_positions(sequence.observed, sequence.given)
    frames = np.flatnonzero(scored_frames(sequence.observed))
    dx, pair = position_error(said.positions, truth.positions), (said.poses, truth.poses)
    dx_rel = relative_position_error(said.positions, said.poses[:, None], truth.positions, truth.poses[:, None])
    expected = {
        "dx": {t: dx[t, counted[t]].mean() for t in frames if counted[t].any()},
        "dx_rel": {t: dx_rel[t, counted[t]].mean() for t in frames if counted[t].any()},
        "dr": {t: rotation_error(*pair)[t] for t in frames},
        "dt": {t: translation_error(*pair)[t] for t in frames},
    }
    for key, values in expected.items():
        series = recording[f"errors/{key}/test"]
        assert series["frame"] == list(values)
        np.testing.assert_allclose(np.ravel(series["Scalars:scalars"]), list(values.values()), atol=1e-12)


def test_words_name_dataset_caution_protocol_and_figures(folder: Path, submission: Path, recording: Entities) -> None:
    (facts,) = recording["facts*"]["TextDocument:text"][0]
    for wanted in (Dataset(folder).info.id, "made up", "sequential/2", "**test**", "Δx̃ 0."):
        assert wanted in facts
    (text,) = recording["now"]["TextDocument:text"][0]
    assert "Frame 0" in text
    assert "given the pose and" in text
    assert score(submission, folder).coverage == 1.0


def test_boxes_are_drawn_at_both_ends_of_a_panorama(folder: Path, recording: Entities) -> None:
    dataset = Dataset(folder)
    sequence, boxes = dataset.sequence(SEQUENCE), recording["ego/boxes"]
    width = dataset.info.camera.picture_size[0]
    for frame, centers in enumerate(boxes["Boxes2D:centers"]):
        columns = np.reshape(centers, (-1, 2))[:, 0]
        seen = sequence.observations[frame, sequence.observed[frame], 0]
        np.testing.assert_allclose(np.unique(np.round(columns % width, 2)), np.unique(np.round(seen, 2)), atol=0.02)
        half = np.reshape(boxes["Boxes2D:half_sizes"][frame], (-1, 2))[:, 0]
        assert np.all((columns + half > 0) & (columns - half < width))


def test_several_submissions_get_names_and_colours_of_their_own(folder: Path, submission: Path, tmp_path: Path) -> None:
    tables = true_answers(folder, 0.2)
    others = [submit(tmp_path / "b", folder, tables), submit(tmp_path / "c", folder, tables)]
    out = record_to_file(Dataset(folder), SEQUENCE, tmp_path / "x.rrd", submissions=[submission, *others])
    entities = read(out)
    names = ["estimates/test (noisy)", "estimates/test (b)", "estimates/test (c)"]
    looks = [entities[f"world/{name}/trails*"]["LineStrips3D:colors"][0][0] for name in names]
    assert len(set(looks)) == 3
    rollout = submit(tmp_path / "d", folder, tables, protocol="rollout")
    entities = read(record_to_file(Dataset(folder), SEQUENCE, tmp_path / "y.rrd", submissions=[submission, rollout]))
    assert "errors/dt/test rollout" in entities


def test_covariances_become_ellipses(folder: Path, tmp_path: Path) -> None:
    out = solve(Dataset(folder), "vb-cv", "sequential", tmp_path / "vb", covariance=True)
    dataset = Dataset(folder)
    sequence = dataset.sequence(SEQUENCE)
    entities = read(record_to_file(dataset, SEQUENCE, tmp_path / "x.rrd", submissions=[out]))
    said = SubmittedEstimates(dataset, out).of(sequence)
    assert said.pose_covariances is not None
    frame = int(np.flatnonzero(np.isfinite(said.pose_covariances[:, 0, 0]))[0])
    ((outline),) = entities["world/estimates/vb-cv/observer-95-percent"]["LineStrips3D:strips"][frame]
    off = np.array(outline)[:, :2] - said.poses[frame, :2]
    distance = np.einsum("ni,ij,nj->n", off, np.linalg.inv(said.pose_covariances[frame, :2, :2]), off)
    np.testing.assert_allclose(distance, 5.991, rtol=0.01)
    assert "map/estimates/vb-cv/95-percent" in entities


def test_without_truth_boxes_given_and_estimates_are_left(folder: Path, submission: Path, tmp_path: Path) -> None:
    shutil.copytree(folder, tmp_path / "withheld", ignore=shutil.ignore_patterns("truth"))
    blind = Dataset(tmp_path / "withheld")
    entities = read(record_to_file(blind, SEQUENCE, tmp_path / "x.rrd", submissions=[submission]))
    assert {"ego/boxes", "world/estimates/test/people"} <= entities.keys()
    assert not {name for name in entities if "errors" in name or "observer/" in name or "unseen" in name}
    assert "no truth available" in entities["facts*"]["TextDocument:text"][0][0]
    bare = read(record_to_file(blind, SEQUENCE, tmp_path / "y.rrd"))
    assert {"ego/boxes", "world/given", "world/people", "map/given-observer"} <= bare.keys()
    elsewhere = Dataset(tmp_path / "withheld", folder / "truth")
    assert "world/observer" in read(record_to_file(elsewhere, SEQUENCE, tmp_path / "z.rrd"))


def test_false_alarms_and_switched_ids_are_shown(tracked: Dataset, tmp_path: Path) -> None:
    entities = read(record_to_file(tracked, 0, tmp_path / "x.rrd"))
    labels = entities["ego/boxes"]["Boxes2D:labels"][0]
    assert "900" in labels
    alarm = entities["ego/boxes"]["Boxes2D:colors"][0][labels.index("900")]
    assert alarm == int.from_bytes(bytes((255, 80, 60, 255)))
    assert "900" not in entities["world/people"]["Ellipsoids3D:labels"][0]


def test_boxes_hang_on_a_pinhole_camera(tmp_path: Path) -> None:
    camera = PerspectiveCamera(width=160, height=90, focal=80.0, cx=80.0, cy=45.0)
    dataset = Dataset(generate("demo", tmp_path / "crowd", Options(camera=camera, limit=1)).folder)
    entities, root = read(record_to_file(dataset, 0, tmp_path / "x.rrd")), "world/observer/camera"
    assert entities[f"{root}*"]["Pinhole:resolution"][0] == [[160.0, 90.0]]
    assert f"{root}/boxes" in entities


def test_a_failure_leaves_nothing(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("vbbench.pictures.viewer.record_boxes", fail)
    with pytest.raises(KeyboardInterrupt):
        record_to_file(Dataset(folder), SEQUENCE, tmp_path / "x.rrd")
    assert not list(tmp_path.iterdir())


def test_mistakes_are_one_line(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = ["--out", str(tmp_path / "x.rrd")]
    assert main(["view", str(folder), "--sequence", "99", *out]) == 2
    assert "has sequences 0 to" in capsys.readouterr().err
    assert main(["view", str(folder), "--sequence", "0", "--out", str(tmp_path / "x.mp4")]) == 2
    assert "ends in .rrd" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert main(["view", str(folder), "--sequence", "0", *out]) == 2
    message = "vbbench: vbbench view needs rerun: python -m pip install 'vbbench[viewer]'\n"
    assert capsys.readouterr().err == message
    assert not list(tmp_path.iterdir())


def test_the_command_prints_the_file_and_how_to_open_it(
    folder: Path,
    submission: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CI", "1")
    monkeypatch.chdir(tmp_path)
    arguments = ["--estimate", str(submission), str(submission)]
    assert main(["view", str(folder), "--sequence", "0", *arguments]) == 0
    captured = capsys.readouterr()
    assert captured.out == "tiny-0.rrd\n"
    assert "open it with: rerun tiny-0.rrd" in captured.err
    assert how_to_open(Path("a b.rrd")) == "rerun 'a b.rrd'"


def test_the_viewer_opens_where_there_is_a_display(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[list[str]] = []
    monkeypatch.setattr(subprocess, "Popen", lambda command, **_: started.append(command))
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("CI", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert open_viewer(tmp_path / "x.rrd") is Opened.NO_DISPLAY
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert open_viewer(tmp_path / "x.rrd") is Opened.SHOWN
    assert started[0][1:] == [str(tmp_path / "x.rrd")]
    monkeypatch.setenv("CI", "true")
    assert open_viewer(tmp_path / "x.rrd") is Opened.NO_DISPLAY
    monkeypatch.delenv("CI")
    monkeypatch.setattr("vbbench.pictures.viewer.marks.viewer_program", lambda: None)
    assert open_viewer(tmp_path / "x.rrd") is Opened.NO_VIEWER
    assert len(started) == 1
