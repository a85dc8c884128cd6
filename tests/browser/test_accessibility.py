"""axe-core on every kind of page, light and dark, wide and narrow: nothing serious."""

from collections.abc import Callable

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.browser.browsing import DESKTOP, PHONE

Open = Callable[..., Page]

PLACES = {
    "front": ("", "#board-table"),
    "board": ("#/hotel/one-step-ideal?columns=all", "#board-table"),
    "caution": ("#/demo/sequential-noisy", "#caution"),
    "player": ("#/demo/sequential-noisy/play?frame=5", "[data-clock]"),
}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("screen", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_nothing_serious(scheme: str, screen: dict[str, int], open_page: Open) -> None:
    for name, (address, shown) in PLACES.items():
        page = open_page(address, color_scheme=scheme, viewport=screen)
        expect(page.locator(shown)).to_be_visible()
        for fold in page.locator("details").all():
            fold.evaluate("one => { one.open = true; }")
        results = Axe().run(page)
        bad = [one for one in results.response["violations"] if one["impact"] in ("serious", "critical")]
        assert not bad, f"{name}: {results.generate_report()}"
        page.close()
