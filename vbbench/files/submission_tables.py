"""Tables of a submission, Parquet or CSV, read a range of sequences at a time; estimates as rows and back."""

import csv
import mmap
from array import array
from collections.abc import Collection, Iterator
from collections.abc import Sequence as Several
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
from numpy.typing import NDArray

from vbbench.errors import FileError, SubmissionError, VbbenchError, is_printable, quoted
from vbbench.estimate import Estimate, is_credible
from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import RowBound, SequenceTable
from vbbench.files.submission import Faults, SubmissionInfo
from vbbench.files.tables import CONVERGED, COVARIANCES, FALLBACK, LARGEST_ID, SCHEMAS, Columns, column_values
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import parse_number
from vbbench.protocol import Protocol, get_protocol, scored_frames, scored_positions
from vbbench.sequence import Sequence

Arrays = dict[str, NDArray[Any]]


class RowsInMemory:
    """A table of a submission that is already in memory."""

    def __init__(self, file: str, columns: Arrays) -> None:
        self.file = file
        order = np.argsort(columns["sequence"], kind="stable")
        self._columns = {name: values[order] for name, values in columns.items()}

    def read(self, first: int, last: int) -> Arrays:
        """Rows with first ≤ sequence < last, an array per column; from CSV also ``line``."""
        start, stop = np.searchsorted(self._columns["sequence"], [first, last])
        return {name: values[start:stop] for name, values in self._columns.items()}


SubmissionTable = SequenceTable | RowsInMemory
"""Rows of a submission, in order of sequence."""


def open_table(
    folder: Path, name: str, dataset: Dataset, faults: Faults, optional: Collection[str] = (FALLBACK,)
) -> SubmissionTable | None:
    """The table ``poses`` or ``positions``; if it cannot be read, ``None``, and a fault is added.

    Of the optional columns (`vbbench.files.tables.OPTIONAL`) only those named are read. A table with more rows than
    an answer to ``dataset`` can have is not read at all.
    """
    parquet, csv = folder / f"{name}.parquet", folder / f"{name}.csv"
    possible = dataset.rows["frames"] if name == "poses" else dataset.cells
    bound = RowBound(int(possible.sum(dtype=np.int64)))
    if parquet.is_file() and csv.is_file():
        faults.add(f"{csv.name}: stands next to {parquet.name}; remove one of them")
    try:
        if parquet.is_file():
            return SequenceTable(parquet, name, optional=optional, bound=bound)
        if csv.is_file():
            columns = read_csv_rows(csv, SCHEMAS[name].names, faults, optional, bound)
            return None if columns is None else RowsInMemory(csv.name, columns)
    except FileError as error:
        faults.add_error(error)
        return None
    faults.add(f"{parquet.name}: the file is missing, and so is {csv.name}; write one of them")
    return None


IDS = ("sequence", "frame", "track")
MARKS = (FALLBACK, CONVERGED)
"""Columns that are True or False in each row."""

_LONGEST_LINE = 1 << 17
"""Most characters of a line, and so of a cell."""

_TRUE, _FALSE = ("True", "true", "TRUE", "1"), ("False", "false", "FALSE", "0")


def read_csv_rows(
    path: Path, wanted: list[str], faults: Faults, optional: Collection[str], bound: RowBound
) -> Arrays | None:
    """Columns of a CSV file with a header, and the 1-based ``line`` of each row.

    Columns may have any order; others than ``wanted`` and ``optional`` ones are ignored. Problems are added to
    ``faults``.

    Raises FileError if reading stops early: there are too many rows, a line is too long, or a quotation mark is not
    closed.

    Returns
    -------
    The rows whose ids could be read (0 for a value that could not), or ``None`` without a usable header.
    """
    header = _header(path)
    wanted = [*wanted, *(name for name in optional if name in header)]
    if not _check_header(path, header, wanted, faults):
        return None
    return _read_fast(path, header, wanted, bound) or _read_carefully(path, header, wanted, faults, bound)


