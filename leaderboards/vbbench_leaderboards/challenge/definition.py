"""``challenge.toml``: all that makes a challenge, checked before anything is done with it."""

import re
import shlex
from dataclasses import dataclass
from datetime import UTC, date, datetime, time, timedelta
from pathlib import Path
from typing import Any, Literal

from vbbench.errors import FileError, VbbenchError, is_printable
from vbbench.parsing.toml_text import read_toml
from vbbench_leaderboards.markup import is_web_address
from vbbench_leaderboards.results.folder import CHALLENGE_FILE

Part = Literal["public", "hidden"]
MOST_SUBMISSIONS = 1000

_NAME = re.compile(r"[a-z0-9][a-z0-9-]{0,39}")
_TEAM = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,39}")
_OWN_OPTIONS = ("--out", "--tier", "--seed", "--withhold-truth", "--overwrite", "--scheduler", "--tls")
"""Options of ``vbbench generate`` that the challenge itself decides."""


@dataclass(frozen=True, kw_only=True)
class SecretSet:
    """The one dataset that everybody answers, and whose truth nobody has.

    Parameters
    ----------
    split, tier : of ``vbbench generate``.
    options : more of its options, as on the command line.
    public_share : share of the sequences whose scores are told while the challenge runs.
    """

    split: str
    tier: str
    options: str = ""
    public_share: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 < self.public_share < 1.0:
            raise ValueError(f"[data] public_share = {self.public_share:g}: must be between 0 and 1, such as 0.5")
        for word in self.words:
            if word.partition("=")[0].replace("_", "-") in _OWN_OPTIONS:
                raise ValueError(f"[data] options: {word} is decided by the challenge; leave it out")

    @property
    def words(self) -> list[str]:
        """The options, one by one."""
        try:
            return shlex.split(self.options)
        except ValueError as error:
            raise ValueError(f"[data] options cannot be read ({error}); write them as on the command line") from error

    def command(self, seed: str, out: str) -> str:
        """The line that makes a set like this one."""
        options = shlex.join(self.words)
        return " ".join(filter(None, ["vbbench generate", self.split, f"--tier {self.tier}", options, seed, out]))


@dataclass(frozen=True, kw_only=True)
class Phase:
    """Days on which submissions are taken.

    Parameters
    ----------
    name : of the phase.
    part : which sequences count: those of the ``public`` part, told at once, or the ``hidden`` ones, told at the end.
    start, end : first and last day, both whole, in UTC.
    submissions : most of a team in this phase.
    """

    name: str
    part: Part
    start: date
    end: date
    submissions: int

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ValueError(f"[[phases]] name = '{self.name}': {_NAME_RULE}")
        if self.end < self.start:
            raise ValueError(f"[[phases]] {self.name}: end = {self.end} is before start = {self.start}; exchange them")
        if not 1 <= self.submissions <= MOST_SUBMISSIONS:
            raise ValueError(
                f"[[phases]] {self.name}: submissions = {self.submissions}: must be 1 to {MOST_SUBMISSIONS}"
            )

    @property
    def opens(self) -> datetime:
        """The first moment."""
        return datetime.combine(self.start, time.min, UTC)

    @property
    def closes(self) -> datetime:
        """The first moment after it."""
        return datetime.combine(self.end, time.min, UTC) + timedelta(days=1)

    def is_open(self, moment: datetime) -> bool:
        """Whether submissions are taken."""
        return self.opens <= moment < self.closes

    def state(self, moment: datetime) -> str:
        """``open``, ``not open yet`` or ``closed``."""
        return "open" if self.is_open(moment) else "not open yet" if moment < self.opens else "closed"


@dataclass(frozen=True, kw_only=True)
class Team:
    """Who takes part: its name on the boards, and who that is."""

    name: str
    members: str = ""

    def __post_init__(self) -> None:
        if not _TEAM.fullmatch(self.name):
            raise ValueError(
                f"[[teams]] name = '{self.name}': up to 40 letters, digits and . _ + -, beginning with a letter or "
                "digit"
            )


