"""The views beside the boards: a solver's own page, two solvers side by side, and addresses that lead nowhere."""

import re
from collections.abc import Mapping

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.lib.browsing import PHONE, Open
from tests.lib.made_site import STRANGER
from vbbench_leaderboards.results.ranking import capped_errors, contrasts
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.site.words import decimals, figure

Boards = Mapping[Board, tuple[Result, ...]]

DEMO = Board(split="demo", tier="noisy", protocol="sequential")
KITTI = Board(split="kitti", tier="footage", protocol="sequential")
COMPARED = f"#/{DEMO.key}/compare?a=vb-cv&b=cv"


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


def test_two_solvers_differ_by_what_the_build_found(open_page: Open, boards: Boards) -> None:
    page = open_page(f"#/{KITTI.key}")
    page.locator("#compare").click()
    expect(page.locator("#comparison-title")).to_be_focused()
    rows = boards[KITTI]
    found, names, (_, figures, _) = contrasts(rows), [row.solver for row in rows], capped_errors(rows)
    for a, b in (("cv", "map-batch"), ("vb-sf", "vb-cv")):
        page.locator("#side-a").select_option(a)
        page.locator("#side-b").select_option(b)
        i, j = names.index(a), names.index(b)
        own = found[min(i, j), max(i, j)]["dx"]
        difference = own.difference if i < j else -own.difference
        cells = page.locator("#differences tr[data-metric=dx] td").all_inner_texts()
        most = decimals([difference])
        assert cells[2].split()[0] == ("+" if difference > 0 else "−") + figure(abs(difference), most)
        better = int(np.sum(figures[i, :, 1] < figures[j, :, 1]))
        assert cells[4] == f"{better} of {own.sequences}"
        assert page.title().startswith(f"{a} and {b} on kitti")
        assert f"a={a}&b={b}" in page.url
    verdict = page.locator(".verdict").inner_text()
    assert ("Nothing is settled" in verdict or "Too few" in verdict) == (not own.p < 0.05)


def test_the_sequences_where_they_differ_most_are_one_click_from_the_player(open_page: Open) -> None:
    page = open_page(COMPARED)
    watch = page.locator(".extremes a").first
    sequence = (watch.inner_text()).split()[-1]
    watch.click()
    expect(page.locator("[data-clock]")).to_be_visible()
    assert f"sequence={sequence}" in page.url
    assert "solvers=vb-cv,cv" in page.url
    assert page.title().startswith("Sequences of demo, sequential, noisy")
    page.go_back()
    expect(page.locator("#comparison-title")).to_be_visible()


def test_the_comparison_follows_the_keyboard(open_page: Open) -> None:
    page = open_page(COMPARED)
    page.locator("#swap").focus()
    page.keyboard.press("Enter")
    expect(page.locator("#side-a")).to_have_value("cv")
    expect(page.locator("#swap")).to_be_focused()
    page.locator("#by-dr").focus()
    page.keyboard.press("Space")
    expect(page.locator("#by-dr")).to_have_attribute("aria-pressed", "true")
    expect(page.locator("#by-dr")).to_be_focused()
    expect(page.locator("#by-dr")).to_have_attribute("title", page.locator("#def-dr").text_content() or "")
    page.keyboard.press("Escape")
    expect(page.locator("#board-table")).to_have_attribute("data-board", DEMO.key)
    expect(page.locator("#board-title")).to_be_focused()


def test_a_comparison_with_nobody_is_with_somebody_else_and_says_so(open_page: Open) -> None:
    page = open_page(f"#/{DEMO.key}/compare?a=nobody&b={STRANGER}")
    expect(page.locator(".verdict")).to_contain_text("No solver nobody is on this board")
    expect(page.locator("#side-b")).to_have_value(STRANGER)


def test_figures_are_written_alike_by_the_build_and_by_the_page(open_page: Open) -> None:
    page = open_page(COMPARED)
    expect(page.locator("#differences")).to_be_visible()
    values = [0.786, 1.244, 0.0432, 0.0076, 12.44, 124.4, 5667.0, 0.9996, 0.0, 0.00001, 2.0]
    for most in (2, 3, 4):
        shown = page.evaluate("([all, most]) => all.map(one => vbbench.figures.figure(one, most))", [values, most])
        assert shown == [figure(value, most) for value in values]
    for column in ([0.66, 1.9], [0.036, 0.1], [0.0076], [1e-7], []):
        assert page.evaluate("all => vbbench.figures.decimals(all)", column) == decimals(column)


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
