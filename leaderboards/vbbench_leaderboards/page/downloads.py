"""The files that lie beside the page for papers and programs: every board in every format, and the links to them."""

from collections.abc import Iterator

from vbbench_leaderboards.exports.exported import ENDINGS, ExportedBoard, Format, exported_text
from vbbench_leaderboards.markup import text
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.results.boards import HEADLINE_METRIC
from vbbench_leaderboards.results.result import Board

_NAMES: dict[Format, str] = {
    "csv": "CSV",
    "latex": "LaTeX",
    "markdown": "Markdown",
    "json": "JSON",
    "bibtex": "what to cite as BibTeX",
}


def download_files(site: Site) -> Iterator[tuple[str, str]]:
    """Path below the site's folder, and text, of every board in every format."""
    for board in site.boards:
        exported = ExportedBoard.of(
            board, site.dataset(board), site.results[board], site.rankings[board][HEADLINE_METRIC]
        )
        for form in ENDINGS:
            yield _path(board, form), exported_text([exported], form)


def download_links(board: Board) -> str:
    """The line below a board's table that leads to its files."""
    links = [f'<a href="{text(_path(board, form))}" download>{name}</a>' for form, name in _NAMES.items()]
    return f'<p class="export" id="export">This table as {", ".join(links[:-1])}; {links[-1]}</p>'


def _path(board: Board, form: Format) -> str:
    return f"tables/{board.key}.{ENDINGS[form]}"
