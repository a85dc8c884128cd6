"""README is short, its leaderboard is the committed one, and its commands do what it shows, from an empty folder."""

import re
import runpy
import shlex
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.lib.commands import understood
from tests.lib.onnx_network import write_network
from vbbench.birdify.example import EXAMPLE
from vbbench.cli import all_commands, main
from vbbench_leaderboards.results.folder import published_results, read_results

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text("utf-8")
RUN = [line for line in re.findall(r"(?m)^    \$ vbbench (.*)$", README) if not line.startswith("leaderboard")]
"""Those of a solver are run together, below."""


def test_commands_in_its_sentences_are_ones_of_today() -> None:
    named = re.findall(r"`vbbench ([^`]+)`", README)
    assert named
    for line in named:
        if " " in line:
            understood(line)
        else:
            assert any(f"{name} ".startswith(f"{line} ") for name in all_commands()), line


@pytest.fixture
def own_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, then with the files of a user that README names."""
    monkeypatch.chdir(tmp_path)
    shutil.copyfile(EXAMPLE / "boxes.csv", "boxes.csv")
    shutil.copyfile(EXAMPLE / "camera.toml", "camera.toml")
    shutil.copyfile(EXAMPLE / "odometry.txt", "odom.txt")
    Path("camera_info.yaml").write_text(
        "image_width: 1280\nimage_height: 720\ndistortion_model: plumb_bob\n"
        "distortion_coefficients: {rows: 1, cols: 5, data: [-0.12, 0, 0, 0, 0]}\n"
        "camera_matrix: {rows: 3, cols: 3, data: [650, 0, 640, 0, 650, 360, 0, 0, 1]}\n"
    )
    return tmp_path


def write_film(folder: Path) -> None:
    """Two seconds of grey, and a network that sees two people in it."""
    from vbbench.pictures.video import write_mp4

    grey = np.full((720, 1280, 3), 128, np.uint8)
    write_mp4(folder / "film.mp4", lambda frames: (grey for _ in frames), 20, 10.0)
    found = np.zeros((1, 7, 120))  # of YOLOv8: a column of centre, size and scores for each box, in a picture of 64 px
    found[0, :5, :2] = np.array([(20.0, 32.0, 3.0, 9.0, 0.9), (44.0, 32.0, 2.0, 6.0, 0.8)]).T
    write_network(folder / "yolo.onnx", found, names={0: "person", 1: "dog", 2: "car"})


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
@pytest.mark.parametrize("line", [line for line in RUN if "film" not in line])
def test_its_commands_run(own_files: Path, line: str) -> None:
    assert main(shlex.split(line)) == 0
    made = own_files / line.split("--out ")[1]
    assert (made / "index.html").is_file() or (made / "map.png").is_file()


@pytest.mark.slow
@pytest.mark.extra("cv2", "onnxruntime")
@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
def test_its_film_becomes_a_map(own_files: Path) -> None:
    (line,) = (line for line in RUN if "film" in line)
    write_film(own_files)
    assert main(shlex.split(line)) == 0
    assert (own_files / "map" / "map.png").is_file()


@pytest.mark.slow
def test_the_leaderboard_is_the_committed_one() -> None:
    board = runpy.run_path(str(ROOT / "docs" / "write_board.py"))
    assert board["table"](read_results(published_results())) in README


@pytest.mark.slow
def test_its_commands_take_a_solver_onto_a_board(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From an empty folder; without the page, which has tests of its own."""
    begin = re.search(r"(?m)^    \$ vbbench (leaderboard template mine) && cd mine$", README)
    trial = re.search(r"(?m)^    \$ vbbench (leaderboard try mysolver:MySolver .*) --out site\n    (.*)$", README)
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(begin[1])) == 0
    monkeypatch.chdir(tmp_path / "mine")
    monkeypatch.syspath_prepend(str(tmp_path / "mine"))
    sys.modules.pop("mysolver", None)  # another test's
    capsys.readouterr()
    try:
        assert main(shlex.split(trial[1])) == 0
    finally:
        sys.modules.pop("mysolver", None)
    assert capsys.readouterr().out.strip() == trial[2]
