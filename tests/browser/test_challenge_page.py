"""The page of a challenge as its readers see it: on every screen."""

from collections.abc import Callable
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

from tests.lib.browsing import DESKTOP, PHONE, Visitor
from tests.lib.challenges import vbbench, withheld_challenge
from vbbench.generation.generator import Options


@pytest.fixture(scope="module")
def page_of_challenge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    room = tmp_path_factory.mktemp("challenge")
    folder = withheld_challenge(room / "tiny", "sim", Options(limit=4))
    for solver, team in (("cv", "honest"), ("sf", "cheat")):
        words = ["--solver", solver, "--protocol", "sequential", "--out", room / solver]
        assert vbbench("solve", folder / "data", *words) == 0
        words = ["--challenge", folder, "--team", team, "--date", "2026-12-02"]
        assert vbbench("challenge", "accept", room / solver, *words) == 0
    build = ["leaderboard", "build", "--results", folder / "results", "--out", room / "site"]
    assert vbbench(*build, "--date", "2026-12-03") == 0
    return room / "site"


@pytest.mark.parametrize(("scheme", "screen"), [("light", DESKTOP), ("dark", PHONE)], ids=["light", "phone"])
def test_everybody_can_read_it(
    page_of_challenge: Path, visitor: Callable[..., Visitor], scheme: str, screen: dict[str, int]
) -> None:
    page = visitor(page_of_challenge, color_scheme=scheme, viewport=screen).open()
    assert page.evaluate("document.documentElement.scrollWidth") <= screen["width"]
    expect(page.locator("#standings tbody th").first).to_be_visible()
    results = Axe().run(page, options={"resultTypes": ["violations"], "preload": False})
    assert not results.response["violations"], results.generate_report()
