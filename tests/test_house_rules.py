"""Habits that this field suffers from, kept out by test: see the names."""

import ast
import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

PACKAGES = ("vbbench", "vbbench_generators", "vbbench_renderers", "vbbench_baselines", "vbbench_leaderboards")
LONGEST_FILE = 300


def modules() -> Iterator[ModuleType]:
    for name in PACKAGES:
        package = importlib.import_module(name)
        yield package
        for found in pkgutil.walk_packages(package.__path__, f"{name}."):
            if not found.name.endswith("__main__"):
                yield importlib.import_module(found.name)


MODULES = {module.__name__: module for module in modules()}


def tree(name: str) -> ast.Module:
    return ast.parse(inspect.getsource(MODULES[name]) or "''")


@pytest.mark.parametrize("name", MODULES)
def test_library_code_never_asks_leaves_or_asserts(name: str) -> None:
    calls = {node.func.id for node in ast.walk(tree(name)) if isinstance(node, ast.Call) and hasattr(node.func, "id")}
    assert not calls & {"input", "exit", "quit"}
    assert not any(isinstance(node, ast.Assert) for node in ast.walk(tree(name)))


@pytest.mark.parametrize("name", [name for name in MODULES if name.partition(".")[0] == "vbbench"])
def test_the_core_names_no_plugin_package(name: str) -> None:
    assert not re.search("|".join(PACKAGES[1:]), inspect.getsource(MODULES[name]))


@pytest.mark.parametrize("name", MODULES)
def test_no_default_argument_is_made_once_for_all(name: str) -> None:
    for node in ast.walk(tree(name)):
        if isinstance(node, ast.FunctionDef):
            for default in [*node.args.defaults, *filter(None, node.args.kw_defaults)]:
                made = isinstance(default, ast.List | ast.Dict | ast.Set) or (
                    isinstance(default, ast.Call) and "rng" in ast.unparse(default)
                )
                assert not made, f"{name}.{node.name}: {ast.unparse(default)}"


@pytest.mark.parametrize("name", MODULES)
def test_the_global_random_state_is_never_used(name: str) -> None:
    source = inspect.getsource(MODULES[name])
    assert not re.search(r"np\.random\.(seed|rand|randn|normal|uniform|choice|shuffle)\(", source)


@pytest.mark.parametrize("name", MODULES)
def test_everything_public_says_what_it_is(name: str) -> None:
    module = MODULES[name]
    assert module.__doc__
    for attribute, value in vars(module).items():
        own = getattr(value, "__module__", None) == name
        if own and not attribute.startswith("_") and (inspect.isfunction(value) or inspect.isclass(value)):
            assert value.__doc__, f"{name}.{attribute}"


@pytest.mark.parametrize("name", MODULES)
def test_no_file_grows_past_one_idea(name: str) -> None:
    path = Path(inspect.getsourcefile(MODULES[name]) or "")
    assert len(path.read_text("utf-8").splitlines()) <= LONGEST_FILE
