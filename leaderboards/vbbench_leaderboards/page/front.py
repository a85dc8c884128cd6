"""The front page: the frame in ``front.html`` with the headlines, the picker of boards and the definitions."""

from collections.abc import Iterable
from importlib.resources import files
from string import Template

from vbbench import __version__
from vbbench.paper import the_paper
from vbbench_leaderboards.charts.task import task_drawing
from vbbench_leaderboards.markup import NONE, code, decimals, link, text
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.words import (
    COLUMNS,
    HEADLINE_METRIC,
    HEADLINE_TIER,
    PROTOCOLS,
    SUMMARIES,
    TIERS,
    Term,
    drift_terms,
    error_terms,
    term_of,
)
from vbbench_leaderboards.results.ranking import LEVEL
from vbbench_leaderboards.results.result import Board

_COMMANDS = [
    "pip install vbbench",
    "vbbench leaderboard template mine && cd mine",
    "vbbench generate sim --tier noisy --out sim-noisy",
    "vbbench solve sim-noisy --solver mysolver:MySolver --protocol sequential --out answer",
    "vbbench leaderboard add answer --dataset sim-noisy --name my-solver",
    "vbbench leaderboard build --out site",
]


def front_page(site: Site) -> str:
    """The text of ``index.html``."""
    frame = Template((files("vbbench_leaderboards.page") / "front.html").read_text("utf-8"))
    return frame.substitute(
        version=text(__version__),
        drawing=task_drawing(),
        headline=_headlines(site),
        picker=_picker(site),
        metrics=_terms(error_terms() | drift_terms() | SUMMARIES),
        protocols=_terms(PROTOCOLS),
        tiers=_terms(TIERS),
        columns=_terms(COLUMNS),
        level=f"{LEVEL:g}",
        paper=link(the_paper().link, the_paper().source),
        commands=code(_COMMANDS, "Lines that add a solver"),
        count=sum(map(len, site.results.values())),
        boards_count=len(site.results),
    )


def _terms(terms: dict[str, Term]) -> str:
    """Definitions, which the tooltips show too: their ids are ``def-`` and the key."""
    return f'<dl class="terms">{"".join(_term(key, term) for key, term in terms.items())}</dl>'


def _term(key: str, term: Term) -> str:
    full = f" <span>{text(term.full)}</span>" if term.full.lower() != term.name.lower() else ""
    unit = f' <span class="unit">{text(term.unit)}</span>' if term.unit else ""
    return f'<div><dt>{text(term.name)}{full}{unit}</dt><dd id="def-{key}">{text(term.meaning)}</dd></div>'


def _headlines(site: Site) -> str:
    """Who is best on each split, with noise, by the position error of people; none where a caution stands."""
    cautioned = {
        board.split for board in site.boards if board.tier == HEADLINE_TIER and site.caution(board) is not None
    }
    rows = "".join(_headline_row(site, split) for split in site.splits)
    if not rows:
        return '<p class="note">No board is fit for a headline yet.</p>'
    heads = "".join(
        f'<th scope="col"><button type="button" class="term" data-def="def-{name}" aria-describedby="def-{name}">'
        f"{text(term.full)}</button></th>"
        for name, term in PROTOCOLS.items()
    )
    names = ", ".join(split for split in site.splits if split in cautioned)
    note = f'<p class="note">No headline is taken from {text(names)}: see the caution at its boards.</p>'
    return (
        '<div class="scroll" tabindex="0" role="region" aria-label="Table of best solvers"><table class="headline" '
        f'id="headline"><thead><tr><th scope="col">Split</th>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'
        f"{note if cautioned else ''}"
    )


def _headline_row(site: Site, split: str) -> str:
    """The row of a split; empty where it has no board that is fit for a headline."""
    boards = [Board(split=split, tier=HEADLINE_TIER, protocol=protocol) for protocol in PROTOCOLS]
    fit = [board in site.results and site.is_headline(board) for board in boards]
    if not any(fit):
        return ""
    cells = (_best(site, board) if good else f"<td>{NONE}</td>" for board, good in zip(boards, fit, strict=True))
    return f'<tr><th scope="row">{text(split)}</th>{"".join(cells)}</tr>'


def _best(site: Site, board: Board) -> str:
    """The solvers that nobody is significantly better than, the smallest error first; at most three."""
    places = site.rankings[board][HEADLINE_METRIC].places
    means = {result.solver: result.score["metrics"][HEADLINE_METRIC]["mean"] for result in site.results[board]}
    first = [(mean, solver) for solver, mean in means.items() if places[solver].rank == 1 and mean is not None]
    best = sorted(first)[:3]
    digits = decimals([mean for mean, _ in best])
    names = "".join(
        f'<span class="best"><span class="dot c{site.colours[solver]}"></span>{text(solver)} '
        f'<b class="figure">{mean:.{digits}f}</b></span>'
        for mean, solver in best
    )
    return f'<td><a href="#/{text(board.key)}">{names}</a></td>'


def _picker(site: Site) -> str:
    """Links to boards; the scripts keep their addresses in step with the board that is shown."""
    boards, tiers = " ".join(board.key for board in site.boards), {board.tier for board in site.boards}
    return (
        f'<nav class="picker" id="picker" aria-label="Boards" data-boards="{text(boards)}" '
        f'data-first="{text(site.first.key)}">'
        f'<ul class="splits">{"".join(_split(site, split) for split in site.splits)}</ul>'
        f"{_choices('protocol', PROTOCOLS, PROTOCOLS)}"
        f"{_choices('tier', [name for name in TIERS if name in tiers], TIERS)}</nav>"
    )


def _split(site: Site, split: str) -> str:
    first = next(board for board in site.boards if board.split == split)
    counts, paper = site.datasets[split, first.tier].counts, the_paper().table1.get(split)
    people = f"{counts['people_min']} / {counts['people_mean']:.2f} / {counts['people_max']}"
    quoted = text(f"paper: {paper.sequences} × {paper.frames}; {paper.people}") if paper else ""
    printed = f'<span class="about paper">{quoted}</span>' if paper else ""
    return (
        f'<li><a class="split" data-split="{text(split)}" href="#/{text(first.key)}"><strong>{text(split)}</strong>'
        f'<span class="about">{counts["sequences"]} × {counts["mean_frames"]:.1f} frames</span>'
        f'<span class="about">{people} people</span>'
        f"{printed}</a></li>"
    )


def _choices(what: str, names: Iterable[str], words: dict[str, Term]) -> str:
    links = "".join(
        f'<li><a data-{what}="{text(name)}" data-def="def-{text(name)}" aria-describedby="def-{text(name)}" '
        f'href="#boards">{text(term_of(words, name).full)}</a></li>'
        for name in names
    )
    return (
        f'<div class="row"><span class="label" id="pick-{what}">{what.title()}</span>'
        f'<ul class="choices" aria-labelledby="pick-{what}">{links}</ul></div>'
    )
