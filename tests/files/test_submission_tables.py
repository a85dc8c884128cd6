"""CSV of submissions: read as Python's csv module and a grammar of their own read it, whatever stands there."""

import csv
import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from vbbench.errors import FileError
from vbbench.exchange.box_tables import read_box_text
from vbbench.exchange.tum import import_tum
from vbbench.files.sequence_tables import RowBound
from vbbench.files.submission import Faults
from vbbench.files.submission_tables import read_csv_rows
from vbbench.parsing.numbers import parse_number

WANTED = ["sequence", "frame", "x"]
BOUND = RowBound(1000)
NO_NUMBERS = ["0_2", "1_000.5", "0x10", "0X1F", "infinity", "-Infinity", "１", "٣", "1e", "1 0", "--1", "1f", "nan(1)"]
NO_IDS = ["-9223372036854775808", "18446744073709551615", "2147483648", "1.5", "nan", "inf", "1e400", "9" * 400]


def read(path: Path, text: str, optional: tuple[str, ...] = ("fallback",)) -> tuple[Any, tuple[str, ...]]:
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    faults = Faults()
    rows = read_csv_rows(path, WANTED, faults, optional, BOUND)
    return rows, faults.listing()


def one(tmp_path: Path, **cells: str) -> tuple[Any, tuple[str, ...]]:
    """What is read of a file of one row with these cells."""
    row = {"sequence": "0", "frame": "2", "x": "1.0", **cells}
    return read(tmp_path / "poses.csv", ",".join(row) + "\n" + ",".join(row.values()) + "\n")


@pytest.mark.parametrize("text", NO_NUMBERS)
def test_what_is_no_number_is_none_in_csv_mot_and_tum(tmp_path: Path, text: str) -> None:
    assert parse_number(text) is None
    assert "x is " in one(tmp_path, x=text)[1][0]
    assert "sequence is " in one(tmp_path, sequence=text)[1][0]
    with pytest.raises(FileError, match=r"left is .*; write a number"):
        read_box_text(tmp_path / "a.txt", f"1,1,{text},1,1,1\n2,1,1,1,1,1,1,1\n".encode())
    with pytest.raises(FileError, match=r"left is .*; write a number"):
        read_box_text(tmp_path / "a.txt", f"1,1,{text},1,1,1\n".encode())
    if " " not in text:
        (tmp_path / "t.txt").write_text(f"0 {text} 0 0 0 0 0 1\n", encoding="utf-8")
        with pytest.raises(FileError, match=r"tx is .*; write a number"):
            import_tum(tmp_path / "t.txt", 0.4)


@pytest.mark.parametrize("text", NO_IDS)
def test_what_is_no_id_is_a_fault(tmp_path: Path, text: str) -> None:
    rows, faults = one(tmp_path, sequence=text)
    assert len(rows["sequence"]) == 0
    assert len(faults) == 1
    assert "write a whole number" in faults[0]


@pytest.mark.parametrize(
    ("text", "value"), [("True", True), ("False", False), ("1", True), ("0", False), ("true", True)]
)
def test_marks_are_true_and_false(tmp_path: Path, text: str, value: bool) -> None:
    rows, faults = one(tmp_path, fallback=text)
    assert faults == ()
    assert rows["fallback"].tolist() == [value]
    rows, faults = one(tmp_path, fallback=f" {text} ")
    assert (rows["fallback"].tolist(), faults) == ([value], ())


@pytest.mark.parametrize("text", ["nan", "-5e9", "2", "yes", "", "None", "1.0"])
def test_marks_are_nothing_else(tmp_path: Path, text: str) -> None:
    assert f"fallback is '{text}'; write True or False" in one(tmp_path, fallback=text)[1][0]


def test_a_column_that_stands_twice_is_refused(tmp_path: Path) -> None:
    rows, faults = read(tmp_path / "poses.csv", "sequence,frame,x,x\n0,2,1,5\n")
    assert rows is None
    assert faults == ("poses.csv, line 1: column 'x' is there twice; keep one",)
    rows, faults = read(tmp_path / "poses.csv", "sequence,frame,x,note,note\n0,2,1,a,b\n")
    assert (rows["x"].tolist(), faults) == ([1.0], ())


