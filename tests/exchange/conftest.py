"""A walk that its files hold, for the tests of readers."""

from pathlib import Path

import pytest

from tests.lib.own_recording import Walk, make_walk, write_folder


@pytest.fixture(scope="module")
def walk() -> Walk:
    return make_walk()


@pytest.fixture
def folder(tmp_path: Path, walk: Walk) -> Path:
    return write_folder(tmp_path / "walk", walk)
