"""Builds the site from a folder of results: whole, or not at all."""

import warnings
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from vbbench import __version__
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.work_folder import WorkFolder
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.player.writing import Films, write_player
from vbbench_leaderboards.results.ranking import rank
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.results.folder import Records, read_datasets, read_results
import json
from collections.abc import Iterator
from importlib.resources import files
from typing import Any
from vbbench_leaderboards.page.board import board_html
from vbbench_leaderboards.page.front import front_page
from vbbench_leaderboards.page.site import Site, key
from vbbench_leaderboards.results.result import Board

# DOC """Every file of the site but the player's, as text by its path."""
MARKER = ".vbbench-site"
"""File that tells a site that was built here from a folder that must not be touched."""


def build(out: Path, *results: Path, films: Films | None = None) -> Site:
    """Write the site of all results below the folders ``results`` into ``out``, and return what it shows.

    A file that cannot be used is left out, with a warning that names it and says why.

    Parameters
    ----------
    results : folders of result files; of a result in several of them the first counts.
    films : which sequences can be played; ``None`` for none.

    Raises
    ------
    VbbenchError
        If ``out`` is there and no site, or if there are no results that can be used.
    """
    with WorkFolder(out, partial(check_site, out)) as work:
        unusable: list[FileError] = []
        records = read_datasets(*results, unusable=unusable)
        found = read_results(*results, records=records, unusable=unusable)
        for error in unusable:
            warnings.warn(VbbenchWarning(f"LEFT OUT of the site: {error}"), stacklevel=2)
        if not found:
            places = ", ".join(map(str, results))
            raise VbbenchError(f"{places} holds no results that can be used; add one with 'vbbench leaderboard add'")
        work.begin()
        work.new.mkdir()
        (work.new / MARKER).write_text(f"vbbench {__version__}\n", encoding="utf-8")
        site = _write(work.new, found, records, films)
        work.publish()
    return site


def check_site(folder: Path) -> None:
    """Raise VbbenchError if ``folder`` is there and was not made by `build`."""
    if folder.exists() and not (folder / MARKER).is_file():
        raise VbbenchError(f"{folder} exists and is no site of 'vbbench leaderboard build'; choose another --out")


def _write(draft: Path, found: Mapping[Board, tuple[Result, ...]], records: Records, films: Films | None) -> Site:
    site = Site(
        results=found,
        datasets=records,
        rankings={board: rank(rows) for board, rows in found.items()},
        playable=write_player(draft, found, films),
    )
    for name, text in site_files(site):
        path = draft / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
    return site


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
