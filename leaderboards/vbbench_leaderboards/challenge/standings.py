"""Who leads: the standings of the public part, and those of the hidden part once they may be shown."""

import warnings
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path

from vbbench import __version__
from vbbench.errors import FileError, VbbenchWarning
from vbbench.folders.work_folder import WorkFolder
from vbbench_leaderboards.challenge.definition import Part
from vbbench_leaderboards.challenge.organiser import Entry, Organiser, digest_of_last
from vbbench_leaderboards.results.folder import read_results
from vbbench_leaderboards.results.ranking import Place, failure_rate, headline, rank_apart, ranking_figure
from vbbench_leaderboards.results.result import Result, write_result
from vbbench_leaderboards.site.pages import MARKER, SITE, assets, build, check_made, render, write_files


@dataclass(frozen=True, kw_only=True)
class Row:
    """A team in the standings of a part: its place by Δx, its result, and the submission that it is of."""

    place: Place
    result: Result
    entry: Entry

    def text(self) -> str:
        """Its line of the standings."""
        result, about, seen = self.result, self.result.about, self.result.seen
        figure, lost = headline(result, "dx"), failure_rate(result)
        ends = "–" if figure.low is None or figure.high is None else f"{figure.low:.4f}–{figure.high:.4f}"
        facts = f", {about.timing}" * about.sees_the_future + f", {seen} on these recordings" * bool(seen)
        who = f"  {self.place.rank:>4}  {result.solver:<20} {ranking_figure(result):>8.4f} {ends:>15}"
        return f"{who} {'' if lost is None else f'{lost:.0%}':>6}  {self.entry.number} of {self.entry.day}{facts}"


def standings(organiser: Organiser, part: Part) -> list[Row]:
    """The rows of a part, group by group of solvers that compete, the best first.

    Results that no submission in the log accounts for are omitted, with a warning.
    """
    counting = organiser.last_accepted({phase.name for phase in organiser.challenge.phases if phase.part == part})
    unusable, folder, found = list[FileError](), organiser.results(part), list[Result]()
    for result in (one for rows in read_results(folder, unusable=unusable).values() for one in rows):
        entry = counting.get(result.solver)
        if entry and {name: sha for name, sha in entry.files.items() if name in result.submission} == result.submission:
            found.append(result)
        else:
            reason = "no submission in the log accounts for it; it came in another way than 'challenge accept'"
            unusable.append(FileError(folder / result.path, reason))
    for fault in unusable:
        warnings.warn(VbbenchWarning(f"OMITTED from the standings: {fault}"), stacklevel=2)
    places = rank_apart(found)["dx"].places
    rows = [Row(place=places[one.solver], result=one, entry=counting[one.solver]) for one in found]
    return sorted(rows, key=lambda row: (row.result.group, row.place.rank, ranking_figure(row.result)))


def shown_standings(organiser: Organiser, moment: datetime) -> dict[Part, list[Row]]:
    """The standings of the parts that may be shown, the one that counts first."""
    parts: list[Part] = ["hidden", "public"] if organiser.shows_hidden(moment) else ["public"]
    counting = {phase.part for phase in organiser.challenge.phases}
    return {part: standings(organiser, part) for part in parts if part in counting}


def standings_text(organiser: Organiser, moment: datetime) -> str:
    """The standings that may be shown at a ``moment``, as text for a terminal."""
    blocks = []
    for part, rows in shown_standings(organiser, moment).items():
        if rows:
            count = rows[0].result.score
            head = f"{part} part, {count['sequences']} of {count['sequences_in_dataset']} sequences"
            columns = f"  {'rank':>4}  {'team':<20} {'Δx m':>8} {'95 % interval':>15} {'lost':>6}  submission"
            blocks.append("\n".join([head, columns, *(row.text() for row in rows)]))
    return "\n".join(blocks) or "no standings yet"


def build_challenge(out: Path, folder: Path, moment: datetime) -> Path:
    """Write the page of the challenge in ``folder`` into ``out``; return the path of the page.

    Raises VbbenchError if ``out`` exists and is not a site, or the challenge cannot be read.
    """
    organiser = Organiser(folder)
    challenge, dataset, entries = organiser.challenge, organiser.dataset, organiser.entries
    info, over, rows = dataset.info, challenge.is_over(moment), shown_standings(organiser, moment)
    page = render(
        "challenge.html",
        challenge=challenge,
        moment=moment,
        standings=rows,
        over=over,
        taken=[(entry.team, entry.phase) for entry in entries if entry.is_accepted],
        pairs={
            "Protocol": challenge.protocol,
            "Data": f"{info.split}, tier {info.tier}, {len(dataset)} sequences, dataset {info.id}",
            "Truth": f"withheld, SHA-256 {info.truth_sha256}",
            "Log": f"{len(entries)} submissions, SHA-256 {digest_of_last(entries)}",
            "Licence": challenge.licence,
        },
    )
    own = {name: assets()[name] for name in ("assets/page.css", "assets/page.js")}
    with WorkFolder(out, partial(check_made, out, SITE, MARKER)) as work:
        work.begin()
        work.new.mkdir()
        for part, own_rows in rows.items() if over else ():
            results = work.new / "results" / part
            for row in own_rows:
                write_result(row.result, results, organiser.record(part))
            if own_rows:
                build(work.new / part, results)
        write_files(work.new, {MARKER: f"vbbench {__version__}\n", "index.html": page, **own})
        work.publish()
    return out / "index.html"
