"""What the player says of errors: the moment it opens at, who has no box, who is nobody."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from tests.lib.browsing import Visitor
from tests.lib.made_player import MOUNT, gone_astray, with_false_alarm, write_crowd, write_page
from tests.lib.made_sequence import made_sequence

PHONE = {"width": 390, "height": 844}
ASTRAY, ALARM = 7, 3
READY = "vbbench.player.session?.moment"
Open = Callable[..., Page]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """44 people, a false alarm; of three solvers one goes astray, by 80 m, in frame 7."""
    site = tmp_path_factory.mktemp("crowd")
    made = with_false_alarm(made_sequence(44, 14, share=1.0, seed=2), ALARM)
    answers = {
        "near": gone_astray(made, 14, (0.0, 0.0)),
        "wide": gone_astray(made, 14, (0.0, 0.0), error=0.4),
        "lost": gone_astray(made, ASTRAY, (80.0, 0.0)),
    }
    write_crowd(site, made, answers)
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
    page.keyboard.press("End")
    expect(page.locator("[data-clock]")).to_contain_text("13 /")
    page.keyboard.press("w")
    expect(page.locator("[data-clock]")).to_contain_text(f"{ASTRAY} /")


def test_an_address_with_a_frame_opens_there(play: Open) -> None:
    page = play({"solvers": "lost", "frame": 3})
    assert clock(page).startswith("3 /")


def test_two_solvers_are_shown_at_first_the_best(play: Open) -> None:
    page = play({})
    assert page.locator("[data-solvers] input:checked").evaluate_all("all => all.map(one => one.value)") == [
        "near",
        "wide",
    ]


def test_boxes_and_false_alarms_are_counted(play: Open) -> None:
    page = play({"frame": 5})
    said = page.locator("[data-boxes-line]")
    expect(said.locator("[data-boxes]")).to_have_text("44 boxes")
    expect(said.locator("[data-alarms]")).to_have_text("1 of them shows nobody")
    page.locator("[data-person]").select_option(index=ALARM + 1)  # nobody stands first
    expect(page.locator("[data-person-text]")).to_contain_text("shows nobody: a false alarm")


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
    for name in ("worst", "fit"):
        box = page.locator(f"[data-do={name}]").bounding_box()
        assert box
        assert min(box["width"], box["height"]) >= 24
    page.locator("[data-do=worst]").tap()
    found = Axe().run(page, options={"resultTypes": ["violations"], "preload": False}).response["violations"]
    assert not found, json.dumps(found)[:2000]
