"""The boards' tables: order, filters, ranks, cautions and the paper's rows, against the files of results."""

import re
from collections.abc import Mapping
from typing import Any

from playwright.sync_api import Page, expect

from tests.lib.browsing import Open
from tests.lib.made_site import HOSTILE, STRANGER, TWIN
from vbbench_leaderboards.results.ranking import rank_apart
from vbbench_leaderboards.results.result import Board, Result

Boards = Mapping[Board, tuple[Result, ...]]

DEMO = Board(split="demo", tier="noisy", protocol="sequential")
KITTI = Board(split="kitti", tier="footage", protocol="sequential")
HOTEL = Board(split="hotel", tier="noisy", protocol="sequential")
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


def test_every_column_sorts_both_ways(open_page: Open, boards: Boards) -> None:
    page = opened(open_page, DEMO)
    page.locator("#more-columns").click()
    figures = {result.solver: result for result in boards[DEMO]}
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


def test_solvers_share_a_rank_where_nothing_is_settled(open_page: Open, boards: Boards) -> None:
    page = opened(open_page, DEMO, by="dt")
    rankings = rank_apart(boards[DEMO])
    for metric in ("dt", "dx", "drift_m"):
        if metric == "drift_m":
            page.locator("#more-columns").click()
        if metric != "dt":
            page.locator(f"#board-table [data-sort={metric}]").click()
        for solver, place in rankings[metric].places.items():
            cell = page.locator(f"#board-table tr[data-solver='{solver}'] td.rank")
            wanted = [place.rank] if place.best == place.worst else [place.rank, place.best, place.worst]
            assert [int(n) for n in re.findall(r"\d+", cell.inner_text())] == wanted, (metric, solver)
    assert len({rankings["dx"].places[solver].rank for solver in (STRANGER, TWIN)}) == 1


def test_words_filter_the_rows_and_solvers_can_be_hidden_by_the_address_too(open_page: Open) -> None:
    page = opened(open_page, DEMO)
    find, shown = page.get_by_role("searchbox"), page.locator("#board-rows tr:visible")
    find.fill("VB-")
    expect(shown).to_have_count(2)
    assert set(solvers(page)) == {"vb-cv", "vb-sf"}
    find.fill("nobody is called so")
    expect(page.locator("#nothing-found")).to_be_visible()
    find.fill("")
    expect(shown).to_have_count(5)
    expect(page.locator("#nothing-found")).to_be_hidden()
    for name in ("sf", STRANGER):
        page.locator("#chips").get_by_label(name, exact=True).uncheck()
    expect(shown).to_have_count(3)
    assert set(solvers(page)) == {"cv", "vb-cv", "vb-sf"}
    again = page.context.new_page()
    again.goto(page.url)
    expect(again.locator("#board-rows tr:visible")).to_have_count(3)
    assert solvers(again) == solvers(page)


def test_split_protocol_and_tier_are_switched(open_page: Open) -> None:
    page = opened(open_page, HOTEL)
    picker = page.locator("#picker")
    picker.locator("#kept summary").click()
    chosen = [Board(split="eth", tier=t, protocol=p) for t, p in (("noisy", "sequential"), ("noisy", "rollout"))]
    for choice, board in zip(("split=eth", "protocol=rollout"), chosen, strict=True):
        picker.locator(f"[data-{choice}]").click()
        on_board(page, board)
    picker.locator("[data-tier=ideal]").click()
    on_board(page, Board(split="eth", tier="ideal", protocol="rollout"))
    assert picker.locator("[aria-current=true], [aria-current=page]").count() == 3
    for board in (*reversed(chosen), HOTEL):
        page.go_back()
        on_board(page, board)
    page.go_forward()
    on_board(page, chosen[0])


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


def test_a_strangers_words_are_words(open_page: Open) -> None:
    page = opened(open_page, DEMO)
    expect(page.locator("#who")).to_contain_text(HOSTILE)
    assert page.locator("#board img").count() == 0
