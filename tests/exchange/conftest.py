"""A walk that its files hold, and files of boxes, for the tests of readers."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.lib.own_recording import Walk, make_walk, write_folder
from vbbench.exchange.box_rows import OwnBoxes, read_boxes

PICTURE = (1280.0, 720.0)


@pytest.fixture(scope="module")
def walk() -> Walk:
    return make_walk()


@pytest.fixture
def folder(tmp_path: Path, walk: Walk) -> Path:
    return write_folder(tmp_path / "walk", walk)


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., OwnBoxes]:
    """Write a file of boxes, and read it."""

    def make(name: str, content: str | bytes, dt: float | None = 0.1, **options: Any) -> OwnBoxes:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_boxes(path, dt, picture=PICTURE, **options)

    return make
