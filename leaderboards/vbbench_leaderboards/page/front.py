"""The front page: the frame in ``front.html`` with the headlines, the picker of boards and the definitions."""

from collections.abc import Iterable
from importlib.resources import files
from string import Template

from vbbench import __version__
from vbbench.generation.footage import FOOTAGE
from vbbench.paper import the_paper
from vbbench.protocol import get_protocol
from vbbench.version import INSTALL
from vbbench_leaderboards.charts.task import task_drawing
from vbbench_leaderboards.markup import code, link, text
from vbbench_leaderboards.page.headline import headline_table
from vbbench_leaderboards.page.lines import take_part_lines
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.words import (
    COLUMNS,
    PROTOCOLS,
    SUMMARIES,
    Term,
    drift_terms,
    error_terms,
    term_of,
    tiers,
)
from vbbench_leaderboards.results.boards import HEADLINE_PROTOCOL, LEADING_TIERS, PAPER_SPLITS, PAPER_TIER
from vbbench_leaderboards.results.ranking import LEVEL


def front_page(site: Site) -> str:
    """The text of ``index.html``."""
    frame = Template((files("vbbench_leaderboards.page") / "front.html").read_text("utf-8"))
    return frame.substitute(
        version=text(__version__),
        docs=f'<a href="{text(site.docs)}">Docs</a>\n' if site.docs else "",
        drawing=task_drawing(),
        headline=headline_table(site),
        picker=_picker(site),
        metrics=_terms(error_terms() | drift_terms() | SUMMARIES),
        protocols=_terms(PROTOCOLS),
        tiers=_terms(tiers()),
        columns=_terms(COLUMNS),
        level=f"{LEVEL:g}",
        caps=_caps(),
        paper=link(the_paper().link, the_paper().source),
        commands=code([INSTALL, *take_part_lines(site)], "Lines that add a solver"),
        count=sum(map(len, site.results.values())),
        boards_count=len(site.results),
    )


def _caps() -> str:
    caps = get_protocol(HEADLINE_PROTOCOL).caps
    return f"{caps['dx']:g} m or {caps['dr']:g} rad"


def _terms(terms: dict[str, Term]) -> str:
    """Definitions, which the tooltips show too: their ids are ``def-`` and the key."""
    return f'<dl class="terms">{"".join(_term(key, term) for key, term in terms.items())}</dl>'


def _term(key: str, term: Term) -> str:
    full = f" <span>{text(term.full)}</span>" if term.full.lower() != term.name.lower() else ""
    unit = f' <span class="unit">{text(term.unit)}</span>' if term.unit else ""
    return f'<div><dt>{text(term.name)}{full}{unit}</dt><dd id="def-{key}">{text(term.meaning)}</dd></div>'


def _picker(site: Site) -> str:
    """Links to boards; the scripts keep their addresses in step with the board that is shown."""
    boards, shown = " ".join(board.key for board in site.boards), {board.tier for board in site.boards}
    names = [name for name in _TIERS if name in shown]
    names += sorted(shown.difference(names, (PAPER_TIER,))) + [PAPER_TIER] * (PAPER_TIER in shown)
    kept = [split for split in site.splits if split in PAPER_SPLITS]
    leading, solvers = " ".join(board.key for board in site.headlines), " ".join(site.solvers)
    return (
        f'<nav class="picker" id="picker" aria-label="Boards" data-boards="{text(boards)}" '
        f'data-first="{text(site.first.key)}" data-leading="{text(leading)}" data-solvers="{text(solvers)}">'
        f"{_splits(site, [split for split in site.splits if split not in kept])}"
        f"{_choices('protocol', PROTOCOLS, PROTOCOLS)}"
        f"{_choices('tier', names, tiers())}"
        f"{_diagnostics(site, kept)}</nav>"
    )


_TIERS = (*reversed(LEADING_TIERS), FOOTAGE)


def _splits(site: Site, splits: Iterable[str]) -> str:
    return f'<ul class="splits">{"".join(_split(site, split) for split in splits)}</ul>'


def _diagnostics(site: Site, splits: list[str]) -> str:
    """The paper's own splits, folded away."""
    if not splits:
        return ""
    return (
        '<details class="kept" id="kept"><summary>The paper\'s own splits</summary><p>Kept to compare with the paper: '
        f"these recordings are too smooth to tell solvers apart.</p>{_splits(site, splits)}</details>"
    )


def _split(site: Site, split: str) -> str:
    first = site.entry(split)
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
