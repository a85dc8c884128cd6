"""Fixtures that tests of extensions share."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.extensions.installing import Installed
from vbbench import registry

Install = Callable[[str, str, str], Installed]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Installs a package with an entry point: group, name and value; called again, it adds another."""
    yield lambda group, name, value: Installed(monkeypatch, tmp_path / "site-packages", group, name, value)
    monkeypatch.undo()
    registry.registered.cache_clear()
