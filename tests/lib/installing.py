"""Installs a package as pip does, as far as vbbench looks: a folder with entry points on the path."""

from collections.abc import Callable
from pathlib import Path

import pytest

from vbbench import registry


class Installed:
    """A package that adds an entry point for as long as a test runs, or until it is removed."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path, group: str, name: str, value: str) -> None:
        self._monkeypatch, self._folder = monkeypatch, folder
        facts = folder / "an_extension-1.0.dist-info"
        facts.mkdir(parents=True, exist_ok=True)
        (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: an-extension\nVersion: 1.0\n")
        with (facts / "entry_points.txt").open("a", encoding="utf-8") as points:
            points.write(f"[{group}]\n{name} = {value}\n")
        monkeypatch.syspath_prepend(str(folder))
        registry.registered.cache_clear()

    def remove(self) -> None:
        """Uninstall it."""
        for file in (self._folder / "an_extension-1.0.dist-info").iterdir():
            file.unlink()
        (self._folder / "an_extension-1.0.dist-info").rmdir()
        registry.registered.cache_clear()


Install = Callable[[str, str, str], Installed]
"""The fixture `install`: group, name and value of an entry point."""
