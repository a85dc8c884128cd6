"""``vbbench birdify``: boxes in, map out; what it writes, how sure it says that it is, and what it refuses."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from tests.lib.own_recording import CAMERA_TOML, Walk, make_walk, write_csv, write_folder, write_tum
from vbbench.birdify.birdify import birdify
from vbbench.birdify.cues import HeightPrior, compare_cues
from vbbench.boxes import rectangles
from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.own.camera_file import read_camera
from vbbench.exchange.tum import import_tum
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray, relative_to_world, world_to_relative
from vbbench.solver import Frame, FrameEstimate, Problem


def crossing(frames: int = 40, people: int = 12, **camera: float) -> Walk:
    """People cross before a camera that stands still: their common motion is none."""
    walk = make_walk(frames, people, **camera)
    rng, time = np.random.default_rng(5), 0.1 * np.arange(frames)
    speed = np.where(np.arange(people) % 2, 0.8, -0.8)
    start = np.stack([rng.uniform(6.0, 14.0, people), rng.uniform(-2.0, 2.0, people) - speed], axis=-1)
    places = start + time[:, None, None] * np.stack([np.zeros(people), speed], axis=-1)
    poses = np.zeros((frames, 3))
    boxes = walk.camera.project(world_to_relative(places, poses), np.broadcast_to(walk.heights, (frames, people)))
    flat = rectangles(boxes)
    return replace(walk, poses=poses, people=places, boxes=flat + rng.normal(0.0, 1.0, flat.shape) * [1, 1, 0, 1])


class Odometer:
    """Believes odometry, if there is any, and that people are of mean height."""

    def start(self, problem: Problem) -> None:
        self.problem, self.pose = problem, np.zeros(3)

    def step(self, frame: Frame) -> FrameEstimate:
        if frame.given.odometry is not None and frame.index:
            forward, left, turn = frame.given.odometry.motions[-1]
            place = relative_to_world(np.array([[-left, forward]]), self.pose)[0]
            self.pose = np.array([*place, self.pose[2] + turn])
        relative = self.problem.camera.unproject(frame.observations, np.full(len(frame.observations), 1.72))
        return FrameEstimate(pose=self.pose, positions=relative_to_world(relative, self.pose))


FAST = f"{__name__}:Odometer"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("birdify") / "walk", crossing())


@pytest.fixture(scope="module")
def made(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("birdify") / "map"
    return birdify(folder / "boxes.csv", folder / "camera.toml", out, film=True).folder


def table(path: Path) -> dict[str, FloatArray]:
    rows = list(csv.reader(path.read_text().splitlines()))
    return dict(zip(rows[0], np.array(rows[1:], float).T, strict=True))


@pytest.mark.slow
def test_the_map_is_where_everybody_was(made):
    walk, poses, people = crossing(), table(made / "poses.csv"), table(made / "positions.csv")
    assert poses["frame"].tolist() == list(range(40))
    assert np.hypot(poses["x"], poses["y"]).max() < 1.0
    frame, column = people["frame"].astype(int), people["id"].astype(int) - 1
    assert len(frame) == len(walk.rows)
    off = np.hypot(*(np.stack([people["x"], people["y"]], axis=-1) - walk.people[frame, column]).T)
    assert np.median(off) < 1.0
    assert np.isfinite(people["std"][frame > 1]).all()


@pytest.mark.slow
def test_every_form_of_the_answer_has_figures_of(made):
    for name in ("poses", "positions"):
        parquet, text = pq.read_table(made / f"{name}.parquet"), table(made / f"{name}.csv")
        assert parquet.column_names == list(text)
        for column in parquet.column_names:
            np.testing.assert_allclose(np.array(parquet[column].to_pylist(), float), text[column], rtol=1e-12)
    frames, poses = import_tum(made / "poses.txt", 0.1)
    expected = table(made / "poses.csv")
    np.testing.assert_array_equal(frames, expected["frame"])
    np.testing.assert_allclose(poses, np.stack([expected["x"], expected["y"], expected["yaw"]], axis=-1), atol=1e-9)


def test_pictures_are_made_and_what_was_read_is_kept(made, folder, tmp_path):
    assert (made / "map.png").read_bytes()[:4] == b"\x89PNG"
    assert (made / "film.mp4").stat().st_size > 10_000
    assert (made / "recording" / "boxes.csv").read_bytes() == (folder / "boxes.csv").read_bytes()
    assert "as written" in verify(made / "dataset")
    again = generate("own", tmp_path / "d", Options(source=made / "recording"))
    one, other = Dataset(made / "dataset").sequence(0), again.sequence(0)
    np.testing.assert_array_equal(one.observations, other.observations)
    assert main(["plot", str(made / "dataset"), "--sequence", "0", "--estimate", str(made / "submission"),
                 "--out", str(tmp_path / "x.png")]) == 0  # fmt: skip


def test_the_report_says_how_sure_it_is(made):
    report, text = json.loads((made / "report.json").read_text()), (made / "report.md").read_text()
    assert (report["frames"], report["tracks"], report["solver"]) == (40, 12, "map-causal")
    verdict = report["verdict"]
    assert text.startswith(f"# boxes\n\n{' '.join(verdict['sentences'])}\n\n")
    assert verdict["seconds"] == pytest.approx(4.0)
    assert verdict["end"] == pytest.approx(1.96 * 2**0.5 * report["place_std"]["last"], rel=0.35)
    assert verdict["fast"] == []
    assert report["cues"]["mount_height"] == pytest.approx(1.5, abs=0.15)
    assert abs(report["cues"]["tilt"]) < 0.02
    assert report["heights_median"] == pytest.approx(1.72, abs=0.08)
    assert report["place_std"]["last"] > 0.0
    assert report["converged"] > 0.9
    assert report["people_speed"]["median"] == pytest.approx(0.8, abs=0.3)
    assert report["misfits"] < 0.02
    assert not report["warnings"]
    for words in ("σ of people's positions", "relative to the camera hold", "above the ground; its file says 1.5 m"):
        assert words in text


LEVEL = {"pitch": 0.0, "mount_height": 1.5}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("camera", "said", "problem"),
    [
        ({"mount_height": 2.2}, {}, "2.* m above the ground, the camera file 1.5 m: mount_height is wrong"),
        ({"roll": 0.1}, {}, "the camera's right side hangs 0.* rad lower than its file says: try roll = 0.1"),
        ({"pitch": -0.06}, {}, "feet and heights agree best if the camera looks 0.0[56].* rad lower"),
        (LEVEL, {"pitch": 1.0}, r"try pitch = -?0\.0[0-9]+, or check cy"),
        (LEVEL, {"mount_height": 2.1}, "mount_height is wrong, people are 2.[34][0-9] m tall"),
    ],
)
def test_a_wrong_camera_file_is_found_out(tmp_path, camera, said, problem):
    size = (60, 20) if said else (40, 12)
    lines = "\n".join(f"{name} = {value}" for name, value in ({"mount_height": 1.5} | said).items())
    text = CAMERA_TOML.replace("mount_height = 1.5", lines)
    folder = write_folder(tmp_path / "walk", crossing(*size, **camera), camera=text)
    with pytest.warns(VbbenchWarning, match=problem):
        made = birdify(folder / "boxes.csv", folder / "camera.toml", tmp_path / "map", solver=FAST)
    assert "## Warnings" in (made.folder / "report.md").read_text()


@pytest.mark.parametrize("steps", [1.5, 2.0])
def test_a_camera_that_bobs_is_neither_higher_nor_tilted(steps):
    """By feet exactly one second later a camera that nods twice a second was 15 % too high, and looked .02 rad down."""
    rng, level = np.random.default_rng(1), PerspectiveCamera(mount_height=1.5, focal=700.0)
    start = np.stack([rng.uniform(-3, 3, 150), rng.uniform(5, 20, 150)], axis=-1)
    relative = start + np.cumsum(rng.normal(0.0, 0.02, (60, 150, 2)), axis=0)
    heights, boxes = rng.normal(1.72, 0.08, 150), []
    for t, places in enumerate(relative):
        camera = replace(level, pitch=0.026 * np.sin(2.0 * np.pi * steps * 0.1 * t))
        boxes.append(camera.project(places, heights))
    cues = compare_cues(np.stack(boxes), level, PEOPLE, 0.1)
    assert cues.mount_height == pytest.approx(1.5, abs=0.08)
    assert abs(cues.tilt) < 0.008


PEOPLE, STEP = HeightPrior(1.72, 0.09), 0.4


def walkers(rng):
    """Places [30, 40, 2] of people who walk before a camera, and their heights [30, 40]."""
    start = np.stack([rng.uniform(-3, 3, 40), rng.uniform(9, 20, 40)], axis=-1)
    steps = np.stack([rng.normal(0.0, 0.05, (30, 40)), rng.normal(-0.1, 0.1, (30, 40))], axis=-1)
    return start + np.cumsum(steps, axis=0), np.broadcast_to(rng.normal(1.72, 0.08, 40), (30, 40))


def test_feet_and_heights_are_held_against_each_other():
    camera = PerspectiveCamera(mount_height=1.6, pitch=0.05)
    boxes = camera.project(*walkers(np.random.default_rng(0)))
    cues = compare_cues(boxes, camera, PEOPLE, STEP)
    assert cues.mount_height == pytest.approx(1.6, abs=3 * cues.mount_height_std)
    assert abs(cues.tilt) < 3 * cues.tilt_std + 1e-3
    level = compare_cues(boxes, PerspectiveCamera(mount_height=1.6), PEOPLE, STEP)
    assert level.tilt == pytest.approx(0.05, abs=0.01)
    assert compare_cues(boxes[:1, :2], camera, PEOPLE, STEP) is None


def test_noise_does_not_bend_the_line():
    """People 8 to 14 m away, in boxes with errors of 4 %: by least squares the camera would come out 8 % too low."""
    camera, rng = PerspectiveCamera(mount_height=1.6, focal=900.0), np.random.default_rng(0)
    start = np.stack([rng.uniform(-3, 3, 250), rng.uniform(8, 14, 250)], axis=-1)
    relative = start + np.cumsum(rng.normal(0.0, 0.02, (40, 250, 2)), axis=0)
    boxes = camera.project(relative, np.broadcast_to(rng.normal(1.72, 0.08, 250), (40, 250)))
    boxes += rng.normal(0.0, 0.03, boxes.shape) * boxes[..., 2:] * (1.0, 0.5**0.5, 2.0**0.5)
    cues = compare_cues(boxes, camera, PEOPLE, 0.1)
    assert cues.mount_height_std < 0.04
    assert cues.mount_height == pytest.approx(1.6, abs=3 * cues.mount_height_std)
    assert abs(cues.tilt) < 3 * cues.tilt_std


def test_cues_of_a_panorama_and_of_a_camera_that_looks_straight_down():
    rng = np.random.default_rng(0)
    ahead, heights = walkers(rng)
    around = PanoramaCamera(mount_height=1.6)
    relative = ahead * rng.choice((-1.0, 1.0), (40, 2))
    cues = compare_cues(around.project(relative, heights), replace(around, cy=around.cy + 5.0), PEOPLE, STEP)
    assert cues.mount_height == pytest.approx(1.6, abs=3 * cues.mount_height_std)
    assert (cues.tilt, cues.horizon) == (0.0, pytest.approx(-5.0 / around.focal, abs=3 * cues.horizon_std))
    tilted = compare_cues(replace(around, pitch=0.06).project(relative, heights), around, PEOPLE, STEP)
    assert (tilted.tilt, tilted.mount_height) == (pytest.approx(0.06, abs=0.02), pytest.approx(1.6, abs=0.2))
    assert abs(tilted.horizon) < 3 * tilted.horizon_std
    camera = PerspectiveCamera(mount_height=1.6)
    boxes = camera.project(ahead, heights)
    for wrong in (-1.45, -1.2, 0.9, 1.2, 1.45):
        cues = compare_cues(boxes, replace(camera, pitch=wrong), PEOPLE, STEP)
        assert cues is None or cues.mount_height > 0.0


def test_a_roll_is_no_pitch():
    camera, (ahead, heights) = PerspectiveCamera(mount_height=1.6), walkers(np.random.default_rng(3))
    ahead = ahead * [2.0, 1.0]
    cues = compare_cues(replace(camera, roll=0.08).project(ahead, heights), camera, PEOPLE, STEP)
    assert (cues.roll, cues.tilt) == (pytest.approx(0.08, abs=0.02), pytest.approx(0.0, abs=0.02))
    assert cues.mount_height == pytest.approx(1.6, abs=0.15)
    level = compare_cues(camera.project(ahead, heights), camera, PEOPLE, STEP)
    assert level.roll == 0.0


def test_few_people_whose_heights_happen_to_lean_one_way_are_no_tilt():
    """Eight of them put a camera up to .03 rad off, which was given as ± .005."""
    camera, off = PerspectiveCamera(mount_height=1.5, focal=420.0), []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        start = np.stack([rng.uniform(-3, 3, 8), rng.uniform(3, 9, 8)], axis=-1)
        relative = start + 0.1 * np.arange(40)[:, None, None] * rng.normal(0.0, 0.3, (8, 2))
        heights = np.broadcast_to(rng.normal(1.72, 0.09, 8), (40, 8))
        cues = compare_cues(camera.project(relative, heights), camera, PEOPLE, 0.1)
        if cues is not None:
            off.append([cues.tilt / cues.tilt_std, (cues.mount_height - 1.5) / cues.mount_height_std])
    assert len(off) > 25
    assert (np.abs(off) > 2.0).mean() < 0.1


def test_people_who_all_move_as_fast_as_the_odometry_says_point_at_it(tmp_path):
    walk = make_walk(60)
    folder = write_folder(tmp_path / "walk", walk)
    wrong = write_tum(folder / "odo.txt", replace(walk, poses=walk.poses * [6.0, 6.0, 1.0]))
    with pytest.warns(VbbenchWarning, match=r"people walk at .* m/s \(median\), all much the same: check the odometry"):
        birdify(folder / "boxes.csv", folder, tmp_path / "map", odometry=wrong, solver=FAST)


def test_odometry_reaches_any_solver_and_time_stamps_stay(tmp_path):
    walk = make_walk(30)
    folder = write_folder(tmp_path / "walk", walk)
    boxes = write_csv(folder / "boxes.csv", walk, begin=1.6e9)
    odometry = write_tum(folder / "odo.txt", walk, begin=1.6e9, every=0.5)
    made = birdify(boxes, folder / "camera.toml", tmp_path / "map", odometry=odometry, solver=FAST)
    poses = table(made.folder / "poses.csv")
    np.testing.assert_allclose(poses["x"], walk.poses[:, 0], atol=1e-3)
    np.testing.assert_allclose(poses["time"], 1.6e9 + 0.1 * np.arange(30), atol=1e-3)
    assert (made.folder / "poses.txt").read_text().splitlines()[1].startswith("1600000000.0 ")
    assert (made.report.odometry, made.report.place_std, made.report.converged) == (1.0, None, None)
    assert (made.folder / "recording" / "odometry.txt").is_file()


def test_what_is_kept_says_how_long_a_frame_lasts(tmp_path, capsys):
    walk = crossing()
    folder = write_folder(tmp_path / "walk", walk)
    camera = folder / "camera.toml"
    camera.write_text("".join(line for line in camera.read_text().splitlines(True) if not line.startswith("fps")))
    asked = ["birdify", str(folder / "boxes.csv"), "--camera", str(camera), "--solver", FAST]
    assert main([*asked, "--out", str(tmp_path / "none")]) == 2
    assert "write dt or fps in camera.toml" in capsys.readouterr().err
    assert main([*asked, "--out", str(tmp_path / "map"), "--dt", "0"]) == 2
    assert main([*asked, "--out", str(tmp_path / "map"), "--dt", "0.1"]) == 0
    kept = tmp_path / "map" / "recording"
    asked[1:4:2] = [str(kept / "boxes.csv"), str(kept / "camera.toml")]
    assert main([*asked, "--out", str(tmp_path / "other"), "--dt", "0.4"]) == 2
    assert "--dt says that a frame lasts 0.4 s, and" in capsys.readouterr().err
    again = birdify(kept / "boxes.csv", kept / "camera.toml", tmp_path / "again", solver=FAST)
    birdify(kept / "boxes.csv", camera, tmp_path / "numpy", solver=FAST, dt=np.float64(0.1))
    assert read_camera(tmp_path / "numpy" / "recording" / "camera.toml").facts.seconds == 0.1
    assert (again.folder / "poses.csv").read_bytes() == (tmp_path / "map" / "poses.csv").read_bytes()


@pytest.mark.slow
def test_a_folder_is_whole_or_not_there(folder, tmp_path):
    arguments = folder / "boxes.csv", folder / "camera.toml"
    with pytest.raises(VbbenchError, match="no solver is called 'map-casual'; did you mean 'map-causal'"):
        birdify(*arguments, tmp_path / "map", solver="map-casual")
    with pytest.raises(FileError, match="there is no such file"):
        birdify(folder / "none.csv", folder / "camera.toml", tmp_path / "map")
    with pytest.raises(FileError, match="there is no such file"):
        birdify(*arguments, tmp_path / "map", odometry=folder / "none.txt")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "mine").mkdir()
    with pytest.raises(VbbenchError, match="exists and is not a folder that birdify made"):
        birdify(*arguments, tmp_path / "mine", solver="cv", overwrite=True)
    birdify(*arguments, tmp_path / "map", solver=FAST)
    with pytest.raises(VbbenchError, match=r"set .overwrite. to replace it"):
        birdify(*arguments, tmp_path / "map", solver=FAST)
    with pytest.warns(VbbenchWarning, match=r"\d+% of the boxes are not where their person is on the map"):
        birdify(*arguments, tmp_path / "map", solver="cv", overwrite=True)
    assert json.loads((tmp_path / "map" / "report.json").read_text())["solver"] == "cv"


def test_the_command_says_where_and_how_sure(folder, tmp_path, capsys):
    given = ["birdify", str(folder / "boxes.csv"), "--camera", str(folder / "camera.toml"), "--solver", FAST]
    assert main([*given, "--out", str(tmp_path / "map")]) == 0
    shown = capsys.readouterr()
    assert f"{tmp_path / 'map'}: The solver reports no uncertainty" in shown.out
    assert "m travelled in 4 s" in shown.out
    assert not (tmp_path / "map" / "film.mp4").exists()
    assert "without odometry the map may drift with the crowd by more than that" in shown.out
    assert "40 frames of 0.1 s, 12 tracks" in shown.err
    assert main([*given, "--out", str(tmp_path / "map")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    broken = tmp_path / "camera.toml"
    broken.write_text(CAMERA_TOML.replace("1.5", "0"))
    given[3] = str(broken)
    assert main([*given, "--out", str(tmp_path / "x")]) == 2
    assert "mount_height, the camera's height over the ground, must be 0.05 to 100 m, not 0" in capsys.readouterr().err
