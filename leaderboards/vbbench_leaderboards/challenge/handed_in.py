"""A submission that was handed in: copied into the challenge's folder first; what is checked is what is kept."""

import hashlib
import os
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vbbench.errors import FileError, SubmissionError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.files.tables import file_sha256
from vbbench.folders.locks import NO_LINKS
from vbbench.folders.work_folder import WorkFolder
from vbbench.geometry import wrap_angle
from vbbench.scoring.answers import OR_HOLD, Checked, CheckedSubmission, check_submission
from vbbench_leaderboards.challenge.definition import Challenge

FILES = (SUBMISSION_FILE, "poses.parquet", "positions.parquet", "poses.csv", "positions.csv")
MOST_BYTES = 1 << 30
"""Of one file: no answer to a challenge is larger."""


@contextmanager
def copied(submission: Path, place: Path) -> Iterator[WorkFolder]:
    """The files of a submission in the folder ``new`` of the work on ``place``, which it becomes when published.

    Raises
    ------
    VbbenchError
        If one of them is a link or no plain file: links could lead to the truth; or if it is too large.
    """
    if not submission.is_dir():
        raise FileError(submission, "is not a folder; unpack the submission")
    with WorkFolder(place) as work:
        work.begin()
        work.new.mkdir()
        for name in FILES:
            if os.path.lexists(submission / name):
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


def file_hashes(folder: Path) -> dict[str, str]:
    """File → SHA-256 of every file of a submission."""
    return {name: file_sha256(folder / name) for name in FILES if (folder / name).is_file()}


def check(challenge: Challenge, submission: Path, dataset: Dataset) -> Checked:
    """Check all that can be checked without truth: what `vbbench check` does, and what the challenge asks besides.

    Raises
    ------
    VbbenchError
        If it answers another dataset, or another protocol, or has faults; every fault of its rows is listed.
    """
    info = SubmissionInfo.read(submission)
    if info.dataset != dataset.info.id:
        raise VbbenchError(
            f"{submission} answers dataset {info.dataset}; {challenge.name} is dataset {dataset.info.id}, solve that"
        )
    if info.protocol != challenge.protocol:
        raise VbbenchError(
            f"{submission} is solved under {info.protocol}; {challenge.name} is held under {challenge.protocol}, "
            "solve it so"
        )
    if challenge.missing_rows == "refuse" and info.failure_policy != "refuse":
        raise VbbenchError(
            f"{submission}: failure_policy is '{info.failure_policy}'; {challenge.name} wants every answer: 'refuse'"
        )
    try:
        return check_submission(submission, dataset)
    except SubmissionError as error:
        if challenge.missing_rows == "refuse":
            raise SubmissionError(submission, tuple(fault.replace(OR_HOLD, "") for fault in error.faults)) from error
        raise


def digest_of_answers(submission: Path, dataset: Dataset) -> str:
    """SHA-256 of what a submission without a fault answers.

    It is the same however its rows are stored, in which order, whatever rows stand there beside those that must be
    answered, and however often yaws go round.
    """
    whole = hashlib.sha256()
    for _, answers in CheckedSubmission(submission, dataset, None).chunks():
        poses = answers.poses.copy()
        poses[:, 2] = wrap_angle(poses[:, 2])
        for values in (poses, answers.positions):
            whole.update((values.astype("<f8") + 0).tobytes())
    return whole.hexdigest()
