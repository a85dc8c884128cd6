"""From a film to a map: on a film of coloured boxes whose truth is known."""

import csv
import json
from typing import Any

import cv2
import numpy as np
import pytest

from tests.lib import square_film
from tests.lib.mot_text import read_mot
from vbbench.birdify.films import Detection, FilmBoxes, birdify_film, find_boxes, kept_detections, key_of
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
from vbbench.pictures.video import open_film, write_mp4
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


SHOWN = square_film.FRAMES


class Square:
    """Finds the square of `square_film`, and a false alarm in the first picture."""

    seen = 0

    def detect(self, rgb: Any, period: float | None = None) -> Detections:
        rows, columns = np.nonzero(rgb.min(axis=-1) > 128)
        box = [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
        self.seen += 1
        found = [box, [70.0, 5.0, 8.0, 20.0]] if self.seen == 1 else [box]
        return Detections(boxes=np.array(found, float), scores=np.full(len(found), 0.9))


class Once(Square):
    """Finds the square in the first picture alone."""

    def detect(self, rgb: Any, period: float | None = None) -> Detections:
        found = super().detect(rgb)
        kept = slice(1 if self.seen == 1 else 0)
        return Detections(boxes=found.boxes[kept], scores=found.scores[kept])


class Tired(Square):
    """Stops before its eighth picture."""

    def detect(self, rgb: Any, period: float | None = None) -> Detections:
        if self.seen == 7:
            raise KeyboardInterrupt
        return super().detect(rgb, period)


def search(film: Any, out: Any, kind: type[Square] = Square, *, every: int = 1, fps: float | None = 10.0) -> FilmBoxes:
    detector = f"{__name__}:{kind.__name__}"
    return find_boxes(open_film(film), out, Detection(detector=detector, every=every), fps=fps)


@pytest.fixture
def film(tmp_path: Any) -> Any:
    return square_film.write_folder(tmp_path / "pictures")


@pytest.fixture
def stopped(film: Any, tmp_path: Any) -> Any:
    """The detections of a search that was stopped; what a whole one writes is in ``whole.txt``."""
    with pytest.raises(KeyboardInterrupt):
        search(film, tmp_path / "boxes.txt", Tired)
    search(film, tmp_path / "whole.txt")
    return tmp_path / "boxes.txt.detections"


@pytest.mark.parametrize("kind", ["video", "folder"])
def test_people_become_boxes_and_what_does_not_last_is_dropped(film, tmp_path, kind):
    path = square_film.write_video(tmp_path / "film.mp4") if kind == "video" else film
    found = search(path, tmp_path / "boxes.txt", fps=None if kind == "video" else 10.0)
    assert (found.dt, found.first, found.step) == (pytest.approx(0.1), 0, 1)
    assert found.summary == "12 frames, 13 detections: the tracker keeps 12 boxes of 1 people"
    rows = read_mot(tmp_path / "boxes.txt", SHOWN)
    np.testing.assert_array_equal(rows.frame, np.arange(SHOWN))
    np.testing.assert_allclose(rows.boxes[:, 0], 10 + 5 * np.arange(SHOWN), atol=3.0)
    np.testing.assert_allclose(rows.boxes[:, 3], 30.0, atol=3.0)


def test_a_search_that_was_stopped_continues(film, stopped, tmp_path, monkeypatch):
    """Also where the last line was half written."""
    assert len(stopped.read_text().splitlines()) == 1 + 7
    assert not (tmp_path / "boxes.txt").exists()
    with stopped.open("a") as file:
        file.write("[[1.0, 2.0")
    seen = []

    def rested(self: Any, rgb: Any, period: float | None = None) -> Detections:
        seen.append(rgb)
        return Square.detect(self, rgb)

    monkeypatch.setattr(Square, "seen", 1)
    monkeypatch.setattr(Tired, "detect", rested)
    assert "13 detections: the tracker keeps 12 boxes" in search(film, tmp_path / "boxes.txt", Tired).summary
    assert len(seen) == SHOWN - 7
    assert (tmp_path / "boxes.txt").read_bytes() == (tmp_path / "whole.txt").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["boxes.txt", "pictures", "whole.txt"]


@pytest.mark.parametrize("damage", [b"\0\0\0\0\n", b"[5, [[1.0, 2.0]]]\n", b"[3, []]\n", b"{}\n"])
def test_lines_from_a_damaged_one_on_are_recomputed(film, stopped, tmp_path, damage):
    lines = stopped.read_bytes().splitlines(keepends=True)
    stopped.write_bytes(b"".join([*lines[:6], damage, *lines[7:]]))
    with kept_detections(stopped, key_of(open_film(film), f"{__name__}:Tired", None)) as (found, _):
        assert len(found) == 5
    search(film, tmp_path / "boxes.txt")
    assert (tmp_path / "boxes.txt").read_bytes() == (tmp_path / "whole.txt").read_bytes()


def test_detections_of_another_detector_are_recomputed(film, stopped, tmp_path):
    assert "13 detections" in search(film, tmp_path / "boxes.txt").summary


def test_a_users_own_file_is_not_overwritten_by_detections(film, tmp_path):
    (tmp_path / "boxes.txt.detections").write_text("mine\n")
    with pytest.raises(FileError, match="is in the way of detections that are kept there; move it"):
        search(film, tmp_path / "boxes.txt")
    assert (tmp_path / "boxes.txt.detections").read_text() == "mine\n"


def test_every_third_frame_is_written_but_all_are_tracked(film, tmp_path):
    found = search(film, tmp_path / "boxes.txt", every=3)
    assert read_mot(tmp_path / "boxes.txt", SHOWN).frame.tolist() == [0, 3, 6, 9]
    assert (found.step, found.summary[:25]) == (3, "12 frames, 13 detections:")


def test_without_a_frame_rate_or_people_it_is_one_clear_line(film, tmp_path):
    out = tmp_path / "boxes.txt"
    with pytest.raises(FileError, match="does not say how many frames a second it has; write fps in camera"):
        search(film, out, fps=None)
    with pytest.raises(FileError, match="hog finds nobody in 12 pictures; do they show people"):
        find_boxes(open_film(film), out, Detection(), fps=10.0)
    with pytest.raises(FileError, match="finds 1 boxes, and none of them lasts; a better detector"):
        search(film, out, Once)
    with pytest.raises(VbbenchError, match="every must be at least 1 frame, not 0"):
        search(film, out, every=0)
