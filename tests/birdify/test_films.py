"""From a film to a map: on a film of coloured boxes whose truth is known."""

import csv
import json
from typing import Any

import cv2
import numpy as np
import pytest

from tests.lib.mot_text import read_mot
from vbbench.birdify.films import Detection, birdify_film
from vbbench.boxes import rectangles
from vbbench.camera import PerspectiveCamera
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.detection import Detections
from vbbench.exchange.matching import match_boxes
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.geometry import world_to_relative
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of
from vbbench.pictures.video import write_mp4
from vbbench.solver import Frame, FrameEstimate, Problem

FRAMES, FPS, PEOPLE = 40, 10.0, 6
CAMERA = PerspectiveCamera(width=640, height=360, focal=400.0, cx=320.0, cy=180.0, mount_height=1.5)
TOML = "width = 640\nheight = 360\nfocal = 400\nmount_height = 1.5\n"
COLOURS = np.array([(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0), (255, 0, 255), (0, 255, 255)])
POSES = np.stack([0.08 * np.arange(FRAMES), np.zeros(FRAMES), 0.002 * np.arange(FRAMES)], axis=-1)


def places() -> Any:
    """[T, K, 2] of people who cross at different distances."""
    time = np.arange(FRAMES)[:, None] / FPS
    ahead = np.array([8.0, 9.5, 11.0, 12.5, 14.0, 16.0])
    aside = np.linspace(-2.5, 3.0, PEOPLE)
    walk = np.array([0.4, -0.3, 0.5, -0.4, 0.2, -0.5])
    return np.stack([ahead - 0.3 * time, aside + walk * time], axis=-1)


def drawn(frame: int) -> Any:
    """A picture; bodies are as high as their near edges, .45 m before their middles, have it."""
    relative = world_to_relative(places()[frame], POSES[frame])
    edges = relative * (1.0 - 0.45 / np.linalg.norm(relative, axis=-1, keepdims=True))
    boxes = rectangles(CAMERA.project(edges, np.full(PEOPLE, 1.72)))
    picture = np.zeros((360, 640, 3), np.uint8)
    for person in np.argsort(-relative[:, 1]):
        left, top, width, height = np.round(boxes[person]).astype(int)
        picture[max(top, 0) : top + height, max(left, 0) : left + width] = COLOURS[person]
    return picture


class Colours:
    """Finds the part of each box that shows."""

    def detect(self, rgb: Any, period: float | None = None) -> Detections:
        found = []
        for colour in COLOURS:
            rows, columns = np.nonzero((np.abs(rgb.astype(int) - colour) < 90).all(axis=-1))
            if len(rows) > 50:
                left, right = np.percentile(columns, (1, 99))
                top, bottom = np.percentile(rows, (1, 99))
                found.append([left, top, right - left + 1, bottom - top + 1])
        return Detections(boxes=np.array(found, float).reshape(-1, 4), scores=np.full(len(found), 0.9))


FOUND = Detection(detector="tests.birdify.test_films:Colours")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Any:
    place = tmp_path_factory.mktemp("film")
    (place / "pictures").mkdir()
    for frame in range(FRAMES):
        cv2.imwrite(str(place / "pictures" / f"{frame + 1:04d}.png"), drawn(frame)[..., ::-1])
    write_mp4(place / "film.mp4", lambda frames: map(drawn, frames), FRAMES, FPS)
    (place / "camera.toml").write_text(TOML)
    (place / "timed.toml").write_text(TOML + "fps = 10\n")
    return place


