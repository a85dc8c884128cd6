"""A small board for all tests of result files, and a copy of its results to be spoilt."""

import shutil
from pathlib import Path

import pytest

from tests.lib.tiny_board import tiny_board


@pytest.fixture(scope="package")
def tiny_room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with the results of two solvers, and the work folder with their dataset and submissions."""
    return tiny_board(tmp_path_factory.mktemp("board")).parent


@pytest.fixture
def results(tiny_room: Path, tmp_path: Path) -> Path:
    """A copy of the results."""
    return Path(shutil.copytree(tiny_room / "results", tmp_path / "results"))
