"""Backend ``moderngl``: OpenGL through EGL, off-screen, on a GPU or in software."""

from vbbench_renderers.opengl.renderer import OpenGLRenderer

__all__ = ["OpenGLRenderer"]
