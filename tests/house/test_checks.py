"""A test that skips where none is allowed to is a failure, wherever it skips."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OTHERS = """
import pytest
def test_that_runs(): pass
@pytest.mark.xfail
def test_that_is_expected_to_fail(): assert False
"""
SKIPS = {
    "test": "def test_that_skips(): pytest.skip('for want of it')",
    "fixture": "@pytest.fixture\ndef it(): pytest.skip('for want of it')\ndef test_that_skips(it): pass",
    "mark": "@pytest.mark.skip(reason='for want of it')\ndef test_that_skips(): pass",
    "file": "pytest.importorskip('no_such_module', reason='for want of it')",
}


@pytest.mark.parametrize("skip", SKIPS)
def test_a_skip_fails_where_none_is_allowed(pytester: pytest.Pytester, skip: str) -> None:
    pytester.makeconftest((ROOT / "tests" / "conftest.py").read_text("utf-8"))
    pytester.makepyfile(test_others=OTHERS, test_it="import pytest\n" + SKIPS[skip])
    allowed, wanted = pytester.runpytest("-rs"), pytester.runpytest("--no-skips")
    assert allowed.ret == 0
    allowed.stdout.fnmatch_lines("SKIPPED*for want of it")
    assert wanted.ret != 0
    wanted.stdout.fnmatch_lines("*for want of it*")
