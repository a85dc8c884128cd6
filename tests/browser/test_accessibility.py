"""Every kind of page, light and dark, wide and narrow: axe-core has no finding, and a phone holds it all."""

from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

from tests.lib.browsing import DESKTOP, PHONE, Open

PLACES = {
    "board": ("#/hotel/one-step-ideal?columns=all", "#board-table"),
    "caution": ("#/demo/sequential-noisy", "#caution"),
    "player": ("#/demo/sequential-noisy/play?frame=5", "[data-clock]"),
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


SIZE = 24  # px, WCAG 2.2, 2.5.8

CONTROLS = """size => {
  const faults = [];
  const inline = (one) => one.tagName === 'A' && getComputedStyle(one).display === 'inline';
  for (const one of document.querySelectorAll('a, button, input, select, summary')) {
    if (!one.checkVisibility({ visibilityProperty: true }) || one.disabled || one.closest('.skip, .unseen')) continue;
    const target = one.closest('label') || one;
    target.scrollIntoView({ block: 'center', inline: 'center', behavior: 'instant' });
    const box = target.getBoundingClientRect(), words = `${one.outerHTML.slice(0, 90)} `;
    if (!inline(one) && (box.width < size - 0.5 || box.height < size - 0.5)) {
      faults.push(`${words} is ${box.width.toFixed()} × ${box.height.toFixed()}`);
    }
    const own = one.getClientRects()[0];
    const found = document.elementFromPoint(own.x + own.width / 2, own.y + own.height / 2);
    if (!found || !(target.contains(found) || found.contains(one))) {
      faults.push(`${words} cannot be pressed: ${found && found.outerHTML.slice(0, 60)} lies there`);
    }
  }
  return faults;
}"""


@pytest.mark.parametrize("place", PLACES)
def test_a_narrow_screen_holds_it_all(place: str, open_page: Open) -> None:
    address, shown = PLACES[place]
    page = open_page(address, viewport=PHONE, has_touch=True, is_mobile=True, device_scale_factor=2)
    expect(page.locator(shown)).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    assert page.evaluate("visualViewport.width") == PHONE["width"]
    assert not page.evaluate(CONTROLS, SIZE)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
