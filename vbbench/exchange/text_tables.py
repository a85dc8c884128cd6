"""Tables of text whose columns are found by their names: read fast, and line by line where something is wrong.

Any first line or comment that names two columns is a header, whatever separates its cells; without one the columns are
in an order that the reader states. Decimal commas (with other separators), UTF-16 with its mark, and empty lines do no
harm.
"""

import codecs
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path
from typing import Any, Self

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray
from pyarrow import csv

from vbbench.errors import FileError, quoted, suggestion
from vbbench.files.tables import column_values, first_repetition
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.column_names import UNITS, Header, header_of, name_columns, separator_of, split_cells
from vbbench.parsing.numbers import finite_number, parse_number

WORDS = ("frame", "id", "film", "class", "class_name", "last")
"""Columns that may hold words, or whole numbers of 64 bits."""
EMPTY = ("", "nan", "NaN", "None", "none", "null", "NULL", "NA", "N/A")
_MARKS = {"true": "1", "false": "0", "yes": "1", "no": "0"}
_TEXTS = pa.dictionary(pa.int32(), pa.string())
_SHOWN = 1000
_DIGIT, _QUOTED_COMMA = re.compile(r"\d"), re.compile(rb'"([-+]?\d+),(\d+)"')


@dataclass(frozen=True, kw_only=True)
class Rows:
    """Rows of a file, as arrays of one length N.

    Parameters
    ----------
    lines : [N] their line numbers from 1, or 0 where there are no lines.
    where : [N] where rows stand in a file without lines, for messages.
    """

    path: Path
    lines: IntArray
    where: NDArray[np.str_] | None = None

    def __len__(self) -> int:
        return len(self.lines)

    def select(self, kept: BoolArray | IntArray) -> Self:
        """Some of the rows, by marks or in an order."""
        if kept.dtype == np.bool_ and kept.all():
            return self
        return replace(self, **{name: _selected(value, kept) for name, value in vars(self).items()})

    def refuse(self, wrong: BoolArray, problem: str, *facts: NDArray[Any]) -> None:
        """Raise FileError at the first row marked in ``wrong`` [N]; ``problem`` is filled with that row's ``facts``."""
        if wrong.any():
            row = int(wrong.argmax())
            raise self.fault(row, problem.format(*(fact[row] for fact in facts)))

    def refuse_twice(self, problem: str, *keys: IntArray, among: BoolArray | None = None) -> None:
        """Raise FileError at the first row whose ``keys`` [N] an earlier one has, too, of all or of those ``among``.

        ``problem`` is filled with these keys, and with the place of the earlier row as ``at``.
        """
        rows = np.arange(len(self)) if among is None else np.flatnonzero(among)
        found = first_repetition(*(key[rows] for key in keys))
        if found is not None:
            before, again = rows[list(found)].tolist()
            raise self.fault(again, problem.format(*(key[again] for key in keys), at=self.place(before)))

    def place(self, row: int) -> str:
        """Where a row stands, in words."""
        line = int(self.lines[row])
        return f"line {line}" if line else f"box {row + 1}" if self.where is None else str(self.where[row])

    def fault(self, row: int, problem: str) -> FileError:
        """The error to raise about a row."""
        line = int(self.lines[row])
        return FileError(self.path, problem if line else f"{self.place(row)}: {problem}", line or None)


def _selected(value: Any, kept: BoolArray | IntArray) -> Any:
    if isinstance(value, Mapping):
        return {name: _selected(one, kept) for name, one in value.items()}
    return value[kept] if isinstance(value, np.ndarray) else value


