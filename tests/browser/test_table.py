"""The boards' tables: order, filters, ranks, cautions and the paper's rows, against the files of results."""

import re
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.lib.made_site import HOSTILE, STRANGER, TWIN
from vbbench.paper import the_paper
from vbbench_leaderboards.results.ranking import rank_apart
from vbbench_leaderboards.results.result import Board, Result

Boards = Mapping[Board, tuple[Result, ...]]
Open = Callable[..., Page]

DEMO = Board(split="demo", tier="noisy", protocol="sequential")
KITTI = Board(split="kitti", tier="footage", protocol="sequential")
HOTEL = Board(split="hotel", tier="noisy", protocol="sequential")
SPLITS = ("demo", "hotel")
METRICS = ("dx_rel", "dx", "dr", "dt")


def on_board(page: Page, board: Board) -> None:
    expect(page.locator("#board-table")).to_have_attribute("data-board", board.key)


def opened(open_page: Open, board: Board, **state: str) -> Page:
    """The page of a board, when its table is there."""
    query = "&".join(f"{name}={value}" for name, value in state.items())
    page = open_page(f"#/{board.key}{'?' if query else ''}{query}")
    on_board(page, board)
    return page


def solvers(page: Page) -> list[str]:
    rows = page.locator("#board-rows tr:visible")
    return rows.evaluate_all("rows => rows.map(row => row.dataset.solver)")


def figure(result: Result, column: str) -> Any:
    """What a column shows of a result."""
    metric, _, summary = column.rpartition("_")
    if column in METRICS:
        return result.score["metrics"][column]["capped"]
    if metric in METRICS and summary in ("median", "mean", "p95"):
        return result.score["metrics"][metric][summary]
    if column.startswith("drift"):
        return result.score["drift"][column]["capped"]
    if column == "failures":
        return result.score["metrics"]["dx"]["failure_rate"]
    own = {"solver": result.solver, "coverage": result.score["coverage"], "time": result.score["seconds_per_frame"]}
    return own[column]


@pytest.mark.parametrize("board", [DEMO, HOTEL], ids=SPLITS)
def test_every_column_sorts_both_ways(board: Board, open_page: Open, boards: Boards) -> None:
    page = opened(open_page, board)
    page.locator("#more-columns").click()
    figures = {result.solver: result for result in boards[board]}
    columns = page.locator("#board-table [data-sort]:visible").evaluate_all("all => all.map(one => one.dataset.sort)")
    assert {"solver", "coverage", "time", "drift_m", "drift_rad", *METRICS, "dx_median", "dt_p95"} <= set(columns)
    for column in columns:
        head = page.locator(f"#board-table th[data-column={column}]")
        directions = set()
        for _ in range(2):
            head.get_by_role("button").click()
            direction = head.get_attribute("aria-sort")
            directions.add(direction)
            if column not in ("rank", "version", "hardware"):
                values = [figure(figures[name], column) for name in solvers(page)]
                assert values == sorted(values, reverse=direction == "descending"), column
        assert directions == {"ascending", "descending"}, column
        assert page.locator("#board-table th[aria-sort=ascending], #board-table th[aria-sort=descending]").count() == 1


@pytest.mark.parametrize("board", [DEMO, HOTEL], ids=SPLITS)
def test_solvers_share_a_rank_where_nothing_is_settled(board: Board, open_page: Open, boards: Boards) -> None:
    page = opened(open_page, board, by="dt")
    rankings = rank_apart(boards[board])
    for metric in ("dt", "dx", "drift_m"):
        if metric == "drift_m":
            page.locator("#more-columns").click()
        if metric != "dt":
            page.locator(f"#board-table [data-sort={metric}]").click()
        for solver, place in rankings[metric].places.items():
            cell = page.locator(f"#board-table tr[data-solver='{solver}'] td.rank")
            wanted = [place.rank] if place.best == place.worst else [place.rank, place.best, place.worst]
            assert [int(n) for n in re.findall(r"\d+", cell.inner_text())] == wanted, (metric, solver)
    if board == DEMO:
        assert len({rankings["dx"].places[solver].rank for solver in (STRANGER, TWIN)}) == 1


