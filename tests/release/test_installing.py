"""What is said about installing is true: by its name only once it is released, from a lock that is the tested one."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]


def pins(file: str) -> dict[str, str]:
    text = (ROOT / file).read_text("utf-8")
    found = re.findall(r"(?m)^([\w.-]+)==([\w.+!]+)", text)
    return {canonicalize_name(name): version for name, version in found}


def test_the_lock_holds_what_was_tested_with_hashes_and_without_hosts() -> None:
    text = (ROOT / "requirements.lock").read_text("utf-8")
    locked, tested = pins("requirements.lock"), pins("constraints.txt")
    assert {name: tested.get(name) for name in locked} == locked, "make requirements.lock anew: docs/releasing.md"
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    needed = [Requirement(line) for line in project["dependencies"]]
    assert all(one.specifier.contains(locked[canonicalize_name(one.name)]) for one in needed)
    for block in re.split(r"(?m)^(?=\w)", text)[1:]:
        assert "--hash=sha256:" in block, block
    assert "://" not in text
    assert "://" not in (ROOT / "constraints.txt").read_text("utf-8")
