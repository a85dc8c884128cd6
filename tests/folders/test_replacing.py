"""Single files: whole or not there, devices and pipes written through, nobody else's file overwritten."""

import os
import stat
import subprocess
import sys
import threading
from functools import partial
from pathlib import Path

import pytest

from tests.lib.stopping import contents, names, stopped_at_every_step
from vbbench import __version__
from vbbench.cli import main
from vbbench.errors import FileError
from vbbench.folders import replacing as module
from vbbench.folders.locks import lock_file
from vbbench.folders.replacing import is_temporary, replacing, write_bytes_atomically, write_text_atomically
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.solving import solve


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("room")
    solve(generate("demo", folder / "data", Options(limit=2)), "cv", "rollout", folder / "answer")
    return folder


def score(room: Path, path: object) -> list[str]:
    return ["score", str(room / "answer"), "--dataset", str(room / "data"), "--per-sequence", str(path)]


def test_a_full_device_stays_a_device(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = names(Path("/dev"))
    assert main(score(room, "/dev/full")) == 2
    assert capsys.readouterr().err == "vbbench: /dev/full: No space left on device; choose another place\n"
    assert main(score(room, "/dev/null")) == 0
    assert all(stat.S_ISCHR(os.stat(device).st_mode) for device in ("/dev/full", "/dev/null"))  # noqa: PTH116
    assert names(Path("/dev")) == before


OWN = ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]
IN_TURN = """import sys
from vbbench.cli import main
*command, places = sys.argv[1:]
sys.exit(max(main([*command, place]) for place in places.split()))"""


@pytest.mark.slow
@pytest.mark.parametrize(("where", "places"), [("pipe", OWN), ("file", OWN), ("file", ["out.txt"])])
def test_ones_own_output_is_written_in_order(room: Path, tmp_path: Path, where: str, places: list[str]) -> None:
    command = [sys.executable, "-c", IN_TURN, *score(room, " ".join(places))]
    if where == "pipe":
        text = subprocess.run(command, cwd=tmp_path, check=True, stdout=subprocess.PIPE, text=True).stdout
    else:
        with (tmp_path / "out.txt").open("w") as file:
            subprocess.run(command, cwd=tmp_path, check=True, stdout=file)
        text = (tmp_path / "out.txt").read_text("utf-8")
    pieces = text.split("sequence,scene,first_frame,last_frame,frames,")
    assert [piece.count(f"cv {__version__} on demo") for piece in pieces] == [0, *(1 for _ in places)]
    assert pieces[0] == ""
    assert names(tmp_path) == ([] if where == "pipe" else ["out.txt"])


def test_a_pipe_with_a_name_is_written_through(room: Path, tmp_path: Path) -> None:
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_text("utf-8")))
    reader.start()
    assert main(score(room, pipe)) == 0
    reader.join()
    assert read[0].startswith("sequence,scene,first_frame,last_frame,frames,")
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_a_folder_is_no_file(room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(score(room, tmp_path)) == 2
    assert capsys.readouterr().err == f"vbbench: {tmp_path}: is a folder; give the name of a file\n"


@pytest.mark.parametrize(
    "path", ["x" * 300 + ".csv", "x" * 251 + ".csv", "/proc/x.csv", "/dev/null/x.csv", "a/../b/\udcff"]
)
def test_a_name_that_no_file_can_have_is_one_line(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], path: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status = main(score(room, path))
    said = capsys.readouterr().err
    longest = os.pathconf(tmp_path, "PC_NAME_MAX")
    if len(path) <= longest and path[0] != "/" and path.isascii():
        assert status == 0, said
    else:
        assert (status, said.count("\n")) == (2, 1), said
        assert names(tmp_path) == []


def test_the_link_stays_and_its_file_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    (tmp_path / "link.json").symlink_to(tmp_path / "far" / "file.json")
    for text in ("one", "two"):
        write_text_atomically(tmp_path / "link.json", text)
        assert (tmp_path / "far" / "file.json").read_text() == text
    assert (tmp_path / "link.json").is_symlink()
    assert (names(tmp_path), names(tmp_path / "far")) == (["far", "link.json"], ["file.json"])


def test_files_beside_it_are_somebody_elses(tmp_path: Path) -> None:
    mine = {f"x.json{ending}": b"years of work" for ending in (".partial", ".old", ".tmp", "~", ".vbbench-1234abcd")}
    for name, data in mine.items():
        (tmp_path / name).write_bytes(data)
    write_text_atomically(tmp_path / "x.json", "new")
    assert contents(tmp_path) == {**mine, "x.json": b"new"}


def test_a_file_is_whole_at_every_step_and_the_next_run_cleans_up(tmp_path: Path) -> None:
    path = tmp_path / "at" / "x.json"
    command = partial(write_bytes_atomically, path, b"new")

    def prepare() -> None:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"old")

    left = 0
    for _ in stopped_at_every_step(command, prepare):
        assert path.read_bytes() in (b"old", b"new")
        left += len(names(path.parent)) - 1
        module._remove_stale.cache_clear()
        command()
        assert contents(path.parent) == {"x.json": b"new"}
    assert left > 0


def test_what_another_process_is_writing_stays(tmp_path: Path) -> None:
    with replacing(tmp_path / "one.txt") as temporary:
        assert is_temporary(temporary)
        module._remove_stale.cache_clear()
        write_text_atomically(tmp_path / "two.txt", "two")
        temporary.write_text("one")
    assert contents(tmp_path) == {"one.txt": b"one", "two.txt": b"two"}


def test_an_error_leaves_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("old")
    with pytest.raises(FileNotFoundError), replacing(tmp_path / "x"):
        (tmp_path / "another").read_text()
    assert contents(tmp_path) == {"x": b"old"}


def test_a_disk_that_fills_up_is_said_with_the_files_name(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"x: No space left on device"), replacing(tmp_path / "x"):
        raise OSError(28, "No space left on device")


def test_a_name_that_a_process_which_cleans_up_has_locked_is_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cleaning: list[tuple[Path, int]] = []

    def lock_late(handle: int) -> bool:
        if not cleaning:
            path = next(path for path in tmp_path.iterdir() if is_temporary(path))
            cleaning.append((path, os.open(path, os.O_RDWR)))
            assert lock_file(cleaning[0][1])
        return lock_file(handle)

    monkeypatch.setattr(module, "lock_file", lock_late)
    with replacing(tmp_path / "one.txt") as temporary:
        cleaning[0][0].unlink()
        os.close(cleaning[0][1])
        assert temporary.exists()
        temporary.write_text("one")
    assert contents(tmp_path) == {"one.txt": b"one"}
