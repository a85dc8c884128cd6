"""The page of a challenge: what it is, which phase is open, who leads, and how to take part.

While the challenge runs, it shows figures of the public part alone, and nothing of single sequences; after the end it
leads to full boards of both parts.
"""

from datetime import datetime
from functools import partial
from importlib.resources import files
from pathlib import Path
from string import Template

from vbbench import __version__
from vbbench.folders.work_folder import WorkFolder
from vbbench_leaderboards.challenge.definition import Challenge, Part, Phase
from vbbench_leaderboards.challenge.instructions import (
    OWN_RULES,
    missing_words,
    parts_words,
    phase_words,
    practice_commands,
    solving_commands,
    unpacking_commands,
)
from vbbench_leaderboards.challenge.log import digest_of_last
from vbbench_leaderboards.challenge.organiser import Organiser
from vbbench_leaderboards.challenge.standings import Row, shown_parts, standings
from vbbench_leaderboards.markup import NONE, code, link, percent, text
from vbbench_leaderboards.page.building import MARKER, build, check_site
from vbbench_leaderboards.results.result import write_result
from vbbench_leaderboards.results.standings import GROUPS, failure_rate, headline

_ROOM = files("vbbench_leaderboards.challenge")
_ASSETS = ("page.css", "board.css", "print.css", "theme.js")
"""Of the leaderboard's page."""


def build_challenge(out: Path, folder: Path, moment: datetime) -> Path:
    """Write the page of the challenge in ``folder`` into ``out``; return the path of the page.

    Raises
    ------
    VbbenchError
        If ``out`` exists and is not a site, or the challenge cannot be read.
    """
    organiser = Organiser(folder)
    rows = {part: standings(organiser, part) for part in shown_parts(organiser, moment)}
    over = organiser.challenge.is_over(moment)
    with WorkFolder(out, partial(check_site, out)) as work:
        work.begin()
        (work.new / "assets").mkdir(parents=True)
        (work.new / MARKER).write_text(f"vbbench {__version__}\n", encoding="utf-8")
        if over:
            for part in (part for part, own in rows.items() if own):
                _write_boards(work.new, organiser, part, rows[part])
        page = _page(organiser, moment, rows, over)
        for name, words in {"index.html": page, **_assets()}.items():
            (work.new / name).write_text(words, encoding="utf-8", newline="\n")
        work.publish()
    return out / "index.html"


def _assets() -> dict[str, str]:
    own = {f"assets/{name}": (_ROOM / name).read_text("utf-8") for name in ("challenge.css", "challenge.js")}
    shared = files("vbbench_leaderboards.page") / "assets"
    return own | {f"assets/{name}": (shared / name).read_text("utf-8") for name in _ASSETS}


def _write_boards(site: Path, organiser: Organiser, part: Part, rows: list[Row]) -> None:
    """The part's result files, and their boards in full: every sequence may be looked at now."""
    results = site / "results" / part
    for row in rows:
        write_result(row.result, results, organiser.record(part))
    build(site / part, results)


def _page(organiser: Organiser, moment: datetime, rows: dict[Part, list[Row]], over: bool) -> str:
    challenge = organiser.challenge
    rules = "".join(f"<li>{text(rule.replace('`', ''))}</li>" for rule in (*OWN_RULES, *challenge.rules))
    return Template((_ROOM / "page.html").read_text("utf-8")).substitute(
        version=text(__version__),
        moment=f"{moment:%Y-%m-%d %H:%M}",
        name=text(challenge.name),
        title=text(challenge.title),
        description=text(" ".join(challenge.about)[:300] or challenge.title),
        about="".join(f"<p>{text(words)}</p>" for words in challenge.about),
        now=text(now_words(challenge, moment)),
        facts=_facts(organiser),
        standings="".join(_standings(part, own, over) for part, own in rows.items()) or _NOT_YET,
        parts=text(parts_words(challenge)),
        phases=_phases(challenge, moment),
        teams=_teams(organiser),
        bundle=_bundle(challenge),
        solving=code([*unpacking_commands(challenge), *solving_commands(challenge)], "Lines that make a submission"),
        practice=code(practice_commands(challenge), "Lines that practise"),
        contact=_contact(challenge),
        missing=text(missing_words(challenge)),
        rules=rules,
    )


def now_words(challenge: Challenge, moment: datetime) -> str:
    """Which phase is open, or when one opens."""
    open_now = challenge.phase_at(moment)
    if open_now is not None:
        return f"Phase {open_now.name} is open, to the end of {open_now.end} (UTC)."
    following = challenge.phase_after(moment)
    if following is not None:
        return f"No phase is open. Phase {following.name} opens on {following.start}."
    return f"The challenge is over: its last phase closed after {challenge.phases[-1].end}."


def _facts(organiser: Organiser) -> str:
    challenge, info = organiser.challenge, organiser.dataset.info
    facts = {
        "Organisers": text(challenge.organisers),
        "Contact": _contact(challenge),
        "Protocol": text(challenge.protocol),
        "Data": text(f"{info.split}, tier {info.tier}, {len(organiser.dataset)} sequences, dataset {info.id}"),
        "Truth": text(f"withheld, SHA-256 {info.truth_sha256}"),
        "Log": text(f"{len(organiser.entries)} submissions, SHA-256 {digest_of_last(organiser.entries)}"),
        "Licence": text(challenge.licence),
    }
    return "".join(f"<dt>{name}</dt><dd>{value}</dd>" for name, value in facts.items())