@dataclass(frozen=True, kw_only=True)
class NamedColumns(Rows):
    """Columns of a table by what they are.

    Parameters
    ----------
    columns : [N] by noun: floats, NaN for an empty cell; of `WORDS` int64 where all are whole, texts where not all are
        numbers.
    header : what the columns are called; ``None`` where the file does not name them.
    """

    columns: Mapping[str, NDArray[Any]]
    header: Header | None = None

    def __contains__(self, noun: str) -> bool:
        return noun in self.columns

    def __getitem__(self, noun: str) -> NDArray[Any]:
        return self.columns[noun]

    def numbers(self, noun: str, missing: float = np.nan) -> FloatArray:
        """[N] the column as numbers, ``missing`` where it has none."""
        column = self.columns.get(noun)
        if column is None:
            return np.full(len(self), missing)
        if column.dtype.kind not in "if":
            cells = zip(self.lines.tolist(), column.tolist(), strict=True)
            column = np.array([finite_number(self.path, n or None, noun, one) if one else np.nan for n, one in cells])
        values = column.astype(np.float64, copy=False)
        return values if np.isnan(missing) else np.where(np.isnan(values), missing, values)

    def refuse_films(self) -> None:
        """Raise FileError if rows are of several films."""
        films = np.unique(self["film"]).tolist() if "film" in self else []
        if len(films) > 1:
            listed = ", ".join(quoted(str(one)) for one in films[:4])
            raise FileError(self.path, f"holds rows of {len(films)} films ({listed}); write a file for each of them")

    def called(self, noun: str) -> str:
        """What the file calls a column; empty where it does not."""
        return self.header.names[self.header.columns[noun]] if self.header else ""

    def unit(self, noun: str) -> str:
        """The unit in a column's name; empty where it has none."""
        return self.header.units.get(noun, "") if self.header else ""

    @property
    def time_units(self) -> tuple[float, ...]:
        """What `scaled` times may have to be multiplied by: 1, unless their name has no unit."""
        return (1.0,) if self.unit("time") else (1.0, 1e-3, 1e-6, 1e-9)

    def scaled(self, noun: str) -> FloatArray:
        """[N] the numbers of a column in s, m, rad, px or shares, by its `unit`."""
        return np.asarray(self.numbers(noun) * UNITS.get(self.unit(noun), 1.0))

    def stacked(self, *nouns: str) -> FloatArray:
        """[N, C] numbers of some columns."""
        return np.stack([self.numbers(noun) for noun in nouns], axis=-1)

    def whole(self, noun: str, least: int, most: int, wanted: str) -> IntArray:
        """[N] the column as integers."""
        values = self.numbers(noun)
        bad = (values != np.round(values)) | (values < least) | (values > most)
        self.refuse(bad, "{0:.10g} is " + wanted, values)
        return values.astype(np.int64)

    def places(self, noun: str, known: Sequence[str]) -> IntArray:
        """[N] place of each word of the column among the ``known``; raises FileError at the first that is none."""
        words, place = np.unique(self[noun].astype(np.str_), return_inverse=True)
        lost = ~np.isin(words, known)[place]
        if lost.any():
            word = str(words[place[lost.argmax()]])
            raise self.fault(int(lost.argmax()), f"{noun} is {quoted(word)}; {suggestion(word, known)}")
        return np.array([known.index(word) for word in words.tolist()], np.int64)[place]


Layout = str
"""Columns of a text that does not name them: nouns, or ``noun:name`` where messages call one so, with blanks between.

Those in [ ] may be missing at the end of a row; one in ( ) is not read.
"""


def names_several(header: Header, comment: bool) -> bool:
    """Whether a first line names two columns or more, or a comment three: then it is a header."""
    return len(set(header.columns.values())) >= (3 if comment else 2)


