"""What strangers' files, names and terminals hold never ends in a traceback: one line, status 2."""

import errno
import io
import os
import stat
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.cli.test_cli import Mistake, run
from tests.lib.make_dataset import Crowd
from tests.lib.mot_text import read_mot
from tests.lib.tiny_board import tiny_dataset
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.tum import import_tum
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.archives import open_archive
from vbbench.generation.generator import Options
from vbbench.generation.options_file import parse_people
from vbbench.parsing.numbers import Within
from vbbench_generators.crowds import read_scenario
from vbbench_generators.recordings.loading import SceneFile
from vbbench_generators.recordings.readers.crohd import parse_seqinfo
from vbbench_generators.recordings.readers.tables import trajnet
from vbbench_generators.recordings.readers.tracks import read_homography
from vbbench_generators.recordings.readers.vsp import vsp
from vbbench_generators.recordings.recipe import read_recipe

Write = Callable[..., Path]

VBBENCH = [sys.executable, "-m", "vbbench"]
SCENARIO = """name = "mine"
title = "t"
sequences = 2
people = [3]
frames = 5
dt = 0.4
walls = [[0.0, 0.0, 1.0, 1.0]]
[[flow]]
start = [0.0, 0.0, 4.0, 4.0]
goal = [0.0, 0.0, 4.0, 4.0]
"""


class Stream(io.TextIOWrapper):
    """Stdout or stderr on something that takes nothing."""

    def __init__(self, error: int) -> None:
        class Full(io.RawIOBase):
            def writable(self) -> bool:
                return True

            def write(self, _data: object) -> int:
                raise OSError(error, os.strerror(error))

        super().__init__(io.BufferedWriter(Full()), encoding="ascii")


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("frames", "2000000000", "frames must be 1 to 1,000,000, not 2,000,000,000"),
        ("frames", "2e9", "has the wrong type"),
        ("dt", "nan", "dt, the time of a frame, must be 0.001 to 60 s, not nan"),
        ("sequences", "2000000000", "sequences must be 1 to 10,000,000"),
        ("sequences", "9" * 5000, "more than 2,000 bytes; write it in several lines"),
        ("sequences", "0x" + "f" * 1500, "not TOML: a whole number has more than 64 bits"),
        ("people", "[2000000000]", "people must be 2 to 10,000"),
        ("walls", "[[nan, 0.0, 1.0, 1.0]]", "walls must be -100,000 to 100,000 m, not nan"),
        ("walls", "[[0.0, 0.0, 2e9, 1.0]]", "walls must be -100,000 to 100,000 m, not 2e+09"),
        ("walls", "[" * 700 + "]" * 700, "nested too deeply"),
        ("start", "[0.0, 0.0, inf, 4.0]", "start must be -100,000 to 100,000 m, not inf"),
        ("warm_up", "inf", "warm_up must be 0 to 3,600 s, not inf"),
        ("speed_mean", "nan", "speed_mean must be 0.01 to 10 m/s, not nan"),
        ("step", "inf", "step must be 0.001 to 10 s"),
        ("min_seen", "2000000000", "min_seen must be"),
    ],
)
def test_a_scenarios_numbers_have_ranges(
    write: Write, mistake: Mistake, key: str, value: str, said: str, tmp_path: Path
) -> None:
    rows = [row for row in SCENARIO.splitlines() if not row.startswith(f"{key} =")]
    place = rows.index("[[flow]]") + (key in ("start", "goal"))
    path = write("\n".join([*rows[:place], f"{key} = {value}", *rows[place:]]), "mine.toml")
    with pytest.raises(FileError) as caught:
        read_scenario(path)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    mistake("generate", "sim", "--options", f"scenario={path}", "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"frames = 5": "frames = 1000000", "[3]": "[10000]"}, "people in 1,000,000 frames"),
        ({"0.0, 0.0, 1.0, 1.0": "-1e5, 0.0, 1e5, 1.0"}, "the walls are 200,000 m long"),
        (
            {"dt = 0.4": "dt = 60.0\nstep = 10.0\nleast_way = 0.01", "frames = 5": "frames = 10000"},
            "would need .* goals: give them a longer least_way",
        ),
    ],
)
def test_a_scenario_that_no_memory_holds(write: Write, changes: dict[str, str], said: str) -> None:
    text = SCENARIO + "then = [[0.0, 0.0, 4.0, 4.0]]\n"
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    with pytest.raises(FileError, match=said):
        read_scenario(write(text, "mine.toml"))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"a = " + b"[" * 1500 + b"]" * 1500, "has more than 2,000 bytes; write it in several lines"),
        (b"a = " + b"[\n" * 3000 + b"]" * 1500, "nested too deeply|is not TOML"),
        (b"[" + b"a." * 20_000 + b"a]\n", "more than 2,000 bytes"),
        (b"[" + b"a." * 500 + b"a]\nb = 1", "nested too deeply"),
        (b"a = 1\ntitle = '\xff'", "mine.toml, line 2: is not UTF-8; save it as UTF-8"),
        (b"\xef\xbb\xbftitel = 1", "unknown key 'titel'"),
        (b"\xef\xbb\xbfa = 1\n\xff", "mine.toml, line 2: is not UTF-8"),
        (b"# " + b"x" * 70_000, "has more than 65,536 bytes"),
    ],
)
def test_absurd_settings(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_bytes(content)
    for read in (read_scenario, read_recipe):
        with pytest.raises(FileError, match=said):
            read(path)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"height_std": np.nan}, "height_std, the spread of people's heights, must be 0 to 0.3 m, not nan"),
        ({"dt": np.inf}, "dt, the time of a frame, must be 0.001 to 60 s, not inf"),
        ({"limit": 0}, "limit must be 1 to 2,147,483,648, not 0"),
        ({"limit": 10**5000}, "limit must be .* not a whole number of 16610 bits"),
        ({"seed": -1}, "seed must be 0 to"),
        ({"seed": "secret"}, "seed must be a number"),
        ({"look": "wandr"}, r"look cannot be 'wandr'; did you mean 'wander'\?"),
    ],
)
def test_options_have_ranges(options: dict[str, float], said: str) -> None:
    with pytest.raises(VbbenchError, match=said):
        Options(**options)


