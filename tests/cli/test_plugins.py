"""Commands of other packages: found by entry point, and a broken one harms nobody."""

import subprocess
import sys

import pytest

from tests.lib.installing import Install
from vbbench.cli import COMMANDS, all_commands, main


def greet(name: str = "you") -> int:
    """Greet somebody.

    Args:
        name: Whom.
    """
    sys.stdout.write(f"hello {name}\n")
    return 3


TOOLS = {"greet": greet}


GROUP = "vbbench.commands"


def test_a_command_of_another_package_runs_and_its_status_counts(
    install: Install, capsys: pytest.CaptureFixture[str]
) -> None:
    install(GROUP, "tool", f"{__name__}:TOOLS")
    assert main(["tool", "greet", "--name", "Ada"]) == 3
    assert capsys.readouterr().out == "hello Ada\n"
    assert main(["tool", "gret"]) == 2
    assert "did you mean 'tool greet'?" in capsys.readouterr().err


@pytest.mark.filterwarnings("default::vbbench.errors.VbbenchWarning")
@pytest.mark.parametrize(
    ("value", "name", "reason"),
    [
        ("nowhere:TOOLS", "broken", "command 'broken' (nowhere:TOOLS) cannot be imported"),
        (f"{__name__}:NOTHING", "broken", "cannot be imported"),
        ("nowhere:TOOLS", "broken", "; run in the folder of nowhere.py"),
        (f"{__name__}:greet", "broken", "commands 'broken' are skipped: it is not a dict"),
        (f"{__name__}:TOOLS", "score", "commands 'score' are skipped: its name is a command of vbbench"),
    ],
)
def test_a_broken_one_is_a_warning_that_names_it(
    install: Install, capsys: pytest.CaptureFixture[str], value: str, name: str, reason: str
) -> None:
    install(GROUP, name, value)
    assert main(["--help"]) == 0
    captured = capsys.readouterr()
    assert "generate" in captured.out
    assert captured.err.startswith("vbbench: warning: ")
    assert reason in captured.err
    assert main(["info", "nowhere"]) == 2
    assert "warning" not in capsys.readouterr().err


def test_the_leaderboard_is_such_a_package() -> None:
    mine = {name for name in all_commands() if name not in COMMANDS}
    assert {"leaderboard add", "leaderboard check", "leaderboard rerun"} <= mine


def test_help_of_a_group_lists_its_commands_alone() -> None:
    command = [sys.executable, "-m", "vbbench", "leaderboard", "--help"]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "\n  rerun " in text
    assert "generate" not in text