def read_table(
    path: Path,
    content: bytes,
    nouns: Sequence[str] = (),
    *,
    layout: Layout | Callable[[list[str]], Layout] = "",
    required: Collection[str] = (),
    usable: Callable[[Header, bool], bool] = names_several,
    repeated: Collection[str] = (),
) -> NamedColumns:
    """The columns of a text; empty lines and comments (``#``) are skipped.

    Parameters
    ----------
    content : the text, UTF-8 or UTF-16 with a byte order mark.
    nouns : what columns are looked for by their names.
    layout : the columns of a text that does not name them, which may depend on the cells of its first row; empty if it
        must name them.
    required : columns whose cells must not be empty where they have names; without names none may, but in the last.
    usable : whether a first line, or a comment, is the header.
    repeated : nouns of which several columns may be, and the first counts.
    """
    body, header, first = split_header(decode(path, content), nouns, usable)
    sample = body[: 100 * _SHOWN].partition(b"\n")[0].decode("utf-8", "replace").strip()
    mark = separator_of(sample) if sample else ","
    if mark != "," and b"," in body:
        body, sample = body.replace(b",", b"."), sample.replace(",", ".")
    elif b'"' in body:
        body = _QUOTED_COMMA.sub(rb"\1.\2", body)
    if header is None and sample.endswith((",", ";")):
        body, sample = re.sub(rb"[,;][ \t]*(?=\n|$)", b"", body), sample[:-1]
    cells = split_cells(sample) if sample else []
    if header is not None:
        _refuse_doubtful(path, header, first - 1, repeated)
        named, least, filled = header, len(header.names), frozenset(required)
    else:
        wordy = all(parse_number(cell) is None for cell in cells) and re.search("[A-Za-z]", sample)
        if sample and (not layout or wordy):
            known = ", ".join(nouns or re.findall(r"\w+", str(layout)))
            problem = f"its first line is {quoted(sample)}, which names no columns that are known: {known}"
            raise FileError(path, problem, first)
        try:
            named, least = _laid_out(layout if isinstance(layout, str) else layout(cells))
        except ValueError as error:
            raise FileError(path, str(error), first) from error
        filled = frozenset(named.columns) - {"last"}
    form = _Form(path, named, filled, least, header is not None, mark, first, cells)
    body = body.rstrip() if body.endswith(b"\n\n") else body
    if mark == " " and (b"  " in body or b"\t" in body or b" \n" in body or b"\n " in body):
        body = re.sub(rb"[ \t]+", b" ", body).replace(b" \n", b"\n").replace(b"\n ", b"\n").strip(b" ")
    found, lines = _read_fast(body, form, len(header.names if header else cells)) or _read_carefully(body, form)
    return NamedColumns(path=path, columns=found, lines=lines, header=header)


def read_fixed(path: Path, layout: Layout, wanted: str) -> NamedColumns:
    """The columns of a text without names that should hold what is ``wanted``."""
    table = read_table(path, read_content(path, wanted), layout=layout)
    if not len(table):
        raise FileError(path, f"is empty; it should hold {wanted}")
    return table


def read_content(path: Path, wanted: str) -> bytes:
    """The bytes of a file that should hold what is ``wanted``; raises FileError if it is missing or unreadable."""
    try:
        return path.read_bytes()
    except OSError as error:
        missing = isinstance(error, FileNotFoundError)
        problem = f"is missing; it holds {wanted}" if missing else f"cannot be read: {error.strerror}"
        raise FileError(path, problem) from error


def first_cells(path: Path) -> list[str]:
    """The cells of the first line of a text that is not blank; none where there is no file."""
    content = path.read_bytes()[: 100 * _SHOWN] if path.is_file() else b""
    return split_cells(content.decode("utf-8-sig", "replace").strip().partition("\n")[0])


def columns_of_records(path: Path, records: Sequence[Mapping[str, Any]], nouns: Sequence[str]) -> NamedColumns:
    """The columns of a list of records, such as of JSON; a cell that is not there is empty."""
    names = list(dict.fromkeys(name for record in records for name in record))
    header = name_columns(names, nouns)
    _refuse_doubtful(path, header, None)
    form, lines = _Form(path, header, frozenset(), 0, True), np.zeros(len(records), np.int64)
    columns = {}
    for noun, column in header.columns.items():
        cells = [None if (cell := record.get(names[column])) is None else str(cell) for record in records]
        columns[noun] = _typed(noun, cells, form, lines)
    return NamedColumns(path=path, columns=columns, lines=lines, header=header)


def decode(path: Path, content: bytes) -> bytes:
    """A text as UTF-8, its lines ended by line feeds alone."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            content = content.decode("utf-16").encode()
        except UnicodeDecodeError as error:
            raise FileError(path, "begins as UTF-16 text and does not go on so; save it as UTF-8") from error
    if b"\0" in content:
        line = content.count(b"\n", 0, content.find(b"\0")) + 1
        raise FileError(path, "holds zero bytes: it is no text, or UTF-16 without its mark; save it as UTF-8", line)
    content = content.removeprefix(codecs.BOM_UTF8)
    return content.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in content else content


def refuse_missing(table: NamedColumns, wanted: Sequence[Collection[str]]) -> None:
    """Raise FileError if of one of the ``wanted`` collections no noun is there; it names the file's own columns."""
    for names in wanted:
        if not any(name in table for name in names):
            listed, unread = (table.header.names, table.header.ignored) if table.header else ((), ())
            near = (hint for name in unread if "?" in (hint := suggestion(name.lower(), names)))
            everything = ", ".join(" or ".join(one) for one in wanted)
            hint = next(near, f"its columns are {quoted(','.join(listed))}, wanted: {everything}")
            line = int(table.lines[0]) - 1 if len(table) else 0
            raise FileError(table.path, f"has no column {' or '.join(names)}; {hint}", line if line > 0 else None)


