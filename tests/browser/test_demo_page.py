"""The page of ``vbbench demo``: its player is shown whole, on a desk and on a phone."""

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.lib.browsing import DESKTOP, PATIENCE, PHONE, visit
from vbbench_leaderboards import demo

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.fixture(scope="module")
def page_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("demo") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(demo, "SEQUENCES", 2)
        demo.make_demo(out)
    return out


@pytest.mark.parametrize("size", [DESKTOP, {"width": 420, "height": 900}, PHONE], ids=["desktop", "420 px", "phone"])
def test_the_frame_is_as_high_as_its_player(browser: "Browser", page_folder: Path, size: dict[str, int]) -> None:
    with visit(browser, page_folder, viewport=size) as visitor:
        page = visitor.open()
        frame = page.locator("iframe")
        frame.scroll_into_view_if_needed()
        page.wait_for_function("document.querySelector('iframe').style.height", timeout=PATIENCE)
        inner = page.frame_locator("iframe")
        inner.locator("[data-clock]").wait_for()
        inner.locator(".player-said").scroll_into_view_if_needed()
        page.wait_for_timeout(300)
        room = inner.locator("html").evaluate("html => [html.clientHeight, html.scrollHeight]")
        assert room[0] >= room[1]
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
