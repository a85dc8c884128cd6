"""Backend ``moderngl``: OpenGL through EGL, off-screen, on a GPU or in software."""

from typing import Any

import vbbench_renderers.required  # noqa: F401 (says what to install)

__all__ = ["OpenGLRenderer"]


def __getattr__(name: str) -> Any:
    """The renderer, imported on first use, so that checking whether OpenGL works is fast."""
    if name != "OpenGLRenderer":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from vbbench_renderers.opengl.renderer import OpenGLRenderer

    return OpenGLRenderer
