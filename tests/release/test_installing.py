"""What is said about installing is true: by its name only once it is released, from a lock that is the tested one."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from vbbench.version import INSTALL, ON_PYPI

ROOT = Path(__file__).parents[2]
BY_NAME = re.compile(
    r"(?:pip3?|pipx|uv) (?:install|add|pip install)(?: -{1,2}\S+)* [\"']?vbbench(?![\w\[./-])|uvx vbbench"
)
NOT_YET = re.compile(r"not yet (?:been )?released", re.IGNORECASE)


def test_an_installation_by_name_is_promised_once_it_is_true() -> None:
    assert bool(BY_NAME.search(INSTALL)) is ON_PYPI
    pages = [ROOT / "README.md", ROOT / "Containerfile", *(ROOT / "docs").rglob("*.md")]
    words = [text for page in pages for text in re.split(r"\n\s*\n", page.read_text("utf-8"))]
    if ON_PYPI:
        assert not [text for text in words if NOT_YET.search(text)]
    else:
        assert not [text for text in words if BY_NAME.search(text) and not NOT_YET.search(text)]


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
