"""What is run where: `.ci/run` begins with README's commands in an empty environment, and no test it wants can skip."""

import os
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TARGETS = ("demo", "test", "packages", "check", "sanitize", "test-kills", "test-slow", "bench-summary")
ASIDE, UNTIL = ("test-extras", "browser", "wheel-test"), "test-slow"
"""The targets that run one after the other beside others, from ``check`` on, and the last of those."""
A_FRESH_MACHINE = {"PATH", "HOME", "LANG", "VBBENCH_DATA"}
SHELL_AND_MAKE = {"_", "PWD", "OLDPWD", "SHLVL", "MAKELEVEL", "MAKEFLAGS", "MFLAGS", "MAKE_TERMOUT", "MAKE_TERMERR"}
GETTING_PACKAGES = ("PIP_", "SSL_CERT_", "http_proxy", "https_proxy", "no_proxy")
NOTE = 'echo "$@ $$(env | cut -d= -f1 | tr "\\n" " ")" >> ../../../ran; test ! -e ../../../no-$@'
"""A target's name, and the names in its environment; it fails if it shall."""


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A repository with our README and `.ci/run`, whose targets only note that they ran; recordings lie beside it."""
    folder = tmp_path / "a folder" / "clone"
    (folder / ".ci").mkdir(parents=True)
    (folder.parent / "shared" / "data").mkdir(parents=True)
    for name in ("README.md", ".ci/run", ".gitignore"):
        shutil.copy(ROOT / name, folder / name)
    rules = "".join(f"{name}:\n\t@{NOTE}\n" for name in (*TARGETS, *ASIDE))
    (folder / "Makefile").write_text(
        f"{rules}\ndemo: .venv/bin/activate\n.venv/bin/activate:\n\tmkdir -p .venv/bin; touch $@\n"
    )
    subprocess.run(["git", "init"], cwd=folder, check=True, capture_output=True)
    commit(folder)
    return folder


def commit(clone: Path) -> None:
    for command in ("add --all", "-c user.name=t -c user.email=t@t commit --message all"):
        subprocess.run(["git", *command.split()], cwd=clone, check=True, capture_output=True)


def run_checks(clone: Path) -> tuple[int, dict[str, set[str]]]:
    """The exit status of `.ci/run`, and the targets in the order in which they ran, with what each found set."""
    environment = {**os.environ, "CI": "true", "PYTEST_ADDOPTS": "-x", "PIP_INDEX_URL": "https://example.org"}
    status = subprocess.run(["bash", ".ci/run"], cwd=clone, env=environment, stdin=subprocess.DEVNULL, check=False)
    return status.returncode, {
        name: set(names) for name, *names in map(str.split, (clone / "ran").read_text("utf-8").splitlines())
    }


def one_by_one(ran: Iterable[str]) -> tuple[str, ...]:
    """The targets that ran, but for those beside them, which may end at any time."""
    return tuple(name for name in ran if name not in ASIDE)


def test_readme_comes_first_and_finds_what_a_fresh_machine_has(clone: Path) -> None:
    status, ran = run_checks(clone)
    assert (status, one_by_one(ran)) == (0, TARGETS)
    assert tuple(name for name in ran if name in ASIDE) == ASIDE
    for names in ran.values():
        assert names >= {"PIP_INDEX_URL", *A_FRESH_MACHINE}
        rest = names - A_FRESH_MACHINE - SHELL_AND_MAKE
        assert all(name.startswith(GETTING_PACKAGES) for name in rest), rest


@pytest.mark.parametrize("target", ["demo", "check", "bench-summary"])
def test_a_stage_that_fails_is_the_last(clone: Path, target: str) -> None:
    (clone / f"no-{target}").touch()
    status, ran = run_checks(clone)
    assert status != 0
    assert one_by_one(ran) == TARGETS[: TARGETS.index(target) + 1]


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
