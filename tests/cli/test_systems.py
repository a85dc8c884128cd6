"""Commands work where Python has no POSIX modules, as on Windows, and say in one line what cannot work there."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from vbbench.folders import locks, replacing, work_folder
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench_leaderboards.commands import TEMPLATE

WITHOUT_POSIX = """
import os, signal, sys

MODULES = {"fcntl", "grp", "pty", "pwd", "resource", "syslog", "termios", "tty"}
ATTRIBUTES = {
    os: ("O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "fork", "forkpty", "getgid", "getsid", "getuid", "killpg", "pread",
         "pwrite", "set_blocking", "setsid"),
    signal: ("SIGHUP", "SIGKILL", "pthread_sigmask"),
}

class Refusing:
    def find_spec(self, name, path=None, target=None):
        if name in MODULES:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

for name in MODULES:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Refusing())
for module, names in ATTRIBUTES.items() if "VBBENCH_TEST_MODULES_ALONE" not in os.environ else ():
    for name in names:
        delattr(module, name)
"""

BOXES = "frame,id,left,top,width,height\n" + "".join(
    f"{t},{k},{300 + 90 * k + t},{170 - 2 * k},{30 + 3 * k},{80 + 8 * k}\n" for t in range(10) for k in range(4)
)
CAMERA = "width = 1242\nheight = 375\nfocal = 721.5\nmount_height = 1.65\nfps = 10\n"


@pytest.fixture
def without_posix(tmp_path: Path) -> dict[str, str]:
    """The environment of a Python without the modules and functions that Windows lacks."""
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "sitecustomize.py").write_text(WITHOUT_POSIX, encoding="utf-8")
    paths = [str(tmp_path / "site"), *filter(None, [os.environ.get("PYTHONPATH")])]
    quiet = "ignore:only soft file lock:UserWarning"  # filelock's, which has locks of Windows where that is
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "PYTHONWARNINGS": quiet}


def run_command(command: str, folder: Path, environment: dict[str, str]) -> None:
    line = [sys.executable, "-m", "vbbench", *command.split()]
    run = subprocess.run(line, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, f"{command}\n{run.stdout}\n{run.stderr}"
    assert "Traceback" not in run.stderr, command


@pytest.mark.slow
def test_the_main_commands_need_no_posix(without_posix: dict[str, str], tmp_path: Path) -> None:
    room = tmp_path / "room"
    room.mkdir()
    (room / "boxes.csv").write_text(BOXES, encoding="utf-8")
    (room / "camera.toml").write_text(CAMERA, encoding="utf-8")
    (room / "mysolver.py").write_text((TEMPLATE / "mysolver.py").read_text("utf-8"), encoding="utf-8")
    commands = [
        "--help",
        "generate demo --limit 4 --tier noisy --out data",
        "info data",
        "solve data --solver vb-cv --protocol sequential --out answer",
        "solve data --solver cv --protocol sequential --jobs 2 --out other",
        "score answer other --dataset data",
        "plot data --sequence 0 --estimate answer --out plot.png",
        "birdify boxes.csv --camera camera.toml --out map",
        "leaderboard add answer --dataset data --results results",
        "leaderboard build --results results --out page",
        "leaderboard try mysolver:MySolver --board sim/sequential-noisy",
    ]
    for command in commands:
        run_command(command, room, without_posix)
    run_command(  # Linux itself confines it, by what it has and Windows has not
        "solve data --solver mysolver:MySolver --protocol sequential --isolate --out isolated",
        room,
        without_posix | {"VBBENCH_TEST_MODULES_ALONE": "1"},
    )
    for made in ("data/dataset.json", "answer/submission.json", "plot.png", "map", "page/index.html"):
        assert (room / made).exists()
    assert not [path for path in room.rglob("*.vbbench-*") if path.name != ".vbbench-site"]


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="open files are listed by Linux alone")
def test_files_are_closed_before_they_are_renamed_where_the_system_asks_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (locks, work_folder):
        monkeypatch.setattr(module, "HOLDS_OPEN_FILES", True)
    rename, remove = Path.replace, Path.unlink

    def is_open(path: Path) -> bool:
        return any(
            Path(os.path.realpath(link)).is_relative_to(path.resolve()) for link in Path("/proc/self/fd").iterdir()
        )

    def checked_rename(path: Path, target: Path) -> Path:
        assert not is_open(path)
        return rename(path, target)

    def checked_removal(path: Path, missing_ok: bool = False) -> None:
        assert not is_open(path)
        remove(path, missing_ok=missing_ok)

    monkeypatch.setattr(Path, "replace", checked_rename)
    monkeypatch.setattr(Path, "unlink", checked_removal)
    replacing.write_text_atomically(tmp_path / "file", "text")
    with pytest.raises(RuntimeError), replacing.replacing(tmp_path / "file"):
        raise RuntimeError
    generate("demo", tmp_path / "data", Options(limit=2))
    generate("demo", tmp_path / "data", Options(limit=2), overwrite=True)
    assert (tmp_path / "file").read_text("utf-8") == "text"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["data", "file"]
