"""Where numba keeps compiled kernels, so that an isolated solver need not compile what was compiled before.

Numba's caches are pickles. A solver may read those that are there, but what it adds goes into a folder of its own: a
cache that it could write to would be loaded by the next process that holds truth.
"""

import os
import shutil
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

LOCATOR = "vbbench.solving.isolation.numba_locator.Overlay"
CACHES_VARIABLE = "VBBENCH_NUMBA_CACHES"
"""Names the folders of `user_caches` to the solver's process."""

MOST_BYTES = 1 << 28
"""Bytes of compiled kernels that are kept; a solver that makes more compiles again and again."""


def user_caches() -> list[str]:
    """Numba's caches outside of ``__pycache__``: the one that is set, and the user's, where they are."""
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
    """The bytes of a file that is neither a link nor a device, nor longer than ``most``; empty where it is not so."""
    try:
        file = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
    except OSError:
        return b""
    try:
        facts = os.fstat(file)  # of what was opened, whatever bears its name by now
        return os.read(file, most) if stat.S_ISREG(facts.st_mode) and facts.st_size <= most else b""
    finally:
        os.close(file)
