"""Builds the site from folders of results."""

import warnings
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from vbbench import __version__
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.folders.work_folder import WorkFolder
from vbbench_leaderboards.results.boards import HEADLINE_METRIC
from vbbench_leaderboards.results.folder import read_datasets, read_results
from vbbench_leaderboards.results.ranking import rank_apart
from vbbench_leaderboards.site.charts import colours_css
from vbbench_leaderboards.site.export import DOWNLOADS, ExportedBoard, exported_text, table_address
from vbbench_leaderboards.site.pages import Site, board_page, comparison_values, front_page, solver_page
from vbbench_leaderboards.site.player import Films, write_player
from vbbench_leaderboards.site.words import PROTOCOLS, provided, term_of, tiers

MARKER = ".vbbench-site"
"""File that marks a site, which may be replaced; other folders must not be."""

_ASSETS = Path(__file__).with_name("assets")


def build(out: Path, *results: Path, films: Films | None = None, docs: str = "") -> Site:
    """Write the site of all results below the folders ``results`` into ``out``, and return what it shows.

    A file that cannot be used is omitted, with a warning of its name and the reason.

    Raises VbbenchError if ``out`` exists and is not a site, or if there are no usable results.

    Parameters
    ----------
    results : folders of result files; the first counts if several hold the same result.
    films : which sequences can be played; ``None`` for none.
    docs : address of the documentation, to which the page leads; "" if it does not.
    """
    with WorkFolder(out, partial(check_site, out)) as work:
        unusable: list[FileError] = []
        records = read_datasets(*results, unusable=unusable)
        found = read_results(*results, records=records, unusable=unusable)
        for error in unusable:
            warnings.warn(VbbenchWarning(f"OMITTED from the site: {error}"), stacklevel=2)
        if not found:
            places = ", ".join(map(str, results))
            raise VbbenchError(f"{places} holds no results that can be used; add one with 'vbbench leaderboard add'")
        work.begin()
        work.new.mkdir()
        site = Site(
            results=found,
            datasets=records,
            rankings={board: rank_apart(rows) for board, rows in found.items()},
            playable=write_player(work.new, found, films),
            docs=docs,
        )
        write_files(work.new, {MARKER: f"vbbench {__version__}\n"} | dict(site_files(site)))
        work.publish()
    return site


def write_files(folder: Path, texts: dict[str, str]) -> None:
    """Write texts by their path below a folder."""
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")


def site_files(site: Site) -> Iterator[tuple[str, str]]:
    """Path below the site's folder, and text, of every file but the player's data."""
    yield "index.html", front_page(site)
    yield from assets().items()
    for board in site.boards:
        own = {
            "key": board.key,
            "split": board.split,
            "protocol": board.protocol,
            "tier": board.tier,
            "title": site.title(board.split),
            "words": f"{board.split}, {term_of(PROTOCOLS, board.protocol).name}, {term_of(tiers(), board.tier).name}",
            "solvers": [{"name": one.solver, "colour": site.colours[one.solver]} for one in site.results[board]],
            "playable": list(site.playable.get(board, ())),
            "html": board_page(site, board),
        }
        yield f"data/{board.key}.js", provided(board.key, own)
        key = f"pages/pairs/{board.key}"
        yield f"data/{key}.js", provided(key, comparison_values(site, board))
        ranking = site.rankings[board][HEADLINE_METRIC]
        exported = ExportedBoard.of(board, site.dataset(board), site.results[board], ranking)
        yield from ((table_address(board, form), exported_text([exported], form)) for form in DOWNLOADS)
    for solver in site.solvers:
        key = f"pages/solver/{solver}"
        yield f"data/{key}.js", provided(key, {"name": solver, "html": solver_page(site, solver)})
    yield from (
        (source.address, source.text) for source in {one.address: one for one in site.sources.values()}.values()
    )


def assets() -> dict[str, str]:
    """Styles and scripts by their path in a site."""
    found = {f"assets/{path.name}": path.read_text("utf-8") for path in sorted(_ASSETS.iterdir())}
    return found | {"assets/colours.css": colours_css()}


def check_site(folder: Path) -> None:
    """Raise VbbenchError if ``folder`` exists and was not made by `build`."""
    if folder.exists() and not (folder / MARKER).is_file():
        raise VbbenchError(f"{folder} exists and is not a site of 'vbbench leaderboard build'; choose another `out`")