@dataclass(frozen=True, kw_only=True)
class Challenge:
    """A challenge.

    Parameters
    ----------
    name, title : a short name for folders and files, and the one that people read.
    about, rules : paragraphs and rules, one text each.
    organisers, contact : who holds it, and the address for submissions and questions.
    licence : of the data.
    bundle : web address of the participants' bundle, where it is published.
    protocol, missing_rows : how it is solved, and whether an answer may be incomplete.
    data : the secret set.
    phases : in order of time; a hidden one is the last.
    teams : who may submit.
    """

    name: str
    title: str
    organisers: str
    contact: str
    licence: str
    protocol: Literal["sequential", "rollout", "cold-start"]
    data: SecretSet
    phases: tuple[Phase, ...]
    missing_rows: Literal["refuse", "hold"] = "refuse"
    about: tuple[str, ...] = ()
    rules: tuple[str, ...] = ()
    bundle: str = ""
    teams: tuple[Team, ...] = ()

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ValueError(f"name = '{self.name}': {_NAME_RULE}")
        for key in ("title", "organisers", "contact", "licence"):
            if not getattr(self, key).strip():
                raise ValueError(f"{key} is empty; fill it in")
        for key, text in self._texts():
            if not is_printable(text):
                raise ValueError(f"{key}: write each text on one line, without control characters")
        if self.bundle and not is_web_address(self.bundle):
            raise ValueError(f"bundle = '{self.bundle}' is not an address; give one that begins with https://")
        self._check_phases()
        _check_unique("teams", [team.name.casefold() for team in self.teams])

    def _texts(self) -> list[tuple[str, str]]:
        own = [(key, getattr(self, key)) for key in ("title", "organisers", "contact", "licence")]
        lists = [(key, text) for key in ("about", "rules") for text in getattr(self, key)]
        return [*own, *lists, *(("[[teams]] members", team.members) for team in self.teams)]

    def _check_phases(self) -> None:
        if not self.phases:
            raise ValueError("[[phases]]: there is none; add one")
        _check_unique("phases", [phase.name for phase in self.phases])
        for before, after in zip(self.phases, self.phases[1:], strict=False):
            if after.start <= before.end:
                raise ValueError(
                    f"[[phases]] {after.name}: start = {after.start} is not after the end of {before.name}, "
                    f"{before.end}; list phases in order of time, without a day in common"
                )
            if before.part == "hidden":
                raise ValueError(
                    f"[[phases]] {before.name}: part = 'hidden' must be the last phase; {after.name} comes after it"
                )

    @property
    def hidden_phase(self) -> Phase | None:
        """The last phase, if its part is hidden."""
        return self.phases[-1] if self.phases[-1].part == "hidden" else None

    def open_phase(self, moment: datetime) -> Phase:
        """The phase that takes submissions; raises VbbenchError, which says when one does or did."""
        found = self.phase_at(moment)
        if found is None:
            raise VbbenchError(f"{self.name} takes no submissions on {moment:%Y-%m-%d %H:%M} UTC: {self._why(moment)}")
        return found

    def _why(self, moment: datetime) -> str:
        following = self.phase_after(moment)
        if following is not None:
            return f"phase {following.name} opens on {following.start}"
        return f"its last phase, {self.phases[-1].name}, closed after {self.phases[-1].end}"

    def phase_at(self, moment: datetime) -> Phase | None:
        """The phase that takes submissions."""
        return next((phase for phase in self.phases if phase.is_open(moment)), None)

    def phase_after(self, moment: datetime) -> Phase | None:
        """The next phase that opens."""
        return next((phase for phase in self.phases if moment < phase.opens), None)

    def is_over(self, moment: datetime) -> bool:
        """Whether the last phase has closed."""
        return moment >= self.phases[-1].closes

    def team(self, name: str) -> Team:
        """The team of a name; raises VbbenchError if there is none."""
        found = next((team for team in self.teams if team.name == name), None)
        if found is None:
            known = ", ".join(team.name for team in self.teams) or "none yet"
            raise VbbenchError(
                f"no team of {self.name} is called '{name}'; known: {known}. teams stand in {CHALLENGE_FILE}"
            )
        return found


def read_challenge(folder: Path | str) -> Challenge:
    """The challenge in a folder; raises FileError, which names file and key."""
    if not (Path(folder) / CHALLENGE_FILE).exists():
        raise FileError(folder, f"holds no {CHALLENGE_FILE}; make a challenge with 'vbbench challenge new'")
    return read_toml(Path(folder) / CHALLENGE_FILE, Challenge, "challenge")


def parse_moment(text: str) -> datetime:
    """A day, or a day and a time in UTC, as a moment; now if the text is empty.

    Raises
    ------
    VbbenchError
        If it is none.
    """
    if not text:
        return datetime.now(UTC)
    try:
        found = datetime.fromisoformat(text)
    except ValueError as error:
        raise VbbenchError(f"`date` {text} is not a day; write it as YYYY-MM-DD or YYYY-MM-DDTHH:MM, in UTC") from error
    return found.replace(tzinfo=UTC) if found.tzinfo is None else found.astimezone(UTC)


def _check_unique(key: str, names: list[str]) -> None:
    again: Any = next((name for n, name in enumerate(names) if name in names[:n]), None)
    if again is not None:
        raise ValueError(f"[[{key}]] name = '{again}' stands there twice; rename one")


_NAME_RULE = "up to 40 small letters, digits and -, beginning with a letter or digit"
