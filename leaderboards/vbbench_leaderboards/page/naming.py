"""How the pages name a solver: its colour, the way to its page, and the way to its code."""

from urllib.parse import quote

from vbbench_leaderboards.markup import link, text
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.results.result import Board, Result


def dot(site: Site, solver: str) -> str:
    """The mark in the solver's colour."""
    return f'<span class="dot c{site.colours[solver]}"></span>'


def solver_link(solver: str) -> str:
    """The name, which leads to the solver's page."""
    return f'<a href="#/solver/{quote(solver, safe="")}">{text(solver)}</a>'


def code_link(site: Site, result: Result) -> str:
    """The way to its code: what its row names, or the file that came with vbbench; empty where there is none."""
    if result.about.code:
        found = link(result.about.code, "code")
        return found if found != "code" else ""
    source = site.sources.get(result.solver)
    return f'<a href="{text(source.address)}">code</a>' if source else ""


def board_address(board: Board, view: str = "", **options: str) -> str:
    """The address of a board, or of another view of it."""
    query = "&".join(f"{name}={quote(value, safe='')}" for name, value in options.items())
    return f"#/{board.key}{f'/{view}' if view else ''}{f'?{query}' if query else ''}"
