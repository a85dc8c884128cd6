"""Text files of numbers, read fast, with errors that name file and line."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vbbench.arrays import FloatArray, IntArray
from vbbench.errors import FileError

Lines = list[tuple[int, str]]
"""1-based line numbers with what stands there."""


def read_lines(path: Path) -> Lines:
    """The lines of a text file that are neither blank nor comments (``#``).

    Raises
    ------
    FileError
        If the file cannot be read, is no text, or holds no such line.
    """
    try:
        text = path.read_text("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(path, "is no text file") from error
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    stripped = ((number, line.strip()) for number, line in enumerate(text.split("\n"), 1))
    lines = [(number, line) for number, line in stripped if line and not line.startswith("#")]
    if not lines:
        raise FileError(path, "is empty: it holds no row of numbers")
    return lines


def read_numbers(path: Path, columns: Sequence[str]) -> tuple[FloatArray, IntArray]:
    """Rows of finite numbers, parted by white space, tabs or commas.

    Parameters
    ----------
    path : the file.
    columns : names of the columns, all of which every row must have, and no more.

    Returns
    -------
    [N, C] numbers and [N] 1-based line numbers.

    Raises
    ------
    FileError
        At the first line with a missing or superfluous column, text in a number, or a number that is not finite.
    """
    lines = read_lines(path)
    rows = [line.replace(",", " ") for _, line in lines]
    try:
        values = np.loadtxt(rows, comments=None, ndmin=2)
    except ValueError:
        values = np.empty((0, 0))
    if values.shape != (len(lines), len(columns)) or not np.isfinite(values).all():
        raise _first_fault(path, lines, columns)
    return values, np.array([number for number, _ in lines], np.int64)


def parse_row(path: Path, number: int, line: str, columns: Sequence[str]) -> list[float]:
    """The numbers of one line, or the error that says what is wrong with it."""
    words = line.replace(",", " ").split()
    if len(words) != len(columns):
        raise FileError(path, f"has {len(words)} columns, not {len(columns)} ({' '.join(columns)})", number)
    for name, word in zip(columns, words, strict=True):
        if not _is_number(word):
            raise FileError(path, f"{name} is '{word}', not a number", number)
        if not np.isfinite(float(word)):
            raise FileError(path, f"{name} is {word}, not a finite number", number)
    return [float(word) for word in words]


def _first_fault(path: Path, lines: Lines, columns: Sequence[str]) -> FileError:
    try:
        for number, line in lines:
            parse_row(path, number, line, columns)
    except FileError as fault:
        return fault
    return FileError(path, f"cannot be read as rows of {' '.join(columns)}")


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word