def _refuse_doubtful(path: Path, header: Header, line: int | None, repeated: Collection[str] = ()) -> None:
    """Raise FileError if several columns could be of one noun that is not among the ``repeated``."""
    for noun in (noun for noun in header.doubtful if noun not in repeated):
        shown = " and ".join(map(quoted, header.doubtful[noun]))
        raise FileError(path, f"columns {shown} could both be the {noun}; keep one of them", line or None)


def _laid_out(layout: Layout) -> tuple[Header, int]:
    """The columns of a layout, and how few of them a row may have."""
    names, least = layout.replace("[", "").replace("]", "").split(), len(layout.partition("[")[0].split())
    parts = [name.strip("()").partition(":") for name in names]
    columns = {noun: place for place, (noun, *_) in enumerate(parts) if not names[place].startswith("(")}
    return Header(tuple(name or noun for noun, _, name in parts), columns, {}, {}), least


@dataclass(frozen=True)
class _Form:
    """How a text is read: its columns, those of them that must be ``filled``, and how few of them a row may have.

    ``named`` is whether the text itself names its columns; ``first`` is the number of its first row, which has the
    ``cells``.
    """

    path: Path
    header: Header
    filled: frozenset[str]
    least: int
    named: bool
    mark: str = ","
    first: int = 0
    cells: Sequence[str] = ()


Read = tuple[dict[str, NDArray[Any]], IntArray]


def split_header(
    content: bytes, nouns: Sequence[str], usable: Callable[[Header, bool], bool] = names_several
) -> tuple[bytes, Header | None, int]:
    """The text after its header and the comments before it, the header, and the number of the text's first line.

    Of a comment that begins with other words its last words count, as many as a row has columns.
    """
    header, line, begin, number = None, b"", 0, 0
    while begin < len(content):
        number += 1
        line = content[begin : (content.find(b"\n", begin) + 1) or len(content)]
        text = line[: 100 * _SHOWN].decode("utf-8", "replace").strip()
        comment = text.startswith(("#", "sep="))
        found = header_of(text, nouns) if text else None
        found = found if found is not None and usable(found, comment) else None
        header = found or header
        if found and not comment:
            return content[begin + len(line) :], found, number + 1
        if text and not comment:
            break
        begin += len(line)
    width = len(split_cells(line[:_SHOWN].decode("utf-8", "replace").strip()))
    if header is not None and len(header.names) != width:  # a comment may begin with other words
        header = name_columns(header.names[-width:], nouns) if len(header.names) > width else None
    return content[begin:], header, max(number, 1)


def _read_fast(body: bytes, form: _Form, width: int) -> Read | None:
    """The rows of a table whose lines all have the same columns, empty cells only where they may be; else ``None``."""
    if not form.least <= width <= len(form.header.names) or b"0x" in body or b"0X" in body:
        return None
    names = list(map(str, range(width)))
    nouns = {names[place]: noun for noun, place in form.header.columns.items() if place < width}
    parse = csv.ParseOptions(delimiter=form.mark, ignore_empty_lines=False)
    kinds = {name: _TEXTS if noun in WORDS else pa.float64() for name, noun in nouns.items()}
    shown = dict(zip(names, form.cells, strict=False))
    words = [name for name, noun in nouns.items() if noun in WORDS and noun != "class_name"]
    whole = [name for name in words if shown.get(name, "").lstrip("+-").isdecimal()]
    for integers in (dict.fromkeys(whole, pa.int64()), {}):
        convert = csv.ConvertOptions(
            column_types=kinds | integers, include_columns=list(nouns), null_values=EMPTY, strings_can_be_null=True
        )
        try:
            table = csv.read_csv(BytesIO(body), csv.ReadOptions(column_names=names), parse, convert)
        except pa.ArrowException:
            continue
        columns = {noun: _from_arrow(noun, table[name]) for name, noun in nouns.items()}
        for noun, column in columns.items():  # infinities, or empty cells where there must be none
            empty = np.isnan(column) if column.dtype.kind == "f" else column == ""
            infinite = column.dtype.kind == "f" and np.isinf(column).any()
            if infinite or (noun in form.filled and column.dtype.kind in "fU" and empty.any()):
                return None
        return columns, np.arange(form.first, form.first + len(table))
    return None


