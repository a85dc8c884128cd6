"""The only place with workarounds for faults of pyrender 0.1.45; it changes no other library.

* It opens an interactive viewer's libraries on import, which need a display: a stand-in is imported for that module.
* It uses ``np.infty``, which NumPy 2 dropped: its own modules see a NumPy that has it.
* It reads PYOPENGL_PLATFORM when PyOpenGL is first imported and whenever a renderer is made: the variable is set for
  as long as that takes.
"""

import ctypes.util
import importlib
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError, needs_extra

_VARIABLE = "PYOPENGL_PLATFORM"
_LIBRARIES = {"egl": "EGL", "osmesa": "OSMesa"}


class _OlderNumpy:
    """NumPy with the names that pyrender still uses."""

    infty = np.inf

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)


def load_pyrender() -> Any:
    """The module `pyrender`, ready for off-screen use.

    Raises
    ------
    VbbenchError
        If it is not installed or finds no OpenGL.
    """
    if "pyrender" not in sys.modules:
        with needs_extra("pyrender", "backend 'pyrender'"), off_screen():
            _import_without_viewer()
    mesh: Any = sys.modules["pyrender.mesh"]
    if not hasattr(mesh.np, "infty"):
        mesh.np = _OlderNumpy()
    return sys.modules["pyrender"]


def open_off_screen(width: int, height: int) -> Any:
    """A `pyrender.OffscreenRenderer`.

    Raises
    ------
    VbbenchError
        If no context can be made.
    """
    pyrender = load_pyrender()
    with off_screen() as platform:
        try:
            return pyrender.OffscreenRenderer(width, height)
        except Exception as error:  # OpenGL's errors have no common base
            raise VbbenchError(
                f"pyrender gets no {platform} context ({type(error).__name__}); install Mesa (on Debian "
                "mesa-utils-bin), or use backend 'moderngl' or 'raster'"
            ) from error


def device_name() -> str:
    """What draws in the current context."""
    gl = importlib.import_module("OpenGL.GL")
    return f"{gl.glGetString(gl.GL_RENDERER).decode()}, through pyrender"


@contextmanager
def off_screen() -> Iterator[str]:
    """PYOPENGL_PLATFORM as it was set, otherwise EGL if available, otherwise OSMesa; restored afterwards."""
    before = os.environ.get(_VARIABLE)
    platform = before if before in _LIBRARIES else _first_library()
    os.environ[_VARIABLE] = platform
    try:
        yield platform
    finally:
        if before is None:
            del os.environ[_VARIABLE]
        else:
            os.environ[_VARIABLE] = before


def _first_library() -> str:
    for platform, library in _LIBRARIES.items():
        if ctypes.util.find_library(library):
            return platform
    raise VbbenchError("pyrender needs EGL or OSMesa; install Mesa (on Debian mesa-utils-bin), or use backend 'raster'")


def _import_without_viewer() -> None:
    stand_in: Any = ModuleType("pyrender.viewer")
    stand_in.Viewer = None
    sys.modules["pyrender.viewer"] = stand_in
    try:
        pyrender = importlib.import_module("pyrender")
    except Exception as error:  # PyOpenGL passes on the exceptions of its platform
        for name in [name for name in sys.modules if name.split(".")[0] == "pyrender"]:
            del sys.modules[name]
        if isinstance(error, ModuleNotFoundError):
            raise
        raise VbbenchError(
            f"pyrender cannot be imported ({type(error).__name__}: {error}); install it with Mesa (on Debian "
            "mesa-utils-bin), or use backend 'moderngl' or 'raster'"
        ) from error
    del sys.modules["pyrender.viewer"], pyrender.Viewer
