"""Pictures of the site in all its states, to be looked at: ``python -m tests.lib.pictures SITE OUT``."""

import sys
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

from tests.lib.browsing import DESKTOP, PHONE, launch, visit

BOARD = "#/hotel/sequential-field"
PLAY = "#/students-resampled/sequential-field/play?frame=30"
STATES: dict[str, tuple[str, dict[str, Any], str]] = {
    "front": ("", {}, "window"),
    "front-dark": ("", {"color_scheme": "dark"}, "window"),
    "front-phone": ("", {"viewport": PHONE}, "whole"),
    "board": (BOARD, {}, "#boards"),
    "board-dark": (BOARD, {"color_scheme": "dark"}, "#boards"),
    "board-phone": (BOARD, {"viewport": PHONE}, "#boards"),
    "board-all-columns": (f"{BOARD}?columns=all&by=dt_p95&order=down", {}, "#boards"),
    "board-filtered": (f"{BOARD}?show=vb-cv,sf", {}, "#boards"),
    "caution": ("#/kitti/sequential-footage", {}, "#boards"),
    "caution-dark-phone": ("#/kitti/sequential-footage", {"viewport": PHONE, "color_scheme": "dark"}, "#boards"),
    "paper": ("#/hotel/one-step-ideal", {}, "#boards"),
    "folds": (BOARD, {}, "folds"),
    "tip": (BOARD, {}, "tip"),
    "play": (PLAY, {}, "#boards"),
    "play-dark": (PLAY, {"color_scheme": "dark"}, "#boards"),
    "play-phone": (PLAY, {"viewport": PHONE, "device_scale_factor": 2}, "#boards"),
    "play-sim": ("#/sim/sequential-field/play?frame=10", {}, "#boards"),
    "play-hotel": ("#/hotel/rollout-field/play?frame=12", {}, "#boards"),
    "compare": (f"{BOARD}/compare?a=vb-cv&b=vb-sf", {}, "#comparison"),
    "compare-dark-phone": (f"{BOARD}/compare?a=vb-cv&b=cv", {"viewport": PHONE, "color_scheme": "dark"}, "#comparison"),
    "solver": ("#/solver/vb-cv", {}, "#page"),
    "solver-dark": ("#/solver/map-causal", {"color_scheme": "dark"}, "#page"),
    "solver-phone": ("#/solver/vb-cv", {"viewport": PHONE}, "#page"),
    "nowhere": ("#/hotle/sequential-feild", {}, "window"),
    "meanings": ("", {}, "#meanings"),
    "take-part": ("", {}, "#take-part"),
    "print": (BOARD, {}, "print"),
    "no-scripts": ("", {"java_script_enabled": False}, "whole"),
}


def main(site: Path, out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = launch(playwright)
        for name, (address, options, what) in STATES.items():
            with visit(browser, site, **{"viewport": DESKTOP, **options}) as visitor:
                page = visitor.open(address)
                page.wait_for_timeout(600)
                take(page, what, out / f"{name}.png")
                width = page.evaluate("document.documentElement.scrollWidth")
                sys.stdout.write(" ".join([name, str(width), *visitor.faults]) + "\n")
        browser.close()


def take(page: Page, what: str, path: Path) -> None:
    """A part of the page by its selector, or one of a few other ways to look at it."""
    if what == "window":
        page.screenshot(path=path)
    elif what == "whole":
        page.screenshot(path=path, full_page=True)
    elif what == "print":
        page.emulate_media(media="print")
        page.screenshot(path=path, full_page=True)
    elif what == "tip":
        page.locator("[data-sort=dx_rel]").focus()
        page.screenshot(path=path)
    elif what == "folds":
        for fold in page.locator("details").all():
            fold.evaluate("one => { one.open = true; }")
        page.locator("#boards").screenshot(path=path)
    else:
        page.locator(what).screenshot(path=path)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
