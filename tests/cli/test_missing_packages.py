"""A default install: what it lacks is asked for in one line that names the extra, and nothing else needs it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from vbbench.birdify.example import EXAMPLE
from vbbench.cli import main

OPTIONAL = (
    "cv2",
    "trimesh",
    "pyrender",
    "pandas",
    "distributed",
    "torch",
    "rerun",
    "rosbags",
)
WITHOUT = """import json, sys
class Missing:
    def find_spec(self, name, *_):
        if name in MISSING:
            raise ModuleNotFoundError("as if it were not installed", name=name)
sys.meta_path.insert(0, Missing())
from vbbench.__main__ import main
for words in json.loads(sys.argv[1]):
    sys.argv[1:] = words
    status = main()
    if status:
        sys.exit(status)"""


def run_without(missing: tuple[str, ...], *commands: list[object]) -> "subprocess.CompletedProcess[str]":
    """Run commands one after the other, until one fails, as if packages were not installed."""
    words = json.dumps([[str(word) for word in command] for command in commands])
    process = [sys.executable, "-c", WITHOUT.replace("MISSING", str(missing)), words]
    return subprocess.run(process, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("default") / "data"
    assert main(["generate", "demo", "--out", str(folder), "--limit", "2"]) == 0
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    ("missing", "extra", "command"),
    [
        ("cv2", "render", ["render", "DATA", "--sequence", "0", "--out", "OUT.mp4"]),
        ("trimesh", "render", ["export", "mot", "DATA", "--out", "OUT", "--backend", "raster"]),
        ("pyrender", "pyrender", ["export", "mot", "DATA", "--out", "OUT", "--backend", "pyrender"]),
        ("rerun", "viewer", ["view", "DATA", "--sequence", "0", "--out", "OUT.rrd"]),
        ("rerun", "viewer", ["live", "BOXES", "--camera", "CAMERA", "--out", "OUT.rrd"]),
        ("cv2", "render", ["reproduce", "figure-keypoints", "--out", "OUT"]),
        ("distributed", "dask", ["generate", "demo", "--scheduler", "tcp://127.0.0.1:1", "--out", "OUT"]),
    ],
)
def test_what_is_missing_is_one_line_that_names_the_extra(
    dataset: Path, tmp_path: Path, missing: str, extra: str, command: list[str]
) -> None:
    places = {"DATA": str(dataset), "OUT": str(tmp_path / "out")}
    places |= {"BOXES": str(EXAMPLE / "boxes.csv"), "CAMERA": str(EXAMPLE / "camera.toml")}
    done = run_without((missing,), [places.get(word, word.replace("OUT", places["OUT"])) for word in command])
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    line = done.stderr.splitlines()[-1]
    assert line.startswith("vbbench: ")
    assert missing in line
    assert line.endswith(f"pip install 'vbbench[{extra}]'")


@pytest.mark.slow
def test_the_rest_works_without_any_of_them(dataset: Path, tmp_path: Path) -> None:
    answer = tmp_path / "answer"
    commands: list[list[object]] = [
        ["solve", dataset, "--solver", "cv", "--protocol", "sequential", "--out", answer],
        ["score", answer, "--dataset", dataset, "--per-sequence", tmp_path / "rows.csv"],
        ["plot", dataset, "--sequence", "0", "--estimate", answer, "--out", tmp_path / "picture.png"],
        ["export", "mot", dataset, "--out", tmp_path / "mot"],
        ["solvers"],
    ]
    done = run_without(OPTIONAL, *commands)
    assert done.returncode == 0, done.stderr
