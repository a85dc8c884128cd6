"""Prints the budgets of the house and what it takes of them: ``python docs/budgets.py``. More needs a decision."""

import re
from collections.abc import Iterable
from importlib.metadata import distribution
from pathlib import Path

from packaging.requirements import Requirement

from vbbench.cli import all_commands
from vbbench.cli.parsing import parameters_of

ROOT = Path(__file__).parents[1]
PRODUCT = ("vbbench", "cpp", "generators", "renderers", "baselines", "leaderboards/vbbench_leaderboards")


def files(*homes: str, endings: Iterable[str]) -> list[Path]:
    """The files below these folders that have one of the endings."""
    return [path for home in homes for path in (ROOT / home).rglob("*") if path.suffix in endings and path.is_file()]


def lines(paths: Iterable[Path]) -> int:
    """Their lines."""
    return sum(path.read_text("utf-8").count("\n") for path in paths)


def words(paths: Iterable[Path]) -> int:
    """Their words."""
    return sum(len(path.read_text("utf-8").split()) for path in paths)


def needed(name: str, found: set[str]) -> set[str]:
    """The distributions that an installation of one brings, itself included."""
    if name not in found:
        found.add(name)
        for text in distribution(name).requires or ():
            requirement = Requirement(text)
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                needed(re.sub(r"[-_.]+", "-", requirement.name).lower(), found)
    return found


def megabytes(names: Iterable[str]) -> float:
    """What their files take."""
    found = (distribution(name).locate_file(file) for name in names for file in distribution(name).files or ())
    return sum(Path(str(path)).stat().st_size for path in found if Path(str(path)).is_file()) / 1e6


def figures() -> list[tuple[str, int, int]]:
    """What is counted, how many there are, and how many are wanted at most."""
    code = files(*PRODUCT, endings={".py", ".pyi", ".hpp", ".cpp", ".js", ".css", ".glsl", ".html"})
    pages = [*files("docs", endings={".md"}), ROOT / "README.md", ROOT / "CHANGELOG.md"]
    parameters = {name: len([*parameters_of(command)]) for name, command in all_commands().items()}
    return [
        ("lines of the product", lines(code), 50_000),
        ("files of the product", len(code), 320),
        ("lines of tests", lines(files("tests", endings={".py", ".sh"})), 32_000),
        ("words of docs, README and changelog", words(pages), 65_000),
        ("lines of README", lines([ROOT / "README.md"]), 150),
        ("commands, a group as one", len({name.split()[0] for name in parameters}), 30),
        ("parameters of all commands", sum(parameters.values()), 200),
        ("options of generate", parameters["generate"] - 1, 16),
        ("MB of an installation", round(megabytes(needed("vbbench", set()))), 520),
    ]


if __name__ == "__main__":
    for what, found, wanted in figures():
        print(f"{found:>8,} {what}, {'within' if found <= wanted else 'MORE THAN'} {wanted:,}")
