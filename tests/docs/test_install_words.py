"""What is said about installing is true: by its name only once it is released, from a lock that is the tested one."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from vbbench.version import INSTALL, ON_PYPI

ROOT = Path(__file__).parents[2]
BY_NAME = re.compile(
    r"(?:pip3?|pipx|uv) (?:install|add|tool install|pip install)(?: -{1,2}\S+)* [\"']?vbbench(?![\w\[./-])|uvx vbbench"
)
NOT_YET = re.compile(r"not yet (?:been )?released", re.IGNORECASE)
KINDS = (".md", ".py", ".html", ".toml", ".js", ".yml", ".ipynb")
WORKFLOW = (ROOT / ".github" / "workflows" / "release.yml").read_text("utf-8")


def told() -> Iterator[Path]:
    """Files that tell people something: pages, packages, templates, workflows."""
    homes = ("docs", "vbbench", "generators", "renderers", "baselines", "leaderboards/vbbench_leaderboards", ".github")
    found = [path for home in homes for path in sorted((ROOT / home).rglob("*")) if path.suffix in KINDS]
    return iter([ROOT / "README.md", ROOT / "Containerfile", *found])


def paragraphs(path: Path) -> Iterator[str]:
    yield from re.split(r"\n\s*\n", path.read_text("utf-8"))


@pytest.mark.parametrize("asked", ["", "-q ", "--upgrade --quiet "])
@pytest.mark.parametrize("command", ["pip install", "pip3 install", "uv add", "pipx install", "uv pip install"])
def test_the_search_finds_it(command: str, asked: str) -> None:
    for name in ("vbbench", "'vbbench'", "vbbench==0.4.0"):
        assert BY_NAME.search(f"{command} {asked}{name}")


@pytest.mark.parametrize(
    "text",
    ["pip install 'vbbench[render]'", "pip install ./vbbench", "pip install dist/vbbench-0.4.0-py3-none-any.whl"],
)
def test_extras_checkouts_and_wheels_are_no_such_claim(text: str) -> None:
    assert not BY_NAME.search(text)


def test_an_installation_by_name_is_promised_once_it_is_true() -> None:
    if ON_PYPI:
        wrong = [path for path in told() if NOT_YET.search(path.read_text("utf-8"))]
        assert not wrong, "these still say that vbbench is not released"
        return
    wrong = [
        f"{path.relative_to(ROOT)}: {words.strip()[:200]}"
        for path in told()
        for words in paragraphs(path)
        if path != ROOT / "vbbench" / "version.py" and BY_NAME.search(words) and not NOT_YET.search(words)
    ]
    assert not wrong, "say how to install from a checkout, or that vbbench is not yet released"


def test_the_page_shows_the_line_that_is_true() -> None:
    assert bool(BY_NAME.search(INSTALL)) is ON_PYPI


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


def test_the_release_keeps_no_secret_and_every_action_is_pinned() -> None:
    actions = re.findall(r"uses: (\S+)", WORKFLOW)
    assert len(actions) >= 6
    assert all(re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action) for action in actions)
    assert "secrets." not in WORKFLOW
    assert re.search(r"(?m)^permissions: \{\}$", WORKFLOW), "each job asks for what it needs"
    publish = WORKFLOW.partition("  publish:")[2].partition("  announce:")[0]
    assert "id-token: write" in publish
    assert WORKFLOW.count("id-token: write") == 1
    for step in (
        "python -m release.notes",
        "make wheel-test DIST=tried",
        "cibuildwheel dist/*.tar.gz",
        "python -m release.artefacts dist tree.whl",
        "twine check --strict",
        "--notes-file notes.md",
    ):
        assert step in WORKFLOW


def test_the_container_takes_what_is_locked_and_runs_without_rights() -> None:
    text = (ROOT / "Containerfile").read_text("utf-8")
    assert "--require-hashes --requirement /wheels/requirements.lock" in text
    assert text.rindex("USER vbbench") < text.index("ENTRYPOINT")
    kept = re.findall(r"(?m)^!(\S+)$", (ROOT / ".dockerignore").read_text("utf-8"))
    assert all((ROOT / name).exists() for name in kept)
    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["scikit-build"]["wheel"]
    assert {*(folder.partition("/")[0] for folder in wheel["packages"].values()), "CMakeLists.txt"} <= set(kept)
    assert not re.search(r"/(work|root)/", text)
