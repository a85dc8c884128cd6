"""The errors that users meet. All of them are mistakes that the user can mend: exit status 2, no traceback."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any


class VbbenchError(Exception):
    """Something the user can put right; the message says what is wrong and what to do."""

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
        listing = "".join(f"\n  {n}. {fault}" for n, fault in enumerate(self.faults, 1))
        count = "1 fault" if len(self.faults) == 1 else f"{len(self.faults)} faults"
        super().__init__(f"{path}: {count}; mend and score again{listing}")


class SourceMissingError(VbbenchError):
    """Source files of a split that are not on this machine."""


class VbbenchWarning(UserWarning):
    """Something that works but that the user should know."""


@contextmanager
def plain_errors(path: Path, place: Path | None = None) -> Iterator[None]:
    """Say of what the system refuses that ``path`` cannot be written.

    Parameters
    ----------
    place : only of what is refused there, or nowhere in particular; by default of everything.
    """
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.errno is None or (place is not None and error.filename not in (None, str(place))):
            raise
        raise FileError(path, f"{os.strerror(error.errno)}; choose another place") from error
