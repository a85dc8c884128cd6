"""The field's words: identifiers, docstrings and messages of all packages have none of the private ones."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("vbbench", *(f"{name}/vbbench_{name}" for name in ("generators", "renderers", "baselines", "leaderboards")))

SAY = {
    r"un?told|told|tells?|telling": "given, measured; information; observable",
    r"slopes": "gradient, Jacobian",
    r"deviances?": "cost",
    r"settle[sd]?|believe[sd]?": "minimise, solution, relinearise",
    r"let(?:s|ting)? go": "marginalise",
    r"lively|liveliness": "process noise, acceleration noise",
    r"shared area": "IoU",
    r"foot slope": "foot cue",
    r"(?:made )?anew": "regenerated, again",
    r"of (?:its|their|his|her|our) own": "its own",
    r"beside": "next to, with",
    r"alike": "equal",
    r"(?:some|any)body": "a person, people",
    r"ha(?:s|ve) no use for": "X is not accepted here because …",
    r"leave[s]? (?:it |them |this |that |\S+ )?out|left out|leaving out": "remove",
}
"""What is not said, as patterns of whole words, and what is said instead."""

KEPT = {"told", "as told", "told mean", "told std", "told values", "told of detector", "left out", ".tell"}
"""Identifiers of samples, tiers and parts that users import, and names in ids of datasets and files of weights."""
QUOTED = ("poses have errors of their own",)
"""Beginnings of texts that stand in committed results."""


def room_of(path: Path) -> str:
    """The folder of a package that a module lies in, or the module itself."""
    parts = path.relative_to(ROOT).parts
    depth = 2 if parts[0] == "vbbench" else 3
    return "/".join(parts[:depth])


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """Every identifier, docstring and text of a module with its line; an identifier's words have blanks between.

    Names that a text quotes are left to the place of their definition.
    """
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        line = getattr(node, "lineno", 0)
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            prose = re.sub(r"`[^`]*`|^\s*[\w, ]+ :(?= )", " ", node.value, flags=re.MULTILINE)
            yield line, " ".join(prose.split())
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield line, spoken(node.name)
        elif isinstance(node, ast.arg):
            yield line, spoken(node.arg)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield line, spoken(node.id)


def spoken(name: str) -> str:
    """The words of an identifier, in snake case or camel case."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_+", " ", name).lower()


@cache
def faults(room: str) -> list[str]:
    """What a room says that is not the field's, by file and line."""
    pattern = re.compile("|".join(rf"(?P<w{n}>\b(?:{words})\b)" for n, words in enumerate(SAY)), re.IGNORECASE)
    instead = list(SAY.values())
    return [
        f"{path.relative_to(ROOT)}:{line}: '{found[0]}'; say {instead[int(str(found.lastgroup)[1:])]}"
        for path in modules(room)
        for line, text in texts(path)
        if text not in KEPT and not text.startswith(QUOTED)
        for found in pattern.finditer(text)
    ]


def modules(room: str) -> list[Path]:
    return sorted((ROOT / room).rglob("*.py")) if (ROOT / room).is_dir() else [ROOT / room]


ROOMS = sorted({room_of(path) for package in PACKAGES for path in (ROOT / package).rglob("*.py")})


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_speaks_the_words_of_the_field(room: str) -> None:
    found = faults(room)
    assert not found, "\n".join(found)


def test_a_private_word_is_found(tmp_path: Path) -> None:
    assert spoken("toldNoise_of_data") == "told noise of data"
    path = tmp_path / "made.py"
    path.write_text('def told_mean():\n    """Data beside others."""\n    raise ValueError(f"leave {1} out")\n')
    said = [text for _, text in texts(path)]
    assert "told mean" in said
    assert "Data beside others." in said