def _contact(challenge: Challenge) -> str:
    contact = challenge.contact
    if "@" in contact and " " not in contact:
        return f'<a href="mailto:{text(contact)}">{text(contact)}</a>'
    return link(contact, contact)


def _bundle(challenge: Challenge) -> str:
    name = f"{challenge.name}.zip"
    return f"Get {link(challenge.bundle, name) if challenge.bundle else f'<code>{text(name)}</code>'}."


def _table(name: str, heads: list[tuple[str, str]], body: str) -> str:
    """A table that scrolls; heads are words and a class."""
    cells = "".join(f'<th scope="col" class="{kind}">{text(words)}</th>' for words, kind in heads)
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{text(name)}"><table class="plain">'
        f"<thead><tr>{cells}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _phases(challenge: Challenge, moment: datetime) -> str:
    heads = [("Phase", ""), ("Now", ""), ("First day", ""), ("Last day", ""), ("Submissions", "num")]
    heads += [("What counts", "")]
    return _table("Table of phases", heads, "".join(_phase(phase, moment) for phase in challenge.phases))


def _phase(phase: Phase, moment: datetime) -> str:
    current = ' aria-current="true"' if phase.is_open(moment) else ""
    return (
        f'<tr{current} data-phase="{text(phase.name)}" data-first="{phase.start}" data-last="{phase.end}" '
        f'data-opens="{phase.opens.isoformat()}" data-closes="{phase.closes.isoformat()}">'
        f'<th scope="row">{text(phase.name)}</th><td class="state">{phase.state(moment)}</td>'
        f'<td>{phase.start}</td><td>{phase.end}</td><td class="num">{phase.submissions} a team</td>'
        f'<td class="words">{text(phase_words(phase).capitalize())}</td></tr>'
    )


def _teams(organiser: Organiser) -> str:
    challenge = organiser.challenge
    if not challenge.teams:
        return '<p class="note">No team has registered yet.</p>'
    heads = [("Team", ""), ("Members", ""), *((f"Used in {phase.name}", "num") for phase in challenge.phases)]
    taken = [(entry.team, entry.phase) for entry in organiser.entries if entry.is_accepted]
    rows = (
        f'<tr><th scope="row">{text(team.name)}</th><td class="words">{text(team.members)}</td>'
        + "".join(
            f'<td class="num">{taken.count((team.name, phase.name))} of {phase.submissions}</td>'
            for phase in challenge.phases
        )
        + "</tr>"
        for team in challenge.teams
    )
    return _table("Table of teams", heads, "".join(rows))


def _standings(part: Part, rows: list[Row], over: bool) -> str:
    title = f"<h3>{part.capitalize()} part</h3>"
    if not rows:
        return f'{title}<p class="note">{_NOBODY[part]}</p>'
    count = rows[0].result.score
    lead = f"{count['sequences']} of {count['sequences_in_dataset']} sequences. {_LEADS[part]}{_RANKED}"
    more = f' <a href="{part}/index.html">All figures of this part</a>.' if over else ""
    heads = [("Rank", "num"), ("Team", ""), ("Δx m", "num"), ("95 % interval", "num"), ("Lost", "num")]
    heads += [("Δt m", "num"), ("Δr rad", "num"), ("Solver", ""), ("Handed in", "")]
    body = ""
    for group, words in GROUPS.items():
        own = [_row(row) for row in rows if row.result.group == group]
        head = f'<tr class="apart"><th colspan="{len(heads)}" scope="rowgroup">{words}</th></tr>' if words else ""
        body += "".join([head, *own]) if own else ""
    return f'{title}<p class="lead">{text(lead)}{more}</p>{_table(f"Table of the {part} part", heads, body)}'


_NOT_YET = '<p class="note">Everything counts on the hidden part, which is scored after the end.</p>'
_NOBODY: dict[Part, str] = {
    "public": "No submission has been taken yet.",
    "hidden": "The hidden part has not been scored yet.",
}
_LEADS: dict[Part, str] = {
    "public": "The last submission of each team counts. ",
    "hidden": "The last submission of each team in the last phase counts: the result of the challenge. ",
}
_RANKED = "Ranks are by Δx, capped; teams between which nothing is settled share one."


def _row(row: Row) -> str:
    result, place = row.result, row.place
    figure, lost = headline(result, "dx"), failure_rate(result)
    interval = NONE if figure.low is None or figure.high is None else f"{figure.low:.3f}–{figure.high:.3f}"
    others = "".join(f'<td class="num">{_figure(headline(result, metric).value)}</td>' for metric in ("dt", "dr"))
    ranks = "" if place.best == place.worst else f" ({place.best}–{place.worst})"
    timing = f", {result.about.timing}" if result.about.sees_the_future else ""
    return (
        f'<tr><td class="num">{place.rank}{ranks}</td><th scope="row">{text(result.solver)}</th>'
        f'<td class="num">{_figure(figure.value)}</td><td class="num">{interval}</td>'
        f'<td class="num">{NONE if lost is None else percent(lost)}</td>{others}'
        f'<td class="words">{link(result.about.code, result.about.reference + timing)}</td>'
        f"<td>{row.entry.day}, number {row.entry.number}</td></tr>"
    )


def _figure(value: float | None) -> str:
    return NONE if value is None else f"{value:.3f}"
