"""Reader of all TOML files, users' and bundled ones: it makes frozen dataclasses of their tables.

msgspec checks the type of each value. A key that is unknown, missing or of the wrong type is an error that names file,
key and repair. So is a file that is too large to be one of settings.
"""

import reprlib
import tomllib
from codecs import BOM_UTF8
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from datetime import date
from importlib.resources import as_file, files
from pathlib import Path
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import msgspec

from vbbench.errors import FileError, suggestion

T = TypeVar("T")

MOST_BYTES, LONGEST_ROW = 2**16, 2000
"""Bytes of the largest file of settings and of its longest line: the time of parsing grows with the square of both."""
DEEPEST = 8
"""Arrays and tables in one another."""


def bundled_names(package: str, folder: str) -> list[str]:
    """The TOML files in a folder of an installed package, without their ending, in alphabetical order."""
    names = (entry.name for entry in (files(package) / folder).iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def read_bundled(package: str, place: str, kind: type[T], where: str) -> T:
    """Read the file ``place``, such as ``recipes/hotel.toml``, of an installed package; otherwise as `read_toml`."""
    with as_file(files(package).joinpath(place)) as path:
        return read_toml(path, kind, where)


def bundled_table(package: str, place: str) -> dict[str, Any]:
    """The keys of the file ``place`` of an installed package."""
    with as_file(files(package).joinpath(place)) as path:
        return toml_table(path)


def read_toml(path: Path, kind: type[T], where: str) -> T:
    """Make a ``kind``, a frozen dataclass, of the file ``path``; messages call its top level ``where``.

    A field that is a dataclass is a table, one that is a tuple of dataclasses an array of tables, and one that is a
    ``Mapping`` a table with any keys; other lists become tuples.

    Raises FileError if the file is missing or not TOML, a key is unknown (the nearest is suggested), missing, of
    another type, or has a value outside its range.
    """
    return from_table(toml_table(path), kind, path, where)


def from_table(table: Mapping[str, Any], kind: type[T], path: Path, where: str) -> T:
    """Make a ``kind`` of the keys of a table that was read from ``path``; otherwise as `read_toml`."""
    try:
        return _build(kind, table, path, where)
    except ValueError as error:
        raise FileError(path, str(error)) from error


def _build(kind: type[T], table: Mapping[str, Any], path: Path, where: str) -> T:
    known = {field.name: field for field in fields(kind)}  # type: ignore[arg-type]
    for key in table:
        if key not in known:
            raise FileError(path, f"{where}: unknown key '{key}'; {suggestion(key, known)}")
    for name, field in known.items():
        if name not in table and field.default is MISSING and field.default_factory is MISSING:
            raise FileError(path, f"{where}: key '{name}' is missing; add it")
    hints = get_type_hints(kind)
    return kind(**{key: _value(value, hints[key], path, where, key) for key, value in table.items()})


def _value(value: Any, hint: Any, path: Path, where: str, key: str) -> Any:
    """The value of a key as `hint` wants it, with the dataclasses that it names in place of tables."""
    hint = _options(hint)[0] if len(_options(hint)) == 1 else hint
    nested: Any = next((kind for kind in (hint, *get_args(hint)) if is_dataclass(kind)), None)
    if nested is not None and get_origin(hint) is Mapping:
        if not isinstance(value, dict) or not all(isinstance(table, Mapping) for table in value.values()):
            raise FileError(path, f"[{key}] holds tables: write each as [{key}.NAME] or NAME = {{ ... }}")
        return {name: _build(nested, table, path, f"[{key}.{name}]") for name, table in value.items()}
    if nested is not None and get_origin(hint) is tuple:
        if not isinstance(value, list) or not all(isinstance(table, Mapping) for table in value):
            raise FileError(path, f"these are tables in a row, each with the heading [[{key}]]: double brackets")
        return tuple(_build(nested, table, path, f"[[{key}]]") for table in value)
    if nested is not None and isinstance(value, Mapping):
        return _build(nested, value, path, f"[{key}]")
    try:
        made = msgspec.convert(value, hint, builtin_types=(date,))
    except msgspec.ValidationError as error:
        words = [word for option in _options(hint) if get_origin(option) is Literal for word in get_args(option)]
        if words:
            problem = f"{where}: {key} cannot be {reprlib.repr(value)}; {suggestion(str(value), words)}"
            raise FileError(path, problem) from error
        advice = str(error)
        if date in _options(hint):
            advice = "write a day, YYYY-MM-DD without quotation marks"
        raise FileError(path, f"{where}: {key} = {reprlib.repr(value)} has the wrong type; {advice}") from error
    written = _tuples(value)
    return written if made == written else made  # 1 stays 1: ids of datasets are digests of what is written


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _options(hint: Any) -> list[Any]:
    """The types that a value may have; that of a key that may be missing is the one where it is there."""
    options = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return [option for option in options if option is not type(None)]


def toml_table(path: Path) -> dict[str, Any]:
    """The keys of a TOML file.

    Raises FileError if it is missing or not TOML, or larger than a file of settings.
    """
    try:
        with path.open("rb") as file:
            text = file.read(MOST_BYTES + 1)
        if len(text) > MOST_BYTES:
            raise FileError(path, f"has more than {MOST_BYTES:,} bytes; a file of settings is short")
        endless = next((n for n, row in enumerate(text.split(b"\n"), 1) if len(row) > LONGEST_ROW), None)
        if endless is not None:
            raise FileError(path, f"has more than {LONGEST_ROW:,} bytes; write it in several lines", endless)
        table = tomllib.loads(_decoded(path, text))
        _check_values(table)
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from error
    except RecursionError as error:
        raise FileError(path, "is nested too deeply; arrays and tables here are a few levels deep") from error
    except ValueError as error:  # also of text that is not UTF-8, and of numbers of thousands of digits
        raise FileError(path, f"is not TOML: {error}") from error
    return table


def _decoded(path: Path, text: bytes) -> str:
    """The text without the mark that some editors write before it."""
    text = text.removeprefix(BOM_UTF8)
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise FileError(path, "is not UTF-8; save it as UTF-8 in your editor", line) from error


def _check_values(table: dict[str, Any]) -> None:
    """Refuse values that nothing here can be made of, so that everybody may print and compare them."""
    level: list[Any] = [table]
    for _ in range(DEEPEST):
        level = [item for value in level for item in (value.values() if isinstance(value, dict) else value)]
        if any(isinstance(value, int) and value.bit_length() > 63 for value in level):
            raise ValueError("a whole number has more than 64 bits")
        level = [value for value in level if isinstance(value, (dict, list))]
    if level:
        raise RecursionError