def _read_carefully(body: bytes, form: _Form) -> Read:
    """The rows of a table line by line; raises FileError at the first that is wrong."""
    lines, rows, places, most = [], list[list[str]](), form.header.columns, len(form.header.names)
    nothing = [place for noun, place in places.items() if noun in form.filled and form.named]
    for line, text in enumerate(body.decode("utf-8", "replace").split("\n"), form.first):
        if not text.strip() or text.lstrip().startswith("#"):
            continue
        cells = text.split() if form.mark == " " else text.split(form.mark)
        if not form.least <= len(cells) <= most:
            raise FileError(form.path, f"{len(cells)} columns{_wanted(form)}", line)
        cells = [cell.strip(" \t\"'") for cell in cells]
        if nothing and all(cells[place] in EMPTY for place in nothing):  # nobody is seen in this frame
            continue
        rows.append(cells)
        lines.append(line)
    numbers = np.array(lines, np.int64)
    columns = {
        noun: _typed(noun, [row[place] if place < len(row) else None for row in rows], form, numbers)
        for noun, place in places.items()
        if not rows or any(place < len(row) for row in rows)
    }
    return columns, numbers


def _wanted(form: _Form) -> str:
    """How many columns there should be, in words."""
    least, names = form.least, form.header.names
    if form.named:
        return f", the first line names {len(names)}"
    separated = {",": "commas", ";": "semicolons", " ": "blanks", "\t": "tabs"}.get(form.mark, form.mark)
    wanted = str(least) if least == len(names) else f"{least} to {len(names)}"
    return f" with {separated} between, wanted {wanted}: {form.mark.join(names)}"


def _typed(noun: str, cells: list[str | None], form: _Form, lines: IntArray) -> NDArray[Any]:
    """A column of cells, ``None`` where a row ends before, as numbers, or as words where it may have them."""
    known = [cell if cell is not None and (noun in form.filled or cell not in EMPTY) else None for cell in cells]
    if noun == "ignored":
        known = [_MARKS.get(cell.lower(), cell) if cell else None for cell in known]
    if noun in WORDS:
        column = _from_arrow(noun, pa.chunked_array([pa.array(known, pa.string()).dictionary_encode()]))
        words = noun == "frame" and column.dtype.kind == "U"
        if not any(cell in EMPTY for cell in known) and (not words or all(map(_DIGIT.search, filter(None, known)))):
            return column
    spare, values = noun == "time" and "frame" in form.header, list[float]()  # such as a date, where frames count
    for row, cell in enumerate(known):
        if cell is None or (spare and parse_number(cell) is None):
            values.append(np.nan)
        else:
            called = form.header.names[form.header.columns[noun]]
            values.append(finite_number(form.path, int(lines[row]) or None, called, cell))
    return np.array(values, np.float64)


def _from_arrow(noun: str, column: pa.ChunkedArray) -> NDArray[Any]:
    """A column as int64, floats or texts without blanks and quotes around them: the first that holds every cell."""
    if not pa.types.is_dictionary(column.type):
        column = pc.fill_null(column.cast(pa.float64(), safe=False), np.nan) if column.null_count else column
        return np.array(column_values(column))
    column = column.unify_dictionaries()
    words = pc.utf8_trim(column.chunk(0).dictionary if column.num_chunks else pa.array([], pa.string()), " \t\"'")
    words = pc.if_else(pc.equal(words, ""), None, words)
    place = pa.chunked_array([one.indices for one in column.chunks], pa.int32())
    for pattern, kind in ((r"^[+-]?\d+$", pa.int64()), (r"^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$", pa.float64())):
        if noun != "class_name" and pc.all(pc.match_substring_regex(words, pattern), min_count=0).as_py():
            try:
                return _from_arrow(noun, pa.chunked_array([words.cast(kind).take(place.combine_chunks())]))
            except pa.ArrowInvalid:
                break
    texts: NDArray[Any] = np.array([*(word or "" for word in words.to_pylist()), ""], np.str_)
    return np.asarray(texts[column_values(place.fill_null(len(words)))])
