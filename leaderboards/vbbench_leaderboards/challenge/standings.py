"""Who leads: the standings of the public part, and those of the hidden part once they may be shown."""

import warnings
from dataclasses import dataclass
from datetime import datetime

from vbbench.errors import FileError, VbbenchWarning
from vbbench_leaderboards.challenge.definition import Part
from vbbench_leaderboards.challenge.log import Entry
from vbbench_leaderboards.challenge.organiser import Organiser
from vbbench_leaderboards.results.folder import read_results
from vbbench_leaderboards.results.ranking import Place
from vbbench_leaderboards.results.result import Result
from vbbench_leaderboards.results.standings import failure_rate, headline, rank_apart


@dataclass(frozen=True, kw_only=True)
class Row:
    """A team in the standings of a part: its place by Δx, its result, and the submission that it is of."""

    place: Place
    result: Result
    entry: Entry


def standings(organiser: Organiser, part: Part) -> list[Row]:
    """The rows of a part, group by group of solvers that compete, the best first.

    Results that no submission in the log accounts for are left out, with a warning.
    """
    found, rows = _results(organiser, part), []
    if not found:
        return []
    places = rank_apart([result for result, _ in found])["dx"].places
    for result, entry in found:
        rows.append(Row(place=places[result.solver], result=result, entry=entry))
    return sorted(rows, key=lambda row: (row.result.group, row.place.rank, _dx(row.result)))


def _results(organiser: Organiser, part: Part) -> list[tuple[Result, Entry]]:
    counting, found = organiser.last_of_part(part), list[tuple[Result, Entry]]()
    unusable: list[FileError] = []
    boards = read_results(organiser.results(part), unusable=unusable)
    for error in unusable:
        warnings.warn(VbbenchWarning(f"LEFT OUT of the standings: {error}"), stacklevel=2)
    for result in (result for rows in boards.values() for result in rows):
        entry = counting.get(result.solver)
        tables = {} if entry is None else {name: sha for name, sha in entry.files.items() if name in result.submission}
        if entry is None or tables != result.submission:
            path = organiser.results(part) / result.path
            reason = "no submission in the log accounts for it; it came in another way than 'challenge accept'"
            warnings.warn(VbbenchWarning(f"LEFT OUT of the standings: {path}: {reason}"), stacklevel=2)
            continue
        found.append((result, entry))
    return found


def shown_parts(organiser: Organiser, moment: datetime) -> list[Part]:
    """The parts whose standings may be shown, the one that counts first."""
    counting = {phase.part for phase in organiser.challenge.phases}
    parts: list[Part] = ["hidden", "public"] if organiser.shows_hidden(moment) else ["public"]
    return [part for part in parts if part in counting]


def standings_text(organiser: Organiser, moment: datetime) -> str:
    """The standings that may be shown, for people."""
    blocks = []
    for part in shown_parts(organiser, moment):
        rows = standings(organiser, part)
        if rows:
            count = rows[0].result.score
            head = f"{part} part, {count['sequences']} of {count['sequences_in_dataset']} sequences"
            columns = f"  {'rank':>4}  {'team':<20} {'Δx m':>8} {'95 % interval':>15} {'lost':>6}  submission"
            blocks.append("\n".join([head, columns, *map(_line, rows)]))
    return "\n".join(blocks) or "no standings yet"


def _line(row: Row) -> str:
    figure, lost = headline(row.result, "dx"), failure_rate(row.result)
    interval = "–" if figure.low is None or figure.high is None else f"{figure.low:.4f}–{figure.high:.4f}"
    future = f", {row.result.about.timing}" if row.result.about.sees_the_future else ""
    future += f", {row.result.seen} on these recordings" if row.result.seen else ""
    return (
        f"  {row.place.rank:>4}  {row.result.solver:<20} {_dx(row.result):>8.4f} {interval:>15} "
        f"{'' if lost is None else f'{lost:.0%}':>6}  {row.entry.number} of {row.entry.day}{future}"
    )


def _dx(result: Result) -> float:
    value = headline(result, "dx").value
    return float("inf") if value is None else value


def status_text(organiser: Organiser, moment: datetime) -> str:
    """Phases, teams, and what the log says, for people."""
    challenge, entries = organiser.challenge, organiser.entries
    lines = [
        f"{challenge.name}: {challenge.title}, {moment:%Y-%m-%d %H:%M} UTC",
        *(
            f"  {phase.name:<16} {phase.start} to {phase.end}, {phase.part} part, {phase.submissions} a team: "
            f"{phase.state(moment)}"
            for phase in challenge.phases
        ),
    ]
    for team in challenge.teams:
        own = [entry for entry in entries if entry.team == team.name]
        taken = ", ".join(
            f"{sum(entry.is_accepted and entry.phase == phase.name for entry in own)} of {phase.submissions} in "
            f"{phase.name}"
            for phase in challenge.phases
        )
        refused = sum(not entry.is_accepted for entry in own)
        lines.append(f"  {team.name:<16} {taken}" + (f"; {refused} refused" if refused else ""))
    lines.append(f"  log: {len(entries)} submissions, none changed later")
    return "\n".join([*lines, standings_text(organiser, moment)])
