"""`vbbench solvers`: what `solve` can run, third parties' included; a broken plugin harms nobody."""

import json
from collections.abc import Iterator
from importlib.metadata import Distribution, EntryPoint
from typing import Any, ClassVar

import pytest

from vbbench import registry
from vbbench.cli import main
from vbbench.registry import registered


class Theirs:
    """Answers what it was told.

    More of this is in its paper.
    """

    def solve(self, problem: Any, observations: Any, given: Any) -> None: ...


class Undocumented:
    def start(self, problem: Any) -> None: ...

    def step(self, frame: Any) -> None: ...


def made() -> Undocumented:
    """A solver that a function makes."""
    return Undocumented()


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Registers solvers of another package beside those that are there."""

    class Package(Distribution):
        metadata: ClassVar = {"Name": "theirs", "Version": "3.1"}  # type: ignore[assignment]

        def read_text(self, filename: str) -> None: ...

        def locate_file(self, path: Any) -> Any: ...

    before = registry.entry_points

    def add(**values: str) -> None:
        points = [EntryPoint(name, value, "vbbench.solvers")._for(Package()) for name, value in values.items()]  # type: ignore[attr-defined]
        monkeypatch.setattr(
            registry, "entry_points", lambda group: [*before(group=group), *(p for p in points if p.group == group)]
        )
        registry.registered.cache_clear()

    yield add
    registry.registered.cache_clear()


def cards(capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert main(["solvers", "--json"]) == 0
    return {card["name"]: card for card in json.loads(capsys.readouterr().out)}


def test_every_bundled_solver_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solvers"]) == 0
    text = capsys.readouterr().out
    for name in registered("solver"):
        assert f"{name}: " in text
    found = cards(capsys)
    assert list(found) == sorted(registered("solver"))
    assert found["vb-cv"]["kind"] == "frame by frame"
    assert found["map-batch"]["kind"] == "whole sequence"
    assert all(card["summary"] and card["package"].startswith("vbbench ") for card in found.values())


def test_those_of_other_packages_are_listed_too(install: Any, capsys: pytest.CaptureFixture[str]) -> None:
    install(theirs=f"{__name__}:Theirs", plain=f"{__name__}:Undocumented", made=f"{__name__}:made")
    found = cards(capsys)
    assert found["theirs"] == {
        "name": "theirs",
        "package": "theirs 3.1",
        "kind": "whole sequence",
        "summary": "Answers what it was told.",
    }
    assert (found["plain"]["kind"], found["plain"]["summary"]) == ("frame by frame", "")
    assert (found["made"]["kind"], found["made"]["summary"]) == ("frame by frame", "A solver that a function makes.")
    assert main(["solvers"]) == 0
    text = capsys.readouterr().out
    assert "theirs: Answers what it was told. [whole sequence, theirs 3.1]\n" in text
