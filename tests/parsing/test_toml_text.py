"""The one strict reader of TOML: what is wrong is said with file and key, and what to write instead."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Literal

import pytest

from vbbench.errors import FileError
from vbbench.paper import the_paper
from vbbench.parsing.toml_text import bundled_names, read_bundled, read_toml
from vbbench.protocol import PROTOCOLS, Protocol, get_protocol

Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write_text(text: str) -> Path:
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write_text


@dataclass(frozen=True, kw_only=True)
class Row:
    name: str
    size: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Settings:
    kind: Literal["fast", "exact"]
    place: tuple[float, float] = (0.0, 0.0)
    steps: tuple[int, ...] = ()
    limit: int | None = None
    shares: Mapping[str, float] | None = None
    rows: Mapping[str, Row] | None = None


def test_tables_of_any_keys(write: Write) -> None:
    text = 'kind = "fast"\nplace = [1, 2.5]\nsteps = [1, 2]\nshares = { a = 1, b = 0.5 }\n[rows.one]\nname = "x"\n'
    made = read_toml(write(text), Settings, "settings")
    assert (made.place, made.steps, made.limit) == ((1, 2.5), (1, 2), None)
    assert made.shares == {"a": 1, "b": 0.5}
    assert made.rows == {"one": Row(name="x")}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "settings: key 'kind' is missing; add it"),
        ('kind = "exat"', r"kind cannot be 'exat'; did you mean 'exact'\?"),
        ("kind = 7", "kind cannot be 7; known: fast, exact"),
        ('kind = "fast"\nlimt = 1', r"settings: unknown key 'limt'; did you mean 'limit'\?"),
        ('kind = "fast"\nlimit = "x"', "limit = 'x' has the wrong type; Expected `int`, got `str`"),
        ('kind = "fast"\nlimit = 1.5', "Expected `int`, got `float`"),
        ('kind = "fast"\nplace = [1]', r"place = \[1\] .* Expected `array` of length 2, got 1"),
        ('kind = "fast"\nsteps = 3', "Expected `array`, got `int`"),
        ('kind = "fast"\nshares = { a = "x" }', "shares = .* Expected `float`, got `str`"),
        ('kind = "fast"\nrows = 3', r"\[rows\] holds tables"),
        ('kind = "fast"\n[rows.one]\nsize = 2.0', r"\[rows\.one\]: key 'name' is missing; add it"),
        ('kind = "fast"\n[rows.one]\nnmae = "x"', r"\[rows\.one\]: unknown key 'nmae'; did you mean 'name'"),
        (f"limit = {2**64}", "is not TOML: a whole number has more than 64 bits"),
        (f"steps = {'[' * 40}{']' * 40}", "is nested too deeply"),
    ],
)
def test_what_is_wrong_is_said_with_what_to_write(write: Write, text: str, problem: str) -> None:
    with pytest.raises(FileError, match=problem) as caught:
        read_toml(write(text), Settings, "settings")
    assert caught.value.path.name == "mine.toml"


def test_bundled_files_are_read_as_strictly(write: Write) -> None:
    assert bundled_names("vbbench", "protocols") == sorted(PROTOCOLS)
    for name in PROTOCOLS:
        assert get_protocol(name) == read_bundled("vbbench", f"protocols/{name}.toml", Protocol, "protocol")
    text = (files("vbbench") / "protocols" / "rollout.toml").read_text("utf-8")
    with pytest.raises(FileError, match="given cannot be 'begin'; known: arrivals, start, origin"):
        read_toml(write(text.replace('given = "start"', 'given = "begin"')), Protocol, "protocol")
    assert the_paper().table1["hotel"].sequences == 340
    assert len(the_paper().rows) == (files("vbbench") / "paper.toml").read_text("utf-8").count("[[rows]]")


def test_no_other_module_parses_toml() -> None:
    folders = ("vbbench", "generators", "renderers", "baselines", "leaderboards")
    sources = [path for folder in folders for path in Path(folder).rglob("*.py")]
    found = {path.as_posix() for path in sources if "import tomllib" in path.read_text("utf-8")}
    assert found == {"vbbench/parsing/toml_text.py"}
