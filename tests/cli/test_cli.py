"""The command line as a stranger uses it: exit status, one line for a mistake, results on stdout alone."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from functools import cache
from io import StringIO
from pathlib import Path
from typing import ClassVar
from unittest.mock import patch

import pytest

from tests.lib.installing import Install
from vbbench.camera import PerspectiveCamera
from vbbench.cli import COMMANDS, all_commands, main
from vbbench.cli.parsing import in_options, parameters_of, parse
from vbbench.errors import VbbenchWarning
from vbbench.generation.generator import fetch_splits

Mistake = Callable[..., str]
VBBENCH = [sys.executable, "-m", "vbbench"]


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    status = main([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cli") / "data"
    assert main(["generate", "demo", "--out", str(folder), "--limit", "20"]) == 0
    return folder


@pytest.fixture(scope="module")
def submission(dataset: Path) -> Path:
    out = dataset.parent / "vb"
    assert main(["solve", str(dataset), "--solver", "vb-cv", "--out", str(out)]) == 0
    return out


def test_info_json_has_the_keys_of_the_contract(capsys: pytest.CaptureFixture[str], dataset: Path) -> None:
    status, out, _ = run(capsys, "info", dataset, "--json")
    keys = {"split", "camera", "tier", "sequences", "mean_frames", "people_min", "people_mean", "people_max"}
    assert status == 0
    assert keys | {"observations", "id"} <= set(json.loads(out))


def test_score_json_and_rows_of_a_solve_without_a_protocol(
    capsys: pytest.CaptureFixture[str], dataset: Path, submission: Path
) -> None:
    table = dataset.parent / "rows.csv"
    status, out, _ = run(capsys, "score", submission, "--dataset", dataset, "--json", "--per-sequence", table)
    assert status == 0
    result = json.loads(out)
    assert result["protocol"] == "sequential", "which solve takes by itself"
    assert result["coverage"] == 1.0
    assert len(table.read_text().splitlines()) == 21


@pytest.mark.slow
def test_compare_verify_plot_and_tum(capsys: pytest.CaptureFixture[str], dataset: Path, submission: Path) -> None:
    room = dataset.parent
    other = room / "cv"
    assert run(capsys, "solve", dataset, "--solver", "cv", "--protocol", "sequential", "--out", other)[0] == 0
    status, out, _ = run(capsys, "compare", submission, other, "--dataset", dataset, "--json")
    assert status == 0
    assert json.loads(out)
    assert run(capsys, "verify", dataset)[0] == 0
    picture = room / "p.png"
    assert run(capsys, "plot", dataset, "--sequence", 3, "--estimate", submission, "--out", picture)[0] == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert run(capsys, "export", "tum", dataset, "--out", room / "tum")[0] == 0
    status, *_ = run(
        capsys, "import", "tum", room / "tum", "--dataset", dataset, "--out", room / "perfect", "--solver", "truth"
    )
    assert status == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["generate", "hotle", "--out", "x"], "did you mean 'hotel'"),
        (["generate", "demo"], "--out"),
        (["generate", "demo", "--out", "x", "--limit", "many"], "limit"),
        (["generate", "demo", "--out", "x", "--tier", "blurred"], "no tier is called 'blurred'; known: field, ideal"),
        (
            ["generate", "demo", "--out", "x", "--tier", "niosy"],
            "no tier is called 'niosy'; did you mean 'noisy'",
        ),
        (
            ["generate", "demo", "--out", "x", "--camera", "panorma"],
            "no camera is called 'panorma'; did you",
        ),
        (["generate", "demo", "--out", "x", "--camera", "json:loads"], "no camera is called 'json:loads'"),
        (["generate", "demo", "--out", "x", "--sigma_h", "tall"], "--sigma-h: must be a number, not 'tall'"),
        (["generate", "demo", "--out", "x", "--limit", "None"], "--limit: must be a whole number, not 'None'"),
        (
            ["solve", "nowhere", "--solvr", "cv", "--out", "y"],
            "no option of 'solve' is called '--solvr'; did",
        ),
        (["solve", "nowhere", "--solvr=cv"], "did you mean '--solver'?"),
        (["solve", "nowhere", "--protocol", "onestep"], "did you mean 'one-step'?"),
        (["solve", "nowhere", "--protocol=onestep"], "did you mean 'one-step'?"),
        (["solve", "nowhere", "--protocol", "--out", "y"], "--protocol: expected one argument"),
        (["solve", "nowhere", "--out", "y", "--solver"], "--solver: expected one argument; see 'vbbench solve --help'"),
        (["solve"], "required: FOLDER, --solver, --out; see 'vbbench solve --help'"),
        (["solve", "one", "two", "--solver", "cv", "--out", "y"], "unrecognized arguments: two"),
        (["sovle", "nowhere"], "no command is called 'sovle'; did you mean 'solve'?"),
        (["lederboard"], "did you mean 'leaderboard'?"),
        (["--hepl"], "did you mean '--help'?"),
        ([], "'vbbench --help' lists them"),
        (["info", "nowhere"], "no dataset here"),
        (["solve", "nowhere", "--solver", "cv", "--out", "y"], "no dataset here"),
        (["frobnicate"], "no command is called 'frobnicate'"),
        (["export", "tmu"], "did you mean 'export tum'"),
        (["export"], "'export' needs one of csv, mot, tum"),
        (["leaderboard", "chek"], "did you mean 'leaderboard check'"),
        (["leaderboard", "add", "nowhere"], "--dataset"),
        (["fetch", "hotle"], "no split is called 'hotle'; did you mean 'hotel'"),
        (["fetch"], "name splits"),
        (["birdify", "boxes.csv", "--camera", ""], "--camera: is empty; name a file or folder"),
        (["birdify", "", "--camera", "x"], "RECORDING: is empty; name a file or folder"),
        (["generate", "demo", "--seed", "x", "--out", "x"], "--seed: must be a whole number or secret, not 'x'"),
        (["fetch", "eth", "--source", "x"], "'fetch' has no options; remove --source"),
        (["birdify", "boxes.csv", "-camera", "camera.toml"], "called '-camera'; did you mean '--camera'?"),
        (["birdify", "--example", "--film=yes"], "--film takes no value; write --film alone"),
    ],
)
def test_a_mistake_is_one_line_on_stderr_and_status_2(
    mistake: Mistake, arguments: list[str], message: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in mistake(*arguments)
    assert not list(tmp_path.iterdir())


def test_exchanged_folders_are_named(capsys: pytest.CaptureFixture[str], dataset: Path, submission: Path) -> None:
    for other, said in ((submission, "no dataset here, but a submission"), (dataset, "is a dataset; name that of the")):
        status, _, err = run(capsys, "score", dataset, "--dataset", other)
        assert (status, said in err) == (2, True)


@pytest.mark.parametrize(
    ("split", "why"),
    [("nuscenes", "is made from your own files, which --source names"), ("sim", "has no source files")],
)
def test_what_has_nothing_to_fetch_is_named(split: str, why: str) -> None:
    with pytest.warns(VbbenchWarning, match=f"{split}: nothing to fetch; it {why}"):
        assert fetch_splits([split]) == []


@pytest.mark.parametrize("name", ["generate", ""])
def test_help_fits_a_narrow_terminal(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with patch.dict(os.environ, COLUMNS="60"), suppress(SystemExit):
        main([*name.split(), "--help"])
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 60


@cache
def help_of(name: str) -> str:
    text = StringIO()
    with patch.dict(os.environ, COLUMNS="100"), redirect_stdout(text), pytest.raises(SystemExit) as end:
        main([*name.split(), "--help"])
    assert end.value.code == 0
    return text.getvalue()


@pytest.mark.parametrize("name", all_commands())
def test_every_command_has_help_for_every_option(name: str) -> None:
    text = help_of(name)
    assert "usage: vbbench" in text
    shown = [each.option for each in parameters_of(all_commands()[name]) if not each.positional]
    assert all(f"\n  {option}" in text for option in shown)
    assert len(text.splitlines()) <= 50, "it fits a screen"
    assert all_commands()[name].__doc__.splitlines()[0].split(":")[0][:30] in " ".join(text.replace("│", " ").split())


@pytest.mark.parametrize(
    ("command", "python", "shell"),
    [
        ("solve", "x exists; set `overwrite` to replace it", "x exists; set --overwrite to replace it"),
        ("solve", "jobs is a number of processes", "--jobs is a number of processes"),
        ("generate", "height_std must be 0 or more", "--sigma-h must be 0 or more"),
        ("generate", "the seed must be 0 or more", "the seed must be 0 or more"),
        ("export mot", "pass `pixel_std`, or `backend=True`", "pass `pixel_std`, or --backend"),
        (
            "score",
            "x has no truth; put it at x/truth, or name its folder with `truth` where a command takes that",
            "x has no truth; put it at x/truth, or name its folder with --truth where a command takes that",
        ),
        ("generate", "leave `noise` and `tier` out", "leave --noise and --tier out"),
        ("info", "x exists; set `overwrite` to replace it", "x exists; set `overwrite` to replace it"),
    ],
)
def test_parameters_of_the_library_are_options_in_messages(command: str, python: str, shell: str) -> None:
    assert in_options(python, all_commands()[command]) == shell


@pytest.mark.parametrize(("words", "given"), [(["--no-film"], False), (["--film"], True), ([], False)])
def test_what_is_off_can_be_named_so(words: list[str], given: bool) -> None:
    call = parse({"birdify": COMMANDS["birdify"]}, ["birdify", "boxes.csv", *words, "--out", "map"])
    assert call.keywords["film"] is given


def test_what_a_value_in_a_file_must_be_is_said_of_the_file() -> None:
    function = all_commands()["generate"]
    assert in_options("r.toml: seed must be 2 or more", function, of_file=True) == "r.toml: seed must be 2 or more"
    assert in_options("x: limit must be 1 or more", function) == "x: --limit must be 1 or more"


@pytest.mark.parametrize("name", all_commands())
def test_help_says_nothing_of_defaults_that_say_nothing(name: str) -> None:
    text = " ".join(help_of(name).replace("│", " ").split())
    assert not re.search(r"\{None|\bNone\b|default: (False|True|\(\))?\)", text)


def test_importing_vbbench_stays_light() -> None:
    heavy = ["matplotlib", "cv2", "pandas", "pyarrow", "scipy"]
    code = f"import sys, vbbench; sys.exit(any(name in sys.modules for name in {heavy}))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.slow
def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\nfrom vbbench.cli import main\n"
        "try: main(['--help'])\nexcept SystemExit: pass\n"
        "sys.exit(any(name in sys.modules for name in ['numpy', 'matplotlib', 'pandas', 'pyarrow']))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False, capture_output=True).returncode == 0
    assert (
        b"usage: vbbench solve" in subprocess.run([*VBBENCH, "solve", "--help"], check=True, capture_output=True).stdout
    )
    assert subprocess.run([*VBBENCH, "--version"], check=True, capture_output=True).stdout.startswith(b"vbbench ")


@pytest.mark.parametrize("command", [["export", "mot"], ["export", "tum"]])
def test_loose_files_do_not_go_into_a_dataset(mistake: Mistake, dataset: Path, command: list[str]) -> None:
    before = sorted(dataset.rglob("*"))
    assert "is a dataset; choose another folder" in mistake(*command, dataset, "--out", dataset)
    assert sorted(dataset.rglob("*")) == before


class Narrow(PerspectiveCamera):
    """A camera of another package."""

    kind: ClassVar[str] = "narrow"


def test_a_camera_of_another_package_is_asked_for_by_its_name(
    install: Install, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    install("vbbench.cameras", "narrow", f"{__name__}:Narrow")
    assert run(capsys, "generate", "demo", "--camera", "narow", "--out", tmp_path / "a")[0] == 2
    status, out, _ = run(capsys, "generate", "demo", "--camera", "narrow", "--limit", 2, "--out", tmp_path / "a")
    assert status == 0
    assert "camera narrow" in out
    assert run(capsys, "verify", tmp_path / "a")[0] == 0
