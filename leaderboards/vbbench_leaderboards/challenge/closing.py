"""The end of a challenge: the hidden part is scored, for the first time."""

from datetime import datetime
from pathlib import Path

from vbbench.errors import FileError, VbbenchError
from vbbench.folders.locks import locked
from vbbench_leaderboards.challenge.accepting import result_of
from vbbench_leaderboards.challenge.handed_in import file_hashes
from vbbench_leaderboards.challenge.log import Entry
from vbbench_leaderboards.challenge.organiser import Organiser
from vbbench_leaderboards.challenge.standings import standings_text
from vbbench_leaderboards.results.result import Result, write_result


def close(folder: Path, moment: datetime) -> str:
    """Score the last submission of each team in the hidden phase on the hidden part; return the standings as text.

    Raises
    ------
    VbbenchError
        If the challenge has no hidden phase, it has not closed, nobody handed anything in, or what was handed in is not
        what is kept.
    """
    organiser = Organiser(folder)
    challenge, phase = organiser.challenge, organiser.challenge.hidden_phase
    if phase is None:
        raise VbbenchError(f"{challenge.name} has no hidden phase; its standings are those of the public part")
    if not organiser.shows_hidden(moment):
        raise VbbenchError(
            f"{challenge.name}: the hidden part is scored when phase {phase.name} has closed, after {phase.end}"
        )
    with locked(folder):
        counting = organiser.last_accepted(phase.name)
        if not counting:
            raise VbbenchError(f"{challenge.name}: no team handed anything in in phase {phase.name}")
        for entry in counting.values():
            write_result(_hidden_result(organiser, entry), organiser.results("hidden"), organiser.record("hidden"))
    return standings_text(organiser, moment)


def _hidden_result(organiser: Organiser, entry: Entry) -> Result:
    kept = organiser.folder / entry.folder
    if file_hashes(kept) != entry.files:
        raise FileError(kept, f"is not what was handed in on {entry.day}: its SHA-256 differ from the log's")
    return result_of(organiser, entry, kept, "hidden")
