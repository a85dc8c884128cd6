"""`vbbench solvers`: what `solve` can run, third parties' included; a broken plugin harms nobody."""

from dataclasses import asdict
from typing import Any

import pytest

from tests.lib.installing import Install
from vbbench.cli import main
from vbbench.registry import registered
from vbbench.solving.provenance import solver_cards


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


def cards() -> dict[str, Any]:
    return {card.name: asdict(card) for card in solver_cards()}


def test_every_bundled_solver_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solvers"]) == 0
    text = capsys.readouterr().out
    for name in registered("solver"):
        assert f"{name}: " in text
    found = cards()
    assert list(found) == sorted(registered("solver"))
    assert found["vb-cv"]["kind"] == "frame by frame"
    assert found["map-batch"]["kind"] == "whole sequence"
    assert all(card["summary"] and card["package"].startswith("vbbench ") for card in found.values())


def test_those_of_other_packages_are_listed_too(install: Install, capsys: pytest.CaptureFixture[str]) -> None:
    for name, value in (("theirs", "Theirs"), ("plain", "Undocumented"), ("made", "made")):
        install("vbbench.solvers", name, f"{__name__}:{value}")
    found = cards()
    assert found["theirs"] == {
        "name": "theirs",
        "package": "an-extension 1.0",
        "kind": "whole sequence",
        "summary": "Answers what it was told.",
    }
    assert (found["plain"]["kind"], found["plain"]["summary"]) == ("frame by frame", "")
    assert (found["made"]["kind"], found["made"]["summary"]) == ("frame by frame", "A solver that a function makes.")
    assert main(["solvers"]) == 0
    text = capsys.readouterr().out
    assert "theirs: Answers what it was told. [whole sequence, an-extension 1.0]\n" in text
