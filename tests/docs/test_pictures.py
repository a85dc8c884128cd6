"""Pictures of README and docs: each is listed with its command, its command is one today, and it shows what is."""

import runpy
import tomllib
from pathlib import Path

import pytest

from tests.lib.commands import understood

ROOT = Path(__file__).parents[2]
LISTED = tomllib.loads((ROOT / "docs" / "pictures.toml").read_text("utf-8"))
MADE = LISTED.pop("made")
COMMANDS = [*MADE.values(), *(picture["run"] for picture in LISTED.values() if "run" in picture)]


def test_every_picture_is_listed() -> None:
    there = {path.name for path in (ROOT / "docs" / "images").iterdir() if path.suffix in (".png", ".webp")}
    assert {picture["file"] for picture in LISTED.values()} == there


@pytest.mark.parametrize("command", COMMANDS)
def test_its_command_is_one_of_today(command: str) -> None:
    program, line = command.replace("PICTURE", "picture.png").split(" ", 1)
    if program == "python":
        assert (ROOT / f"{line.split()[1].replace('.', '/')}.py").is_file()
    else:
        understood(line)


def test_pictures_show_what_is() -> None:
    stale = runpy.run_path(str(ROOT / "docs" / "draw.py"))["stale"]()
    assert not stale, f"out of date: run 'python docs/draw.py', or --record those that still show what is: {stale}"
