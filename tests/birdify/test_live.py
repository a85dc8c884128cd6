"""vbbench live: what each frame shows is the answer of a session, which is that of the map that birdify makes."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.birdify.test_bags import write_bag
from tests.lib.own_recording import CAMERA_TOML, Walk, make_walk, write_mot
from vbbench.birdify import live
from vbbench.birdify.birdify import birdify
from vbbench.cli import main
from vbbench.exchange.tum import import_tum

FRAMES = 12


class Stream:
    """What is used of ``rerun.RecordingStream``: notes what is logged, by frame and entity."""

    made: list["Stream"] = []  # noqa: RUF012

    def __init__(self, name: str) -> None:
        self.name, self.frame, self.seconds = name, -1, -1.0
        self.logged: list[tuple[int, float, str, Any]] = []
        self.sink = ""
        Stream.made.append(self)

    def set_time(self, timeline: str, *, sequence: int | None = None, duration: float | None = None) -> None:
        if sequence is not None:
            self.frame = sequence
        if duration is not None:
            self.seconds = duration

    def log(self, entity: str, shown: Any) -> None:
        self.logged.append((self.frame, self.seconds, entity, shown))

    def save(self, path: Path) -> None:
        self.sink = "file"
        path.write_text("recording")

    def spawn(self) -> None:
        self.sink = "viewer"

    def disconnect(self) -> None:
        """Nothing is kept open."""

    def of(self, entity: str) -> list[Any]:
        return [shown for *_, name, shown in self.logged if name == entity]


def noted(*places: Any, **fields: Any) -> Any:
    return SimpleNamespace(values=places[0] if places else None, **fields)


@pytest.fixture
def walk() -> Walk:
    return make_walk(frames=FRAMES)


@pytest.fixture
def files(tmp_path: Path, walk: Walk) -> list[str]:
    """The arguments that name a walk's boxes and camera."""
    (tmp_path / "camera.toml").write_text(CAMERA_TOML)
    return [str(write_mot(tmp_path / "gt.txt", walk)), "--camera", str(tmp_path / "camera.toml")]


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch) -> type[Stream]:
    """The package rerun, as far as it is used."""
    package = ModuleType("rerun")
    kinds = dict.fromkeys(("Boxes2D", "Points2D", "LineStrips2D", "Arrows2D"), noted)
    strict = SimpleNamespace(strict_mode=lambda: False, set_strict_mode=lambda on: None)
    vars(package).update(kinds, RecordingStream=Stream, is_enabled=lambda stream: True, error_utils=strict)
    vars(package)["Box2DFormat"] = SimpleNamespace(XYWH="xywh")
    monkeypatch.setitem(sys.modules, "rerun", package)
    monkeypatch.setattr(Stream, "made", [])
    return Stream


