"""Mutated files of every kind are read or refused in one clear line; and the fuzzer sees what breaks that.

``python -m tests.fuzz`` runs more, and any case again; see docs/development.md.
"""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.fuzz.mutations import TEXT
from tests.fuzz.oracle import boxes_of, finite, rows_of
from tests.fuzz.property import Broken, Tally, check
from tests.fuzz.running import KINDS, run
from vbbench.errors import FileError

CASES = int(os.environ.get("FUZZ_CASES", "2500"))
QUICK = 8
"""Cases of every kind that run each time."""


@pytest.mark.parametrize("name", KINDS)
def test_a_few_cases_of_every_kind(name: str) -> None:
    tally, broken = run([KINDS[name]], QUICK)
    assert not broken, "\n".join(map(str, broken))
    assert tally.read + tally.refused == QUICK


@pytest.mark.slow
def test_many_cases() -> None:
    tally, broken = run(KINDS.values(), CASES)
    assert not broken, "\n".join(map(str, broken))
    assert tally.read + tally.refused >= 0.99 * CASES
    assert min(tally.read, tally.refused) > 0.05 * CASES


def test_a_case_is_the_same_whenever_it_runs(tmp_path: Path) -> None:
    seen: list[bytes] = []
    kind = replace(KINDS["tum"], read=lambda folder: seen.append((folder / KINDS["tum"].target).read_bytes()))
    kind = replace(kind, oracle=None)
    kind.make(tmp_path)
    for case in (5, 6, 5):
        check(kind, case, tmp_path, Tally())
    assert seen[0] == seen[2] != seen[1]


def refuse(problem: str) -> Callable[[Path], object]:
    def read(folder: Path) -> object:
        raise FileError(folder / "tracks.txt", problem)

    return read


def fail(folder: Path) -> object:
    raise KeyError("x")


def warn(folder: Path) -> object:
    return float(np.array([1e308]) @ np.array([1e308]))


def fill(folder: Path) -> object:
    return np.ones(2**24).sum()


def endless(folder: Path) -> object:
    while True:
        folder = folder / "."


def nameless(folder: Path) -> object:
    raise FileError("elsewhere", "is bad")


def careless(folder: Path) -> object:
    (folder / "b.txt").write_text("left behind")
    return None


@pytest.mark.parametrize(
    ("read", "fault"),
    [
        (fail, "KeyError.*another error"),
        (warn, "warned: overflow"),
        (fill, "took 1[0-9][0-9] MB"),
        (nameless, "does not name the file"),
        (careless, "folder was changed"),
        (lambda folder: {"other": "numbers"}, "the oracle says so"),
        (endless, "more than 5 s"),
    ],
)
def test_the_fuzzer_sees_what_breaks_the_property(
    tmp_path: Path, read: Callable[[Path], object], fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def oracle(_content: bytes, outcome: object) -> str | None:
        return "the oracle says so" if isinstance(outcome, dict) else None

    monkeypatch.setattr("tests.fuzz.property.MOST_TIME", 0.05 if "5 s" in fault else 1.0)
    fault = fault.replace("5 s", "0.25 s")
    (tmp_path / "tracks.txt").write_text("1 2 3\n")
    kind = replace(KINDS["tum"], name="made", target="tracks.txt", mutations=TEXT, read=read, oracle=oracle)
    with pytest.raises(Broken, match=fault) as caught:
        check(kind, 7, tmp_path, Tally())
    assert str(caught.value).endswith("again: python -m tests.fuzz made --case 7")
    assert (tmp_path / "tracks.txt").read_text() == "1 2 3\n"


def test_a_refusal_is_fit_for_a_terminal_whatever_it_quotes(tmp_path: Path) -> None:
    (tmp_path / "tracks.txt").write_text("1 2 3\n")
    for problem in ("a\x1b[2J", "a\nb", "x" * 100_000, "\ud800", "\u202e"):
        kind = replace(KINDS["tum"], target="tracks.txt", read=refuse(problem), oracle=None)
        check(kind, 1, tmp_path, Tally())


@pytest.mark.parametrize(
    ("cell", "value"),
    [("1", 1.0), ("-0", 0.0), (".5", 0.5), ("5.", 5.0), ("1e400", None), ("1e-400", 0.0), ("nan", None), ("1_0", None)],
)
def test_the_oracle_knows_numbers(cell: str, value: float | None) -> None:
    assert finite(cell) == value


def test_the_oracle_knows_rows() -> None:
    assert rows_of(b"\xef\xbb\xbf# x\r\n1, 2\t3\r\n\r\n", 3, commas=True) == [(1.0, 2.0, 3.0)]
    assert rows_of(b"1 2\n", 3, commas=True) is None
    assert boxes_of(b"1,2,3,4,5,6,.5,1\n") == [(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.5, 1.0)]
    assert boxes_of(b"1,2,3,4,5,6,.5,1,x\n") is None
