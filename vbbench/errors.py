"""The errors that users meet. All of them are mistakes that the user can fix: exit status 2, no traceback."""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from vbbench.quoting import escaped, one_line, quoted


class VbbenchError(Exception):
    """Something the user can put right; the message says what is wrong and what to do.

    Whatever of it a stranger wrote, no character of it steers a terminal (`vbbench.quoting`).
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(escaped(message, lines=True))

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
        self.problem = one_line(problem)
        super().__init__(f"{escaped(str(path))}{'' if line is None else f', line {line}'}: {self.problem}")


class UnknownNameError(VbbenchError):
    """A name that nobody registered; the nearest known one is suggested."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        near = get_close_matches(name, names, n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"known: {', '.join(names)}"
        super().__init__(f"no {kind} is called {quoted(name)}; {hint}")


class SubmissionError(VbbenchError):
    """A submission with faults; every one of them is listed."""

    def __init__(self, path: Path | str, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        listing = "".join(f"\n  {n}. {fault}" for n, fault in enumerate(self.faults, 1))
        count = "1 fault" if len(self.faults) == 1 else f"{len(self.faults)} faults"
        super().__init__(f"{escaped(str(path))}: {count}; fix and score again{listing}")


class SourceMissingError(VbbenchError):
    """Source files of a split that are not on this machine."""


class VbbenchWarning(UserWarning):
    """Something that works but that the user should know, on one line."""

    def __init__(self, message: str = "") -> None:
        super().__init__(escaped(message))
