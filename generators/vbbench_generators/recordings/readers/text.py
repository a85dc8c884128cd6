"""Text files of numbers, read fast, with errors that name file and line; one of three rows is a homography."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.text_tables import decode
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.column_names import Header, name_columns, split_cells
from vbbench.parsing.numbers import finite_number

LONGEST_ROW = 10_000
"""Characters of a line; a row of numbers has some hundred at most."""

NOUNS = ("frame", "time", "id", "x", "y")
"""What a header may name."""

Lines = list[tuple[int, str]]
"""1-based line numbers with what stands there."""


def read_lines(path: Path) -> Lines:
    """The lines of a text file that are neither blank nor comments (``#``).

    Raises
    ------
    FileError
        If the file cannot be read, is not text, holds no such line, or one of absurd length.
    """
    lines = [(number, line) for number, line in _all_lines(path) if not line.startswith("#")]
    if not lines:
        raise FileError(path, "is empty: it holds no row of numbers")
    endless = next((number for number, line in lines if len(line) > LONGEST_ROW), None)
    if endless is not None:
        raise FileError(path, f"has more than {LONGEST_ROW:,} characters; write one row of numbers a line", endless)
    return lines


def _all_lines(path: Path) -> Lines:
    """The lines of a text file that are not blank, in UTF-8 or with a mark of UTF-16."""
    try:
        text = decode(path, path.read_bytes()).decode("utf-8")
    except UnicodeDecodeError as error:
        raise FileError(path, "is not a text file") from error
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    if "\0" in text:
        raise FileError(path, "is not a text file: it holds zero bytes")
    stripped = ((number, line.strip()) for number, line in enumerate(text.split("\n"), 1))
    return [(number, line) for number, line in stripped if line]


def read_header(path: Path) -> tuple[Header, int] | None:
    """What the first line names the columns, or a comment before the first row, and the number of that line.

    It must name at least two of `NOUNS`, a comment three. Of a comment that begins with other words its last words
    count, as many as a row has columns.
    """
    first, row = read_lines(path)[0]
    for number, line in [*((n, line) for n, line in _all_lines(path) if n < first), (first, row)]:
        words = split_cells(re.sub(r"^#[#\s]*", "", line))
        header = name_columns(words if number == first else words[-len(split_cells(row)) :], NOUNS)
        if len(header.columns) >= (2 if number == first else 3):
            return header, number
    return None


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
        for number, line in lines:
            parse_row(path, number, line, columns)  # raises at the first fault
        raise FileError(path, f"cannot be read as rows of {' '.join(columns)}")
    return values, np.array([number for number, _ in lines], np.int64)


def parse_row(path: Path, number: int, line: str, columns: Sequence[str]) -> list[float]:
    """The numbers of one line, or the error that says what is wrong with it."""
    words = line.replace(",", " ").split()
    if len(words) != len(columns):
        raise FileError(path, f"has {len(words)} columns, not {len(columns)} ({' '.join(columns)})", number)
    return [finite_number(path, number, name, word) for name, word in zip(columns, words, strict=True)]


def count_columns(line: str) -> int:
    """How many columns a line has, parted by white space, tabs or commas."""
    return len(line.replace(",", " ").split())


def read_homography(path: Path) -> FloatArray:
    """Read a [3, 3] homography: three rows of three numbers.

    Raises
    ------
    FileError
        If the shape differs, a number is bad, or the matrix is singular.
    """
    matrix, lines = read_numbers(path, ("h1", "h2", "h3"))
    if len(matrix) != 3:
        raise FileError(path, f"a homography has 3 rows of 3 numbers, not {len(matrix)}", int(lines[-1]))
    largest = np.abs(matrix).max()
    if not largest or np.linalg.matrix_rank(matrix / largest) < 3:
        raise FileError(path, "the homography is singular: it maps the image onto a line or a point")
    return matrix


def to_ground(points: FloatArray, homography: FloatArray) -> FloatArray:
    """Image points [N, 2] in px to the ground plane [N, 2] in m; not finite for points on the horizon."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mapped = points @ homography[:, :2].T + homography[:, 2]
        ground: FloatArray = mapped[:, :2] / mapped[:, 2:]
    return ground
