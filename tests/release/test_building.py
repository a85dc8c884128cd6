"""Building from source: what is missing is named in one sentence."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.skipif(sys.platform == "win32", reason="compilers of Windows are not looked for on the path")
def test_a_missing_compiler_is_named_with_how_to_get_one(tmp_path: Path) -> None:
    cmake, ninja = (
        shutil.which(tool, path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
        for tool in ("cmake", "ninja")
    )
    if cmake is None or ninja is None:
        pytest.skip("needs cmake and ninja")
    nowhere = tmp_path / "empty"
    nowhere.mkdir()
    kept = {name: value for name, value in os.environ.items() if name not in ("CXX", "CC", "PATH")}
    configure = [cmake, "-S", ROOT, "-B", tmp_path / "build", "-G", "Ninja", f"-DCMAKE_MAKE_PROGRAM={ninja}"]
    found = subprocess.run(configure, env=kept | {"PATH": str(nowhere)}, capture_output=True, text=True, check=False)
    said = " ".join(found.stderr.split())
    assert found.returncode
    assert "found no compiler; install g++ (Debian, Ubuntu: apt install g++;" in said
    assert said.count("CMake Error") == 1
