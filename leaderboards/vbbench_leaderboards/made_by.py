"""By which code a folder was made: a note beside it, so that only what is up to date is used again."""

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from vbbench import __version__
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.registry import Kind, registered


def code_of(kind: Kind, name: str) -> str:
    """A hash of the source files of vbbench and of the package that ``name`` comes from, after vbbench's version."""
    point = registered(kind).get(name)
    module = (point.value if point else name).partition(":")[0].partition(".")[0]
    return f"{__version__} {_hash_of_source('vbbench')[:16]} {_hash_of_source(module)[:16]}"


def is_made_by(code: str, folder: Path) -> bool:
    """Whether the note beside ``folder`` names that code, and every file is as it was then."""
    note = _note(folder)
    return note.is_file() and note.read_text("utf-8") == _text(code, folder)


def note_code(code: str, folder: Path) -> None:
    """Write the note beside ``folder``."""
    write_text_atomically(_note(folder), _text(code, folder))


def forget(folder: Path) -> None:
    """Remove the note: what is made next is not up to date before it is whole."""
    _note(folder).unlink(missing_ok=True)


def _note(folder: Path) -> Path:
    return folder.with_name(folder.name + ".made-by")


def _text(code: str, folder: Path) -> str:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return "".join([f"{code}\n", *(f"{file_sha256(path)}  {path.relative_to(folder)}\n" for path in files)])


@cache
def _hash_of_source(module: str) -> str:
    spec = find_spec(module)
    roots = [Path(place) for place in (spec.submodule_search_locations or [])] if spec else []
    files = sorted(path for root in roots for path in root.rglob("*") if path.suffix in (".py", ".toml"))
    if spec and spec.origin and not roots:
        files = [Path(spec.origin)]
    whole = hashlib.sha256()
    for path in files:
        whole.update(f"{path.name}\0".encode() + path.read_bytes())
    return whole.hexdigest()
