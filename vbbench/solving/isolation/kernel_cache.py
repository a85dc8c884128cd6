"""Where numba keeps compiled kernels, so that an isolated solver need not compile what was compiled before.

Numba's caches are pickles. A solver may read existing ones, but what it adds goes into a folder of its own: a cache
that it could write to would be loaded by the next process that holds truth.
"""

import os
import shutil
import stat
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

LOCATOR = "vbbench.solving.isolation.kernel_cache.Overlay"
CACHES_VARIABLE = "VBBENCH_NUMBA_CACHES"
"""Names the folders of `user_caches` to the solver's process."""

MOST_BYTES = 1 << 28
"""Bytes of compiled kernels that are kept; beyond them a solver compiles in every process."""


def user_caches() -> list[str]:
    """Numba's existing caches outside of ``__pycache__``: the configured one, and the user's."""
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "numba")
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    return [str(path.resolve()) for path in ([Path(chosen)] if chosen else []) + [user] if path.is_dir()]


def keep_files(source: Path, target: Path) -> None:
    """Copy numba's files below ``source``, two levels deep, into the folder ``target``, which appears whole or not.

    ``source`` is not trusted: links are not followed, nothing is loaded, and there is a limit to the bytes.
    """
    draft = Path(tempfile.mkdtemp(prefix=f"{target.name}-", dir=target.parent))
    left = MOST_BYTES
    for path in sorted(source.glob("*/*.nb[ic]")):
        content = b"" if path.parent.is_symlink() else _read_plain_file(path, left)
        left -= len(content)
        if content:
            (draft / path.parent.name).mkdir(exist_ok=True)
            (draft / path.parent.name / path.name).write_bytes(content)
    with suppress(OSError):  # another process was faster
        draft.rename(target)
    shutil.rmtree(draft, ignore_errors=True)


def _read_plain_file(path: Path, most: int) -> bytes:
    """The bytes of a regular file of at most ``most`` bytes; empty for anything else."""
    try:
        file = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
    except OSError:
        return b""
    try:
        facts = os.fstat(file)  # of what was opened, whatever bears its name by now
        return os.read(file, most) if stat.S_ISREG(facts.st_mode) and facts.st_size <= most else b""
    finally:
        os.close(file)


def __getattr__(name: str) -> Any:
    """``Overlay``, which numba looks up by name in the solver's process; elsewhere numba is not imported."""
    if name != "Overlay":
        raise AttributeError(f"module '{__name__}' has no attribute {name!r}")
    from numba.core.caching import UserProvidedCacheLocator

    class Overlay(UserProvidedCacheLocator):  # type: ignore[misc]
        """A cache in ``$NUMBA_CACHE_DIR`` that starts with links to other caches of the same module.

        What numba adds replaces a link and never what it points to.
        """

        @classmethod
        def from_function(cls, py_func: Any, py_file: str) -> Any:
            """The locator, for a function of a file."""
            found = super().from_function(py_func, py_file)
            if found is not None:
                link_caches(py_file, found.get_cache_path())
            return found

    return Overlay


@cache
def link_caches(py_file: str, folder: str) -> None:
    """Link a module's files in other caches into ``folder``, unless it has them already."""
    elsewhere = [
        Path(path, Path(folder).name) for path in os.environ.get(CACHES_VARIABLE, "").split(os.pathsep) if path
    ]
    for source in (Path(py_file).parent / "__pycache__", *elsewhere):
        for path in source.glob(f"{Path(py_file).stem}.*.nb[ic]"):
            link = Path(folder, path.name)
            if not link.is_symlink() and not link.exists():
                with suppress(OSError):  # Windows has links for administrators alone: the function is compiled again
                    link.symlink_to(path)
