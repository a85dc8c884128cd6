"""Submissions to a challenge: copied, checked, taken or refused; and the end, when the hidden part is scored."""

import hashlib
import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from vbbench.errors import FileError, SubmissionError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.folders.locks import NO_LINKS, locked
from vbbench.folders.work_folder import WorkFolder
from vbbench.geometry import wrap_angle
from vbbench.scoring import score
from vbbench.scoring.answers import OR_HOLD, Checked, CheckedSubmission, check_submission
from vbbench.solving import solve
from vbbench_leaderboards.challenge.definition import BASELINE, Challenge, Part, parse_moment
from vbbench_leaderboards.challenge.organiser import Entry, Organiser, append, digest_of_last
from vbbench_leaderboards.challenge.standings import standings_text
from vbbench_leaderboards.results.ranking import headline
from vbbench_leaderboards.results.result import NOBODY_YET, TABLES, About, Result, file_hashes, write_result

FILES = (SUBMISSION_FILE, *TABLES)
MOST_BYTES = 1 << 30
"""Of one file: no answer to a challenge is larger."""


def accept(folder: Path, submission: Path, team: str, moment: datetime, **about: Any) -> str:
    """Take a submission of a team into the challenge in ``folder``; return the receipt, for people.

    Accepted or refused, it is written into the log. Raises VbbenchError if it is refused: the team is unknown, no phase
    is open, the team has used up its submissions, the submission has faults, answers something else, or repeats what
    another team handed in.

    Parameters
    ----------
    moment : when it was handed in.
    about : facts of the team's row (`About`) that replace or complete what the submission declares.
    """
    organiser = Organiser(folder)
    if team != BASELINE:
        organiser.challenge.check_team(team)
        _take_baseline(organiser, moment)
        organiser = Organiser(folder)
    with locked(folder):
        _ = organiser.parts  # what is wrong with the challenge is no refusal of a team
        entries, phase = organiser.entries, organiser.challenge.phase_at(moment)
        blank = Entry(
            number=len(entries) + 1,
            time=moment.isoformat(timespec="seconds"),
            written=parse_moment("").isoformat(timespec="seconds"),
            team=team,
            phase=phase.name if phase else "",
            decision="accepted",
            before=digest_of_last(entries),
        )
        try:
            return _take(organiser, submission, blank, moment, about)
        except VbbenchError as error:
            refused = replace(blank, decision="refused", reason=str(error).partition("\n")[0])
            append(folder, entries, refused)
            raise


def _take_baseline(organiser: Organiser, moment: datetime) -> None:
    """Take the baseline's answers into the phase that is open, unless they are there."""
    challenge, phase = organiser.challenge, organiser.challenge.phase_at(moment)
    if not challenge.baseline or phase is None or BASELINE in organiser.last_accepted({phase.name}):
        return
    with TemporaryDirectory() as room:
        answers = solve(Dataset(organiser.data), challenge.baseline, challenge.protocol, Path(room) / "answers")
        accept(organiser.folder, answers, BASELINE, phase.opens)


def _take(organiser: Organiser, submission: Path, blank: Entry, moment: datetime, facts: dict[str, Any]) -> str:
    challenge, team, accepted = organiser.challenge, blank.team, [one for one in organiser.entries if one.is_accepted]
    last = max((entry.time for entry in accepted if entry.team == team), default="")
    if last and moment < datetime.fromisoformat(last):  # the last one is the one that counts
        raise VbbenchError(f"{blank.time} is before the last submission of {team}, taken at {last}; check `date`")
    phase = challenge.open_phase(moment)
    own = [each for each in accepted if (each.team, each.phase) == (team, phase.name)]
    with _copied(submission, organiser.folder / blank.folder) as work:
        try:
            info = check(challenge, work.new, organiser.dataset).info
        except VbbenchError as error:  # it is named as it was handed in
            raise VbbenchError(*str(error).replace(str(work.new), str(submission)).split("\n")) from error
        about = About.of(info, **{"date": blank.day, **facts})
        if about.authors.strip() == NOBODY_YET:
            raise VbbenchError(f"the authors are '{NOBODY_YET}', as in the template; name who made the solver")
        answers = digest_of_answers(work.new, organiser.dataset)
        if own and own[-1].answers == answers:
            before = f"handed these answers in before, in phase {phase.name} on {own[-1].day} (number {own[-1].number})"
            return f"{challenge.name}: {team} {before}; they count already, and nothing was added"
        if len(own) >= phase.submissions:
            used = f"{team} has used its {phase.submissions} submissions of phase {phase.name}"
            raise VbbenchError(f"{used}, the last on {own[-1].day}")
        for other in accepted:
            if other.answers == answers and other.team != team:
                where = f"on {other.day} (submission {other.number})"
                raise VbbenchError(f"these are the answers that {other.team} handed in {where}; hand in your own")
        entry = replace(blank, answers=answers, files=file_hashes(work.new, FILES), about=vars(about))
        result = result_of(organiser, entry, work.new, "public") if phase.part == "public" else None
        work.publish()
    if result is not None:
        write_result(result, organiser.results("public"), organiser.record("public"))
    append(organiser.folder, organiser.entries, entry)
    counts = f"submission {len(own) + 1} of {phase.submissions}, number {entry.number}"
    taken = f"{challenge.name}: taken from {team} in phase {phase.name}, {counts}\nSHA-256 of its answers: {answers}"
    if result is None:
        return f"{taken}\nThis phase counts on the hidden part, which is scored after its end."
    dx, dt, dr = (f"{headline(result, metric).value:.4f}" for metric in ("dx", "dt", "dr"))
    sequences = f"{result.score['sequences']} of {result.score['sequences_in_dataset']} sequences"
    return f"{taken}\nPublic part, {sequences}, capped: Δx {dx} m, Δt {dt} m, Δr {dr} rad"


