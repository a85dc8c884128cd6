"""The page around the boards: addresses, explanations, light and dark, paper, and life without scripts or server."""

from collections.abc import Callable

from playwright.sync_api import expect

from tests.lib.browsing import Open, Visitor

DEMO = "#/demo/sequential-noisy"
BACKGROUND = "getComputedStyle(document.body).backgroundColor"
LIGHT = f"{BACKGROUND}.match(/\\d+/g).slice(0, 3).every(part => part > 200)"
DARK = f"{BACKGROUND}.match(/\\d+/g).slice(0, 3).every(part => part < 60)"


def test_a_shared_address_opens_as_it_was(open_page: Open) -> None:
    page = open_page("#/hotel/one-step-ideal?by=dr&order=down&show=vb-cv,sf&columns=all")
    expect(page.locator("#board-table")).to_have_attribute("data-board", "hotel/one-step-ideal")
    expect(page.locator("th[data-column=dr]")).to_have_attribute("aria-sort", "descending")
    expect(page.locator("#board-rows tr:visible")).to_have_count(2)
    expect(page.locator("th[data-column=drift_m]")).to_be_visible()
    expect(page.locator("#board-table")).to_be_in_viewport()
    page.reload()
    expect(page.locator("th[data-column=dr]")).to_have_attribute("aria-sort", "descending")


def test_the_site_works_below_a_servers_folder(visitor: Callable[..., Visitor], address: str) -> None:
    guest = visitor(address)
    page = guest.open("#/hotel/sequential-noisy")
    expect(page.locator("#board-table")).to_have_attribute("data-board", "hotel/sequential-noisy")
    page.locator("#picker [data-split=demo]").click()
    page.locator("#watch").click()
    expect(page.locator("[data-clock]")).to_contain_text("/ 24")
    assert all(asked.startswith((address, "data:")) for asked in guest.asked)


def test_every_explained_word_is_explained_to_those_who_point_and_those_who_hear(open_page: Open) -> None:
    page = open_page(DEMO)
    head, meaning = (
        page.locator("#board-table [data-sort=coverage]"),
        page.locator("#def-coverage").text_content() or "",
    )
    expect(head).to_have_attribute("title", meaning)
    expect(head).to_have_accessible_description(meaning)
    silent = page.locator("[data-def]").evaluate_all(
        "all => all.filter(one => (document.getElementById(one.dataset.def)?.textContent ?? '').length < 20"
        " || one.title !== document.getElementById(one.dataset.def).textContent"
        " || one.getAttribute('aria-describedby') !== one.dataset.def).map(one => one.outerHTML)"
    )
    assert not silent


def test_the_keyboard_alone_sorts_filters_and_switches(open_page: Open) -> None:
    page = open_page(DEMO)
    page.keyboard.press("Tab")
    expect(page.locator(".skip")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("#board-table")).to_be_visible()
    reached = []
    for _ in range(60):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.dataset.sort || document.activeElement.id"))
        if reached[-1] == "dr":
            break
    assert {"filter", "more-columns", "dx", "dr"} <= set(reached)
    page.keyboard.press("Enter")
    expect(page.locator("th[data-column=dr]")).to_have_attribute("aria-sort", "ascending")
    expect(page.locator("#board-table [data-sort=dr]")).to_be_focused()
    outline = page.evaluate("(s => s.outlineStyle + s.boxShadow)(getComputedStyle(document.activeElement))")
    assert outline != "nonenone", "the focus can be seen"


def test_light_and_dark_follow_the_system_until_one_chooses(visitor: Callable[..., Visitor]) -> None:
    guest = visitor(color_scheme="dark")
    page = guest.open(DEMO)
    assert page.evaluate(DARK)
    page.emulate_media(color_scheme="light")
    assert page.evaluate(LIGHT)
    page.locator("#theme").click()
    page.wait_for_function(DARK)
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.reload()
    assert page.evaluate(DARK), "the choice is remembered"
    other = guest.open("#/hotel/rollout-ideal")
    assert other.evaluate(DARK)
    other.locator("#theme").click()
    other.wait_for_function(LIGHT)


def test_without_scripts_the_headlines_can_be_read(open_page: Open) -> None:
    page = open_page(java_script_enabled=False)
    rows = page.locator("#headline tbody tr")
    assert rows.count() >= 1
    expect(rows.first).to_be_visible()
    assert any(letter.isdigit() for letter in rows.first.inner_text())
    assert "need JavaScript" in page.locator("#boards").inner_text()


def test_nothing_moves_for_those_who_want_it_still(open_page: Open) -> None:
    page = open_page(DEMO, reduced_motion="reduce")
    page.locator("#board-table [data-sort=dr]").click()
    page.locator("#theme").click()
    moving = page.evaluate("document.getAnimations().filter(one => one.effect.getTiming().duration > 10).length")
    assert moving == 0
    assert page.evaluate("getComputedStyle(document.documentElement).scrollBehavior") == "auto"
