"""What a row says of a solver beside its figures: who made it, what it has seen, who made its figures again."""

import datetime
import re
from dataclasses import dataclass, fields, replace
from typing import Any, Literal

from vbbench.errors import VbbenchError
from vbbench.files.submission import OFFLINE, SubmissionInfo
from vbbench.parsing.dates import is_day

Delay = int | Literal["offline"]
"""Frames that an answer comes after its own frame; 0 = causal, `OFFLINE` = after the whole sequence."""

LONGEST_TEXT = 500
_CODE = re.compile(r"(https?://[^\s<>\"']{1,492})?")
NEEDED = ("authors", "trained_on", "tuned_on")
"""What every row must say."""

NOBODY_YET = "your name"
"""The authors that the template and examples name; nobody may hand them in."""


@dataclass(frozen=True, kw_only=True)
class About:
    """The facts of a row.

    Parameters
    ----------
    reference : what the solver is, or where it is described, in one line.
    code : web address of its code; may be empty.
    authors : who made it.
    date : the day of the result, YYYY-MM-DD.
    delay : whether it is causal, late or offline; see `Delay`.
    trained_on : what its parameters were learned from; "nothing" is an answer.
    tuned_on : what its makers looked at when they chose the rest; "nothing" is an answer.
    rerun_by : who made the figures again, and when; empty = nobody yet.
    """

    reference: str = ""
    code: str = ""
    authors: str
    date: str
    delay: Delay
    trained_on: str
    tuned_on: str
    rerun_by: str = ""

    @property
    def sees_the_future(self) -> bool:
        """Whether an answer may depend on frames after its own; such solvers are ranked apart."""
        return self.delay != 0

    @property
    def timing(self) -> str:
        """Causal, late or offline, in words."""
        if self.delay == OFFLINE:
            return "offline"
        return "causal" if self.delay == 0 else f"{self.delay} frame{'' if self.delay == 1 else 's'} late"

    @staticmethod
    def of(info: SubmissionInfo, **asked: Any) -> "About":
        """What a submission declares, with what is ``asked`` in its place; the day is today unless asked otherwise.

        Raises
        ------
        VbbenchError
            If something that every row must say is missing, or cannot be shown.
        """
        own = {field.name: getattr(info, field.name) for field in fields(About) if hasattr(info, field.name)}
        given = {name: value for name, value in asked.items() if value not in ("", None)}
        facts = {"date": f"{datetime.date.today()}", **own, **given}
        if facts["delay"] is None:
            raise VbbenchError(
                "a row must say whether the solver is causal: give `delay`, the frames that an answer comes after its "
                f"own (0 for none), or '{OFFLINE}'; or write it into submission.json"
            )
        for name in NEEDED:
            if not facts[name].strip():
                raise VbbenchError(f"a row must say {_WORDS[name]}: give `{name}`, or write it into submission.json")
        about = About(**facts)
        about.check()
        return about

    def check(self) -> None:
        """Raise VbbenchError if the address or the day is none."""
        if not _CODE.fullmatch(self.code):
            raise VbbenchError(f"`code` {self.code} is not an address; give one that begins with https:// or http://")
        if not is_day(self.date):
            raise VbbenchError(f"`date` {self.date} is not a day; write it as YYYY-MM-DD")

    def made_again(self, by: str) -> "About":
        """The same, with who made the figures again."""
        return replace(self, rerun_by=by)


def parse_delay(text: str) -> Delay | None:
    """The delay that a command line names; ``None`` where it names none.

    Raises
    ------
    VbbenchError
        If it is neither a number of frames nor `OFFLINE`.
    """
    if text in ("", OFFLINE):
        return OFFLINE if text else None
    if not re.fullmatch(r"[0-9]{1,6}", text):
        raise VbbenchError(f"a delay is a number of frames, 0 for a causal solver, or '{OFFLINE}', not '{text}'")
    return int(text)


_WORDS = {
    "authors": "who made the solver",
    "trained_on": "what the solver was trained on ('nothing' is an answer)",
    "tuned_on": "what the solver was tuned on by hand ('nothing' is an answer)",
}