@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
def test_each_frame_shows_boxes_map_and_ellipses_as_birdify_has_them(
    tmp_path: Path, walk: Walk, files: list[str], stand_in: type[Stream], capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "walk.rrd"
    assert main(["live", *files, "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    assert out.read_text() == "recording"
    (stream,) = stand_in.made
    assert (stream.sink, stream.name) == ("file", "vbbench live gt")
    assert sorted({(frame, seconds) for frame, seconds, *_ in stream.logged}) == [
        (frame, pytest.approx(0.1 * frame)) for frame in range(FRAMES)
    ]
    birdify(files[0], files[2], tmp_path / "map")
    _, poses = import_tum(tmp_path / "map" / "poses.txt", 0.1)
    path = stream.of("map/path")[-1].values[0]
    np.testing.assert_allclose(path * [1.0, -1.0], poses[:, :2], atol=1e-5)
    for frame, (boxes, people, ellipses) in enumerate(
        zip(*(stream.of(name) for name in ("camera/boxes", "map/people", "map/95-percent")), strict=True)
    ):
        seen = np.flatnonzero(np.isfinite(walk.boxes[frame, :, 0]))
        assert boxes.labels == [str(k + 1) for k in seen]
        np.testing.assert_allclose(boxes.array[:, [1, 3]], walk.boxes[frame, seen][:, [1, 3]], atol=1e-3)
        assert people.labels == boxes.labels
        np.testing.assert_allclose(ellipses.values[:-1, :-1].mean(axis=1), people.values, atol=1e-9)


def test_without_a_file_it_opens_the_viewer_and_keeps_the_pace(
    files: list[str], stand_in: type[Stream], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    waited: list[float] = []
    monkeypatch.setattr(live, "can_open", lambda: live.Opened.SHOWN)
    monkeypatch.setattr(live, "monotonic", lambda: 100.0)
    monkeypatch.setattr(live, "sleep", waited.append)
    assert main(["live", *files, "--solver", "cv"]) == 0
    assert capsys.readouterr().out == f"{FRAMES} frames shown\n"
    assert waited == pytest.approx([0.1 * frame for frame in range(FRAMES)])
    assert [stream.sink for stream in stand_in.made] == ["viewer"]


def test_how_long_a_frame_lasts_may_be_said(
    tmp_path: Path, files: list[str], stand_in: type[Stream], capsys: pytest.CaptureFixture[str]
) -> None:
    camera = tmp_path / "camera.toml"
    assert main(["live", *files, "--dt", "0.2", "--out", str(tmp_path / "walk.rrd")]) == 2
    assert "keep one of them" in capsys.readouterr().err
    lines = CAMERA_TOML.splitlines(keepends=True)
    camera.write_text("".join(line for line in lines if not line.startswith(("fps", "dt"))))
    assert main(["live", *files, "--dt", "0.2", "--out", str(tmp_path / "walk.rrd")]) == 0
    assert max(seconds for _, seconds, *_ in stand_in.made[-1].logged) == pytest.approx(0.2 * (FRAMES - 1))


@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
def test_it_reads_a_recording_as_birdify_does(
    tmp_path: Path, files: list[str], stand_in: type[Stream], capsys: pytest.CaptureFixture[str]
) -> None:
    """What the camera file lacks, the class of people, and the axes of odometry."""
    camera, odometry, out = tmp_path / "camera.toml", tmp_path / "odometry.txt", str(tmp_path / "walk.rrd")
    lines = CAMERA_TOML.splitlines(keepends=True)
    camera.write_text("".join(line for line in lines if not line.startswith(("mount_height", "pitch", "carried_by"))))
    said = ["--mount-height", "1.5", "--pitch", "0.02", "--carried-by", "robot", "--person-class", "1"]
    assert main(["live", *files, "--out", out]) == 2
    assert "mount_height" in capsys.readouterr().err
    assert main(["live", *files, *said, "--odometry-axes", "ned", "--out", out]) == 2
    assert "--odometry-axes: there is no odometry" in capsys.readouterr().err
    odometry.write_text("".join(f"{0.1 * n} {0.1 * n} 0 0 0 0 0 1\n" for n in range(FRAMES)))
    said += ["--odometry", str(odometry)]
    paths = []
    for axes in ("body", "ned"):
        assert main(["live", *files, *said, "--odometry-axes", axes, "--out", out]) == 0
        paths.append(stand_in.made[-1].of("map/path")[-1].values[0])
    assert main(["birdify", files[0], *files[1:], *said, "--odometry-axes", "ned", "--out", str(tmp_path / "map")]) == 0
    _, poses = import_tum(tmp_path / "map" / "poses.txt", 0.1)
    np.testing.assert_allclose(paths[1] * [1.0, -1.0], poses[:, :2], atol=1e-5)


def test_mistakes_are_one_line(
    files: list[str], stand_in: type[Stream], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("CI", "1")
    for arguments, text in (
        (files, "there is no display here; write a recording with --out map.rrd"),
        ([*files, "--out", "map.mp4"], "ends in .rrd"),
        ([*files, "--solver", "map-batch", "--out", "map.rrd"], "works frame by frame"),
        (files[:1], "name the file of the camera with --camera"),
    ):
        assert main(["live", *arguments]) == 2
        assert text in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert main(["live", *files]) == 2
    message = "vbbench: vbbench live needs rerun: python -m pip install 'vbbench[viewer]'\n"
    assert capsys.readouterr().err == message


@pytest.mark.extra("rerun", "rosbags")
@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
def test_a_bag_becomes_a_whole_recording(tmp_path: Path, walk: Walk) -> None:
    from tests.pictures.test_viewer import read

    bag, out = write_bag(tmp_path, walk, 2), tmp_path / "live.rrd"
    assert main(["live", f"bag:{bag}", "--mount-height", "1.5", "--out", str(out)]) == 0
    entities = read(out)
    people = entities["map/people"]
    assert people["frame"] == list(range(FRAMES))
    seen = [np.flatnonzero(np.isfinite(row[:, 0])) for row in walk.boxes]
    assert people["Points2D:labels"] == [[str(k + 1) for k in row] for row in seen]
    assert entities["camera/boxes"]["Boxes2D:labels"] == people["Points2D:labels"]
    # With odometry the path is the walk, in the axes of its first pose.
    (path,) = entities["map/path"]["LineStrips2D:strips"][-1]
    np.testing.assert_allclose(np.array(path) * [1.0, -1.0], walk.poses[:, :2], atol=0.15)
    assert [len(strips) for strips in entities["map/95-percent"]["LineStrips2D:strips"]] == [1 + len(s) for s in seen]
