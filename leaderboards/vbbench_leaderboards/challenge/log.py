"""``log.jsonl``: every submission that a challenge took or refused, one line each, chained by SHA-256."""

import hashlib
import json
from dataclasses import asdict, dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Literal

from vbbench.errors import FileError
from vbbench.folders.replacing import write_text_atomically

LOG_FILE = "log.jsonl"
FIRST = "0" * 64
"""What stands for the line before the first."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A submission that was handed in.

    Parameters
    ----------
    number : from 1 on, accepted or not.
    time : when it was handed in, in UTC, and when that was written down.
    team, phase : who, and in which phase; a phase is empty where none was open.
    decision, reason : what became of it, and why it was refused.
    answers : SHA-256 of what it answers, whatever its files look like; empty where that could not be read.
    files : file → SHA-256 of each file.
    about : what the team's row says (`About`).
    before : SHA-256 of the line before.
    """

    number: int
    time: str
    written: str
    team: str
    phase: str
    decision: Literal["accepted", "refused"]
    reason: str = ""
    answers: str = ""
    files: dict[str, str] = field(default_factory=dict)
    about: dict[str, Any] = field(default_factory=dict)
    before: str = FIRST

    @property
    def is_accepted(self) -> bool:
        """Whether it counts."""
        return self.decision == "accepted"

    @property
    def folder(self) -> Path:
        """Where an accepted submission is kept, below the challenge's folder."""
        return Path("submissions", f"{self.number:04}-{self.team}")

    @property
    def day(self) -> str:
        """The day on which it was handed in."""
        return self.time[:10]

    @property
    def line(self) -> str:
        """Its line of the log."""
        return json.dumps(asdict(self), ensure_ascii=False)


def read_log(folder: Path) -> list[Entry]:
    """The entries, the first first.

    Raises
    ------
    FileError
        If a line is damaged, or was changed or removed after others were written.
    """
    path, entries, before = folder / LOG_FILE, list[Entry](), FIRST
    if not path.is_file():
        return entries
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        try:
            entry = Entry(**json.loads(line))
        except (ValueError, TypeError) as error:
            raise FileError(path, f"is damaged ({error}); restore a copy", number) from error
        if (entry.number, entry.before) != (number, before):
            raise FileError(path, "a line before this one was changed or removed; restore a copy", number)
        entries.append(entry)
        before = hashlib.sha256(line.encode()).hexdigest()
    return entries


def append(folder: Path, entries: list[Entry], entry: Entry) -> None:
    """Write the log with one entry more."""
    lines = [*(each.line for each in entries), entry.line]
    write_text_atomically(folder / LOG_FILE, "".join(f"{line}\n" for line in lines))


def digest_of_last(entries: list[Entry]) -> str:
    """SHA-256 of the last line, which stands for the whole log."""
    return hashlib.sha256(entries[-1].line.encode()).hexdigest() if entries else FIRST


def said(moment: datetime) -> str:
    """A moment as the log has it."""
    return moment.isoformat(timespec="seconds")
