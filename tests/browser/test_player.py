"""The sequence player: its data, time, solvers, the map, shared addresses, and what it says of errors."""

import re
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.lib.browsing import Open, Visitor
from tests.lib.made_player import MOUNT, gone_astray, with_false_alarm, write_crowd, write_page
from tests.lib.made_sequence import DT, made_sequence
from tests.lib.player_decoding import decode_clip, decode_estimate
from vbbench_leaderboards.site.pages import assets
from vbbench_leaderboards.site.player import encode_clip, encode_estimate, write_data

BOARD = "#/demo/sequential-noisy"
PLAY = f"{BOARD}/play"
FIRST = f"{PLAY}?frame=0"
START = datetime(2026, 1, 1, tzinfo=UTC)
ASTRAY, ALARM = 7, 3
DRAWN = "vbbench.player.session.ui.map.toDataURL()"


def clock(page: Page) -> Locator:
    return page.locator("[data-clock]")


def frame(page: Page) -> int:
    found = re.match(r"\d+", clock(page).inner_text())
    assert found
    return int(found[0])


def do(page: Page, name: str) -> None:
    page.locator(f".player [data-do={name}]").click()


def chosen(page: Page) -> list[str]:
    return [box.locator("xpath=..").inner_text().strip() for box in page.locator("[data-solvers] input:checked").all()]


@pytest.fixture
def player(open_page: Open) -> Page:
    page = open_page(FIRST)
    expect(clock(page)).to_contain_text("0 /")
    return page


@pytest.fixture
def frozen(visitor: Callable[..., Visitor]) -> Page:
    """The player where time stands still, unless a test lets some pass."""
    guest = visitor()
    guest.context.clock.install(time=START)
    page = guest.open(FIRST)
    expect(clock(page)).to_contain_text("0 /")
    page.clock.pause_at(START + timedelta(hours=1))
    return page


def wait_for_another(page: Page, picture: str) -> str:
    """The map's picture, when it is no longer this one."""
    return str(page.wait_for_function(f"before => {DRAWN} !== before && {DRAWN}", arg=picture).json_value())


def last_frame(page: Page) -> int:
    expect(clock(page)).to_contain_text("/")  # which it is not before the sequence has come
    return int(clock(page).inner_text().split("/")[1].split()[0])


def test_it_plays_pauses_and_stops_at_the_end(frozen: Page) -> None:
    assert not frozen.evaluate("vbbench.player.session.smooth")  # as readers who want it still have it
    frozen.clock.run_for(1000)
    assert frame(frozen) == 0
    do(frozen, "play")
    expect(frozen.get_by_role("button", name="Pause", exact=True)).to_be_visible()
    frozen.clock.run_for(1000)
    assert frame(frozen) == pytest.approx(1.0 / DT, abs=1)
    do(frozen, "play")
    expect(frozen.get_by_role("button", name="Play", exact=True)).to_be_visible()
    frozen.clock.run_for(20)
    paused = frame(frozen)
    frozen.clock.run_for(1000)
    assert frame(frozen) == paused
    frozen.locator("[data-speed]").select_option("4")
    do(frozen, "play")
    frozen.clock.run_for(1000 * last_frame(frozen) * DT)
    assert frame(frozen) == last_frame(frozen)
    expect(frozen.get_by_role("button", name="Play", exact=True)).to_be_visible()