def test_words_filter_the_rows(open_page: Open) -> None:
    page = opened(open_page, DEMO)
    find = page.get_by_role("searchbox")
    find.fill("VB-")
    expect(page.locator("#board-rows tr:visible")).to_have_count(2)
    assert set(solvers(page)) == {"vb-cv", "vb-sf"}
    find.fill("nobody is called so")
    expect(page.locator("#nothing-found")).to_be_visible()
    find.fill("")
    expect(page.locator("#board-rows tr:visible")).to_have_count(5)
    expect(page.locator("#nothing-found")).to_be_hidden()


def test_solvers_can_be_left_out_and_the_address_says_so(open_page: Open) -> None:
    page = opened(open_page, DEMO)
    page.locator("#chips").get_by_label("sf", exact=True).uncheck()
    page.locator("#chips").get_by_label(STRANGER).uncheck()
    expect(page.locator("#board-rows tr:visible")).to_have_count(3)
    assert set(solvers(page)) == {"cv", "vb-cv", "vb-sf"}
    again = page.context.new_page()
    again.goto(page.url)
    expect(again.locator("#board-rows tr:visible")).to_have_count(3)
    assert solvers(again) == solvers(page)


def test_split_protocol_and_tier_are_switched(open_page: Open) -> None:
    page = opened(open_page, HOTEL)
    picker = page.locator("#picker")
    picker.locator("#kept summary").click()
    picker.locator("[data-split=eth]").click()
    on_board(page, Board(split="eth", tier="noisy", protocol="sequential"))
    picker.locator("[data-protocol=rollout]").click()
    on_board(page, Board(split="eth", tier="noisy", protocol="rollout"))
    picker.locator("[data-tier=ideal]").click()
    on_board(page, Board(split="eth", tier="ideal", protocol="rollout"))
    assert picker.locator("[aria-current=true], [aria-current=page]").count() == 3
    page.go_back()
    on_board(page, Board(split="eth", tier="noisy", protocol="rollout"))
    page.go_back()
    page.go_back()
    on_board(page, HOTEL)
    page.go_forward()
    on_board(page, Board(split="eth", tier="noisy", protocol="sequential"))


def test_a_tier_that_a_split_does_not_have_leads_to_one_that_has_it(open_page: Open) -> None:
    page = opened(open_page, KITTI)
    page.locator("#picker [data-tier=field]").click()
    expect(page.locator("#board-table")).to_have_attribute("data-board", re.compile(".*/sequential-field"))


def test_who_sees_the_future_stays_below_however_the_table_is_sorted(open_page: Open) -> None:
    page = opened(open_page, KITTI, by="solver", order="down")
    assert solvers(page) == ["vb-sf", "vb-cv", "sf", "map-causal", "cv"]
    late = page.locator("#late-rows tr")
    expect(late).to_have_count(1)
    expect(page.locator("#board-table tbody.apart")).to_contain_text("ranked among themselves")
    page.locator("#chips").get_by_label("map-batch").uncheck()
    expect(page.locator("#board-table tbody.apart")).to_be_hidden()


def test_the_papers_rows_are_quoted_and_take_no_rank(open_page: Open) -> None:
    board = Board(split="hotel", tier="ideal", protocol="one-step")
    page = opened(open_page, board)
    quoted = page.locator("#board-table .quoted")
    expect(quoted.locator("tr").first).to_contain_text("not measured here, not ranked")
    expect(quoted.locator("tr").first).to_contain_text("The paper's text describes sequential")
    printed = the_paper().select("hotel", "ideal")
    wanted = {
        row.solver: [f"{row.figures[metric]:.3f}" for metric in METRICS if metric in row.figures] for row in printed
    }
    for row in quoted.locator("tr").all()[1:]:
        assert row.locator("td").first.inner_text() == ""
        name = row.locator("th").inner_text().split("\n")[0]
        assert re.findall(r"\d\.\d+", row.inner_text()) == wanted[name]
        assert re.search("read as one-step|no single reading fits", row.inner_text())
    page.locator("[data-sort=dt]").click()
    assert page.locator("#board-table tbody").last.get_attribute("class") == "quoted"


def test_a_strangers_words_are_words(open_page: Open) -> None:
    page = opened(open_page, DEMO)
    expect(page.locator("#who")).to_contain_text(HOSTILE)
    row = page.locator(f"#board-rows tr[data-solver='{STRANGER}']")
    assert page.locator("#who img").count() == 0
    assert row.locator("img").count() == 0
    assert row.get_by_role("link", name=STRANGER).get_attribute("href") == f"#/solver/{STRANGER}"
    assert row.get_by_role("link", name="code").get_attribute("href") == "https://example.org/?a=1&b=2"
