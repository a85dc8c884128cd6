"""The errors that users meet. All of them are mistakes that the user can fix: exit status 2, no traceback."""

import json
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

LONGEST_LINE = 1000
"""Characters of a message's line that are shown; of a longer one, the beginning and the end."""


def printable(text: str) -> str:
    r"""``text`` with everything that is no visible character written out, as JSON does it: ``\u001b``, ``\n``.

    Names and cells of files come from strangers. Control characters in them could clear a terminal or write a line that
    looks like ours, and lone surrogates (bytes of a name that is no UTF-8) cannot be printed at all.
    """
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() else json.dumps(letter)[1:-1] for letter in text)


def one_line(text: str) -> str:
    """``text`` as one line that may be shown to a user: `printable`, and no longer than `LONGEST_LINE`."""
    begin, end = LONGEST_LINE * 2 // 3, LONGEST_LINE // 3 - 5
    shown = printable(text if len(text) <= LONGEST_LINE else text[:begin] + text[-begin:])
    if len(text) <= LONGEST_LINE and len(shown) <= LONGEST_LINE:
        return shown
    return f"{shown[:begin]} ... {shown[-end:]}"


class VbbenchError(Exception):
    """Something the user can put right.

    Parameters
    ----------
    message : what is wrong and what to do.
    details : further lines, where there is more than one thing to say.

    What a message quotes need not be checked before: every line of it is made fit to be shown (`one_line`).
    """

    def __init__(self, message: str, *details: str) -> None:
        super().__init__("\n".join(map(one_line, (message, *details))))

    def __reduce__(self) -> tuple[Any, ...]:
        """Errors come whole out of other processes, whatever their constructors take."""
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
    line : 1-based line number, where there is one.
    """

    def __init__(self, path: Path | str, problem: str, line: int | None = None) -> None:
        self.path = Path(path)
        self.line = line
        super().__init__(f"{path}{'' if line is None else f', line {line}'}: {problem}")


class UnknownNameError(VbbenchError):
    """A name that nobody registered; the nearest known one is suggested."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        near = get_close_matches(name, names, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"known: {', '.join(names)}"
        super().__init__(f"no {kind} is called '{name}'; {hint}")


class SubmissionError(VbbenchError):
    """A submission with faults; every one of them is listed."""

    def __init__(self, path: Path | str, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        listing = (f"  {n}. {fault}" for n, fault in enumerate(self.faults, 1))
        count = "1 fault" if len(self.faults) == 1 else f"{len(self.faults)} faults"
        super().__init__(f"{path}: {count}; mend and score again", *listing)


class SourceMissingError(VbbenchError):
    """Source files of a split that are not on this machine."""


class VbbenchWarning(UserWarning):
    """Something that works but that the user should know."""
