"""Other commands after a kill, strangers' folders, links, full disks: nothing is destroyed, and what is asked is made.

That the same command goes on after a kill at any step of it is shown in `tests.cli.test_kills`.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from tests.lib.make_dataset import Crowd
from tests.lib.make_dataset import write_dataset as write_made
from tests.lib.stopping import contents, names, stopped_at_every_step
from tests.parallel.test_parts import last_part_first
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.folders.work_folder import DONE, JOURNAL, WorkFolder
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.parallel import cluster
from vbbench.parallel.parts import Part
from vbbench.pictures.video import write_mp4
from vbbench.solving import solve

Mistake = Callable[..., str]
OPTIONS = Options(limit=2)
OTHER = Options(limit=2, seed=1)


@pytest.fixture(autouse=True)
def _no_cluster(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "on_cluster", last_part_first)
    monkeypatch.setattr("vbbench.parallel.parts.PATIENCE", -1.0)
    monkeypatch.setattr(os, "fsync", lambda _: None)  # nothing here cuts the power


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two datasets whole, and both with their truth withheld."""
    folder = tmp_path_factory.mktemp("room")
    for name, options in (("old", OTHER), ("new", OPTIONS)):
        generate("demo", folder / name, options)
        generate("demo", folder / f"{name}-apart", options, withhold_truth=True)
    return folder


