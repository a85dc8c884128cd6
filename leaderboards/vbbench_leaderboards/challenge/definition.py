"""``challenge.toml``: all that makes a challenge, checked before anything is done with it."""

import re
import shlex
from dataclasses import dataclass
from datetime import UTC, date, datetime, time, timedelta
from pathlib import Path
from typing import Literal

from vbbench.errors import FileError, VbbenchError, is_printable
from vbbench.parsing.toml_text import read_toml, toml_table
from vbbench_leaderboards.results.folder import CHALLENGE_FILE
from vbbench_leaderboards.results.sealed_json import SOLVER_NAME, SPLIT_NAME
from vbbench_leaderboards.site.words import is_web_address

Part = Literal["public", "hidden"]
BASELINE = "baseline"
"""The team whose answers are those of a solver that comes with vbbench."""

START = Path(__file__).with_name("start.toml")
"""The template of the file."""

OWN_RULES = (
    "A solver uses boxes, camera, dt, the prior of heights, and what the protocol gives. It does not look for the "
    "truth or the seed.",
    "Nothing learned from one sequence is used in another.",
    "An answer depends on its own frame and earlier ones, or `delay` in submission.json states that it does not.",
)
"""Of the rules of all boards, those that a challenge cannot do without."""

_MOST_SUBMISSIONS = 1000
_NAME_RULE = "up to 40 small letters, digits and -, beginning with a letter or digit"
_TEAM_RULE = "up to 40 letters, digits and . _ + -, beginning with a letter or digit"
_OWN_OPTIONS = ("--out", "--tier", "--seed", "--withhold-truth", "--overwrite", "--scheduler")
"""Options of ``vbbench generate`` that the challenge itself decides."""

_SOLVE = "--solver mysolver:MySolver --protocol"


def _require(holds: object, problem: str) -> None:
    if not holds:
        raise ValueError(problem)


@dataclass(frozen=True, kw_only=True)
class SecretSet:
    """The one dataset that everybody answers, and whose truth nobody has.

    Its split, tier and ``options`` are those of ``vbbench generate``; the scores of the ``public_share`` of its
    sequences are published while the challenge runs.
    """

    split: str
    tier: str
    options: str = ""
    public_share: float = 0.5

    def __post_init__(self) -> None:
        share = f"[data] public_share = {self.public_share:g}: must be between 0 and 1, such as 0.5"
        _require(0.0 < self.public_share < 1.0, share)
        for word in self.words:
            own = f"--{word.partition('=')[0].lstrip('-').replace('_', '-')}" in _OWN_OPTIONS
            _require(not own, f"[data] options: {word} is decided by the challenge; remove it")

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
    """Days, from ``start`` to ``end``, both whole and in UTC, on which each team may hand in so many submissions.

    They count on the ``public`` sequences, whose scores are published at once, or on the ``hidden`` ones at the end.
    """

    name: str
    part: Part
    start: date
    end: date
    submissions: int

    def __post_init__(self) -> None:
        place = f"[[phases]] {self.name}"
        _require(re.fullmatch(SPLIT_NAME, self.name), f"[[phases]] name = '{self.name}': {_NAME_RULE}")
        backwards = f"{place}: end = {self.end} is before start = {self.start}; exchange them"
        _require(self.start <= self.end, backwards)
        possible = 1 <= self.submissions <= _MOST_SUBMISSIONS
        _require(possible, f"{place}: submissions = {self.submissions}: must be 1 to {_MOST_SUBMISSIONS}")

    @property
    def opens(self) -> datetime:
        """The first moment."""
        return datetime.combine(self.start, time.min, UTC)

    @property
    def closes(self) -> datetime:
        """The first moment after it."""
        return datetime.combine(self.end, time.min, UTC) + timedelta(days=1)

    def state(self, moment: datetime) -> str:
        """``open``, ``not open yet`` or ``closed``."""
        return "not open yet" if moment < self.opens else "open" if moment < self.closes else "closed"


@dataclass(frozen=True, kw_only=True)
class Team:
    """A team: its name on the boards, and its members."""

    name: str
    members: str = ""

    def __post_init__(self) -> None:
        _require(re.fullmatch(SOLVER_NAME, self.name), f"[[teams]] name = '{self.name}': {_TEAM_RULE}")


