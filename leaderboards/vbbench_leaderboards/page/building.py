"""Builds the site from folders of results."""

import warnings
from collections.abc import Iterator
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

from vbbench import __version__
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.folders.work_folder import WorkFolder
from vbbench_leaderboards.charts.colours import colours_css
from vbbench_leaderboards.markup import provided
from vbbench_leaderboards.page.board import board_html
from vbbench_leaderboards.page.comparing import comparison_key, comparison_values
from vbbench_leaderboards.page.downloads import download_files
from vbbench_leaderboards.page.front import front_page
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.solver import solver_key, solver_values
from vbbench_leaderboards.page.words import PROTOCOLS, term_of, tiers
from vbbench_leaderboards.player.writing import Films, write_player
from vbbench_leaderboards.results.folder import read_datasets, read_results
from vbbench_leaderboards.results.result import Board
from vbbench_leaderboards.results.standings import rank_apart

MARKER = ".vbbench-site"
"""File that marks a site, which may be replaced; other folders must not be."""


def build(out: Path, *results: Path, films: Films | None = None, docs: str = "") -> Site:
    """Write the site of all results below the folders ``results`` into ``out``, and return what it shows.

    A file that cannot be used is left out, with a warning that names it and says why.

    Parameters
    ----------
    results : folders of result files; the first counts if several hold the same result.
    films : which sequences can be played; ``None`` for none.
    docs : address of the documentation, to which the page leads; "" if it does not.

    Raises
    ------
    VbbenchError
        If ``out`` exists and is not a site, or if there are no usable results.
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
        site = Site(
            results=found,
            datasets=records,
            rankings={board: rank_apart(rows) for board, rows in found.items()},
            playable=write_player(work.new, found, films),
            docs=docs,
        )
        for name, text in site_files(site):
            path = work.new / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
        work.publish()
    return site


def site_files(site: Site) -> Iterator[tuple[str, str]]:
    """Path below the site's folder, and text, of every file but the player's."""
    yield "index.html", front_page(site)
    for asset in files("vbbench_leaderboards.page").joinpath("assets").iterdir():
        yield f"assets/{asset.name}", asset.read_text("utf-8")
    yield "assets/colours.css", colours_css()
    for board in site.boards:
        yield _data(board.key, _board(site, board))
        yield _data(comparison_key(board), comparison_values(site, board))
    for solver in site.solvers:
        yield _data(solver_key(solver), solver_values(site, solver))
    yield from download_files(site)
    yield from ((source.address, source.text) for source in {s.address: s for s in site.sources.values()}.values())


def _data(key: str, values: dict[str, Any]) -> tuple[str, str]:
    return f"data/{key}.js", provided(key, values)


def _board(site: Site, board: Board) -> dict[str, Any]:
    """What the scripts, the player among them, need to know about a board."""
    return {
        "key": board.key,
        "split": board.split,
        "protocol": board.protocol,
        "tier": board.tier,
        "title": site.title(board.split),
        "caution": site.caution(board),
        "words": f"{board.split}, {term_of(PROTOCOLS, board.protocol).name}, {term_of(tiers(), board.tier).name}",
        "solvers": [{"name": r.solver, "colour": site.colours[r.solver]} for r in site.results[board]],
        "playable": list(site.playable.get(board, ())),
        "html": board_html(site, board),
    }


def check_site(folder: Path) -> None:
    """Raise VbbenchError if ``folder`` exists and was not made by `build`."""
    if folder.exists() and not (folder / MARKER).is_file():
        raise VbbenchError(f"{folder} exists and is not a site of 'vbbench leaderboard build'; choose another `out`")
