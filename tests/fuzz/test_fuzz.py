"""Mutated files of every kind are read or refused in one clear line; and the fuzzer sees what breaks that.

``python -m tests.fuzz`` runs more, and any case again; see docs/development.md.
"""

import os
from dataclasses import replace
from pathlib import Path

import pytest

from tests.fuzz.property import Tally, check
from tests.fuzz.running import KINDS, run

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
