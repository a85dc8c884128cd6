"""A default install: what it lacks is asked for in one line that names the extra.

That the rest works without any extra is shown by `tests/wheel_test.sh`.
"""

import subprocess
import sys
from pathlib import Path

import pytest

from vbbench.cli import main

WITHOUT = """import sys
class Missing:
    def find_spec(self, name, *_):
        if name == 'MISSING':
            raise ModuleNotFoundError("as if it were not installed", name=name)
sys.meta_path.insert(0, Missing())
from vbbench.__main__ import main
sys.exit(main())"""
"""A command as if a package were not installed."""


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
        ("cv2", "render", ["reproduce", "figure-keypoints", "--out", "OUT"]),
        ("distributed", "dask", ["generate", "demo", "--scheduler", "tcp://127.0.0.1:1", "--out", "OUT"]),
    ],
)
def test_what_is_missing_is_one_line_that_names_the_extra(
    dataset: Path, tmp_path: Path, missing: str, extra: str, command: list[str]
) -> None:
    places = {"DATA": str(dataset), "OUT": str(tmp_path / "out")}
    words = [places.get(word, word.replace("OUT", places["OUT"])) for word in command]
    process = [sys.executable, "-c", WITHOUT.replace("MISSING", missing), *words]
    done = subprocess.run(process, capture_output=True, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    line = done.stderr.splitlines()[-1]
    assert line.startswith("vbbench: ")
    assert missing in line
    assert line.endswith(f"pip install 'vbbench[{extra}]'")
