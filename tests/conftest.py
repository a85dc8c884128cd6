"""Fixtures that every test module may use."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture
def data_folder() -> Path:
    """The folder with the real recordings, or a skip that says how to get them."""
    folder = os.environ.get("VBBENCH_DATA")
    if not folder or not Path(folder, "eth", "biwi_hotel.txt").is_file():
        pytest.skip("no recordings: set $VBBENCH_DATA to the folder that `vbbench fetch` fills")
    return Path(folder)


@pytest.fixture
def no_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty $VBBENCH_DATA, with an empty cache folder behind it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = tmp_path / "data"
    folder.mkdir()
    monkeypatch.setenv("VBBENCH_DATA", str(folder))
    return folder


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Write a text file into an empty folder and return its path."""

    def write_text(text: str, name: str = "tracks.txt") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write_text