def emptied(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    return folder


def put(room: Path, place: Path, **copies: str) -> None:
    """Copy folders of the room into the emptied ``place``."""
    emptied(place)
    for name, source in copies.items():
        shutil.copytree(room / source, place / name.replace("_", "."))


@pytest.mark.slow
def test_truth_alone_is_put_right_when_it_is_opened(room: Path, tmp_path: Path) -> None:
    """The dataset lies elsewhere, too: whoever opens the truth finishes the swap."""
    out, truth = tmp_path / "at" / "out", tmp_path / "at" / "out.truth"
    command = partial(generate, "demo", out, OPTIONS, withhold_truth=True, overwrite=True)
    decided = 0
    prepare = partial(put, room, out.parent, out="old-apart", out_truth="old-apart.truth")
    for _ in stopped_at_every_step(command, prepare):
        if (out.parent / "out.partial" / JOURNAL).exists():
            decided += 1
            assert Dataset(room / "new-apart", truth).has_truth
            assert (out.parent / "out.partial" / DONE).exists()
    assert decided > 3


@pytest.mark.slow
def test_another_command_after_a_kill_keeps_to_the_rules(room: Path, tmp_path: Path) -> None:
    """What was decided stands; what comes next is asked as ever, and cleans up."""
    out = tmp_path / "at" / "out"
    command = partial(generate, "demo", out, OPTIONS)
    for _ in stopped_at_every_step(command, lambda: put(room, out.parent)):
        stands = out.exists() or (out.parent / "out.partial" / JOURNAL).exists()
        if stands:
            with pytest.raises(VbbenchError, match=r"exists; set .overwrite"):
                generate("demo", out, OTHER)
        else:
            generate("demo", out, OTHER)
        assert names(out.parent) == ["out"]
        assert contents(out) == contents(room / ("new" if stands else "old"))


@pytest.mark.slow
def test_nothing_stands_in_the_place_of_what_is_being_swapped(room: Path, tmp_path: Path) -> None:
    out = tmp_path / "at" / "out"
    command = partial(generate, "demo", out, OPTIONS, overwrite=True)
    for _ in stopped_at_every_step(command, lambda: put(room, out.parent, out="old")):
        if not out.exists():
            break
    out.mkdir()
    (out / "thesis.tex").write_text("years of work")
    with pytest.raises(VbbenchError, match="appeared while it was being replaced; move it away"):
        command()
    assert (out / "thesis.tex").read_text() == "years of work"
    assert contents(out.parent / "out.partial" / "old") == contents(room / "old")
    shutil.rmtree(out)
    command()
    assert contents(out) == contents(room / "new")


@pytest.mark.parametrize("before", ["nothing", "another"])
def test_a_folder_that_cannot_be_renamed_changes_nothing(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, before: str
) -> None:
    out, truth = tmp_path / "at" / "out", tmp_path / "at" / "out.truth"
    put(room, out.parent, **({"out": "old-apart", "out_truth": "old-apart.truth"} if before == "another" else {}))
    rename, there = Path.replace, contents(out.parent)

    def refused(path: Path, target: Path) -> Path:
        if target == out and path.name == "new":
            raise OSError(18, "Invalid cross-device link")
        return rename(path, target)

    monkeypatch.setattr(Path, "replace", refused)
    with pytest.raises(FileError, match=r"out: cannot be replaced \(Invalid cross-device link\)"):
        generate("demo", out, OPTIONS, withhold_truth=True, overwrite=True)
    monkeypatch.undo()
    assert {name: data for name, data in contents(out.parent).items() if "out.partial" not in name} == there
    generate("demo", out, OPTIONS, withhold_truth=True, overwrite=True)
    assert names(out.parent) == ["out", "out.truth"]
    assert "truth is the published one" in verify(out, truth)


def strangers(folder: Path) -> Iterator[Path]:
    for name in ("out.partial", "out.old"):
        path = folder / name / "thesis.tex"
        path.parent.mkdir(exist_ok=True)
        path.write_text("years of work")
        yield path


def commands(room: Path, out: Path) -> list[tuple[str, Callable[[], object]]]:
    dataset, scheduler = Dataset(room / "new"), {"scheduler": "tcp://nowhere", "overwrite": True}
    return [
        ("new", partial(generate, "demo", out, OPTIONS, overwrite=True)),
        ("new", partial(generate, "demo", out, OPTIONS, **scheduler)),  # type: ignore[arg-type]
        ("answer", partial(solve, dataset, "cv", "rollout", out, overwrite=True)),
        ("answer", partial(solve, dataset, "cv", "rollout", out, **scheduler)),  # type: ignore[arg-type]
    ]


@pytest.mark.parametrize("number", range(4))
def test_folders_of_somebody_else_are_never_touched(room: Path, tmp_path: Path, number: int) -> None:
    out = tmp_path / "at" / "out"
    solve(Dataset(room / "new"), "cv", "rollout", tmp_path / "answer")
    there, command = commands(room, out)[number]
    put(room if (room / there).exists() else tmp_path, out.parent, out=there)
    work, old = strangers(out.parent)
    before = contents(out.parent)
    with pytest.raises(VbbenchError, match=r"out\.partial exists and was not made by vbbench.*move it away"):
        command()
    assert contents(out.parent) == before
    shutil.rmtree(work.parent)
    command()
    assert old.read_text() == "years of work"
    assert names(out.parent) == ["out", "out.old"]


def test_a_link_to_a_folder_is_no_work_folder(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "out.partial").symlink_to(tmp_path / "mine")
    with pytest.raises(VbbenchError, match=r"out\.partial exists and was not made by vbbench"):
        generate("demo", tmp_path / "out", OPTIONS)
    assert (tmp_path / "out.partial").is_symlink()


@pytest.mark.parametrize("withheld", [False, True])
def test_a_link_stays_and_what_it_points_to_is_replaced(room: Path, tmp_path: Path, withheld: bool) -> None:
    put(room, tmp_path / "far", data="old-apart", truth="old-apart.truth")
    link, truth = tmp_path / "out", tmp_path / "far" / "data.truth"
    link.symlink_to(tmp_path / "far" / "data")
    truth.symlink_to(tmp_path / "far" / "truth")
    generate("demo", link, OPTIONS, overwrite=True, withhold_truth=withheld)
    assert link.is_symlink()
    assert truth.is_symlink()
    assert contents(tmp_path / "far" / "data") == contents(room / ("new-apart" if withheld else "new"))
    assert contents(tmp_path / "far" / "truth") == contents(room / f"{'new' if withheld else 'old'}-apart.truth")
    assert names(tmp_path) == ["far", "out"]
    assert names(tmp_path / "far") == ["data", "data.truth", "truth"]


def test_a_link_to_nothing_is_filled_and_one_to_itself_is_a_mistake(
    room: Path, tmp_path: Path, mistake: Mistake
) -> None:
    (tmp_path / "out").symlink_to(tmp_path / "later" / "data")
    generate("demo", tmp_path / "out", OPTIONS)
    assert contents(tmp_path / "later" / "data") == contents(room / "new")
    (tmp_path / "loop").symlink_to("loop")
    mistake("generate", "demo", "--out", tmp_path / "loop")


@pytest.mark.parametrize("place", ["x" * 300, "x" * 250, "/proc/out", "/dev/null/out"])
@pytest.mark.parametrize("command", ["generate demo --limit 2", "solve {} --solver cv", "export csv {}", "import {}"])
def test_places_where_nothing_can_be_made_are_one_line(
    room: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
    place: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    words = command.format(room / "new").split()
    if words[0] == "import":
        assert main(["export", "tum", words[1], "--out", "files"]) == 0
        words = ["import", "tum", "files", "--dataset", words[1], "--solver", "me"]
    status = main([*words, "--out", place])
    said = capsys.readouterr().err
    if (status, len(place)) == (0, 250):
        return  # the name itself is not too long
    assert status == 2, said
    assert said.count("\n") == 1
    assert "choose another" in said or len(place) > 20, said
    assert set(names(tmp_path)) <= {"files"}


def test_a_mistake_leaves_no_folder_behind(tmp_path: Path, mistake: Mistake) -> None:
    for words in (["nosuch"], ["hotel", "--source", "nowhere"], ["sim", "--seed", "-1"]):
        mistake("generate", *words, "--out", tmp_path / "a" / "b" / "out")
        assert names(tmp_path) == [], words


def test_a_mistake_keeps_the_parts_of_interrupted_work(room: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with WorkFolder(out) as work:
        work.begin("a key")
        (work.parts / "00000000-00000002.arrows").write_bytes(b"part")
    with pytest.raises(VbbenchError, match="seed must be"):
        generate("sim", out, Options(limit=2, seed=-1))
    assert [path.name for path in tmp_path.rglob("*.arrows")] == ["00000000-00000002.arrows"]
    generate("demo", out, OPTIONS)
    assert names(tmp_path) == ["out"]
    assert contents(out) == contents(room / "new")


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 2 MB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", str(disk)], capture_output=True)
    if mounted.returncode:
        pytest.skip("no disk can be mounted here")
    yield disk
    subprocess.run(["umount", "--lazy", str(disk)], check=True)


def fill(disk: Path, left: int) -> Path:
    """Leave so many bytes free."""
    free = shutil.disk_usage(disk).free
    (disk / "ballast").write_bytes(b"\0" * max(free - left, 0))
    return disk / "ballast"


@pytest.mark.parametrize("left", [0, 8192])
def test_a_submission_stays_when_the_disk_is_full(room: Path, small_disk: Path, mistake: Mistake, left: int) -> None:
    out, files = small_disk / "out", small_disk.parent / "files"
    data = small_disk.parent / "data"
    write_made(data, Crowd(scenes=4, frames=120, people=9))
    assert main(["export", "tum", str(data), "--out", str(files)]) == 0
    command = ["import", "tum", str(files), "--dataset", str(data), "--solver", "me", "--out", str(out)]
    assert main([*command, "--protocol", "rollout"]) == 0
    before = contents(out)
    ballast = fill(small_disk, left)
    mistake(*command)
    assert contents(out) == before
    ballast.unlink()
    assert main(command) == 0
    assert names(out) == ["poses.parquet", "positions.parquet", "submission.json"]


@pytest.mark.slow
def test_a_limit_on_the_size_of_files_is_one_line(room: Path, tmp_path: Path) -> None:
    shutil.copytree(room / "old", tmp_path / "out")
    limited = f"ulimit -f 4; exec {sys.executable} -m vbbench generate demo --limit 60 --overwrite --out out"
    run = subprocess.run(["bash", "-c", limited], cwd=tmp_path, capture_output=True, text=True)
    assert (run.returncode, run.stderr.count("\n")) == (2, 1), run.stderr
    assert "File too large" in run.stderr
    assert contents(tmp_path / "out") == contents(room / "old")


def test_parts_that_were_cut_short_are_made_again(tmp_path: Path) -> None:
    from vbbench.files.tables import to_arrow
    from vbbench.parallel.parts import write_in_parts

    made: list[int] = []

    def work(first: int, last: int) -> Part:
        made.append(first)
        row = {"sequence": [first], "frame": [0], "x": [0.0], "y": [0.0], "yaw": [0.0]}
        return Part(groups={"poses": [to_arrow("poses", row)]}, facts={})  # type: ignore[arg-type]

    with WorkFolder(tmp_path / "out") as place:
        place.begin("key")
        tables = {"poses": place.new / "poses.parquet"}
        ranges = [(0, 1), (1, 2), (2, 3)]
        write_in_parts(work, ranges, place.parts, tables, label="test")
        first, second, _ = sorted(place.parts.iterdir())
        first.write_bytes(b"")
        second.write_bytes(second.read_bytes()[:-1])
        write_in_parts(work, ranges, place.parts, tables, label="test")
    assert made == [0, 1, 2, 0, 1]


def test_a_film_on_a_full_disk_is_a_mistake_and_the_old_one_stays(small_disk: Path) -> None:
    rng, path = np.random.default_rng(0), small_disk / "film.mp4"
    pictures = rng.integers(0, 255, (40, 240, 320, 3), np.uint8)

    def write(count: int) -> None:
        write_mp4(path, lambda wanted: (pictures[frame] for frame in wanted), count, 5.0)

    write(2)
    before = path.read_bytes()
    ballast = fill(small_disk, 50_000)
    with pytest.raises(FileError, match=r"film\.mp4: could not be written to its end"):
        write(40)
    assert path.read_bytes() == before
    ballast.unlink()
    assert names(small_disk) == ["film.mp4"]