def check(challenge: Challenge, submission: Path, dataset: Dataset) -> Checked:
    """Check all that can be checked without truth: what `vbbench check` does, and the challenge's own demands.

    Raises VbbenchError if it answers another dataset, or another protocol, or has faults; every fault of its rows is
    listed.
    """
    info, name, refuses = SubmissionInfo.read(submission), challenge.name, challenge.missing_rows == "refuse"
    if info.dataset != dataset.info.id:
        wanted = f"{name} is dataset {dataset.info.id}, solve that"
        raise VbbenchError(f"{submission} answers dataset {info.dataset}; {wanted}")
    if info.protocol != challenge.protocol:
        problem = f"is solved under {info.protocol}; {name} is held under {challenge.protocol}, solve it so"
        raise VbbenchError(f"{submission} {problem}")
    if refuses and info.failure_policy != "refuse":
        policy = f"failure_policy is '{info.failure_policy}'"
        raise VbbenchError(f"{submission}: {policy}; {name} wants every answer: 'refuse'")
    try:
        return check_submission(submission, dataset)
    except SubmissionError as error:
        faults = tuple(fault.replace(OR_HOLD, "") if refuses else fault for fault in error.faults)
        raise SubmissionError(submission, faults) from error


def result_of(organiser: Organiser, entry: Entry, submission: Path, part: Part) -> Result:
    """The figures of a submission on a part alone."""
    figures = score(submission, organiser.data, organiser.truth, sequences=organiser.parts[part])
    about = About(**entry.about)
    described = f"{figures.info.solver} {figures.info.version}".strip()
    return Result.of(figures, submission, replace(about, reference=about.reference or described), name=entry.team)


def close(folder: Path, moment: datetime) -> str:
    """Score the last submission of each team in the hidden phase on the hidden part; return the standings as text.

    Raises VbbenchError if the challenge has no hidden phase, it has not closed, nobody handed anything in, or a kept
    submission was changed.
    """
    organiser = Organiser(folder)
    name, phase = organiser.challenge.name, organiser.challenge.hidden_phase
    if phase is None:
        raise VbbenchError(f"{name} has no hidden phase; its standings are those of the public part")
    if not organiser.shows_hidden(moment):
        raise VbbenchError(f"{name}: the hidden part is scored when phase {phase.name} has closed, after {phase.end}")
    with locked(folder):
        counting = organiser.last_accepted({phase.name})
        if not counting:
            raise VbbenchError(f"{name}: no team handed anything in in phase {phase.name}")
        for entry in counting.values():
            kept = folder / entry.folder
            if file_hashes(kept, FILES) != entry.files:
                raise FileError(kept, f"is not what was handed in on {entry.day}: its SHA-256 differ from the log's")
            result = result_of(organiser, entry, kept, "hidden")
            write_result(result, organiser.results("hidden"), organiser.record("hidden"))
    return standings_text(organiser, moment)


@contextmanager
def _copied(submission: Path, place: Path) -> Iterator[WorkFolder]:
    """The files of a submission in the folder ``new`` of the work on ``place``: what is checked is what is kept.

    Raises VbbenchError if one of them is a link or no plain file: links could lead to the truth; or if it is too large.
    """
    if not submission.is_dir():
        raise FileError(submission, "is not a folder; unpack the submission")
    with WorkFolder(place) as work:
        work.begin()
        work.new.mkdir()
        for name in (name for name in FILES if os.path.lexists(submission / name)):
            _copy(submission / name, work.new / name)
        yield work


def _copy(path: Path, copy: Path) -> None:
    try:
        handle = os.open(path, os.O_RDONLY | NO_LINKS | getattr(os, "O_NONBLOCK", 0))
    except OSError as error:
        raise FileError(path, "is a link or cannot be read; hand in the file itself") from error
    with os.fdopen(handle, "rb") as source:
        facts = os.fstat(source.fileno())
        if not stat.S_ISREG(facts.st_mode) or facts.st_size > MOST_BYTES:
            raise FileError(path, f"is not a plain file of at most {MOST_BYTES >> 20} MB; hand in the file itself")
        with copy.open("wb") as target:
            shutil.copyfileobj(source, target)


def digest_of_answers(submission: Path, dataset: Dataset) -> str:
    """SHA-256 of what a submission without a fault answers.

    It does not depend on how the rows are stored, on their order, on rows that need no answer, or on full turns of yaw.
    """
    whole = hashlib.sha256()
    for _, answers in CheckedSubmission(submission, dataset, None).chunks():
        poses = np.column_stack([answers.poses[:, :2], wrap_angle(answers.poses[:, 2])])
        for values in (poses, answers.positions):
            whole.update((values.astype("<f8") + 0).tobytes())
    return whole.hexdigest()
