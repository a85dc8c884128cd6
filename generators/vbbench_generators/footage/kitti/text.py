"""Tables in KITTI's text files: one row a line, read fast, and read again line by line where something is wrong."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv

from vbbench.errors import FileError, quoted, suggestion
from vbbench.files.tables import column_values
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.numbers import finite_number

LONGEST_ID = 2**31 - 1
LONGEST_LINE = 10_000
"""Characters of a line; a row of numbers has some hundred."""


def names(text: str) -> tuple[str, ...]:
    """The names in a text, blanks between."""
    return tuple(text.split())


@dataclass(frozen=True, kw_only=True)
class Layout:
    """What a line holds.

    Parameters
    ----------
    columns : names of all columns, in order.
    wanted : names of those that are read.
    words : the words that may stand in a column; it is read as the place of the word among them.
    commas : whether columns are parted by commas instead of blanks.
    """

    columns: tuple[str, ...]
    wanted: tuple[str, ...]
    words: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    commas: bool = False

    def cells(self, line: str) -> list[str]:
        """The columns of a line."""
        return line.split(",") if self.commas else line.split()


@dataclass(frozen=True)
class Rows:
    """The rows of a file.

    Parameters
    ----------
    path : the file, for messages.
    columns : [N] numbers of each column that was wanted, by name.
    lines : [N] line numbers, from 1.
    """

    path: Path
    columns: Mapping[str, FloatArray]
    lines: IntArray

    def __len__(self) -> int:
        return len(self.lines)

    def numbers(self, *columns: str) -> FloatArray:
        """[N, len(columns)] numbers of some columns."""
        return np.stack([self.columns[name] for name in columns], axis=-1)

    def whole(self, name: str, least: int, most: int, wanted: str) -> IntArray:
        """[N] the column as integers.

        Raises
        ------
        FileError
            At the first row with something else than a whole number from ``least`` to ``most``.
        """
        values = self.columns[name]
        with np.errstate(invalid="ignore"):  # of numbers beyond all integers, which are refused
            integers = values.astype(np.int64)
        bad = (integers != values) | (values < least) | (values > most)
        self.refuse(bad, "{0:.10g} is " + wanted, values)
        return integers

    def refuse(self, bad: BoolArray, problem: str, *facts: FloatArray) -> None:
        """Raise FileError for the first row marked in ``bad`` [N]; ``problem`` is filled with that row's ``facts``."""
        if bad.any():
            row = int(bad.argmax())
            raise FileError(self.path, problem.format(*(fact[row] for fact in facts)), int(self.lines[row]))


def read_content(path: Path, wanted: str) -> bytes:
    """The bytes of a file; ``wanted`` says what it should hold.

    Raises
    ------
    FileError
        If it is missing, cannot be read, or is empty.
    """
    try:
        content = path.read_bytes()
    except FileNotFoundError as error:
        raise FileError(path, f"is missing; it holds {wanted}") from error
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    if not content or content.isspace():
        raise FileError(path, f"is empty; it should hold {wanted}")
    return content


def parse_rows(path: Path, content: bytes, layout: Layout) -> Rows:
    """Parse a table; blank lines are skipped.

    Raises
    ------
    FileError
        At the first line with another number of columns, an unknown word, or something else than finite numbers.
    """
    columns = _read_even(content, layout)
    if columns is not None:
        return Rows(path, columns, np.arange(1, len(columns[layout.wanted[0]]) + 1))
    rows, lines = [], []
    for line, text in enumerate(content.decode("utf-8-sig", errors="replace").splitlines(), 1):
        if text.strip():
            rows.append(_row(path, line, text, layout))
            lines.append(line)
    values = np.array(rows, np.float64).reshape(-1, len(layout.wanted))
    return Rows(path, dict(zip(layout.wanted, values.T, strict=True)), np.array(lines, np.int64))


def first_cells(content: bytes, layout: Layout) -> list[str]:
    """The columns of the first line that is not blank."""
    line = content[:LONGEST_LINE].lstrip().partition(b"\n")[0].decode("utf-8-sig", errors="replace")
    return layout.cells(line)


def _read_even(content: bytes, layout: Layout) -> dict[str, FloatArray] | None:
    """The columns of a text whose lines are all equal in form, in finite numbers and known words; else ``None``."""
    word = pa.dictionary(pa.int32(), pa.string())
    convert = csv.ConvertOptions(
        column_types={name: word if name in layout.words else pa.float64() for name in layout.wanted},
        include_columns=list(layout.wanted),
        null_values=[],
    )
    parse = csv.ParseOptions(delimiter="," if layout.commas else " ", quote_char=False, ignore_empty_lines=False)
    try:
        table = csv.read_csv(
            pa.BufferReader(content), csv.ReadOptions(column_names=list(layout.columns)), parse, convert
        )
    except pa.ArrowException:
        return None
    columns = {}
    for name in layout.wanted:
        values = _word_places(table[name], layout.words[name]) if name in layout.words else column_values(table[name])
        if values is None or not np.isfinite(values).all():
            return None
        columns[name] = values
    return columns


def _word_places(column: pa.ChunkedArray, known: tuple[str, ...]) -> FloatArray | None:
    """[N] place of each word among the ``known``; ``None`` if one of them is not."""
    places = []
    for chunk in column.chunks:
        words = chunk.dictionary.to_pylist()
        if not set(words) <= set(known):
            return None
        place = np.array([known.index(word) for word in words], np.float64)
        places.append(place[np.from_dlpack(chunk.indices)])
    return np.concatenate([np.empty(0), *places])


def _row(path: Path, line: int, text: str, layout: Layout) -> list[float]:
    """The numbers of a line that are wanted."""
    cells = layout.cells(text)
    if len(cells) != len(layout.columns):
        separator = "commas" if layout.commas else "blanks"
        wanted = f"{len(layout.columns)} with {separator} between: {' '.join(layout.columns)}"
        raise FileError(path, f"has {len(cells)} columns, not {wanted}", line)
    named = dict(zip(layout.columns, cells, strict=True))
    return [_number(path, line, name, named[name], layout.words.get(name)) for name in layout.wanted]


def _number(path: Path, line: int, name: str, cell: str, words: Collection[str] | None) -> float:
    if words is None:
        return finite_number(path, line, name, cell)
    word = cell.strip()
    if word not in words:
        raise FileError(path, f"{name} is {quoted(word)}; {suggestion(word, words)}", line)
    return float(list(words).index(word))