def test_it_steps_by_buttons_and_keys(player: Page) -> None:
    last = last_frame(player)
    for name, wanted in (("next", 1), ("next", 2), ("previous", 1), ("end", last), ("start", 0), ("previous", 0)):
        do(player, name)
        expect(clock(player)).to_contain_text(f"{wanted} /")
    player.locator("[data-map]").focus()
    for key, wanted in (("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1), ("End", last), ("Home", 0)):
        player.keyboard.press(key)
        expect(clock(player)).to_contain_text(f"{wanted} /")
    player.keyboard.press("Space")
    expect(player.get_by_role("button", name="Pause", exact=True)).to_be_visible()
    player.keyboard.press("Space")


def test_ids_are_shown_on_demand_and_keys_are_explained(player: Page) -> None:
    plain = player.evaluate(DRAWN)
    player.keyboard.press("i")
    expect(player.locator("[data-ids]")).to_be_checked()
    wait_for_another(player, plain)
    player.locator("[data-ids]").uncheck()
    player.wait_for_function(f"plain => {DRAWN} === plain", arg=plain)
    player.keyboard.press("?")
    keys = player.get_by_role("dialog", name="Keys")
    expect(keys).to_contain_text("the frame of the largest error")
    player.keyboard.press("End")
    player.keyboard.press("Escape")
    expect(keys).to_be_hidden()
    expect(clock(player)).to_contain_text("0 /")


def test_another_board_shows_the_same_sequence_and_frame(player: Page) -> None:
    player.locator("[data-scrub]").fill("4")
    sequence = player.locator("[data-sequence]").input_value()
    player.locator("[data-board]").select_option("one-step-noisy")
    expect(player).to_have_url(re.compile(rf"/demo/one-step-noisy/play\?.*sequence={sequence}&.*frame=4"))
    expect(clock(player)).to_contain_text("4 /")
    expect(player.locator("[data-board]")).to_have_value("one-step-noisy")


def test_scrubbing_and_the_error_strip_go_there(player: Page) -> None:
    player.locator("[data-scrub]").fill("7")
    expect(clock(player)).to_contain_text("7 /")
    before = player.evaluate(DRAWN)
    strip = player.locator("[data-strip]")
    box = strip.bounding_box()
    assert box
    strip.click(position={"x": box["width"] - 8, "y": box["height"] / 2})
    expect(clock(player)).to_contain_text(f"{last_frame(player)} /")
    wait_for_another(player, before)
    expect(player).to_have_url(re.compile(rf"frame={last_frame(player)}\b"))


def test_three_solvers_and_no_fourth(player: Page) -> None:
    solvers = player.locator("[data-solvers]")
    assert len(chosen(player)) == 2
    third = next(name for name in ("cv", "sf") if name not in chosen(player))
    solvers.get_by_label(third, exact=True).press("Space")
    expect(solvers.locator("input:checked")).to_have_count(3)
    assert solvers.locator("tr").count() == 5
    expect(solvers.locator("input:not(:checked):not(:disabled)")).to_have_count(0)
    out = chosen(player)[0]
    solvers.get_by_label(out, exact=True).press("Space")
    expect(solvers.locator("input:checked")).to_have_count(2)
    expect(solvers.get_by_label(out, exact=True)).to_be_focused()
    other = next(name for name in ("cv", "sf") if name not in (out, *chosen(player)))
    solvers.get_by_label(other, exact=True).press("Space")
    expect(solvers.locator("input:checked")).to_have_count(3)
    expect(player).to_have_url(re.compile(rf"solvers=([^&]*,)?{other}(,|&|$)"))
    do(player, "end")
    expect(clock(player)).to_contain_text(f"{last_frame(player)} /")
    for row in solvers.locator("tr").all():
        figures = [cell for cell in row.locator("td").all_inner_texts() if re.fullmatch(r"\d+(\.\d+)?", cell)]
        assert len(figures) == (3 if row.locator("input").is_checked() else 1)


def test_the_map_zooms_and_moves(player: Page) -> None:
    whole = player.evaluate(DRAWN)
    do(player, "in")
    nearer = wait_for_another(player, whole)
    player.locator("[data-map]").hover()
    player.mouse.wheel(0, -300)
    wheeled = wait_for_another(player, nearer)
    player.mouse.down()
    player.mouse.move(400, 300, steps=4)
    player.mouse.up()
    wait_for_another(player, wheeled)
    do(player, "fit")
    player.mouse.move(0, 0)
    player.wait_for_function(f"whole => {DRAWN} === whole", arg=whole)


def test_a_shared_address_opens_the_same_frame(visitor: Callable[..., Visitor]) -> None:
    guest = visitor(permissions=["clipboard-read", "clipboard-write"])
    page = guest.open(FIRST)
    expect(clock(page)).to_contain_text("0 /")
    page.locator("[data-sequence]").select_option(index=2)
    sequence = page.locator("[data-sequence]").input_value()
    page.wait_for_function(f"vbbench.player.session.folder.endsWith('/{sequence}')")
    page.locator("[data-scrub]").fill("5")
    page.locator("[data-solvers]").get_by_label(chosen(page)[0], exact=True).press("Space")
    expect(page.locator("[data-solvers] input:checked")).to_have_count(1)
    do(page, "link")
    expect(page.get_by_role("button", name=re.compile("link|copied", re.I))).to_contain_text("Copied")
    link = page.evaluate("navigator.clipboard.readText()")
    assert "/play?" in link
    other = guest.context.new_page()
    other.goto(link)
    expect(clock(other)).to_contain_text("5 /")
    assert other.locator("[data-sequence]").input_value() == sequence
    assert chosen(other) == chosen(page)


def test_only_what_is_shown_is_loaded(visitor: Callable[..., Visitor]) -> None:
    guest = visitor()
    page = guest.open(FIRST)
    expect(clock(page)).to_contain_text("0 /")
    page.wait_for_function("vbbench.player.session.moment")
    sequence = page.locator("[data-sequence]").input_value()
    asked = [address.split("/data/player/")[1] for address in guest.asked if "/data/player/" in address]
    answers = [f"demo/sequential-noisy/{sequence}/{name}.js" for name in chosen(page)]
    assert sorted(asked) == sorted(["demo.js", f"demo/noisy/{sequence}.js", *answers])


def test_back_leaves_the_player_and_forward_returns(open_page: Open) -> None:
    page = open_page(BOARD)
    page.locator("#watch").click()
    expect(clock(page)).to_contain_text("/")
    expect(page.locator("#board-table")).to_be_hidden()
    page.go_back()
    expect(page.locator("#board-table")).to_be_visible()
    expect(page.locator(".player")).to_have_count(0)
    page.keyboard.press("Space")
    page.go_forward()
    expect(clock(page)).to_contain_text("/")


def test_an_address_gone_astray_plays_what_there_is(open_page: Open) -> None:
    page = open_page(f"{PLAY}?sequence=99999&frame=-4&solvers=nobody,,%25")
    expect(clock(page)).to_contain_text("0 /")
    assert len(chosen(page)) == 2
    gone = page.locator("[data-gone]")
    expect(gone).to_contain_text("Sequence 99999 cannot be played here")
    expect(gone).to_contain_text("no solver nobody")
    again = open_page(f"{PLAY}?frame=1e9")
    expect(clock(again)).to_contain_text(f"{last_frame(again)} /")


def test_a_missing_file_is_told_kindly(visitor: Callable[..., Visitor]) -> None:
    guest = visitor()
    page = guest.open(BOARD)
    page.route("**/data/player/demo/noisy/*.js", lambda route: route.abort())
    page.locator("#watch").click()
    expect(page.locator(".player [data-note]")).to_be_visible()
    guest.faults.clear()  # the browser itself tells the console that the file is not there


def test_a_person_can_be_chosen_and_is_described(player: Page) -> None:
    do(player, "end")
    expect(clock(player)).to_contain_text(f"{last_frame(player)} /")
    player.locator("[data-person]").select_option(index=1)  # nobody stands first
    expect(player.locator("[data-person-text]")).to_contain_text(
        re.compile(r"Person \d+, \d+\.\d m away.*Off by: .* m")
    )
    expect(player.locator("[data-said]")).to_contain_text("people off by")
    for view in ("ego", "map"):
        assert player.locator(f"[data-{view}]").get_attribute("aria-label")


@pytest.fixture(scope="module")
def crowd(tmp_path_factory: pytest.TempPathFactory) -> Path:
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
def play(crowd: Path, visitor: Callable[..., Visitor]) -> Open:
    """Open the player on the crowd in a state as an address has it; options as for `visit`."""

    def open_it(state: dict[str, Any], **options: Any) -> Page:
        page = visitor(crowd, **options).open(wait="main h1")
        page.wait_for_function("vbbench.made")
        page.evaluate(MOUNT, state)
        page.wait_for_function("vbbench.player.session?.moment")
        return page

    return open_it


def test_it_opens_with_the_best_solvers_where_one_goes_astray_unless_the_address_has_a_frame(play: Open) -> None:
    for state, wanted in (({"solvers": "lost"}, ASTRAY), ({"solvers": "lost", "frame": 3}, 3)):
        expect(clock(play(state))).to_contain_text(f"{wanted} /")
    assert chosen(play({})) == ["near", "wide"]
    page = play({"solvers": "near,lost"})
    expect(clock(page)).to_contain_text(f"{ASTRAY} /")
    page.keyboard.press("End")
    expect(clock(page)).to_contain_text("13 /")
    page.keyboard.press("w")
    expect(clock(page)).to_contain_text(f"{ASTRAY} /")


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


READ = """async () => {
  const { decodeClip, decodeEstimate } = vbbench.player;
  const clip = await decodeClip(vbbench.values["player/clip"]);
  const estimate = await decodeEstimate(vbbench.values["player/estimate"], clip);
  const plain = (values) => Array.from(values, (value) => (Number.isNaN(value) ? null : Number(value)));
  const all = (from, names) => Object.fromEntries(names.map((name) => [name, plain(from[name])]));
  return {
    clip: all(clip, ["known", "observed", "given", "x", "y", "yaw", "px", "py", "u", "v", "l"]),
    estimate: all(estimate, ["x", "y", "yaw", "px", "py"]),
  };
}"""


@pytest.mark.parametrize(
    ("people", "frames", "share", "error"), [(60, 99, 0.9, 0.1), (3, 2, 0.4, 30.0), (1, 1, 0.0, 0.0)]
)
def test_the_script_reads_what_python_wrote(
    browser: Browser, tmp_path: Path, people: int, frames: int, share: float, error: float
) -> None:
    made = made_sequence(people, frames, share=share, far=4321.0)
    clip = encode_clip(made.camera, DT, made.sequence, made.truth)
    answer = made.estimate(np.random.default_rng(0), error)
    estimate = encode_estimate(made.truth, answer)
    got = read_in_browser(browser, tmp_path, {"clip": clip, "estimate": estimate})
    wanted = decode_clip(clip)
    for name in ("known", "observed", "given"):
        assert got["clip"][name] == wanted[name].ravel().tolist()
    for name, values in columns(wanted["poses"], wanted["positions"], wanted["boxes"]):
        assert same(got["clip"][name], values)
    for name, values in columns(*decode_estimate(estimate, wanted)):
        assert same(got["estimate"][name], values)


def columns(poses: Any, positions: Any, boxes: Any = None) -> Any:
    """Name in the script → the values that it stands for."""
    named = {"x": poses[:, 0], "y": poses[:, 1], "yaw": poses[:, 2], "px": positions[..., 0], "py": positions[..., 1]}
    if boxes is not None:
        named |= {"u": boxes[..., 0], "v": boxes[..., 1], "l": boxes[..., 2]}
    return named.items()


def same(got: list[float | None], wanted: Any) -> bool:
    return np.allclose(np.array(got, float), wanted.ravel(), rtol=0.0, atol=1e-9, equal_nan=True)


def read_in_browser(browser: Browser, folder: Path, files: dict[str, dict[str, Any]]) -> Any:
    """A page with the player's script and these files, read by the script."""
    for name, values in files.items():
        write_data(folder, name, values)
    (folder / "player.js").write_text(assets()["assets/player.js"], encoding="utf-8")
    start = "window.vbbench = { values: {}, provide(key, value) { this.values[key] = value; } }"
    places = ["player.js", *(f"data/player/{name}.js" for name in files)]
    scripts = "".join(f'<script src="{place}"></script>' for place in places)
    (folder / "page.html").write_text(f"<!doctype html><meta charset=utf-8><script>{start}</script>{scripts}", "utf-8")
    page = browser.new_page()
    try:
        page.goto((folder / "page.html").as_uri())
        return page.evaluate(READ)
    finally:
        page.close()
