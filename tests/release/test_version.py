"""The version comes from git's tags or what stands in for them, and every release has its section of the changelog."""

import os
import subprocess
import tomllib
from pathlib import Path

import pytest
from packaging.version import Version

import vbbench
from release.notes import notes
from release.version import version
from vbbench.cli import main

ROOT = Path(__file__).parents[2]
CHANGES = (
    "# Changes\n\n## [Unreleased]\n\n## [0.3.0] - 2026-11-22\n\n### Added\n\n* It walks.\n\n## [0.2.0] - 2026-11-21\n"
)


def git(folder: Path, *arguments: str) -> str:
    nobody = {f"GIT_{who}_{what}": "a@b" for who in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}
    alone = {"PATH": os.environ["PATH"], "HOME": str(folder), "GIT_CONFIG_NOSYSTEM": "1"}
    done = subprocess.run(
        ["git", "-C", str(folder), *arguments], env=alone | nobody, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def commit(tree: Path, words: str) -> str:
    git(tree, "commit", "--quiet", "--allow-empty", "--message", words)
    return git(tree, "rev-parse", "--short", "HEAD")


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clone with one commit and no tag."""
    monkeypatch.delenv("VBBENCH_VERSION", raising=False)
    folder = tmp_path / "tree"
    folder.mkdir()
    (folder / "CHANGELOG.md").write_text(CHANGES)
    git(folder, "init", "--quiet")
    git(folder, "add", ".")
    commit(folder, "one")
    return folder


def test_a_tagged_commit_is_the_release(tree: Path) -> None:
    git(tree, "tag", "v0.3.0")
    assert version(tree) == "0.3.0"


def test_commits_after_a_tag_are_counted_towards_the_next_version(tree: Path) -> None:
    git(tree, "tag", "v0.3.0")
    git(tree, "tag", "v2026-workshop")
    commit(tree, "two")
    last = commit(tree, "three")
    assert version(tree) == f"0.4.0.dev2+g{last}"
    assert Version("0.3.0") < Version(version(tree)) < Version("0.4.0")


def test_without_a_tag_the_changelog_tells_the_last_release(tree: Path) -> None:
    last = commit(tree, "two")
    assert version(tree) == f"0.4.0.dev2+g{last}"


def test_without_git_an_sdist_or_the_changelog_tells_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("VBBENCH_VERSION", raising=False)
    (tmp_path / "CHANGELOG.md").write_text(CHANGES)
    assert version(tmp_path) == "0.4.0.dev0"
    (tmp_path / "PKG-INFO").write_text("Metadata-Version: 2.4\nName: vbbench\nVersion: 0.3.1\n\nVersion: 9\n")
    assert version(tmp_path) == "0.3.1"
    monkeypatch.setenv("VBBENCH_VERSION", "0.5.0")
    assert version(tmp_path) == "0.5.0"


def test_the_installed_version_is_that_of_the_distribution(capsys: pytest.CaptureFixture[str]) -> None:
    from importlib.metadata import version as installed

    assert vbbench.__version__ == installed("vbbench")
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"vbbench {installed('vbbench')}\n"
    assert "version" not in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"], "it is told in one place"


def test_notes_are_the_section_of_the_tag(tree: Path) -> None:
    git(tree, "tag", "v0.3.0")
    assert notes("v0.3.0", tree) == "### Added\n\n* It walks."


@pytest.mark.parametrize(
    ("tag", "complaint"),
    [
        ("0.3.0", "0.3.0 is no tag of a release"),
        ("v0.3", "v0.3 is no tag of a release"),
        ("v0.4.0", "the newest section is 0.3.0, not 0.4.0"),
        ("v0.3.0", "the source tree is 0.4.0.dev1"),
    ],
)
def test_no_notes_where_tag_changelog_and_version_disagree(tree: Path, tag: str, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        notes(tag, tree)
