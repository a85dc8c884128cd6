"""Takes a submission into a challenge, or refuses it and says why; either is written into the log."""

from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any

from vbbench.errors import VbbenchError
from vbbench.folders.locks import locked
from vbbench.scoring import score
from vbbench_leaderboards.challenge.definition import Part, Phase, parse_moment
from vbbench_leaderboards.challenge.handed_in import check, copied, digest_of_answers, file_hashes
from vbbench_leaderboards.challenge.log import Entry, append, digest_of_last, said
from vbbench_leaderboards.challenge.organiser import Organiser
from vbbench_leaderboards.results.about import NOBODY_YET, About
from vbbench_leaderboards.results.result import Result, write_result
from vbbench_leaderboards.results.standings import headline


@dataclass(frozen=True, kw_only=True)
class Receipt:
    """What a team is told.

    Parameters
    ----------
    challenge : its name.
    entry : its line of the log.
    phase : the phase it was taken in.
    used : submissions of the team in this phase, this one included.
    result : figures on the public part; ``None`` in a hidden phase.
    is_again : whether the team's same answers were taken before, in the same phase: nothing was added.
    """

    challenge: str
    entry: Entry
    phase: Phase
    used: int
    result: Result | None
    is_again: bool = False

    def text(self) -> str:
        """The receipt, for people."""
        if self.is_again:
            return (
                f"{self.challenge}: {self.entry.team} handed these answers in before, in phase {self.phase.name} on "
                f"{self.entry.day} (number {self.entry.number}); they count already, and nothing was added"
            )
        lines = [
            f"{self.challenge}: taken from {self.entry.team} in phase {self.phase.name}, submission {self.used} of "
            f"{self.phase.submissions}, number {self.entry.number}",
            f"SHA-256 of its answers: {self.entry.answers}",
        ]
        if self.result is None:
            return "\n".join([*lines, "This phase counts on the hidden part, which is scored after its end."])
        sequences = f"{self.result.score['sequences']} of {self.result.score['sequences_in_dataset']}"
        figures = ", ".join(
            f"{name} {headline(self.result, metric).value:.4f} {unit}"
            for metric, name, unit in (("dx", "Δx", "m"), ("dt", "Δt", "m"), ("dr", "Δr", "rad"))
        )
        return "\n".join([*lines, f"Public part, {sequences} sequences, capped: {figures}"])


def accept(folder: Path, submission: Path, team: str, moment: datetime, **about: Any) -> Receipt:
    """Take a submission of a team into the challenge in ``folder``.

    Parameters
    ----------
    moment : when it was handed in.
    about : facts of the team's row (`About`) that replace or complete what the submission declares.

    Raises
    ------
    VbbenchError
        If it is refused: the team is unknown, no phase is open, the team has used up its submissions, the submission
        has faults, answers something else, or repeats what another team handed in.
    """
    organiser = Organiser(folder)
    organiser.challenge.team(team)
    with locked(folder):
        _ = organiser.parts  # what is wrong with the challenge is no refusal of a team
        entries = organiser.entries
        blank = Entry(
            number=len(entries) + 1,
            time=said(moment),
            written=said(parse_moment("")),
            team=team,
            phase="",
            decision="accepted",
            before=digest_of_last(entries),
        )
        try:
            _check_order(entries, team, moment)
            return _take(organiser, submission, blank, moment, about)
        except VbbenchError as error:
            phase = organiser.challenge.phase_at(moment)
            reason = str(error).partition("\n")[0]
            append(
                folder, entries, replace(blank, phase=phase.name if phase else "", decision="refused", reason=reason)
            )
            raise


def _check_order(entries: list[Entry], team: str, moment: datetime) -> None:
    """Raise VbbenchError if one of the team was taken at a later time: its last is the one that counts."""
    last = max((entry.time for entry in entries if entry.is_accepted and entry.team == team), default="")
    if last and moment < datetime.fromisoformat(last):
        raise VbbenchError(f"{said(moment)} is before the last submission of {team}, taken at {last}; check `date`")


def _take(organiser: Organiser, submission: Path, blank: Entry, moment: datetime, facts: dict[str, Any]) -> Receipt:
    phase = organiser.challenge.open_phase(moment)
    own = [
        each for each in organiser.entries if each.is_accepted and (each.team, each.phase) == (blank.team, phase.name)
    ]
    with copied(submission, organiser.folder / blank.folder) as work:
        info = _checked(organiser, work.new, submission)
        about = About.of(info, **{"date": blank.day, **facts})
        _check_authors(about)
        entry = replace(
            blank,
            phase=phase.name,
            answers=digest_of_answers(work.new, organiser.dataset),
            files=file_hashes(work.new),
            about=vars(about),
        )
        if own and own[-1].answers == entry.answers:
            name = organiser.challenge.name
            return Receipt(challenge=name, entry=own[-1], phase=phase, used=len(own), result=None, is_again=True)
        _check_limit(own, phase)
        _check_new(organiser.entries, entry)
        result = result_of(organiser, entry, work.new, "public") if phase.part == "public" else None
        work.publish()
    if result is not None:
        write_result(result, organiser.results("public"), organiser.record("public"))
    append(organiser.folder, organiser.entries, entry)
    return Receipt(challenge=organiser.challenge.name, entry=entry, phase=phase, used=len(own) + 1, result=result)


def _check_authors(about: About) -> None:
    """Raise VbbenchError if they are those of the template."""
    if about.authors.strip() == NOBODY_YET:
        raise VbbenchError(f"the authors are '{NOBODY_YET}', as the template has it; say who made the solver")


def _checked(organiser: Organiser, copy: Path, submission: Path) -> Any:
    """The facts of a submission without a fault; messages name it as it was handed in."""
    try:
        return check(organiser.challenge, copy, organiser.dataset).info
    except VbbenchError as error:
        raise VbbenchError(*str(error).replace(str(copy), str(submission)).split("\n")) from error


def _check_limit(own: list[Entry], phase: Phase) -> None:
    """Raise VbbenchError if these submissions of a team in a phase are all that it has."""
    if len(own) >= phase.submissions:
        raise VbbenchError(
            f"{own[-1].team} has used its {phase.submissions} submissions of phase {phase.name}, the last on "
            f"{own[-1].day}"
        )


def _check_new(entries: list[Entry], entry: Entry) -> None:
    """Raise VbbenchError if another team has handed in the same answers."""
    for other in entries:
        if other.is_accepted and other.answers == entry.answers and other.team != entry.team:
            raise VbbenchError(
                f"these are the answers that {other.team} handed in on {other.day} (submission {other.number}); "
                "hand in your own"
            )


def result_of(organiser: Organiser, entry: Entry, submission: Path, part: Part) -> Result:
    """The figures of a submission on a part alone."""
    figures = score(submission, organiser.data, organiser.truth, sequences=organiser.parts[part])
    about = About(**entry.about)
    described = f"{figures.info.solver} {figures.info.version}".strip()
    about = replace(about, reference=about.reference or described)
    return Result.of(figures, submission, about, name=entry.team)
