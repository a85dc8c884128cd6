"""Numba's cache in an isolated process: it reads all there are and writes to a folder of the process alone."""

import os
from functools import cache
from pathlib import Path
from typing import Any

from numba.core.caching import UserProvidedCacheLocator

from vbbench.solving.isolation.kernel_cache import CACHES_VARIABLE


class Overlay(UserProvidedCacheLocator):  # type: ignore[misc]
    """A cache in ``$NUMBA_CACHE_DIR`` that begins with links to what other caches hold of the same module.

    What numba adds replaces a link and never what it points to.
    """

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> "Overlay | None":
        """The locator, for a function of a file."""
        found: Overlay | None = super().from_function(py_func, py_file)
        if found is not None:
            link_caches(py_file, found.get_cache_path())
        return found


@cache
def link_caches(py_file: str, folder: str) -> None:
    """Link into ``folder`` what caches hold of a module, where it is not there yet."""
    elsewhere = [
        Path(path, Path(folder).name) for path in os.environ.get(CACHES_VARIABLE, "").split(os.pathsep) if path
    ]
    for source in (Path(py_file).parent / "__pycache__", *elsewhere):
        for path in source.glob(f"{Path(py_file).stem}.*.nb[ic]"):
            link = Path(folder, path.name)
            if not link.is_symlink() and not link.exists():
                link.symlink_to(path)
