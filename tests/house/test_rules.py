"""Habits that this field suffers from, kept out by test: see the names. Files are read and not imported."""

import ast
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path

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


def faults(files: Iterable[str], wrong: Callable[[str], object]) -> list[str]:
    """What is wrong with each of these files, which must be some."""
    found = {file: wrong(file) for file in files}
    assert found
    return [f"{file}: {fault}" for file, fault in found.items() if fault]


def test_every_package_is_looked_at() -> None:
    assert len(MODULES) > 100
    assert {file.split("/")[-2] for file in MODULES if file.endswith("__init__.py")} >= {"vbbench", *PLUGINS}


def test_library_code_never_asks_leaves_or_asserts_and_makes_no_default_once_for_all() -> None:
    def once(default: ast.expr) -> bool:
        drawn = isinstance(default, ast.Call) and "rng" in ast.unparse(default)
        return drawn or isinstance(default, ast.List | ast.Dict | ast.Set)

    def wrong(file: str) -> list[str]:
        found = []
        for node in ast.walk(tree(file)):
            if isinstance(node, ast.Call):
                found += {getattr(node.func, "id", "")} & {"input", "exit", "quit"}
            elif isinstance(node, ast.Assert):
                found.append("assert")
            elif isinstance(node, ast.FunctionDef):
                defaults = [*node.args.defaults, *filter(None, node.args.kw_defaults)]
                found += [f"{node.name}: {ast.unparse(default)}" for default in defaults if once(default)]
        return found

    assert not faults(MODULES, wrong)


def test_the_core_names_no_plugin_package() -> None:
    assert not faults(files_below(ROOT / "vbbench"), lambda file: re.search("|".join(PLUGINS), source(file)))


def test_the_global_random_state_is_never_used() -> None:
    used = re.compile(r"np\.random\.(seed|rand|randn|normal|uniform|choice|shuffle)\(")
    assert not faults(MODULES, lambda file: used.search(source(file)))


def test_everything_public_says_what_it_is() -> None:
    def wrong(file: str) -> list[str]:
        nameless = [node.name for node in public(tree(file).body) if not ast.get_docstring(node)]
        return nameless if ast.get_docstring(tree(file)) else ["the module", *nameless]

    assert not faults(MODULES, wrong)


def test_what_skips_without_an_extra_is_marked_so_that_it_is_required_elsewhere() -> None:
    def wrong(file: str) -> bool:
        skips = re.search(r"^(\w+ = )?pytest\.importorskip\(", source(file), re.M)
        return skips is not None and "\npytestmark = pytest.mark.extra\n" not in source(file)

    assert not faults(files_below(ROOT / "tests"), wrong)
