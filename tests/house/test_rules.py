"""Habits that this field suffers from, kept out by test where no linter does it. Files are read and not imported."""

import ast
import re
from collections.abc import Callable, Iterable
from pathlib import Path

ROOT = Path(__file__).parents[2]
PLUGINS = ("vbbench_generators", "vbbench_renderers", "vbbench_baselines", "vbbench_leaderboards")
PACKAGES = (ROOT / "vbbench", *(ROOT / name.removeprefix("vbbench_") / name for name in PLUGINS))


def files_below(*folders: Path) -> list[str]:
    return sorted(path.relative_to(ROOT).as_posix() for folder in folders for path in folder.rglob("*.py"))


MODULES = files_below(*PACKAGES)


def source(file: str) -> str:
    return (ROOT / file).read_text("utf-8")


def faults(files: Iterable[str], wrong: Callable[[str], object]) -> list[str]:
    """What is wrong with each of these files, which must be some."""
    found = {file: wrong(file) for file in files}
    assert found
    return [f"{file}: {fault}" for file, fault in found.items() if fault]


def test_every_package_is_looked_at() -> None:
    assert len(MODULES) > 100
    assert {file.split("/")[-2] for file in MODULES if file.endswith("__init__.py")} >= {"vbbench", *PLUGINS}


def test_library_code_never_asks_or_leaves() -> None:
    def wrong(file: str) -> set[str]:
        calls = (node.func for node in ast.walk(ast.parse(source(file))) if isinstance(node, ast.Call))
        return {getattr(function, "id", "") for function in calls} & {"input", "exit", "quit"}

    assert not faults(MODULES, wrong)


def test_the_core_names_no_plugin_package() -> None:
    assert not faults(files_below(ROOT / "vbbench"), lambda file: re.search("|".join(PLUGINS), source(file)))


def test_what_skips_without_an_extra_is_marked_so_that_it_is_required_elsewhere() -> None:
    def wrong(file: str) -> bool:
        skips = re.search(r"^(\w+ = )?pytest\.importorskip\(", source(file), re.M)
        return skips is not None and "\npytestmark = pytest.mark.extra\n" not in source(file)

    assert not faults(files_below(ROOT / "tests"), wrong)