def table(path: Any) -> dict[str, Any]:
    with path.open() as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def check_map(out: Any, tolerance: float, every: int = 1) -> None:
    """Whether the people are where they are, seen from the camera in every frame."""
    poses, positions = table(out / "poses.csv"), table(out / "positions.csv")
    assert len(poses["x"]) == FRAMES // every
    pose_of = {frame: n for n, frame in enumerate(poses["frame"])}
    errors = []
    for frame, x, y in zip(positions["frame"], positions["x"], positions["y"], strict=True):
        n, t = pose_of[frame], round(frame) - 1
        seen = world_to_relative(np.array([[x, y]]), np.array([poses[c][n] for c in ("x", "y", "yaw")]))
        errors.append(np.linalg.norm(world_to_relative(places()[t], POSES[t]) - seen, axis=-1).min())
    assert np.median(errors) < tolerance


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:people walk at")  # and so they do, slower than most
@pytest.mark.parametrize("kind", ["video", "folder"])
def test_a_film_becomes_a_map_and_its_boxes_are_kept(folder, tmp_path, kind):
    out, said = tmp_path / "map", []
    path, camera = ("film.mp4", "camera.toml") if kind == "video" else ("pictures", "timed.toml")
    birdify_film(folder / path, folder / camera, out, FOUND, announce=said.append)
    check_map(out, 0.35)
    assert json.loads((out / "report.json").read_text())["tracks"] >= PEOPLE
    assert (out / "recording" / "gt.txt").read_text().count("\n") > 200
    assert not list(tmp_path.glob("*.boxes.txt"))
    assert any("40 frames" in line and "the tracker keeps" in line for line in said)
    pictures = json.loads((out / "dataset" / "dataset.json").read_text()).get("pictures")
    if kind == "folder":
        assert pictures[0]["pattern"].endswith("/pictures/{:04d}.png")
        assert (pictures[0]["first"], pictures[0]["step"]) == (1, 1)
    else:
        assert pictures is None


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:people walk at")  # and so they do, slower than most
@pytest.mark.filterwarnings("ignore:frames are numbered in steps of 2")
def test_every_second_frame_and_the_command(folder, tmp_path, capsys):
    out = tmp_path / "map"
    command = ["birdify", str(folder / "pictures"), "--camera", str(folder / "timed.toml"), "--out", str(out)]
    command += ["--detector", FOUND.detector, "--every", "2"]
    assert main(command) == 0
    assert str(out) in capsys.readouterr().out
    check_map(out, 0.35, every=2)
    assert json.loads((out / "report.json").read_text())["dt"] == pytest.approx(0.2)
    assert json.loads((out / "dataset" / "dataset.json").read_text())["pictures"][0]["step"] == 2
    assert main(command) == 2
    assert "exists" in capsys.readouterr().err
    boxes = out / "recording" / "gt.txt"
    assert main(["birdify", str(boxes), *command[2:4], "--out", str(tmp_path / "n"), "--detector", "hog"]) == 2
    assert "--detector is for films, and" in capsys.readouterr().err


def test_a_film_of_another_size_or_of_no_rate_is_one_clear_line(folder, tmp_path):
    other = tmp_path / "other.toml"
    other.write_text(TOML.replace("640", "1280"))
    with pytest.raises(FileError, match=r"says 1280 x 360 px, .*film\.mp4 is 640 x 360: write the size of the film"):
        birdify_film(folder / "film.mp4", other, tmp_path / "map", FOUND)
    with pytest.raises(FileError, match="does not say how many frames a second"):
        birdify_film(folder / "pictures", folder / "camera.toml", tmp_path / "map", FOUND)


class Helpless:
    """Fails at the first frame."""

    def start(self, problem: Problem) -> None:
        """Nothing to begin."""

    def step(self, frame: Frame) -> FrameEstimate:
        raise VbbenchError("this cannot be solved")


@pytest.mark.slow
def test_boxes_stay_where_the_map_cannot_be_made(folder, tmp_path):
    given, helpless = (folder / "pictures", folder / "timed.toml", tmp_path / "map", FOUND), f"{__name__}:Helpless"
    with pytest.raises(VbbenchError, match="no solver is called 'nobody'"):
        birdify_film(*given, solver="nobody")
    assert not (tmp_path / "map.boxes.txt").exists()
    with pytest.raises(VbbenchError, match="this cannot be solved"):
        birdify_film(*given, solver=helpless)
    assert (tmp_path / "map.boxes.txt").is_file()
    assert not (tmp_path / "map").exists()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")  # HOG's map is not a good one
def test_hog_makes_a_map_of_a_rendered_street(tmp_path):
    frames = range(140, 147)
    generate("street", tmp_path / "street", Options(seed=5, simulation=Simulation(sequences=1)))
    dataset = Dataset(tmp_path / "street")
    sequence = dataset.sequence(0)
    (tmp_path / "pictures").mkdir()
    with open_renderer(Backend(name="raster"), scene_of(dataset, sequence.scene), str) as renderer:
        for frame, picture in zip(frames, pictures(dataset, sequence, renderer, frames), strict=True):
            cv2.imwrite(str(tmp_path / "pictures" / f"{frame:06d}.png"), picture.rgb[..., ::-1])
    (tmp_path / "camera.toml").write_text("width = 1280\nheight = 720\nfocal = 640\nmount_height = 1.6\nfps = 10\n")
    made = birdify_film(tmp_path / "pictures", tmp_path / "camera.toml", tmp_path / "map", Detection())
    assert made.report.frames >= 5
    rows = read_mot(tmp_path / "map" / "recording" / "gt.txt", len(frames))
    people = found = 0
    for n, frame in enumerate(frames):
        real = rectangles(sequence.observations[frame, sequence.observed[frame]])
        found += len(match_boxes(rows.boxes[rows.frame == n], real, dataset.camera(sequence))[0])
        people += len(real)
    assert found > 0.15 * people
    assert found > 0.3 * len(rows.frame)