def test_a_cell_too_long_and_bytes_that_are_no_text_are_faults_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    good = "sequence,frame,x\n" + "0,2,1\n" * 3000
    with pytest.raises(FileError, match=r"poses.csv, line 3002: has more than 131072 characters"):
        read(path, good + "0,2," + "1" * 140_000 + "\n")
    with pytest.raises(FileError, match=r"line \d+: cannot be read further \(field larger"):
        read(path, good.replace("x\n", "x,note\n").replace(",1\n", ",1,a\n") + '0,2,1,"' + "a\n" * 80_000 + '"\n')
    rows, faults = read(path, good + "0,3,\udcff\n")
    assert len(rows["x"]) == 3001
    assert faults == (r"poses.csv, line 3002: x is '\udcff'; write a number",)
    with pytest.raises(FileError, match="is not UTF-8 text"):
        read(path, "\udcffsequence,frame,x\n0,2,1\n")


def test_more_rows_than_there_can_be_are_not_read(tmp_path: Path) -> None:
    for end in ("", '0,2,"1"\n'):  # with a quotation mark it is read by the other way
        with pytest.raises(FileError, match="the dataset has 1000 at most"):
            read(tmp_path / "poses.csv", "sequence,frame,x\n" + "0,2,1\n" * (BOUND.most + 1) + end)


def test_what_strangers_wrote_is_escaped_and_cut(tmp_path: Path) -> None:
    _, faults = one(tmp_path, x="\x1b[2J\x1b]0;owned\x07")
    assert r"x is '\x1b[2J\x1b]0;owned\x07'; write a number" in faults[0]
    _, faults = one(tmp_path, x="a" * 20_000)
    assert len(faults[0]) < 200
    assert faults[0].endswith("… (20001 characters); write a number")


NUMBER = re.compile(r"[ \t]*[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?[ \t]*\Z", re.ASCII)


def expected(text: str) -> tuple[list[tuple[int, int, float]], int] | None:
    """Rows and the number of bad cells by the csv module and `NUMBER`; ``None`` where the module cannot read it."""
    try:
        rows = [row for row in csv.reader(io.StringIO(text, newline=""), strict=True) if any(c.strip() for c in row)]
    except csv.Error:
        return None
    header, good, bad = [cell.strip() for cell in rows[0]], [], 0
    for row in rows[1:]:
        if len(row) != len(header):
            bad += 1
            continue
        cells = dict(zip(header, row, strict=True))
        values = [_value(cells[name], whole=name != "x") for name in WANTED]
        bad += sum(value is None for value in values)
        if values[0] is not None and values[1] is not None:
            good.append((int(values[0]), int(values[1]), values[2] or 0.0))
    return good, bad


def _value(cell: str, *, whole: bool) -> float | None:
    if not whole and re.fullmatch(r"[ \t]*[+-]?(nan|inf)[ \t]*", cell, re.IGNORECASE | re.ASCII):
        return float(cell)
    if not NUMBER.match(cell):
        return None
    value = float(cell)
    if whole and not (value.is_integer() and abs(value) < 2**31):
        return None
    return value


cells = st.one_of(
    st.integers(-3, 2**31 + 1).map(str),
    st.floats(allow_nan=True, allow_infinity=True).map(repr),
    st.sampled_from(
        [*NO_NUMBERS, *NO_IDS, "", " 7 ", "3.0", "+1", ".5", "5.", '"2"', '" 2"', '"1,5"', '"a\nb"', '"', 'a"b']
    ),
    st.text(st.characters(codec="utf-8"), max_size=4),
)
rows = st.lists(st.lists(cells, min_size=2, max_size=5).map(",".join), max_size=6)
good = st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9), st.floats(-9, 9)).map(lambda r: ",".join(map(str, r))))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(rows, good), st.sampled_from(["\n", "\r\n"]), st.booleans(), st.booleans())
@example(["0,1,2", "", "1,1,3"], "\n", True, True)
@example(["0,1,0x10", "0x1,1,3"], "\n", False, True)
@example(['0,1,1,"a', '0,2,3,b"'], "\n", True, True)
def test_it_is_read_as_an_independent_reader_reads_it(
    tmp_path: Path, body: list[str], end: str, note: bool, last: bool
) -> None:
    text = end.join(["sequence,frame,x" + (",note" if note else ""), *body]) + (end if last else "")
    want = expected(text)
    if want is None:
        with pytest.raises(FileError):
            read(tmp_path / "poses.csv", text)
        return
    found, faults = read(tmp_path / "poses.csv", text)
    np.testing.assert_array_equal(np.stack([found[name] for name in WANTED], axis=-1), np.reshape(want[0], (-1, 3)))
    assert len(faults) == want[1]
    assert all("\n" not in fault for fault in faults)
