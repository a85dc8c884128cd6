"""What a command takes and prints as text: none of it steers a terminal, and no stream ends in a traceback.

Stdout and stderr may be closed, full, in ASCII, or a pipe whose reader has left.
"""

import contextlib
import errno
import os
import re
import sys
from collections.abc import Iterator, Sequence
from typing import Any, TextIO

from vbbench.errors import VbbenchError, escaped, one_line


class OutputLost(Exception):  # noqa: N818  no mistake of the program
    """Stdout takes no more; ``reason`` is the system's word for it, ``None`` where its reader has had enough."""

    def __init__(self, error: OSError) -> None:
        super().__init__(str(error))
        self.reason = None if error.errno == errno.EPIPE else error.strerror


@contextlib.contextmanager
def guarded_streams() -> Iterator[None]:
    """Make stdout and stderr ready for any text: a closed one drops it, one in ASCII shows escapes.

    What stderr does not take is dropped, too.

    Raises
    ------
    OutputLost
        Within the block, where stdout takes no more.
    """
    with (
        contextlib.redirect_stdout(_Guarded(_ready(sys.stdout))),
        contextlib.redirect_stderr(_Forgiving(_ready(sys.stderr))),
    ):
        yield


@contextlib.contextmanager
def plain_output() -> Iterator[None]:
    """Print to stdout without control characters, but for line ends: strangers wrote titles, names and notes."""
    with contextlib.redirect_stdout(_Plain(sys.stdout)):
        yield


def check_arguments(arguments: Sequence[str]) -> None:
    """Refuse arguments in which no file, name or number can be written.

    Raises
    ------
    VbbenchError
        If one holds bytes that are no text in the encoding of this machine, or a zero byte.
    """
    for number, argument in enumerate(arguments, 1):
        if re.search("[\0\ud800-\udfff]", argument):
            encoding = sys.getfilesystemencoding().upper()
            raise VbbenchError(
                f"argument {number} is no {encoding} text: '{argument}'; rename it, or set LC_ALL=C.UTF-8"
            )


def say(text: str) -> None:
    """One line on stderr that begins with our name."""
    print(f"vbbench: {text}", file=sys.stderr)


def say_warning(message: Warning | str) -> None:
    """One line on stderr that is a warning."""
    say(f"warning: {one_line(str(message))}")


class _Guarded:
    """A text stream; that it takes no more is `OutputLost`, and what waits for it is dropped then."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write, if that is possible."""
        with self._watched():
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush, if that is possible."""
        with self._watched():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @contextlib.contextmanager
    def _watched(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self._drop()
            self._lost(error)

    def _drop(self) -> None:
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())

    def _lost(self, error: OSError) -> None:
        raise OutputLost(error) from error


class _Forgiving(_Guarded):
    """A text stream that drops what it cannot take: no work stops because a progress bar cannot be drawn."""

    def _lost(self, error: OSError) -> None:
        pass


class _Plain:
    """A text stream that writes out control characters."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write; only line ends stay."""
        self._stream.write(escaped(text, lines=True))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def _ready(stream: TextIO | None) -> TextIO:
    """A stream that encodes everything; one that drops it where there is none."""
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123  open as long as the program runs
    if hasattr(stream, "reconfigure"):
        stream.reconfigure(errors="backslashreplace")
    return stream
