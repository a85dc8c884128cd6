"""Safe terminal streams: control characters are escaped, and a failing stream causes no traceback.

Stdout and stderr may be closed, full, in ASCII, or a pipe whose reader has closed it.
"""

import contextlib
import errno
import os
import re
import sys
from collections.abc import Iterator, Sequence
from typing import Any, TextIO

from vbbench.errors import VbbenchError, escaped, one_line


class OutputLost(Exception):  # noqa: N818  not an error of the program
    """Stdout fails; ``reason`` is the system's message, ``None`` if the reader of a pipe has closed it."""

    def __init__(self, error: OSError) -> None:
        super().__init__(str(error))
        self.reason = None if error.errno == errno.EPIPE else error.strerror


@contextlib.contextmanager
def guarded_streams() -> Iterator[None]:
    """Make stdout and stderr accept any text: a closed one drops it, one in ASCII shows escapes.

    Output that fails on stderr is dropped, so that no work stops because a progress bar cannot be drawn.

    Raises OutputLost inside the block, if stdout fails.
    """
    out, err = _Guarded(_ready(sys.stdout)), _Guarded(_ready(sys.stderr), silent=True)
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        yield


@contextlib.contextmanager
def plain_output() -> Iterator[None]:
    """Escape control characters, except line feeds, on stdout: titles, names and notes are untrusted."""
    with contextlib.redirect_stdout(_Plain(sys.stdout)):
        yield


def check_arguments(arguments: Sequence[str]) -> None:
    """Raise VbbenchError if an argument is not text in the system's encoding, or holds a zero byte."""
    for number, argument in enumerate(arguments, 1):
        if re.search("[\0\ud800-\udfff]", argument):
            encoding = sys.getfilesystemencoding().upper()
            raise VbbenchError(
                f"argument {number} is not {encoding} text: '{argument}'; rename it, or set LC_ALL=C.UTF-8"
            )


def say(text: str) -> None:
    """Print a message on stderr, after the program's name."""
    print(f"vbbench: {text}", file=sys.stderr)


def say_warning(message: Warning | str) -> None:
    """Print a warning on stderr, on one line."""
    say(f"warning: {one_line(str(message))}")


class _Guarded:
    """A text stream that drops all output once it fails, and raises `OutputLost` unless ``silent``."""

    def __init__(self, stream: TextIO, *, silent: bool = False) -> None:
        self._stream, self._silent = stream, silent

    def write(self, text: str) -> int:
        with self._watched():
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        with self._watched():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @contextlib.contextmanager
    def _watched(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            with contextlib.suppress(OSError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
            if not self._silent:
                raise OutputLost(error) from error


class _Plain:
    """A text stream that writes control characters, except line feeds, as escapes."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        self._stream.write(escaped(text, lines=True))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def _ready(stream: TextIO | None) -> TextIO:
    """The stream, set to encode any text; a null stream in place of ``None``."""
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123  open as long as the program runs
    if hasattr(stream, "reconfigure"):
        stream.reconfigure(errors="backslashreplace")
    return stream