@dataclass(frozen=True, kw_only=True)
class Challenge:
    """A challenge.

    Parameters
    ----------
    name, title : a short name for folders and files, and the one that people read.
    about, rules : paragraphs and rules, one text each.
    organisers, contact : who holds it, and the address for submissions and questions.
    licence, bundle : of the data; and the web address of the participants' bundle, where it is published.
    protocol, missing_rows : how it is solved, and whether an answer may be incomplete.
    phases : in order of time; a hidden one is the last.
    baseline : solver of vbbench whose answers are first in every phase, those of the team `BASELINE`; "" for none.
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
    baseline: str = "cv"

    def __post_init__(self) -> None:
        _require(re.fullmatch(SPLIT_NAME, self.name), f"name = '{self.name}': {_NAME_RULE}")
        texts = [(key, getattr(self, key)) for key in ("title", "organisers", "contact", "licence")]
        for key, text in texts:
            _require(text.strip(), f"{key} is empty; fill it in")
        texts += [(key, text) for key in ("about", "rules") for text in getattr(self, key)]
        for key, text in [*texts, *(("[[teams]] members", team.members) for team in self.teams)]:
            _require(is_printable(text), f"{key}: write each text on one line, without control characters")
        unusable = f"bundle = '{self.bundle}' is not an address; give one that begins with https://"
        _require(not self.bundle or is_web_address(self.bundle), unusable)
        names = [team.name.casefold() for team in self.teams]
        _check_unique("teams", names)
        taken = f"[[teams]] name = '{BASELINE}' is that of vbbench's own row; choose another"
        _require(not self.baseline or BASELINE not in names, taken)
        _require(self.phases, "[[phases]]: there is none; add one")
        _check_unique("phases", [phase.name for phase in self.phases])
        for before, after in zip(self.phases, self.phases[1:], strict=False):
            overlap = f"{after.name}: start = {after.start} is not after the end of {before.name}, {before.end}"
            advice = "list phases in order of time, without a day in common"
            _require(after.start > before.end, f"[[phases]] {overlap}; {advice}")
            early = f"{before.name}: part = 'hidden' must be the last phase; {after.name} comes after it"
            _require(before.part != "hidden", f"[[phases]] {early}")

    @property
    def hidden_phase(self) -> Phase | None:
        """The last phase, if its part is hidden."""
        return self.phases[-1] if self.phases[-1].part == "hidden" else None

    def phase_at(self, moment: datetime) -> Phase | None:
        """The phase that takes submissions."""
        return next((phase for phase in self.phases if phase.state(moment) == "open"), None)

    def phase_after(self, moment: datetime) -> Phase | None:
        """The next phase that opens."""
        return next((phase for phase in self.phases if moment < phase.opens), None)

    def open_phase(self, moment: datetime) -> Phase:
        """The phase that takes submissions; raises VbbenchError with the day on which one opens or closed."""
        if found := self.phase_at(moment):
            return found
        following, last = self.phase_after(moment), self.phases[-1]
        closed = f"its last phase, {last.name}, closed after {last.end}"
        why = f"phase {following.name} opens on {following.start}" if following else closed
        raise VbbenchError(f"{self.name} takes no submissions on {moment:%Y-%m-%d %H:%M} UTC: {why}")

    def is_over(self, moment: datetime) -> bool:
        """Whether the last phase has closed."""
        return moment >= self.phases[-1].closes

    def check_team(self, name: str) -> None:
        """Raise VbbenchError if there is no team of that name."""
        names = [team.name for team in self.teams]
        if name not in names:
            known = f"known: {', '.join(names) or 'none yet'}. teams stand in {CHALLENGE_FILE}"
            raise VbbenchError(f"no team of {self.name} is called '{name}'; {known}")

    @property
    def placeholders(self) -> list[str]:
        """The keys whose text is that of the template."""
        template = toml_table(START)
        return [key for key in ("title", "organisers", "contact") if getattr(self, key) == template[key]]

    @property
    def all_rules(self) -> list[str]:
        """The rules of all boards that hold here, and the challenge's own."""
        return [*OWN_RULES, *self.rules]

    @property
    def unpacking_lines(self) -> list[str]:
        """Shell lines that unpack the archive and change into its folder."""
        return [f"unzip {self.name}.zip", f"cd {self.name}"]

    @property
    def solving_lines(self) -> list[str]:
        """Shell lines that solve the unpacked bundle with the template's solver and check the submission."""
        solve = f"vbbench solve ../data {_SOLVE} {self.protocol} --out answer"
        check = "vbbench challenge check answer --challenge .."
        return ["vbbench leaderboard template mine", "cd mine", solve, check]

    @property
    def practice_lines(self) -> list[str]:
        """A set like the secret one, whose truth is at hand, and a score on it."""
        solve = f"vbbench solve practice {_SOLVE} {self.protocol} --out practice-answer"
        score = "vbbench score practice-answer --dataset practice"
        return [self.data.command("--seed 1", "--out practice"), solve, score]


def _check_unique(key: str, names: list[str]) -> None:
    again = [name for n, name in enumerate(names) if name in names[:n]]
    _require(not again, f"[[{key}]] name = '{''.join(again[:1])}' stands there twice; rename one")


def read_challenge(folder: Path | str) -> Challenge:
    """The challenge in a folder; raises FileError with file and key."""
    if not (Path(folder) / CHALLENGE_FILE).exists():
        raise FileError(folder, f"holds no {CHALLENGE_FILE}; make a challenge with 'vbbench challenge new'")
    return read_toml(Path(folder) / CHALLENGE_FILE, Challenge, "challenge")


def now() -> datetime:
    """The current moment in UTC."""
    return datetime.now(UTC)


def parse_moment(text: str) -> datetime:
    """A day, or a day and a time in UTC, as a moment; now if the text is empty; raises VbbenchError if it is none."""
    if not text:
        return now()
    try:
        found = datetime.fromisoformat(text)
    except ValueError as error:
        raise VbbenchError(f"`date` {text} is not a day; write it as YYYY-MM-DD or YYYY-MM-DDTHH:MM, in UTC") from error
    return found.replace(tzinfo=UTC) if found.tzinfo is None else found.astimezone(UTC)