@pytest.mark.parametrize("text", ["2:2000000000", "2:" + "9" * 5000, "٢", "nan", "1e3", "10:50:0", ""])
def test_numbers_of_people_are_bounded(text: str) -> None:
    with pytest.raises(VbbenchError, match="numbers of people are"):
        parse_people(text)


@pytest.mark.parametrize(
    "arguments",
    [
        ["demo", "--sigma-h", "nan"],
        ["demo", "--limit", "0"],
        ["demo", "--limit", "9" * 5000],
        ["demo", "--seed", "-1"],
        ["sim", "--sequences", "9" * 30],
        ["sim", "--options", "people=2:" + "9" * 5000],
        ["sim", "--options", "scenario=a\x1b[2J.toml"],
        ["sim", "--options", "scenario=/dev/null.toml"],
    ],
)
def test_numbers_on_the_command_line(arguments: list[str], mistake: Mistake, tmp_path: Path) -> None:
    error = mistake("generate", *arguments, "--out", tmp_path / "out")
    assert len(error) < 6000
    assert "\x1b" not in error
    assert not list(tmp_path.iterdir())


def test_a_range_says_what_it_is() -> None:
    with pytest.raises(ValueError, match=r"^x must be 0 to 10,000 m, not -1$"):
        Within(0, 10_000, "m").check("x", -1)
    for value in (True, "1", None, [1]):
        with pytest.raises(ValueError, match="x must be a number"):
            Within(0, 1).check("x", value)


def test_a_tiny_spline_file_takes_little_memory(write: Write) -> None:
    text = "1 - the number of splines\n2 - Num of control points\n0 0 0 0 - (2D)\n9 9 2000000000 0 - (2D)\n"
    with pytest.raises(FileError, match="goes from frame 0 to 2000000000 with 2 key points; correct"):
        vsp.read(SceneFile(path=write(text, "a.vsp"), dt=0.4, frame_step=1, homography=np.eye(3)))
    header = write("9" * 5000 + " - the number of splines\n", "a.vsp")
    with pytest.raises(FileError, match="line 1: '<count> - the number of splines' should stand here"):
        vsp.read(SceneFile(path=header, dt=0.4, frame_step=1, homography=np.eye(3)))


def test_a_tiny_recording_takes_little_memory(write: Write) -> None:
    with pytest.raises(FileError, match="40,000,002 frames of 2 people from 4 rows are too many"):
        trajnet.read(SceneFile(path=write("0 1 0 0\n1 1 1 0\n40000000 2 0 0\n40000001 2 1 0\n"), dt=0.4, frame_step=1))


@pytest.mark.parametrize(
    "text", ["1e308 0 0\n0 1e308 0\n0 0 1e-308\n", "0 0 0\n0 0 0\n0 0 0\n", "1 1 1\n1 1 1\n1 1 1\n"]
)
def test_a_homography_without_an_inverse(write: Write, text: str) -> None:
    with pytest.raises(FileError, match="singular"):
        read_homography(write(text))


@pytest.mark.parametrize("x", ["1e308", "-1e7", "2e6"])
def test_nobody_walks_on_another_planet(write: Write, x: str) -> None:
    with pytest.raises(FileError, match=r"line 2: .* km from the origin; are these metres"):
        trajnet.read(SceneFile(path=write(f"0 1 0 0\n1 1 {x} 0\n"), dt=0.4))


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("seqLength", "9" * 1900),
        ("seqLength", "٣"),
        ("imWidth", "0"),
        ("frameRate", "nan"),
        ("frameRate", "1_0"),
        ("name", "a\x1b[2Jb"),
        ("name", "x" * 300),
    ],
)
def test_seqinfo_is_not_believed(key: str, value: str) -> None:
    facts = {"name": "HT21-03", "frameRate": "25", "seqLength": "90", "imWidth": "1920", "imHeight": "1080", key: value}
    text = "[Sequence]\n" + "".join(f"{name}={fact}\n" for name, fact in facts.items())
    with pytest.raises(FileError, match=f"{key} is '") as caught:
        parse_seqinfo(Path("seqinfo.ini"), text.encode())
    assert len(str(caught.value)) < 300
    assert "\x1b" not in str(caught.value)


