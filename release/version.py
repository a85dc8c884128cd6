"""The version of this source tree. scikit-build-core runs this file when it builds; it needs git or nothing.

    a commit with the tag v0.4.0, unchanged      0.4.0
    12 commits after the tag v0.3.0              0.4.0.dev12+gabc1234        .dirty at the end: files were changed
    1047 commits, no tag among them              0.4.0.dev1047+gabc1234      after the newest release in CHANGELOG.md
    a clone that is cut off                      0.4.0.dev0+gabc1234
    an unpacked sdist                            what its PKG-INFO says
    neither git nor PKG-INFO                     0.4.0.dev0

The environment variable VBBENCH_VERSION goes before all of these, for builds that see no git, such as a container's.
"""

import os
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
VERSION = r"[0-9]+\.[0-9]+\.[0-9]+(?:(?:a|b|rc)[0-9]+)?"
"""What a version that is released looks like: 0.4.0, 1.0.0rc1."""

_DESCRIBED = re.compile(rf"v(?P<tag>{VERSION})-(?P<since>[0-9]+)-g(?P<commit>[0-9a-f]+)(?P<dirty>-dirty)?")


def dynamic_metadata(_settings: Mapping[str, Any], _project: Mapping[str, Any]) -> dict[str, str]:
    """The fields of ``[project]`` that pyproject.toml calls dynamic, as the build asks for them."""
    return {"version": version()}


def version(root: Path = ROOT) -> str:
    """The version of the source tree in ``root``."""
    told = os.environ.get("VBBENCH_VERSION") or _from_sdist(root) or _from_git(root)
    return told or f"{_after(released(root)[0])}.dev0"


def released(root: Path = ROOT) -> list[str]:
    """The versions that CHANGELOG.md has a section of, the newest first."""
    return re.findall(rf"(?m)^## \[({VERSION})\]", (root / "CHANGELOG.md").read_text("utf-8"))


def _after(release: str) -> str:
    """The version that is worked on once ``release`` is out."""
    major, minor, _ = release.split(".")
    return f"{major}.{int(minor) + 1}.0"


def _from_sdist(root: Path) -> str:
    facts = root / "PKG-INFO"
    found = re.search(r"(?m)^Version: (\S+)$", facts.read_text("utf-8")) if facts.is_file() else None
    return found[1] if found else ""


def _from_git(root: Path) -> str:
    """By the nearest tag; "" outside a clone of this very tree, or without git."""
    top = _git(root, "rev-parse", "--show-toplevel")
    if not top or Path(top).resolve() != root.resolve():
        return ""
    found = _DESCRIBED.fullmatch(
        _git(root, "describe", "--tags", "--long", "--dirty", "--match", "v[0-9]*.[0-9]*.[0-9]*")
    )
    if found is None:
        return _untagged(root)
    tag, since, dirty = found["tag"], int(found["since"]), found["dirty"]
    return f"{_after(tag)}.dev{since}+{_local(found['commit'], dirty)}" if since or dirty else tag


def _untagged(root: Path) -> str:
    commit, _, dirty = _git(root, "describe", "--always", "--dirty", "--exclude", "*").partition("-")
    if not commit:
        return ""
    cut_off = _git(root, "rev-parse", "--is-shallow-repository") == "true"
    count = "0" if cut_off else _git(root, "rev-list", "--count", "HEAD")
    return f"{_after(released(root)[0])}.dev{count}+{_local(commit, dirty)}"


def _local(commit: str, dirty: str | None) -> str:
    return f"g{commit}{'.dirty' if dirty else ''}"


def _git(root: Path, *arguments: str) -> str:
    """What git answers, "" where it does not."""
    try:
        done = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


if __name__ == "__main__":
    sys.stdout.write(f"{version()}\n")
