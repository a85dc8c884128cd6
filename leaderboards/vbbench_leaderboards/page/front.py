"""The front page: the frame in ``front.html``, filled."""

from importlib.resources import files
from string import Template

from vbbench import __version__
from vbbench.paper import the_paper
from vbbench_leaderboards.charts.task import task_drawing
from vbbench_leaderboards.page.headline import headline_table
from vbbench_leaderboards.page.markup import code, link, text
from vbbench_leaderboards.page.picker import picker
from vbbench_leaderboards.page.site import Site
from vbbench_leaderboards.page.words import COLUMNS, DRIFTS, METRICS, PROTOCOLS, SUMMARIES, TIERS, Term
from vbbench_leaderboards.ranking import LEVEL

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
