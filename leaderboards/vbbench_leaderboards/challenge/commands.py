"""Commands of a challenge: parse, call one library function, print."""

from collections.abc import Callable
from pathlib import Path
from typing import Any


def new(folder: Path, /) -> None:
    """Make a folder for a challenge, with a commented challenge.toml to fill in.

    Args:
        folder: Folder to write into; what is yours in it is not overwritten.
    """
    from vbbench.folders.replacing import copy_templates
    from vbbench_leaderboards.challenge.definition import START
    from vbbench_leaderboards.results.folder import CHALLENGE_FILE

    print(*copy_templates(folder, {CHALLENGE_FILE: START}))


def generate(folder: Path, /, jobs: int = 1) -> None:
    """Make the secret set that challenge.toml describes: FOLDER/data, and its truth and seed in FOLDER/data.truth.

    Args:
        folder: The challenge.
        jobs: Processes; the bytes do not depend on it.
    """
    from vbbench.cli import data
    from vbbench.cli.parsing import parse
    from vbbench_leaderboards.challenge.organiser import generate as make

    make(folder, lambda words: parse({"generate": data.generate}, [*words, "--jobs", str(jobs)])())


def bundle(folder: Path, /, out: Path, archive: bool = False) -> None:
    """Make what participants get: the data without truth, their card, licence, rules and commands.

    Args:
        folder: The challenge.
        out: Folder to make; replaced only if it is such a bundle.
        archive: Also write OUT.zip, whose bytes are the same on every machine.
    """
    from vbbench_leaderboards.challenge.bundle import make_bundle

    print(*make_bundle(folder, out, archive=archive), sep="\n")


def check(submission: Path, /, challenge: Path) -> None:
    """Check everything about a submission to a challenge that needs no truth, as its organiser will.

    Args:
        submission: Folder with submission.json, poses and positions (.parquet or .csv).
        challenge: The participants' bundle, or the organiser's folder.
    """
    from vbbench_leaderboards.challenge.bundle import check_for_participant

    print(check_for_participant(submission, challenge))


def accept(submission: Path, /, challenge: Path, team: str, date: str = "") -> None:
    """Take a team's submission into a challenge, or refuse it and say why; both are kept in its log.

    Args:
        submission: Folder with submission.json, poses and positions (.parquet or .csv).
        challenge: The organiser's folder.
        team: Whose it is, as in challenge.toml.
        date: When it was handed in, YYYY-MM-DD or YYYY-MM-DDTHH:MM, in UTC; default: now.
    """
    from vbbench_leaderboards.challenge import submissions
    from vbbench_leaderboards.challenge.definition import parse_moment

    print(submissions.accept(challenge, submission, team, parse_moment(date)))


def close(folder: Path, /) -> None:
    """Score the hidden part, once the last phase has closed, and say who won.

    Args:
        folder: The challenge.
    """
    from vbbench_leaderboards.challenge.definition import now
    from vbbench_leaderboards.challenge.submissions import close as end

    print(end(folder, now()))


COMMANDS: dict[str, Callable[..., Any]] = {one.__name__: one for one in (accept, bundle, check, close, generate, new)}
