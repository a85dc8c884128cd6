"""The views beside the boards: a solver's own page, and addresses that lead nowhere."""

import re
from collections.abc import Mapping

import pytest
from playwright.sync_api import expect

from tests.lib.browsing import PHONE, Open
from vbbench_leaderboards.results.result import Board, Result

Boards = Mapping[Board, tuple[Result, ...]]

DEMO = Board(split="demo", tier="noisy", protocol="sequential")
KITTI = Board(split="kitti", tier="footage", protocol="sequential")


@pytest.mark.parametrize(
    "address", ["#/nothing/here", "#/hotel", "#/hotel/sequential-field/plya", "#/solver/vb-vc", "#/%E0%A4%A"]
)
def test_an_unknown_address_says_so_and_leads_to_the_boards(address: str, open_page: Open) -> None:
    page = open_page(address)
    title = page.locator("#missing-title")
    expect(title).to_have_text(re.compile("No (board|solver) of this name is here|There is no such page"))
    expect(title).to_be_focused()
    expect(page.locator("#board-table")).to_be_hidden()
    expect(page.locator("#page code")).to_have_text(address)
    assert page.title().startswith("No such page")
    page.locator("#page a").click()
    expect(page.locator("#board-table")).to_be_visible()


def test_options_that_a_board_does_not_have_are_named(open_page: Open) -> None:
    page = open_page("#/hotel/rollout-noisy?by=nonsense&show=sf,nobody&order=sideways&colour=red")
    note = page.locator("#board-note")
    for word in ("nonsense", "nobody", "sideways", "colour"):
        expect(note).to_contain_text(word)
    expect(page.locator("#board-rows tr:visible")).to_have_count(1)
    plain = open_page("#/hotel/rollout-noisy?by=dt&show=sf")
    expect(plain.locator("#board-rows tr:visible")).to_have_count(1)
    expect(plain.locator("#board-note")).to_be_hidden()
    unseen = open_page(f"#/{KITTI.key}/play")
    expect(unseen.locator("#board-note")).to_contain_text("cannot be watched")


def test_a_name_leads_to_the_solvers_page_and_back(open_page: Open, boards: Boards) -> None:
    page = open_page(f"#/{KITTI.key}")
    page.locator("#board-table").get_by_role("link", name="vb-sf").click()
    expect(page.locator("#solver-title")).to_be_focused()
    expect(page.locator("#solver-title")).to_have_text("vb-sf")
    assert page.title().startswith("vb-sf")
    expect(page.locator(".hero")).to_be_hidden()
    shown = page.locator("#every a").evaluate_all("all => all.map(one => one.getAttribute('href'))")
    assert set(shown) == {f"#/{board.key}" for board, rows in boards.items() if any(r.solver == "vb-sf" for r in rows)}
    page.locator(f"#page a[href='#/{KITTI.key}']").first.click()
    expect(page.locator("#board-table")).to_have_attribute("data-board", KITTI.key)
    expect(page.locator("#board-table")).to_be_in_viewport()
    page.go_back()
    expect(page.locator("#solver-title")).to_be_visible()
    page.locator(".top").get_by_role("link", name="What it means").click()
    expect(page.locator("#meanings")).to_be_in_viewport()
    expect(page.locator("#solver-title")).to_be_hidden()


def test_a_phone_shows_rank_name_and_the_figure_that_ranks(open_page: Open) -> None:
    page = open_page("#/hotel/one-step-ideal", viewport={**PHONE, "width": 390})
    frame = page.locator("#board .scroll").first
    assert frame.evaluate("one => one.scrollWidth <= one.clientWidth")
    shown = "all => all.filter(one => one.checkVisibility()).map(one => one.dataset.column)"
    heads = page.locator("#board-table thead th")
    assert heads.evaluate_all(shown) == ["rank", "solver", "dx"]
    expect(page.locator("#board-rows tr").first.locator("td[data-column=dx] .ci")).to_be_visible()
    page.locator("[data-choose=dr]").click()
    assert heads.evaluate_all(shown) == ["rank", "solver", "dr"]
    page.locator("#more-columns").click()
    assert "coverage" in heads.evaluate_all(shown)
    lead = page.locator(".headlines .scroll")
    assert lead.evaluate("one => one.scrollWidth <= one.clientWidth"), "the first table has no hidden part"
    expect(page.locator("#headline td").last).to_be_visible()
