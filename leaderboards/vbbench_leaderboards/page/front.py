"""The front page: the frame in ``front.html``, filled."""

from importlib.resources import files
from string import Template
from vbbench import __version__
from vbbench.reproduction.paper import the_paper
from vbbench_leaderboards.charts.task import task_drawing
from vbbench_leaderboards.page.headline import headline_table
from vbbench_leaderboards.markup import code, link, text
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.words import COLUMNS, DRIFTS, METRICS, PROTOCOLS, SUMMARIES, TIERS, Term
from vbbench_leaderboards.results.ranking import LEVEL
from collections.abc import Iterable
from vbbench.protocol import PROTOCOLS
from vbbench.reproduction.paper import the_paper
from vbbench_leaderboards.markup import text
from vbbench_leaderboards.page.site import Site, key
from vbbench_leaderboards.page.words import PROTOCOLS as PROTOCOL_WORDS
from vbbench_leaderboards.page.words import TIERS, Term, term_of

# DOC """The picker of boards: splits with their facts, protocols and tiers."""
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
        headline=headline_table(site),
        picker=picker(site),
        metrics=_terms(METRICS | DRIFTS | SUMMARIES),
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


def picker(site: Site) -> str:
    """Links to boards; the scripts keep their addresses in step with the board that is shown."""
    boards = [key(board) for board in site.boards]
    first = key(site.first) if site.first else ""
    tiers = {board.tier for board in site.boards}
    return (
        f'<nav class="picker" id="picker" aria-label="Boards" data-boards="{text(" ".join(boards))}" '
        f'data-first="{text(first)}">'
        f'<ul class="splits">{"".join(_split(site, split) for split in site.splits)}</ul>'
        f"{_choices('protocol', PROTOCOLS, PROTOCOL_WORDS)}"
        f"{_choices('tier', [name for name in TIERS if name in tiers], TIERS)}</nav>"
    )


def _split(site: Site, split: str) -> str:
    first = next(board for board in site.boards if board.split == split)
    return (
        f'<li><a class="split" data-split="{text(split)}" href="#/{text(key(first))}"><strong>{text(split)}</strong>'
        f"{_counts(site, split)}</a></li>"
    )


def _counts(site: Site, split: str) -> str:
    record = next((record for (name, _), record in site.datasets.items() if name == split), None)
    if record is None:
        return ""
    counts = record.counts
    paper = the_paper().table1.get(split)
    quoted = f"paper: {paper.sequences} × {paper.frames}; {paper.people}" if paper else ""
    printed = f'<span class="about paper">{text(quoted)}</span>' if paper else ""
    people = f"{counts['people_min']} / {counts['people_mean']:.2f} / {counts['people_max']}"
    return (
        f'<span class="about">{counts["sequences"]} × {counts["mean_frames"]:.1f} frames</span>'
        f'<span class="about">{people} people</span>'
        f"{printed}"
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