def _header(path: Path) -> list[str]:
    cells = [cell.strip() for cell in next(_lines(path), (0, [""]))[1]]
    if not all(map(is_printable, cells)):
        raise FileError(
            path, "its first line is not UTF-8 text, or holds control characters; save it as CSV with commas"
        )
    return cells


def _check_header(path: Path, header: list[str], wanted: list[str], faults: Faults) -> bool:
    """Whether each wanted column is in the header once; otherwise a fault is added."""
    missing = [name for name in wanted if name not in header]
    twice = [name for name in wanted if header.count(name) > 1]
    for name in missing:
        faults.add(f"{path.name}, line 1: column '{name}' is missing; the header must read {','.join(wanted)}")
    for name in twice:
        faults.add(f"{path.name}, line 1: column '{name}' is there twice; keep one")
    return not missing and not twice


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of each row that is not blank; bytes that are not UTF-8 are kept, as invalid numbers."""
    with path.open(encoding="utf-8-sig", errors="surrogateescape", newline="") as file:
        reader = csv.reader(_short_lines(path, file), strict=True)
        try:
            for cells in reader:
                if any(cell.strip() for cell in cells):
                    yield reader.line_num, cells
        except csv.Error as error:
            raise FileError(path, f"cannot be read further ({error}); fix the line", reader.line_num) from error


def _short_lines(path: Path, file: TextIO) -> Iterator[str]:
    number = 0
    while line := file.readline(_LONGEST_LINE):
        number += 1
        if len(line) == _LONGEST_LINE:
            raise FileError(path, f"has more than {_LONGEST_LINE} characters; write one row per line", number)
        yield line


def _read_fast(path: Path, header: list[str], wanted: list[str], bound: RowBound) -> Arrays | None:
    """Read a file with a fast parser; ``None`` if a cell has a fault, or quoted cells may contain line ends."""
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        if content.find(b'"') >= 0:
            return None
    names = [name if name in wanted else f"column {number}" for number, name in enumerate(header)]
    kinds = {name: pa.bool_() if name in MARKS else pa.float64() for name in wanted}
    read = pa_csv.ReadOptions(column_names=names, skip_rows=1, use_threads=False)
    parse = pa_csv.ParseOptions(quote_char=False, ignore_empty_lines=False)
    convert = pa_csv.ConvertOptions(
        column_types=kinds, include_columns=wanted, null_values=[], true_values=_TRUE, false_values=_FALSE
    )
    batches, rows = [], 0
    try:
        with pa_csv.open_csv(path, read, parse, convert) as reader:
            for batch in reader:
                rows += len(batch)
                bound.check(path, rows)
                batches.append(batch)
        table = pa.Table.from_batches(batches)
    except (pa.ArrowException, ValueError):
        return None
    columns = {name: column_values(table.column(name)) for name in wanted}
    if not all(np.isfinite(values).all() for values in columns.values()):
        return None
    for name in columns.keys() & set(IDS):
        values = columns[name]
        if np.any((values != np.floor(values)) | (np.abs(values) > LARGEST_ID)):
            return None
        columns[name] = values.astype(np.int64)
    return {**columns, "line": np.arange(2, rows + 2)}


def _read_carefully(path: Path, header: list[str], wanted: list[str], faults: Faults, bound: RowBound) -> Arrays:
    columns = {name: array("q" if name in IDS else "b" if name in MARKS else "d") for name in wanted}
    lines = array("q")
    rows = _lines(path)
    next(rows)
    for number, (line, cells) in enumerate(rows, 1):
        bound.check(path, number)
        if len(cells) != len(header):
            problem = f"{len(cells)} cells, the header has {len(header)}; write one for each column"
            faults.add(f"{path.name}, line {line}: {problem}", kind=f"{path.name}: rows with too many or too few cells")
            continue
        row = _row(dict(zip(header, cells, strict=True)), wanted, f"{path.name}, line {line}", faults)
        if all(row[name] is not None for name in wanted if name in IDS):
            lines.append(line)
            for name, values in columns.items():
                values.append(row[name] or 0)
    arrays = {name: np.array(values) for name, values in columns.items()}
    return {name: values != 0 if name in MARKS else values for name, values in arrays.items()} | {
        "line": np.array(lines)
    }


def _row(cells: dict[str, str], wanted: list[str], place: str, faults: Faults) -> dict[str, Any]:
    row = {name: _value(name, cells[name]) for name in wanted}
    for name, value in row.items():
        if value is None:
            kind = "a whole number" if name in IDS else "True or False" if name in MARKS else "a number"
            problem = f"{name} is {quoted(cells[name].strip())}; write {kind}"
            faults.add(f"{place}: {problem}", kind=f"{place.split(', ')[0]}: {name} is not {kind}")
    return row


def _value(name: str, text: str) -> float | int | bool | None:
    """The value of a cell in the column called ``name``; ``None`` if it is not valid."""
    if name in MARKS:
        mark = text.strip(" \t")
        return True if mark in _TRUE else False if mark in _FALSE else None
    value = parse_number(text)
    if value is None or name not in IDS:
        return value
    return int(value) if value.is_integer() and abs(value) <= LARGEST_ID else None


def answer_rows(sequence: Sequence, protocol: Protocol, estimate: Estimate, covariance: bool) -> dict[str, Columns]:
    """The columns of ``poses`` and ``positions``, and of ``heights`` if reported; with ``covariance`` covariances, too.

    Raises VbbenchError if covariances are wanted and not reported.
    """
    if covariance and estimate.pose_covariances is None and estimate.position_covariances is None:
        raise VbbenchError("the solver reports no covariances; remove `covariance`")
    tables = {
        "poses": _pose_rows(sequence, estimate, covariance),
        "positions": _position_rows(sequence, protocol, estimate, covariance),
    }
    return tables if estimate.heights is None else {**tables, "heights": _height_rows(sequence, estimate)}


def _pose_rows(sequence: Sequence, estimate: Estimate, covariance: bool) -> Columns:
    frame = np.flatnonzero(scored_frames(sequence.observed))
    x, y, yaw = estimate.poses[frame].T
    rows: dict[str, Any] = {"sequence": np.full(len(frame), sequence.index), "frame": frame, "x": x, "y": y, "yaw": yaw}
    if estimate.fallback is not None:
        rows[FALLBACK] = estimate.fallback[frame]
    if estimate.converged is not None:
        rows[CONVERGED] = estimate.converged[frame]
    if covariance and estimate.pose_covariances is not None:
        rows |= _upper_triangle("poses", estimate.pose_covariances[frame])
    return rows


def _position_rows(sequence: Sequence, protocol: Protocol, estimate: Estimate, covariance: bool) -> Columns:
    given = protocol.select_given(sequence.given)
    frame, column = np.nonzero(scored_positions(sequence.observed, given))
    x, y = estimate.positions[frame, column].T
    where = {"sequence": np.full(len(frame), sequence.index), "frame": frame, "track": sequence.tracks[column]}
    rows: dict[str, Any] = {**where, "x": x, "y": y}
    if covariance and estimate.position_covariances is not None:
        rows |= _upper_triangle("positions", estimate.position_covariances[frame, column])
    return rows


def _height_rows(sequence: Sequence, estimate: Estimate) -> Columns:
    unknown = np.full(len(sequence.tracks), np.nan)
    return {
        "sequence": np.full(len(sequence.tracks), sequence.index),
        "track": sequence.tracks,
        "height": unknown if estimate.heights is None else estimate.heights,
        "variance": unknown if estimate.height_variances is None else estimate.height_variances,
    }


def _upper_triangle(table: str, covariances: FloatArray) -> dict[str, FloatArray]:
    """Covariances [N, D, D] as the columns of the table that hold them; NaN, not reported, where one is infinite."""
    finite = (np.abs(covariances) < np.finfo(np.float32).max).all(axis=(1, 2), keepdims=True)
    covariances = np.where(finite, covariances, np.nan)
    i, j = np.triu_indices(covariances.shape[-1])
    return dict(zip(COVARIANCES[table], covariances[:, i, j].T, strict=True))


class SubmittedEstimates:
    """The folder of a submission to ``dataset``, read a sequence at a time; only scoring checks every row.

    Raises VbbenchError if it cannot be read, or answers another dataset.
    """

    def __init__(self, dataset: Dataset, submission: Path | str) -> None:
        self.info = info = SubmissionInfo.read(submission)
        if info.dataset != dataset.info.id:
            raise VbbenchError(f"{submission} answers dataset {info.dataset}, {dataset.folder} is {dataset.info.id}")
        self._protocol = get_protocol(self.info.protocol)
        faults = Faults()
        tables = {name: open_table(Path(submission), name, dataset, faults, COVARIANCES[name]) for name in COVARIANCES}
        self._tables = {name: table for name, table in tables.items() if table is not None}
        if faults:
            raise SubmissionError(submission, faults.listing())

    def of(self, sequence: Sequence) -> Estimate:
        """The estimate of one sequence: given values filled in, NaN without a row; with covariances if it has them."""
        given = self._protocol.select_given(sequence.given)
        poses, positions = given.poses.copy(), given.positions.copy()
        pose_rows, rows = (_rows(self._tables[name], sequence) for name in ("poses", "positions"))
        poses[pose_rows["frame"]] = np.stack([pose_rows["x"], pose_rows["y"], pose_rows["yaw"]], axis=-1)
        where = rows["frame"], np.searchsorted(sequence.tracks, rows["track"])
        positions[where] = np.stack([rows["x"], rows["y"]], axis=-1)
        return Estimate(
            poses=poses,
            positions=positions,
            pose_covariances=_covariances("poses", pose_rows, (pose_rows["frame"],), poses.shape[:1]),
            position_covariances=_covariances("positions", rows, where, positions.shape[:2]),
        )


def _rows(table: SubmissionTable, sequence: Sequence) -> Arrays:
    """Rows of the sequence whose frame and track exist and whose values are credible."""
    rows = table.read(sequence.index, sequence.index + 1)
    usable = (rows["frame"] >= 0) & (rows["frame"] < sequence.frames)
    for name in ("x", "y", "yaw"):
        usable &= is_credible(rows.get(name, np.zeros(1)))
    if "track" in rows:
        usable &= np.isin(rows["track"], sequence.tracks)
    return {column: values[usable] for column, values in rows.items()}


def _covariances(table: str, rows: Arrays, where: tuple[Any, ...], shape: tuple[int, ...]) -> FloatArray | None:
    """Covariances [*shape, D, D] from the columns of their upper triangle, NaN without a row; ``None`` without them."""
    names = COVARIANCES[table]
    if not set(names) <= rows.keys():
        return None
    size = {3: 2, 6: 3}[len(names)]
    found = np.full((*shape, size, size), np.nan)
    for name, (i, j) in zip(names, zip(*np.triu_indices(size), strict=True), strict=True):
        found[(*where, i, j)] = found[(*where, j, i)] = rows[name]
    return found


def unique_names(infos: Several[SubmissionInfo], submissions: Several[Path | str]) -> list[str]:
    """Unique names of submissions: the solver, and where names are equal its protocol, else folder and number."""
    solvers = [info.solver for info in infos]
    protocols = [f"{info.solver} {info.protocol}" if solvers.count(info.solver) > 1 else info.solver for info in infos]
    folders = [
        f"{info.solver} ({Path(folder).resolve().name})" for info, folder in zip(infos, submissions, strict=True)
    ]
    for names in (solvers, protocols, folders):
        if len(set(names)) == len(names):
            return names
    return [f"{name} {number}" for number, name in enumerate(folders, 1)]
