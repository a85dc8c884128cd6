"""The errors that users see. All of them are mistakes that the user can fix: exit status 2, no traceback."""

import os
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any

LONGEST = 5000
"""Most characters of a line of any message: a path may have 4,096."""


class VbbenchError(Exception):
    """Something the user can fix.

    Every line can be shown, whatever text from a file it quotes: its length is limited, and no character controls the
    terminal (`one_line`).

    Parameters
    ----------
    message : what is wrong and what to do.
    details : further lines.
    """

    def __init__(self, message: str, *details: str) -> None:
        super().__init__("\n".join(one_line(line, LONGEST) for line in (message, *details)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Errors survive pickling between processes, whatever arguments their constructors take."""
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[VbbenchError], arguments: tuple[Any, ...], facts: dict[str, Any]) -> VbbenchError:
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(facts)
    return error


class FileError(VbbenchError):
    """A file that cannot be used.

    Parameters
    ----------
    path : the file.
    problem : what is wrong and what to do about it.
    line : 1-based line number, if there is one.
    """

    def __init__(self, path: Path | str, problem: str, line: int | None = None) -> None:
        self.path = Path(path)
        self.line = line
        self.problem = one_line(problem)
        super().__init__(f"{path}{'' if line is None else f', line {line}'}: {self.problem}")


def suggestion(name: str, known: Iterable[str]) -> str:
    """The nearest of the ``known`` names as a question; all of them, in their order, where none is near."""
    names = list(known)
    near = get_close_matches(name, names, n=1)
    return f"did you mean '{near[0]}'?" if near else f"known: {', '.join(names)}"


class UnknownNameError(VbbenchError):
    """A name that is not registered; the nearest known one is suggested."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        super().__init__(f"no {kind} is called {quoted(name)}; {suggestion(name, sorted(known))}")


class SubmissionError(VbbenchError):
    """A submission with faults; every one of them is listed."""

    def __init__(self, path: Path | str, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        listing = (f"  {n}. {fault}" for n, fault in enumerate(self.faults, 1))
        count = "1 fault" if len(self.faults) == 1 else f"{len(self.faults)} faults"
        super().__init__(f"{path}: {count}; fix and score again", *listing)


class SourceMissingError(VbbenchError):
    """Source files of a split that are not on this machine."""


class MissingExtraError(VbbenchError):
    """A package of an optional dependency that is not installed."""


@contextmanager
def needs_extra(extra: str, purpose: str) -> Iterator[None]:
    """For imports of packages that only ``vbbench[extra]`` installs; ``purpose`` begins the message.

    Raises MissingExtraError if a package is not installed; says what to install.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        raise MissingExtraError(f"{purpose} needs {error.name}: python -m pip install 'vbbench[{extra}]'") from error


class VbbenchWarning(UserWarning):
    """Something that works but that the user should know, on one line."""

    def __init__(self, message: str = "") -> None:
        super().__init__(one_line(message, LONGEST))


@contextmanager
def user_mistakes() -> Iterator[None]:
    """Turn a ValueError in the block, about something that the user wrote, into a VbbenchError in the same words."""
    try:
        yield
    except ValueError as error:
        raise VbbenchError(str(error)) from error


@contextmanager
def mistakes_in(path: Path) -> Iterator[None]:
    """Turn a ValueError or VbbenchError in the block, about what ``path`` says, into a FileError in the same words."""
    try:
        yield
    except (ValueError, VbbenchError) as error:
        raise FileError(path, str(error)) from error


@contextmanager
def plain_errors(path: Path, place: Path | None = None) -> Iterator[None]:
    """Turn system errors in the block into a FileError: ``path`` cannot be written.

    With ``place``, only errors about that path or about none are turned.
    """
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.errno is None or (place is not None and error.filename not in (None, str(place))):
            raise
        raise FileError(path, f"{os.strerror(error.errno)}; choose another place") from error


LONGEST_QUOTE = 60
"""Most characters of a quoted value."""

LONGEST_LINE = 600
"""Most characters of a message about a file, without its path."""

_CONTROL = (
    r"\x00-\x09\x0b-\x1f\x7f-\x9f"  # C0 and C1 controls but for the line feed
    r"\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # changes of the writing direction
    r"\u2028\u2029\ufeff\ufff9-\ufffb"  # separators of lines and paragraphs, invisible marks
    r"\ud800-\udfff"  # halves of surrogate pairs: bytes that were not UTF-8
)
_IN_LINES = re.compile(f"[{_CONTROL}]")
_IN_LINE = re.compile(f"[\\n{_CONTROL}]")


def is_printable(text: str) -> bool:
    """Whether a text can be shown as it is on one line."""
    return _IN_LINE.search(text) is None


def escaped(text: str, *, lines: bool = False) -> str:
    r"""The text with escapes such as ``\x1b`` for characters that a terminal would obey, hide or fail to show.

    With ``lines``, line feeds are kept.
    """
    return (_IN_LINES if lines else _IN_LINE).sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def one_line(text: str, longest: int = LONGEST_LINE) -> str:
    """The text escaped; one of more than ``longest`` characters is cut, and their number added."""
    if len(text) <= longest:
        return escaped(text)
    return f"{escaped(text[:longest])}… ({len(text)} characters)"


def quoted(value: object) -> str:
    """A value for a message: text in quotation marks, anything else as Python writes it."""
    if isinstance(value, str):
        return f"'{escaped(value)}'" if len(value) <= LONGEST_QUOTE else one_line(f"'{value}", LONGEST_QUOTE)
    return one_line(repr(value), LONGEST_QUOTE)
