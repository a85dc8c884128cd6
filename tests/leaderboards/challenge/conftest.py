"""One challenge for all tests of the kit, and a copy of it to be spoilt."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.lib.challenges import make_challenge, vbbench


@pytest.fixture(scope="package")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The organiser's folder; the answers of cv and sf lie next to it."""
    return make_challenge(tmp_path_factory.mktemp("kit") / "tiny")


@pytest.fixture
def room(made: Path, tmp_path: Path) -> Path:
    """A copy of the challenge, in the folder ``tiny``, and of the answers."""
    return shutil.copytree(made.parent, tmp_path / "room")


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command that is refused, and gives what it says."""

    def run(*words: object) -> str:
        capsys.readouterr()
        assert vbbench(*words) == 2
        said = capsys.readouterr()
        assert said.out == ""
        return said.err

    return run
