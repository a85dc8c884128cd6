"""What a kernel is compiled from: its own module, and all that this imports for it.

A kernel has the code of those that it calls and the constants that it names compiled into it, wherever they stand.
Numba looks at its own file alone, so that one whose callee has changed would be run from the cache as it was.
"""

import re
import sys
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

_IMPORT = re.compile(r"^from (vbbench[\w.]*) import (\((?:[^)#]|#[^\n]*)*\)|[^\n(]*)", re.MULTILINE)
_NAME = re.compile(r"\w+")


def fingerprint(module: str) -> str | None:
    """Of the sources of a loaded ``module`` and of what it imports at its top of vbbench's packages, and so on.

    Which of these are loaded by now does not matter; ``None`` if the module has no file.
    """
    own = getattr(sys.modules[module], "__file__", None)
    if own is None or not Path(own).is_file():
        return None
    found, to_read = dict[Path, str](), [Path(own)]
    while to_read:
        file = to_read.pop()
        if file not in found:
            found[file], imported = _source(file)
            to_read += imported
    return sha256("".join(sorted(found.values())).encode()).hexdigest()


@cache
def _source(file: Path) -> tuple[str, list[Path]]:
    """The hash of a module's file, and the files of what it imports."""
    text = file.read_bytes()
    names = {
        name
        for package, imported in _IMPORT.findall(text.decode())
        for name in (package, *(f"{package}.{each}" for each in _NAME.findall(imported)))
    }
    return sha256(text).hexdigest(), [found for name in sorted(names) if (found := _file_of(name)) is not None]


@cache
def _file_of(name: str) -> Path | None:
    """The file of a module of vbbench's packages; ``None`` if that is no module."""
    top, *below = name.split(".")
    spec = find_spec(top)
    for folder in () if spec is None else spec.submodule_search_locations or ():
        module = Path(folder, *below)
        for file in (module / "__init__.py", module.with_suffix(".py")):
            if file.is_file():
                return file
    return None
