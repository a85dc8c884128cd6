"""The whole site, as `make site` leaves it in out/site: pages, search, light and dark, phone, the way to the boards."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.conftest import serve
from tests.browser.test_accessibility import ALL, COLOURS
from tests.lib.browsing import DESKTOP, PHONE, Visitor

Visit = Callable[..., Visitor]

ROOT = Path(__file__).parents[2]
SITE = ROOT / "out" / "site"
RESULTS = ROOT / "leaderboards" / "results" / "hotel" / "sequential-field"
PAGES = {
    "front": "index",
    "section": "how-to/index",
    "tutorial": "tutorials/first-result",
    "notebook": "tutorials/notebooks/first_result",
    "commands": "commands",
    "tables": "real-cameras",
    "reference": "reference/api",
}
SHOWN = {"light": "rgb(255, 255, 255)", "dark": "rgb(20, 24, 30)"}


@pytest.fixture(scope="module")
def folder() -> Path:
    if not (SITE / "leaderboard" / "index.html").is_file():
        pytest.skip("no site: make site")
    return SITE


@pytest.fixture(scope="module")
def served(folder: Path) -> Iterator[str]:
    with serve(folder) as address:
        yield address


def opened(guest: Visitor, page: str) -> Page:
    window = guest.context.new_page()
    window.goto(f"{guest.root}/{page}")
    expect(window.locator("h1").first).to_be_visible()
    return window


def test_the_front_page_leads_to_every_way_in(folder: Path, visitor: Visit) -> None:
    page = opened(visitor(folder), "index.html")
    assert page.evaluate("[...document.images].every(one => one.complete && one.naturalWidth)")
    solvers = page.locator(".headline tbody tr code").all_inner_texts()
    assert sorted(solvers) == sorted(result.stem for result in RESULTS.glob("*.json"))
    expect(page.locator(".sd-card")).to_have_count(3)
    page.get_by_role("link", name="Bring a solver").click()
    expect(page.locator("article h1")).to_contain_text("Your solver")


def test_the_leaderboard_is_one_click_from_everywhere(folder: Path, visitor: Visit) -> None:
    page = opened(visitor(folder), "tutorials/notebooks/own_solver.html")
    page.get_by_role("link", name="Leaderboard", exact=True).first.click()
    expect(page.locator("#board-table")).to_be_visible()
    page.go_back()
    page.goto(f"{folder.as_uri()}/index.html")
    page.locator(".headline").get_by_role("link", name="hotel").click()
    expect(page.locator("#board-table")).to_have_attribute("data-board", "hotel/sequential-field")


def test_search_finds_a_word(served: str, visitor: Visit) -> None:
    page = opened(visitor(served), "files.html")
    page.keyboard.press("Control+k")
    page.keyboard.type("rollout")
    page.keyboard.press("Enter")
    found = page.locator("#search-results li a")
    expect(found.filter(has_text="Protocols and metrics").first).to_be_visible()
    found.filter(has_text="Protocols and metrics").first.click()
    expect(page.locator("article h1")).to_contain_text("Protocols and metrics")


@pytest.mark.parametrize("scheme", SHOWN)
def test_it_is_as_light_or_dark_as_the_reader_has_it(scheme: str, folder: Path, visitor: Visit) -> None:
    page = opened(visitor(folder, color_scheme=scheme), "trust.html")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == SHOWN[scheme]


def test_the_copy_button_takes_commands_alone(served: str, visitor: Visit) -> None:
    guest = visitor(served)
    guest.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page = opened(guest, "tutorials/first-result.html")
    block = page.locator(".highlight").filter(has_text="vbbench demo --out demo").first
    block.hover()
    block.locator("button.copybtn").click()
    expect(block.locator("button.copybtn")).to_have_class(re.compile("success"))
    assert page.evaluate("navigator.clipboard.readText()") == "vbbench demo --out demo"


def test_every_kind_of_page_fits_a_phone(folder: Path, visitor: Visit) -> None:
    guest = visitor(folder, viewport=PHONE, has_touch=True, is_mobile=True, device_scale_factor=2)
    for name, address in PAGES.items():
        page = opened(guest, f"{address}.html")
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"], name
        assert page.evaluate("visualViewport.width") == PHONE["width"], name
        page.close()


@pytest.mark.parametrize(
    ("scheme", "screen", "rules", "names"),
    [("light", DESKTOP, ALL, "front tutorial notebook reference"), ("dark", PHONE, COLOURS, "front notebook")],
    ids=["light", "dark"],
)
def test_nothing_stands_in_the_way_of_anybody(
    scheme: str, screen: dict[str, int], rules: dict[str, Any], names: str, folder: Path, visitor: Visit
) -> None:
    guest = visitor(folder, color_scheme=scheme, viewport=screen)
    for name in names.split():
        page = opened(guest, f"{PAGES[name]}.html")
        found = Axe().run(page, options=rules)
        bad = [one for one in found.response["violations"] if one["impact"] in ("serious", "critical")]
        assert not bad, f"{name}: {found.generate_report()}"
        page.close()
