"""Habits that this field suffers from, kept out by test: see the names. Files are read and not imported."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PLUGINS = ("vbbench_generators", "vbbench_renderers", "vbbench_baselines", "vbbench_leaderboards")
PACKAGES = (ROOT / "vbbench", *(ROOT / name.removeprefix("vbbench_") / name for name in PLUGINS))


def files_below(*folders: Path) -> list[str]:
    return sorted(path.relative_to(ROOT).as_posix() for folder in folders for path in folder.rglob("*.py"))


MODULES = files_below(*PACKAGES)


def source(file: str) -> str:
    return (ROOT / file).read_text("utf-8")


@cache
def tree(file: str) -> ast.Module:
    return ast.parse(source(file))


def public(body: list[ast.stmt]) -> Iterator[ast.FunctionDef | ast.ClassDef]:
    """The functions and classes in it that others may use; those in an ``if`` or ``try``, too."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            if not node.name.startswith("_"):
                yield node
        else:
            for name in ("body", "orelse", "handlers", "finalbody"):
                yield from public(getattr(node, name, []))


def test_every_package_is_looked_at() -> None:
    assert len(MODULES) > 100
    assert {file.split("/")[-2] for file in MODULES if file.endswith("__init__.py")} >= {"vbbench", *PLUGINS}


@pytest.mark.parametrize("file", MODULES)
def test_library_code_never_asks_leaves_or_asserts(file: str) -> None:
    calls = {node.func.id for node in ast.walk(tree(file)) if isinstance(node, ast.Call) and hasattr(node.func, "id")}
    assert not calls & {"input", "exit", "quit"}
    assert not any(isinstance(node, ast.Assert) for node in ast.walk(tree(file)))


@pytest.mark.parametrize("file", files_below(ROOT / "vbbench"))
def test_the_core_names_no_plugin_package(file: str) -> None:
    assert not re.search("|".join(PLUGINS), source(file))


@pytest.mark.parametrize("file", MODULES)
def test_no_default_argument_is_made_once_for_all(file: str) -> None:
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.FunctionDef):
            for default in [*node.args.defaults, *filter(None, node.args.kw_defaults)]:
                made = isinstance(default, ast.List | ast.Dict | ast.Set) or (
                    isinstance(default, ast.Call) and "rng" in ast.unparse(default)
                )
                assert not made, f"{node.name}: {ast.unparse(default)}"


@pytest.mark.parametrize("file", MODULES)
def test_the_global_random_state_is_never_used(file: str) -> None:
    assert not re.search(r"np\.random\.(seed|rand|randn|normal|uniform|choice|shuffle)\(", source(file))


@pytest.mark.parametrize("file", MODULES)
def test_everything_public_says_what_it_is(file: str) -> None:
    assert ast.get_docstring(tree(file))
    for node in public(tree(file).body):
        assert ast.get_docstring(node), node.name


@pytest.mark.parametrize("file", files_below(ROOT / "tests"))
def test_what_skips_without_an_extra_is_marked_so_that_it_is_required_elsewhere(file: str) -> None:
    skips = re.search(r"^(\w+ = )?pytest\.importorskip\(", source(file), re.M)
    assert not skips or "\npytestmark = pytest.mark.extra\n" in source(file)
