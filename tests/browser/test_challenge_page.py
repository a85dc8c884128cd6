"""The page of a challenge as its readers see it: which phase is open on their day, on every screen."""

from collections.abc import Callable
from pathlib import Path

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

from tests.lib.browsing import DESKTOP, PHONE, Visitor
from tests.lib.challenges import make_challenge, on, vbbench


@pytest.fixture(scope="module")
def page_of_challenge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_challenge(tmp_path_factory.mktemp("challenge") / "tiny")
    room = folder.parent
    for solver, team in (("cv", "honest"), ("sf", "cheat")):
        words = ["--challenge", folder, "--team", team, "--date", "2026-12-02"]
        assert vbbench("challenge", "accept", room / solver, *words) == 0
    build = ["leaderboard", "build", "--results", folder / "results", "--out", room / "site"]
    with on("2026-12-03"):
        assert vbbench(*build) == 0
    return room / "site"


@pytest.mark.parametrize(
    ("day", "words", "states"),
    [
        ("2026-11-30T23:59:59Z", "No phase is open. Phase development opens on 2026-12-01.", ["not open yet"] * 2),
        ("2026-12-31T23:59:59Z", "Phase development is open, to the end of 2026-12-31", ["open", "not open yet"]),
        ("2027-01-01T00:00:00Z", "No phase is open. Phase final opens on 2027-02-01.", ["closed", "not open yet"]),
        ("2027-02-08T00:00:00Z", "The challenge is over: its last phase closed after 2027-02-07.", ["closed"] * 2),
    ],
)
def test_the_reader_learns_what_holds_on_the_day(
    page_of_challenge: Path, visitor: Callable[..., Visitor], day: str, words: str, states: list[str]
) -> None:
    guest = visitor(page_of_challenge)
    page = guest.context.new_page()
    page.clock.set_fixed_time(day)
    page.goto(f"{guest.root}/index.html")
    expect(page.locator("#now")).to_contain_text(words)
    assert page.locator("#phases .state").all_inner_texts() == states
    assert page.locator("#phases tr[aria-current]").count() == states.count("open")


@pytest.mark.parametrize(("scheme", "screen"), [("light", DESKTOP), ("dark", PHONE)], ids=["light", "phone"])
def test_everybody_can_read_it(
    page_of_challenge: Path, visitor: Callable[..., Visitor], scheme: str, screen: dict[str, int]
) -> None:
    page = visitor(page_of_challenge, color_scheme=scheme, viewport=screen).open()
    assert page.evaluate("document.documentElement.scrollWidth") <= screen["width"]
    expect(page.locator("#standings tbody th").first).to_be_visible()
    results = Axe().run(page, options={"resultTypes": ["violations"], "preload": False})
    assert not results.response["violations"], results.generate_report()
