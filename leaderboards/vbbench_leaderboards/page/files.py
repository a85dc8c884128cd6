"""Every file of the site but the player's, as text by its path."""

import json
from collections.abc import Iterator
from importlib.resources import files
from typing import Any

from vbbench_leaderboards.page.board import board_html
from vbbench_leaderboards.page.front import front_page
from vbbench_leaderboards.page.site import Site, key
from vbbench_leaderboards.result import Board


def site_files(site: Site) -> Iterator[tuple[str, str]]:
    """Path below the site's folder, and text, of every file."""
    yield "index.html", front_page(site)
    for asset in files("vbbench_leaderboards.page").joinpath("assets").iterdir():
        yield f"assets/{asset.name}", asset.read_text("utf-8")
    for board in site.boards:
        yield f"data/{key(board)}.js", provided(key(board), _board(site, board))


def provided(name: str, value: Any) -> str:
    """A data file: one call, harmless even if it were pasted into a page."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    separators = text.replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    return f"vbbench.provide({json.dumps(name)},{separators});\n"


def _board(site: Site, board: Board) -> dict[str, Any]:
    """What the scripts need to know of a board; the player is handed this too."""
    return {
        "key": key(board),
        "split": board.split,
        "protocol": board.protocol,
        "tier": board.tier,
        "title": site.title(board.split),
        "caution": site.caution(board),
        "solvers": [{"name": r.solver, "colour": site.colours[r.solver]} for r in site.results[board]],
        "playable": list(site.playable.get(board, ())),
        "html": board_html(site, board),
    }
