"""What the player says of errors: the moment it opens at, what leaves the map, who has no box, who is nobody."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.lib.browsing import Visitor
from tests.lib.made_player import MOUNT, gone_astray, hidden_people, with_false_alarm, write_crowd, write_page
from tests.lib.made_sequence import made_sequence
from vbbench_leaderboards.site.clip import Reason

PHONE = {"width": 390, "height": 844}
ASTRAY, ALARM = 7, 3
READY = "vbbench.player.session?.moment?.others"
OUTSIDE = "vbbench.player.session.views.map.outside"
Open = Callable[..., Page]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """44 people, two without a box, a false alarm; of three solvers one goes astray, by 80 m, in frame 7."""
    site = tmp_path_factory.mktemp("crowd")
    made = with_false_alarm(made_sequence(44, 14, share=1.0, seed=2), ALARM)
    places = made.truth.poses[0, :2] + np.array([(2.0, 1.0), (-2.0, 3.0)])
    answers = {
        "near": gone_astray(made, 14, (0.0, 0.0)),
        "wide": gone_astray(made, 14, (0.0, 0.0), error=0.4),
        "lost": gone_astray(made, ASTRAY, (80.0, 0.0)),
    }
    write_crowd(site, made, answers, hidden_people(made, places, [Reason.HIDDEN, Reason.MISSED]))
    write_page(site)
    return site


@pytest.fixture
def play(visitor: Callable[..., Visitor]) -> Open:
    """Open the player on the crowd in a state as an address has it; options as for `visit`."""

    def open_it(state: dict[str, Any], **options: Any) -> Page:
        page = visitor(**options).open(wait="main h1")
        page.wait_for_function("vbbench.made")
        page.evaluate(MOUNT, state)
        page.wait_for_function(READY)
        return page

    return open_it


def clock(page: Page) -> str:
    return page.locator("[data-clock]").inner_text()


def test_it_opens_where_a_solver_goes_astray(play: Open) -> None:
    page = play({"solvers": "lost"})
    assert clock(page).startswith(f"{ASTRAY} /")
    page = play({"solvers": "near,lost"})
    assert clock(page).startswith(f"{ASTRAY} /")
    expect(page.locator("[data-pair]")).to_contain_text("near is nearer the truth in")
    page.keyboard.press("End")
    expect(page.locator("[data-clock]")).to_contain_text("13 /")
    page.keyboard.press("w")
    expect(page.locator("[data-clock]")).to_contain_text(f"{ASTRAY} /")
    page.keyboard.press("w")
    expect(page.locator("[data-clock]")).not_to_contain_text(f"{ASTRAY} /")


def test_an_address_with_a_frame_opens_there(play: Open) -> None:
    page = play({"solvers": "lost", "frame": 3})
    assert clock(page).startswith("3 /")


def test_two_solvers_are_shown_at_first_the_best(play: Open) -> None:
    page = play({})
    assert page.locator("[data-solvers] input:checked").evaluate_all("all => all.map(one => one.value)") == [
        "near",
        "wide",
    ]


def test_what_leaves_the_map_is_told_at_its_edge_until_all_of_it_is_shown(play: Open) -> None:
    page = play({"solvers": "near,lost"})
    near, lost = page.evaluate(OUTSIDE)
    assert near == []
    assert any("camera 80 m" in text and "people" in text for text in lost)
    assert "Outside the map: lost camera 80 m" in str(page.locator("[data-map]").get_attribute("aria-label"))
    page.keyboard.press("a")
    page.wait_for_function(f"{OUTSIDE}.every(one => !one.length)")
    page.keyboard.press("0")
    page.wait_for_function(f"{OUTSIDE}[1].length > 0")
    page.locator("[data-do=all]").click()
    page.wait_for_function(f"{OUTSIDE}.every(one => !one.length)")


def test_who_has_no_box_is_told_and_why(play: Open) -> None:
    page = play({"frame": 5})
    said = page.locator("[data-boxes-line]")
    expect(said.locator("[data-boxes]")).to_have_text("44 boxes")
    expect(said.locator("[data-alarms]")).to_have_text("1 of them shows nobody")
    expect(said.locator("[data-without]")).to_have_text("2 people without: 1 hidden, 1 missed")
    places = page.evaluate(
        """() => { const s = vbbench.player.session, { map } = s.views, { others } = s.moment, K = s.clip.K;
        const at = (n) => [map.sx(others.px[n]) / map.canvas.ratio, map.sy(others.py[n]) / map.canvas.ratio];
        return [at(K), at(K + 1)]; }"""
    )
    for (x, y), words in zip(places, ("hidden by people in front", "missed by detector or tracker"), strict=True):
        page.locator("[data-map]").hover(position={"x": x, "y": y})
        expect(page.locator("[data-person-text]")).to_contain_text(f"no box: {words}")
    page.mouse.move(0, 0)
    page.locator("[data-person]").select_option(index=ALARM + 1)  # nobody stands first
    expect(page.locator("[data-person-text]")).to_contain_text("shows nobody: a false alarm")


def test_people_without_a_box_can_be_left_out(play: Open) -> None:
    page = play({"frame": 5})
    drawn = "vbbench.player.session.ui.map.toDataURL()"
    page.wait_for_timeout(50)
    before = page.evaluate(drawn)
    page.keyboard.press("b")
    page.wait_for_function(f"before => {drawn} !== before", arg=before)
    assert not page.locator("[data-flag=unboxed]").is_checked()


def test_a_person_has_one_colour_in_both_views_at_all_times(play: Open) -> None:
    page = play({"frame": 2})
    colours = page.evaluate("[...vbbench.player.session.theme.people]")
    page.keyboard.press("End")
    assert page.evaluate("[...vbbench.player.session.theme.people]") == colours
    assert len(set(colours)) == 10
    dark = play({"frame": 2}, color_scheme="dark").evaluate("[...vbbench.player.session.theme.people]")
    pairs = set(zip(colours, dark, strict=True))
    assert len(pairs) == 10  # a person keeps its place in the other palette


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_on_a_phone_all_of_it_is_there_and_axe_finds_nothing(scheme: str, play: Open) -> None:
    page = play({"solvers": "near,lost"}, color_scheme=scheme, viewport=PHONE, has_touch=True, is_mobile=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    for name in ("telling", "all", "fit"):
        box = page.locator(f"[data-do={name}]").bounding_box()
        assert box
        assert min(box["width"], box["height"]) >= 24
    page.locator("[data-do=telling]").tap()
    found = Axe().run(page, options={"resultTypes": ["violations"], "preload": False}).response["violations"]
    assert not found, json.dumps(found)[:2000]
