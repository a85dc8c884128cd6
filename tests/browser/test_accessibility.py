"""axe-core on every kind of page, light and dark, wide and narrow: no finding."""

from collections.abc import Callable
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.lib.browsing import DESKTOP, PHONE

Open = Callable[..., Page]

PLACES = {
    "board": ("#/hotel/one-step-ideal?columns=all", "#board-table"),
    "caution": ("#/demo/sequential-noisy", "#caution"),
    "player": ("#/demo/sequential-noisy/play?frame=5", "[data-clock]"),
    "comparison": ("#/demo/sequential-noisy/compare?a=vb-cv&b=cv", "#differences"),
    "solver": ("#/solver/vb-cv", "#every"),
    "nowhere": ("#/nothing/here", "#missing-title"),
}
ALL = {"resultTypes": ["violations"], "preload": False}  # to load style sheets anew is refused on file://
COLOURS = {**ALL, "runOnly": ["color-contrast"]}


@pytest.mark.parametrize(
    ("scheme", "screen", "rules"),
    [("light", DESKTOP, ALL), ("light", PHONE, ALL), ("dark", DESKTOP, COLOURS)],
    ids=["light", "phone", "dark"],
)
def test_no_finding(scheme: str, screen: dict[str, int], rules: dict[str, Any], open_page: Open) -> None:
    for name, (address, shown) in PLACES.items():
        page = open_page(address, color_scheme=scheme, viewport=screen)
        expect(page.locator(shown)).to_be_visible()
        for fold in page.locator("details").all():
            fold.evaluate("one => { one.open = true; }")
        results = Axe().run(page, options=rules)
        assert not results.response["violations"], f"{name}: {results.generate_report()}"
        page.close()
