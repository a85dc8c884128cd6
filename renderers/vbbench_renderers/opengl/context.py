"""An off-screen OpenGL context, on a GPU if there is one, and the programs that run in it."""

import os
from collections.abc import Iterable
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from vbbench.errors import VbbenchError
from vbbench_renderers import drawing

if TYPE_CHECKING:
    import moderngl

VERSION = 430
"""OpenGL 4.3 draws all meshes with one indirect call."""
MOST_DEVICES = 8
SOFTWARE = ("llvmpipe", "softpipe", "swrast", "software")
_CONSTANTS = ("RINGS_PER_M", "STRIPES_ROUND", "CHECKS_PER_M")


def is_software(device: str) -> bool:
    """Whether a GL_RENDERER string names a processor rather than a GPU."""
    return any(name in device.lower() for name in SOFTWARE)


def device_name(context: "moderngl.Context") -> str:
    """GL_RENDERER, with a note if it is software."""
    name = str(context.info["GL_RENDERER"])
    return f"{name}, software rendering" if is_software(name) else name


def open_context() -> "moderngl.Context":
    """A context on the first EGL device that is a GPU, otherwise on the first device that works.

    The environment variable GLCONTEXT_DEVICE_INDEX, moderngl's own, chooses a device outright.

    Raises
    ------
    VbbenchError
        If no device offers OpenGL 4.3 through EGL.
    """
    import moderngl

    named = os.environ.get("GLCONTEXT_DEVICE_INDEX")
    spare, problem = None, "no EGL device"
    for index in [int(named)] if named and named.isdecimal() else range(MOST_DEVICES):
        options: dict[str, Any] = {"backend": "egl", "device_index": index}
        try:
            context = moderngl.create_context(standalone=True, require=VERSION, **options)
        except Exception as error:  # moderngl raises no more specific exception
            problem = str(error) if index == 0 or named else problem
            if "device index" in str(error):
                break
            continue
        if not is_software(str(context.info["GL_RENDERER"])):
            if spare is not None:
                spare.release()
            return context
        if spare is None:
            spare = context
        else:
            context.release()
    if spare is None:
        raise VbbenchError(f"no OpenGL 4.3 through EGL here ({problem})")
    return spare


def make_program(
    context: "moderngl.Context", vertex: str, fragment: str, defines: Iterable[str] = ()
) -> "moderngl.Program":
    """A program of shader files; every shader has access to the frame, patterns and light."""
    head = ["#version 430"]
    head += [f"#define {name} {getattr(drawing, name)}" for name in _CONSTANTS]
    head += [f"#define {name}" for name in defines]
    vertex_parts = ["frame.glsl", "light.glsl", "project.glsl", vertex]
    fragment_parts = ["frame.glsl", "light.glsl", fragment]
    program = context.program(
        vertex_shader="\n".join([*head, *map(_read, vertex_parts)]),
        fragment_shader="\n".join([*head, *map(_read, fragment_parts)]),
    )
    if "Frame" in program:
        uniform(program, "Frame").binding = 0
    return program


def uniform(program: "moderngl.Program", name: str) -> Any:
    """A uniform or a uniform block; moderngl's types do not distinguish them from attributes."""
    return program[name]


def _read(name: str) -> str:
    return (files("vbbench_renderers.opengl") / "shaders" / name).read_text("utf-8")