@pytest.mark.parametrize("row", ["seqLength=" + "9" * 5000, "frameRa" + " " * 50_000, "frameRate=" + " 1" * 50_000])
def test_a_long_line_of_seqinfo_takes_no_time(row: str) -> None:
    with pytest.raises(FileError, match=r"key '.*' is missing"):
        parse_seqinfo(Path("seqinfo.ini"), f"[Sequence]\nname=HT21-03\n{row}\n".encode())


def test_a_member_without_a_name(tmp_path: Path) -> None:
    path = tmp_path / "a.zip"
    info = zipfile.ZipInfo("x")
    info.filename = ""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(info, "1")
    with pytest.raises(FileError, match="its member '' has no name"), open_archive(path):
        pass


@pytest.mark.parametrize("cell", ["0_2", "0x2", "٢", "２", "1d0", "infinity", "9" * 400])
def test_mot_and_tum_know_one_grammar_of_numbers(write: Write, cell: str) -> None:
    with pytest.raises(FileError, match="line 1: "):
        read_mot(write(f"1,{cell},1,1,5,5\n"), 5)
    with pytest.raises(FileError, match="line 1: "):
        import_tum(write(f"0 {cell} 0 0 0 0 0 1\n"), 0.4)


def test_what_a_stranger_wrote_never_steers_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    tiny_dataset(tmp_path / "mine", Crowd(sequences=2))
    facts = vars(DatasetInfo.read(tmp_path / "mine"))
    monkeypatch.setattr(
        DatasetInfo, "read", lambda _folder: DatasetInfo(**{**facts, "title": "a\x1b[2J\rb\x9bc\u202ed"})
    )
    assert main(["info", str(tmp_path / "mine")]) == 0
    out = capsys.readouterr().out
    assert r"a\x1b[2J\rb\x9bc\u202ed" in out
    assert out.endswith("\n")


@pytest.mark.parametrize("argument", ["caf\udce9", "a\0b", "mine:\udcff"])
def test_arguments_are_text(mistake: Mistake, argument: str, tmp_path: Path) -> None:
    error = mistake("solve", tmp_path, "--solver", argument, "--out", tmp_path / "out")
    assert "argument 4 is not UTF-8 text" in error


def test_a_full_disk_behind_stdout(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", Stream(errno.ENOSPC))
    status, _, error = run(capsys, "splits")
    assert (status, error) == (2, "vbbench: the output cannot be written: No space left on device\n")


@pytest.mark.parametrize("broken", ["stdout", "stderr"])
def test_nobody_reads_any_more(broken: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for arguments, status in ((["splits"], 0), (["info", "nowhere"], 2)):
        monkeypatch.setattr(sys, broken, Stream(errno.EPIPE))
        assert main(arguments) == status


def test_closed_streams(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    assert main(["splits"]) == 0
    assert main(["info", "nowhere"]) == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    "environment",
    [
        {"PYTHONIOENCODING": "ascii"},
        {"PYTHONIOENCODING": "latin-1"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ],
)
def test_any_encoding_of_the_terminal(environment: dict[str, str], tmp_path: Path) -> None:
    tiny_dataset(tmp_path / "mine", Crowd(sequences=2, caution="not for σ_h = 0"))
    done = subprocess.run(
        [*VBBENCH, "info", "mine"], cwd=tmp_path, env=os.environ | environment, capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert rb"\u03c3_h" in done.stdout


def test_a_failure_of_the_program_stays_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> str:
        raise KeyError("a bug")

    monkeypatch.setattr("vbbench.generation.generator.describe_splits", broken)
    with pytest.raises(KeyError):
        main(["splits"])


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (
            "score answr --dataset mine",
            "vbbench: answr: 1 fault; fix and score again\n  1. there is no such folder; name ",
        ),
        (
            "challenge close crwd",
            "vbbench: crwd: holds no challenge.toml; make a challenge with 'vbbench challenge new'\n",
        ),
    ],
)
def test_a_folder_that_is_not_there_is_named(
    command: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny_dataset(tmp_path / "mine", Crowd(sequences=2))
    monkeypatch.chdir(tmp_path)
    assert main(command.split()) == 2
    assert capsys.readouterr().err.startswith(said)


@pytest.mark.slow
def test_a_device_takes_no_output() -> None:
    device = Path("/dev/full")
    if not (device.exists() and stat.S_ISCHR(device.stat().st_mode)):
        pytest.skip("no device /dev/full")
    with device.open("wb") as full:
        done = subprocess.run([*VBBENCH, "splits"], stdout=full, stderr=subprocess.PIPE, check=False)
    assert (done.returncode, done.stderr.count(b"\n")) == (2, 1)
