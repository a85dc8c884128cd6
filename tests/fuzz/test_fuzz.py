"""Mutated files of every kind are read or refused in one clear line; and the fuzzer sees what breaks that.

``python -m tests.fuzz`` runs more, and any case again; see docs/development.md.
"""

import os

import pytest

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
